//! `splat.kim2019`: adds each deposit to the one pixel that it is seen in, if that pixel sees the place where it lies.
//!
//! Source: [Kim 2019, Caustics using screen-space photon mapping, Ray Tracing Gems, ch. 30]. Cost: a projection a deposit,
//! whatever the number of pixels. Where it is wrong: receivers are primary surfaces only, so that caustics in mirrors,
//! through glass and off glossy surfaces are missing; a pixel is a sharp box, so that few light paths are grains; light
//! leaks between surfaces whose distances from the eye agree within 1 %, or that lie in one plane.

use crate::gather::accumulator::Sum;
use crate::gather::contribution::contribution;
use crate::gather::tables::Tables;
use crate::interface::frame::{Camera, FrameParams};
use crate::interface::point::{DepositGeometry, PointGeometry};
use crate::math::PI;
use crate::seam::Atomics;
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Largest difference between the distances of a deposit and of the surface that its pixel sees, relative to either.
const DISTANCE_TOLERANCE: f32 = 0.01;
/// Smallest cosine that a pixel is projected with.
const MIN_COS: f32 = 0.01;

/// Area of a pixel on the tangent plane of the deposit.
pub const AREA_FOOTPRINT: u32 = 0;
/// Kim's area of a pixel: on a sphere about the eye through the deposit, (d f_w / (f W)) (d f_h / (f H)).
pub const AREA_FACING: u32 = 1;

/// Adds deposit `index` to its pixel; `params.part` chooses the pixel's area.
#[inline(always)]
pub fn kim2019<C: Atomics>(index: u32, tables: &mut Tables<'_>, counters: &mut C) {
    if index >= tables.deposit_count {
        return;
    }
    let params = tables.params;
    let deposit = tables.deposit_geometry[index as usize];
    let to = deposit.position - params.camera.position;
    let (is_seen, pixel) = pixel_of(to, params);
    if !is_seen {
        return;
    }
    let point = tables.point_geometry[pixel as usize];
    let distance = to.length();
    // The pixel's first surface must be the one whose light is collected.
    let is_primary = point.depth == 1 && deposit.scatterings < params.max_bounces;
    if is_primary && agrees(&point, &deposit, to, params.camera.position) {
        let shading = tables.point_shading[pixel as usize];
        let material = material_of(&shading, tables.materials, tables.needs);
        let light = tables.deposit_light[index as usize];
        let roughness = params.specular_roughness;
        let value = contribution(&shading, material, &light, roughness, tables.needs);
        // `resolve` divides by the disc.
        let disc = PI * point.radius * point.radius;
        let sum = Sum::of(value * (disc / area(&deposit, to, distance, params)), params.inverse_quantum());
        sum.add_to(&mut tables.accumulator, pixel);
        sum.tally(counters);
    }
}

/// Whether a deposit, `to` from the eye, lies on the surface of its pixel: as far from the eye as the pixel's point, or as
/// the surface through that point is in the deposit's own direction. At a slant a pixel reaches over far more of its
/// distance than the tolerance: a plane that leans by the mean of both normals follows it, also where it is a little curved.
#[inline(always)]
fn agrees(point: &PointGeometry, deposit: &DepositGeometry, to: Vec3, eye: Vec3) -> bool {
    let distance = to.length();
    let seen = (point.position - eye).length();
    let normals = point.normal + deposit.normal;
    let height = (deposit.position - point.position).dot(normals);
    // Along the ray to the deposit the plane is height / (normals . to / distance) away.
    let on_plane =
        point.normal.dot(deposit.normal) > 0.0 && height.abs() <= DISTANCE_TOLERANCE * to.dot(normals).abs();
    (distance - seen).abs() <= DISTANCE_TOLERANCE * distance || on_plane
}

/// Whether what lies in a direction from the eye is in the picture, and in which pixel.
#[inline(always)]
fn pixel_of(to: Vec3, params: &FrameParams) -> (bool, u32) {
    let camera = &params.camera;
    let depth = to.dot(camera.forward);
    if depth <= 0.0 {
        return (false, 0);
    }
    let x = to.dot(camera.right) / (depth * camera.right.length_squared());
    let y = to.dot(camera.up) / (depth * camera.up.length_squared());
    if x.abs().max(y.abs()) >= 1.0 {
        return (false, 0);
    }
    let column = ((0.5 + 0.5 * x) * params.width as f32) as u32;
    let row = ((0.5 - 0.5 * y) * params.height as f32) as u32;
    (true, row.min(params.height - 1) * params.width + column.min(params.width - 1))
}

