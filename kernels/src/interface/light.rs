//! The light table: every emitter with its record of the alias table and its probability.

use crate::interface::features::Features;
use crate::interface::ray::Ray;
use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// One emitter: an emissive triangle, or a punctual light (KHR_lights_punctual).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Position of a point or spot light (m). For a directional light: centre of the disc that its paths start on (m), which lies
    /// before the whole scene. For an environment: middle of the scene (m). Unused by triangles.
    pub position: Vec3,
    /// Triangle id, or `NONE` for a punctual light.
    pub triangle: u32,
    /// Radiance of a triangle (W m^-2 sr^-1), or intensity of a point or spot light (W sr^-1). For a directional light:
    /// irradiance across it (W m^-2). For an environment: mean radiance (W m^-2 sr^-1); its texels have their own.
    pub emission: Vec3,
    /// Area of the triangle (m^2); 0 for a punctual light.
    pub area: f32,
    /// Probability of choosing this light: its share of the scene's power.
    pub pdf_light_choice: f32,
    /// Threshold of the alias table: keep this light if the second random number is below it, else take `alias`.
    pub threshold: f32,
    /// Other light of this record of the alias table.
    pub alias: u32,
    /// Sides that emit: 1 (front) or 2; 0 for a punctual light.
    pub sides: u32,
    /// Unit direction of a spot or of directional light; unit normal of a triangle's front; zero for others.
    pub direction: Vec3,
    /// Type: the bit of `Features` for lights of its type.
    pub kind: u32,
    /// 1 - cos of a spot's outer angle: its cone's solid angle over 2 pi (sr); 0 for others.
    pub cone: f32,
    /// 1 / (cos of the inner angle - cos of the outer) of a spot; 0 for others.
    pub falloff: f32,
    /// Radius of the disc that a directional light's paths start on (m); 0 for others.
    pub radius: f32,
    /// Share of the scene's power that the records before this one have.
    pub power_below: f32,
    /// Index of the triangle's instance; 0 for a punctual light.
    pub instance: u32,
    /// Distance to keep when leaving the triangle (m); 0 for others.
    pub clearance: f32,
    /// Position among all lights of the scene, whether they shine or not. It rises along the table. Where there are many lights,
    /// neighbours in space have keys close to each other.
    pub key: u32,
}

/// Calls a macro with the types of lights: files in `light/`, bits of `Features`, and names. A record whose kind is not that of
/// another type is an `area` light.
macro_rules! for_each_light {
    ($then:ident) => {
        $then! {
            /// Some triangle emits.
            area AREA_LIGHTS "area-lights";
            /// There is a point light.
            point POINT_LIGHTS "point-lights";
            /// There is a spot light.
            spot SPOT_LIGHTS "spot-lights";
            /// There is a directional light.
            directional DIRECTIONAL_LIGHTS "directional-lights";
            /// There is light from all around.
            environment ENVIRONMENT "environment";
        }
    };
}
pub(crate) use for_each_light;

impl Light {
    /// Whether its light is parallel: paths differ by their start positions, not by their directions.
    #[inline(always)]
    pub fn is_parallel(&self) -> bool {
        self.radius > 0.0
    }

    /// Whether its light comes from infinitely far away.
    #[inline(always)]
    pub fn is_endless(&self) -> bool {
        self.is_parallel() || self.kind == Features::ENVIRONMENT.0
    }

    /// Emission direction of a path: its direction, or for parallel light the offset from the middle of the disc to its start
    /// (m).
    #[inline(always)]
    pub fn emission_direction(&self, ray: &Ray) -> Vec3 {
        if self.is_parallel() { ray.origin - self.position } else { ray.direction }
    }
}

const _: () = assert!(size_of::<Light>() == 92);
