//! One scattering event: from a vertex and the media around it to the ray that leaves.

use crate::interface::features::Features;
use crate::interface::material::Material;
use crate::interface::ray::Ray;
use crate::math::frame::ShadingFrame;
use crate::math::offset;
use crate::surface::class::Classes;
use crate::surface::dispersion::{Channel, Indices};
use crate::surface::hemisphere::flip_to_geometric_hemisphere;
use crate::surface::media::MediaStack;
use crate::surface::vertex::Vertex;
use crate::surface::{Bsdf, DielectricInterface, Evaluated, Sampled, ggx};
use spirv_std::glam::{Vec3, Vec4};

/// Vertex that is about to scatter.
#[derive(Clone, Copy, Debug)]
pub struct ScatteringVertex {
    /// The vertex.
    pub vertex: Vertex,
    /// Its lobes.
    pub bsdf: Bsdf,
    frame: ShadingFrame,
    dielectric: DielectricInterface,
    media: MediaStack,
    behind: MediaStack,
    media_overflow: bool,
}

/// Ray that leaves a scattering event.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// The ray; its direction is a unit vector in the world.
    pub ray: Ray,
    /// How it was sampled. A zero weight ends the path.
    pub sampled: Sampled,
    /// Media around the ray.
    pub media: MediaStack,
    /// Whether the stack of media overflowed here.
    pub media_overflow: bool,
}

impl ScatteringVertex {
    /// Scattering at `vertex`, inside `media`, with the lobes of `classes`. The path carries `throughput` (up to a factor), and
    /// `channel` alone where a rough face disperses (`needs_channel`). `divides` as for [`Bsdf::new`].
    #[inline(always)]
    pub fn new(
        vertex: Vertex,
        material: Material,
        materials: &[Material],
        media: MediaStack,
        throughput: Vec3,
        channel: Channel,
        classes: Classes,
        divides: bool,
        specular_roughness: f32,
        features: Features,
    ) -> Self {
        let frame = ShadingFrame::new(vertex.shading_normal);
        // Find the media on both sides, and the ratio of their indices of refraction
        let mut indices = Indices::new(1.0);
        let around = media.settled(features, materials);
        let (mut media, mut behind, mut media_overflow) = (around, around, false);
        if features.has(Features::DIELECTRIC) && materials[vertex.material as usize].is_medium() {
            let sides = around.at_face(vertex.material, vertex.front, features, materials);
            (media, behind, media_overflow) = (sides.before, sides.behind, sides.overflow);
            let smooth = material.roughness < ggx::DELTA_ROUGHNESS;
            if features.has(Features::DISPERSION)
                && smooth
                && (media.disperses(materials) || behind.disperses(materials))
            {
                indices = Indices::dispersive(media, behind, throughput, features, materials);
            } else {
                let eta = media.ior(channel, features, materials) / behind.ior(channel, features, materials);
                indices = Indices::new(eta);
            }
        }
        // Make the BSDF; paths come from above the face.
        let to_previous = flip_to_geometric_hemisphere(frame.to_local(vertex.to_previous), true);
        let (bsdf, dielectric) =
            Bsdf::new(material, to_previous, indices, specular_roughness, classes, divides, features);
        ScatteringVertex { vertex, bsdf, frame, dielectric, media, behind, media_overflow }
    }

    /// Evaluates the non-delta lobes of `class` in a world direction.
    #[inline(always)]
    pub fn eval(&self, direction: Vec3, class: Classes) -> Evaluated {
        let above = direction.dot(self.vertex.face_normal) > 0.0;
        self.bsdf.eval(flip_to_geometric_hemisphere(self.frame.to_local(direction), above), class)
    }

    /// Media on the side to which a world direction leaves.
    #[inline(always)]
    pub fn media_towards(&self, direction: Vec3) -> MediaStack {
        if direction.dot(self.vertex.face_normal) < 0.0 { self.behind } else { self.media }
    }

    /// Samples a lobe. Returns the ray that leaves.
    #[inline(always)]
    pub fn sample(&self, u: Vec4) -> BsdfSample {
        let sampled = self.bsdf.sample(self.dielectric, u);
        let vertex = &self.vertex;
        let mut direction =
            if sampled.straight { -vertex.to_previous } else { self.frame.to_world(sampled.direction) };
        // Flip the direction to the side of the face that the lobe scatters to
        if (direction.dot(vertex.face_normal) > 0.0) == sampled.transmitted {
            direction = -direction;
        }
        let media = if sampled.transmitted { self.behind } else { self.media };
        let media_overflow = sampled.transmitted && self.media_overflow;
        let origin = offset::leave(vertex.position, vertex.face_normal, direction, vertex.clearance);
        BsdfSample { ray: Ray::endless(origin, direction), sampled, media, media_overflow }
    }
}
