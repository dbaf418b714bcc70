//! The prefix of a camera path: the cone and the pencil around it, and the collection point that it ends in.

use super::PathContext;
use super::camera_path::Arrival;
use super::observer::CollectionPoint;
use super::scratch::PathScratch;
use crate::interface::features::Features;
use crate::interface::material::{FLAGS_SCATTER_TEXTURE, Material};
use crate::interface::packed::to_signed_shares;
use crate::interface::point::{PointGeometry, PointShading};
use crate::interface::ray::Hit;
use crate::math::cone::RayCone;
use crate::math::pencil::VirtualImage;
use crate::math::{PI, is_finite};
use crate::surface::Sampled;
use crate::surface::scatter::BsdfSample;
use crate::surface::textured::packed;
use crate::surface::turn::normal_changes;
use crate::surface::vertex::Vertex;
use spirv_std::glam::Vec3;

/// Features that distort a pencil: without them a prefix meets plane mirrors alone.
const DISTORTING: Features = Features(Features::DIELECTRIC.0 | Features::SMOOTH_NORMALS.0);

/// Whether a history needs the virtual image of a point, and the length of the path does not give its distance.
#[inline(always)]
pub fn needs_virtual_image(features: Features) -> bool {
    features.has(Features::HISTORY) && features.has(DISTORTING)
}

/// Moves cone and pencil along a segment. Returns the width of the cone by which textures are filtered (m); 0 for their finest level.
#[inline(always)]
pub fn advance_prefix(distance: f32, context: PathContext<'_>, scratch: &mut PathScratch<'_>) -> f32 {
    let (cone, length) = scratch.cone();
    let cone = cone.advance(distance);
    scratch.set_cone(cone, length + distance);
    if needs_virtual_image(context.features) {
        scratch.set_pencil(&scratch.pencil().advance(distance));
    }
    let mut texture_width = 0.0;
    if !context.params.sees_finest_textures() {
        texture_width = cone.total_width();
    }
    texture_width
}

/// Collection point of a prefix that ends at a vertex. Its disc is as wide as the footprint of the pixel. Its shading holds the
/// factor between the gathered light and the pixel: throughput over class probability.
#[inline(always)]
pub fn collection_point(
    arrival: &Arrival,
    depth: u32,
    class_probability: f32,
    eta: f32,
    eye_cone: RayCone,
    context: PathContext<'_>,
    scratch: &PathScratch<'_>,
) -> CollectionPoint {
    let Arrival { vertex: here, material, throughput, .. } = *arrival;
    let (cone, length) = scratch.cone();
    let mut virtual_image = VirtualImage::straight(length);
    if needs_virtual_image(context.features) {
        virtual_image = scratch.pencil().virtual_image(length);
    }
    let geometry = PointGeometry {
        position: here.position,
        radius: disc_radius(cone, length, &here, eye_cone, context),
        normal: here.face_normal,
        depth,
    };
    let mut shading = PointShading {
        to_viewer: here.to_previous,
        material: here.material,
        shading_normal: here.shading_normal,
        red_green: 0,
        throughput: throughput / class_probability,
        blue_roughness_metallic: 0,
        eta,
        instance: here.instance,
        distance: virtual_image.distance,
        astigmatism: to_signed_shares(virtual_image.astigmatism),
    };
    if context.features.has(Features::TEXTURES) && material.flags & FLAGS_SCATTER_TEXTURE != 0 {
        (shading.red_green, shading.blue_roughness_metallic) = packed(&material);
    }
    CollectionPoint { geometry, shading, length }
}

/// Radius of the disc (m) around a vertex, for a cone of this length.
#[inline(always)]
fn disc_radius(
    cone: RayCone,
    length: f32,
    here: &Vertex,
    eye_cone: RayCone,
    context: PathContext<'_>,
) -> f32 {
    let cos = here.to_previous.dot(here.face_normal);
    cone.radius(cos, context.params.radius_px, here.position, eye_cone.advance(length).width)
}

/// Radius of the disc (m) of a collection point, without the width of rough lobes. A rough mirror widens the cone of a pixel, but
/// does not spread the points of all pixels over a larger area. So this radius gives the distance between points.
#[inline(always)]
pub fn radius_without_rough_lobes(
    arrival: &Arrival,
    eye_cone: RayCone,
    context: PathContext<'_>,
    scratch: &PathScratch<'_>,
) -> f32 {
    let (cone, length) = scratch.cone();
    disc_radius(RayCone { rough_width: 0.0, ..cone }, length, &arrival.vertex, eye_cone, context)
}

/// Minimum probability of the diffuse lobes of a point that shares indirect light: its samples are at most this much brighter.
const MIN_DIFFUSE: f32 = 0.25;
/// Minimum of the darkest over the brightest channel of a color that light is divided by.
const MIN_CHANNEL: f32 = 1.0e-3;

