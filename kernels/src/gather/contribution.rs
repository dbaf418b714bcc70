//! Photon density estimation at a collection point [Jensen 1996]: finds the photons in its disc, and evaluates BSDF times flux of
//! each. `resolve` divides the sum by the area of the disc, pi R^2.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::material::Material;
use crate::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use crate::math::frame::ShadingFrame;
use crate::math::max_abs;
use crate::surface::class::Classes;
use crate::surface::dispersion::Indices;
use crate::surface::hemisphere::flip_to_geometric_hemisphere;
use crate::surface::{Bsdf, albedo};
use spirv_std::glam::Vec3;

/// Smallest cosine between the normals of a point and of a photon that it takes.
pub const MIN_NORMAL_COS: f32 = 0.9;
/// Half thickness of a point's disc, relative to its radius.
pub const DISC_THICKNESS: f32 = 0.1;

/// Whether `point` takes `photon`. The photon lies in the disc, on the same side of the same surface. Camera path and light path
/// together stay within `max_bounces`.
#[inline(always)]
pub fn takes(point: &PointGeometry, photon: &PhotonGeometry, max_bounces: u32) -> bool {
    let along = photon.position - point.position;
    point.exists()
        && along.length_squared() <= point.radius * point.radius
        && is_same_surface(along, point.normal, photon.normal, point.radius)
        && point.depth + photon.scatterings <= max_bounces
}

/// Whether two positions, `along` apart, lie on the same side of one surface: within a slab across the mean of both normals. The
/// slab's half thickness is `DISC_THICKNESS` times the radius (m).
#[inline(always)]
pub fn is_same_surface(along: Vec3, normal: Vec3, other_normal: Vec3, radius: f32) -> bool {
    let normals = normal + other_normal;
    let height = along.dot(normals);
    let limit = DISC_THICKNESS * radius;
    // Compare squares: |height| <= 0.1 R |n_x + n_y| needs no root.
    normal.dot(other_normal) > MIN_NORMAL_COS && height * height <= limit * limit * normals.length_squared()
}

/// Collection point as photons meet it: its BSDF in its shading frame, the same for all photons.
#[derive(Clone, Copy, Debug, Default)]
pub struct Receiver {
    frame: ShadingFrame,
    surface: Bsdf,
}

impl Receiver {
    /// Receiver of a point and its material.
    #[inline(always)]
    pub fn new(
        shading: &PointShading,
        material: Material,
        specular_roughness: f32,
        features: Features,
    ) -> Receiver {
        let frame = ShadingFrame::new(shading.shading_normal);
        // The viewer is above the face.
        let to_viewer = flip_to_geometric_hemisphere(frame.to_local(shading.to_viewer), true);
        let classes = Classes::NON_SPECULAR;
        let indices = Indices::new(shading.eta);
        let (surface, _) =
            Bsdf::new(material, to_viewer, indices, specular_roughness, classes, false, features);
        Receiver { frame, surface }
    }

    /// Albedo of its diffuse lobes.
    #[inline(always)]
    pub fn diffuse_albedo(&self) -> Vec3 {
        albedo::diffuse(&self.surface)
    }

    /// Returns the contribution of a photon to the sum of a collection point (W/sr): f(viewer, light) Phi |n_s . w| / |n_g . w|, with
    /// `w` the direction to the light [Veach 1997, 5.3]. A photon brings Phi / |n_g . w| as its flux. With n_s = n_g it is f Phi, the
    /// summand of photon density estimation [Jensen 1996].
    #[inline(always)]
    pub fn contribution(&self, photon: &PhotonLight) -> Vec3 {
        // Photons arrive above the face
        let to_light = flip_to_geometric_hemisphere(self.frame.to_local(photon.to_light), true);
        self.surface.eval(to_light, Classes::NON_SPECULAR).f * photon.flux * to_light.z
    }
}

/// Returns BSDF times flux of a photon at a point: f(viewer, light) times its flux (W/sr).
#[inline(always)]
pub fn contribution(
    shading: &PointShading,
    material: Material,
    photon: &PhotonLight,
    specular_roughness: f32,
    features: Features,
) -> Vec3 {
    Receiver::new(shading, material, specular_roughness, features).contribution(photon)
}

/// Half extent (m) of a box that holds every photon a disc may take. The slab of `takes` is tilted by up to half the largest
/// angle between the normals (acos(0.9) / 2 = 12.9 degrees). So a photon may stand off the disc's own plane by R sin(asin(0.1) +
/// 12.9 degrees) = 0.32 R. The box is inflated by 4 ulp of the largest coordinate, for rounding.
#[inline(always)]
pub fn disc_half_extent(point: &PointGeometry) -> Vec3 {
    let normal = point.normal;
    let square = Vec3::ONE - normal * normal;
    let flat = Vec3::new(square.x.max(0.0).sqrt(), square.y.max(0.0).sqrt(), square.z.max(0.0).sqrt());
    let slack = (max_abs(point.position) + point.radius) * (4.0 * f32::EPSILON);
    (flat + normal.abs() * 0.33) * point.radius + Vec3::splat(slack)
}