/// Area of a pixel at the deposit [m^2].
#[inline(always)]
fn area(deposit: &DepositGeometry, to: Vec3, distance: f32, params: &FrameParams) -> f32 {
    let Camera { right, up, forward, .. } = params.camera;
    // That of a pixel a metre before the eye.
    let pixel = 4.0 * right.length() * up.length() / (params.width * params.height) as f32;
    if params.part == AREA_FACING {
        return pixel * distance * distance;
    }
    let depth = to.dot(forward);
    let cos = (deposit.normal.dot(to) / distance).abs().max(MIN_COS);
    pixel * depth * depth * depth / (distance * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params() -> FrameParams {
        let camera = Camera {
            position: Vec3::new(1.0, 2.0, 3.0),
            right: Vec3::X * 0.8,
            up: Vec3::Y * 0.6,
            forward: Vec3::NEG_Z,
        };
        FrameParams { camera, width: 40, height: 30, ..FrameParams::default() }
    }

    #[test]
    fn a_direction_falls_into_the_pixel_whose_ray_it_is() {
        let params = params();
        for pixel in 0..1200 {
            let (column, row) = ((pixel % 40) as f32 + 0.3, (pixel / 40) as f32 + 0.7);
            let Camera { right, up, forward, .. } = params.camera;
            let to = forward + right * (column / 20.0 - 1.0) + up * (1.0 - row / 15.0);
            assert_eq!(pixel_of(to * 7.0, &params), (true, pixel));
            assert!(!pixel_of(to * -1.0, &params).0);
        }
        assert!(!pixel_of(Vec3::new(0.81, 0.0, -1.0), &params).0);
    }

    /// From an eye a metre above a floor: two places of one pixel, a tenth of their distance apart, are on one surface; what
    /// floats above the floor, or hangs below it with its face down, is not.
    #[test]
    fn a_pixel_at_a_slant_has_the_depth_of_its_plane() {
        let eye = Vec3::Y;
        let point = PointGeometry { position: Vec3::X * 5.0, normal: Vec3::Y, ..PointGeometry::default() };
        let at = |position: Vec3, normal| {
            agrees(
                &point,
                &DepositGeometry { position, normal, ..DepositGeometry::default() },
                position - eye,
                eye,
            )
        };
        assert!(at(Vec3::X * 5.5, Vec3::Y) && at(Vec3::X * 4.5, Vec3::Y));
        // A hill of radius 5 m, where the plane through the point alone is 2.4 % off.
        assert!(at(Vec3::new(4.5, -0.025, 0.0), Vec3::new(-0.1, 1.0, 0.0).normalize()));
        assert!(!at(Vec3::new(5.5, 0.05, 0.0), Vec3::Y) && !at(Vec3::X * 5.5, Vec3::NEG_Y));
        assert!(at(Vec3::new(5.0, 0.05, 0.0), Vec3::Y), "the published tolerance stays");
    }

    /// The footprints of all pixels on a plane across the whole view add up to what of it is seen.
    #[test]
    fn footprints_tile_a_plane() {
        let params = params();
        let Camera { right, up, forward, .. } = params.camera;
        // A plane that leans by 0.5 across x: points p with (p - c) . n = 0, c 4 m before the eye.
        let normal = Vec3::new(0.5, 0.0, 1.0).normalize();
        let mut sum = 0.0;
        for pixel in 0..1200 {
            let (column, row) = ((pixel % 40) as f32 + 0.5, (pixel / 40) as f32 + 0.5);
            let ray = forward + right * (column / 20.0 - 1.0) + up * (1.0 - row / 15.0);
            let to = ray * (4.0 * forward.dot(normal) / ray.dot(normal));
            let deposit = DepositGeometry { normal, ..DepositGeometry::default() };
            let area_of = |part| area(&deposit, to, to.length(), &FrameParams { part, ..params });
            sum += area_of(AREA_FOOTPRINT);
            // Kim's leaves out the slant, and that the corners of a flat film are smaller from the eye.
            let slant = normal.dot(to).abs() / to.length();
            let off_axis = to.dot(forward) / to.length();
            let ratio = area_of(AREA_FACING) / area_of(AREA_FOOTPRINT);
            assert!((ratio * off_axis.powi(3) / slant - 1.0).abs() < 1.0e-4, "{ratio}");
        }
        // The trapezoid that is seen: x = 4 s / (1 + s / 2) for s = -0.8 and 0.8, heights 1.2 of the depths there.
        let edge = |s: f32| (4.0 * s / (1.0 - 0.5 * s), 4.0 / (1.0 - 0.5 * s));
        let ((x0, d0), (x1, d1)) = (edge(-0.8), edge(0.8));
        let slanted = (x1 - x0) / normal.z;
        let expected = slanted * 0.5 * 1.2 * (d0 + d1);
        // Midpoints of 40 columns: the integral's error is below 1 / 40^2.
        assert!((sum / expected - 1.0).abs() < 1.0e-3, "{sum} {expected}");
    }
}