/// Factor from the indirect light of a path to a sample of its collection point, 1 / (T pi f). The path found L f cos / pdf times the
/// throughput T; the sample is L cos / (pi pdf). Zero: the point gives no sample. Whether it does depends on its surface alone: if it
/// depended on the sampled direction, the mean of samples would be wrong.
#[inline(always)]
pub fn demodulation(
    throughput: Vec3,
    sampled: &Sampled,
    material: &Material,
    diffuse_probability: f32,
) -> Vec3 {
    let shares = diffuse_probability >= MIN_DIFFUSE && has_all_channels(throughput * material.base_color);
    let f = sampled.weight * (sampled.pdf_solid_angle / sampled.direction.z);
    let factor = 1.0 / (throughput * f * PI);
    if shares && is_finite(factor.element_sum()) { factor } else { Vec3::ZERO }
}

/// Whether light can be divided by a color without much noise in its darkest channel.
#[inline(always)]
fn has_all_channels(color: Vec3) -> bool {
    color.min_element() > MIN_CHANNEL * color.max_element()
}

/// One over a color; zero if it lacks a channel.
#[inline(always)]
pub fn inverse_if_all_channels(color: Vec3) -> Vec3 {
    let inverse = 1.0 / color;
    if has_all_channels(color) && is_finite(inverse.element_sum()) { inverse } else { Vec3::ZERO }
}

/// Turns pencil and cone at a specular event.
#[inline(always)]
pub fn scatter_prefix(
    hit: &Hit,
    vertex: &Vertex,
    scattered: &BsdfSample,
    context: PathContext<'_>,
    scratch: &mut PathScratch<'_>,
) {
    if needs_virtual_image(context.features) {
        scatter_pencil(hit, vertex, scattered, context, scratch);
    }
    let (cone, length) = scratch.cone();
    scratch.set_cone(scatter_cone(cone, vertex, scattered), length);
}

/// The ray cone behind a specular event.
#[inline(always)]
fn scatter_cone(cone: RayCone, vertex: &Vertex, scattered: &BsdfSample) -> RayCone {
    let sampled = &scattered.sampled;
    let cos = vertex.to_previous.dot(vertex.shading_normal).abs();
    // A rough thin wall transmits its mirrored reflection, and refracts nothing on average.
    let unrefracted = sampled.straight || (sampled.roughness > 0.0 && sampled.eta == 1.0);
    if !sampled.transmitted {
        let cone = cone.reflect(vertex.curvature, cos);
        if sampled.roughness > 0.0 { cone.roughen(sampled.roughness) } else { cone }
    } else if unrefracted {
        if sampled.roughness > 0.0 { cone.roughen(sampled.roughness) } else { cone }
    } else if sampled.roughness > 0.0 {
        // Refract at a facet: both cosines are to the facet, of directions flipped as the lobes see them.
        let facing = |direction: Vec3, above: bool| {
            if (direction.dot(vertex.shading_normal) > 0.0) == above { direction } else { -direction }
        };
        let (to_previous, direction) =
            (facing(vertex.to_previous, true), facing(scattered.ray.direction, false));
        let half = (to_previous * sampled.eta + direction).normalize();
        let (cos, cos_behind) = (to_previous.dot(half).abs(), direction.dot(half).abs());
        let cone = cone.refract(vertex.curvature, cos, cos_behind, sampled.eta);
        cone.roughen_refracted(sampled.roughness, sampled.eta)
    } else {
        cone.refract(vertex.curvature, cos, -sampled.direction.z, sampled.eta)
    }
}

/// Turns the pencil at a specular event. Reads it from the scratch at each use, see `path::scratch`.
#[inline(always)]
fn scatter_pencil(
    hit: &Hit,
    vertex: &Vertex,
    scattered: &BsdfSample,
    context: PathContext<'_>,
    scratch: &mut PathScratch<'_>,
) {
    let sampled = &scattered.sampled;
    let (from, to) = (-vertex.to_previous, scattered.ray.direction);
    if !sampled.straight {
        let pencil = if sampled.transmitted && sampled.eta == 1.0 {
            // A rough thin wall refracts nothing on average.
            scratch.pencil().turn(from, to)
        } else {
            let eta = if sampled.transmitted { sampled.eta } else { 1.0 };
            let steps = scratch.pencil().steps(from, vertex.face_normal);
            let (change_x, change_y) =
                normal_changes(context.scene, context.features, hit, vertex.front, steps);
            scratch.pencil().reflect_or_refract(from, to, eta, !sampled.transmitted, change_x, change_y)
        };
        scratch.set_pencil(&pencil);
    }
}
