//! Ray cones: the footprint of a pixel along its path [Akenine-Moller et al., JCGT 10(1) 2021]. The deterministic
//! part (width, spread) is signed, so that it may focus; roughness adds a spread of its own, in quadrature.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::math::{INV_PI, max_abs};
use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// A cone around a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayCone {
    /// Signed width at the ray's start (m).
    pub width: f32,
    /// Signed growth of the width (rad).
    pub spread: f32,
    /// Width from rough scattering, a standard deviation (m).
    pub rough_width: f32,
    /// Spread from rough scattering, a standard deviation (rad).
    pub rough_spread: f32,
    /// Whether a curved surface has distorted it.
    pub is_distorted: bool,
}

/// Smallest cosine that footprints are projected with.
const MIN_COS: f32 = 0.05;
/// Maximum width of a collection point's footprint, relative to that of a direct view.
const MAX_FOOTPRINT_WIDENING: f32 = 32.0;
/// Minimum width behind a curved surface, relative to that of a direct view.
const MIN_FOOTPRINT_WIDENING: f32 = 0.25;

impl RayCone {
    /// The cone of a pixel at the eye.
    #[inline]
    pub const fn at_eye(pixel_spread: f32) -> Self {
        RayCone { width: 0.0, spread: pixel_spread, rough_width: 0.0, rough_spread: 0.0, is_distorted: false }
    }

    /// The cone after `distance` (m).
    #[inline]
    pub fn advance(self, distance: f32) -> Self {
        RayCone {
            width: self.width + self.spread * distance,
            rough_width: self.rough_width + self.rough_spread * distance,
            ..self
        }
    }

    /// The cone after reflection at signed curvature [1/m] (positive where the side met is convex).
    #[shared]
    pub fn reflect(self, curvature: f32, cos: f32) -> Self {
        let cos = cos.max(MIN_COS);
        RayCone {
            spread: self.spread + 2.0 * curvature * self.width / cos,
            is_distorted: self.is_distorted || curvature != 0.0,
            ..self
        }
    }

    /// The cone after refraction; `eta` = index before / index behind, cosines before and behind.
    #[shared]
    pub fn refract(self, curvature: f32, cos: f32, cos_behind: f32, eta: f32) -> Self {
        let (cos, cos_behind) = (cos.max(MIN_COS), cos_behind.max(MIN_COS));
        let surface_spread = curvature * self.width / cos;
        RayCone {
            width: self.width * cos_behind / cos,
            spread: eta * cos / cos_behind * (self.spread + surface_spread) - surface_spread,
            rough_spread: eta * self.rough_spread,
            is_distorted: self.is_distorted || curvature != 0.0,
            ..self
        }
    }

    /// The cone after a lobe of this perceptual roughness: lobe spread sqrt(0.5 s / (1 - s)), s = min(r^4, 0.99).
    #[inline]
    pub fn roughen(self, roughness: f32) -> Self {
        RayCone {
            rough_spread: (self.rough_spread * self.rough_spread + lobe_variance(roughness)).sqrt(),
            ..self
        }
    }

    /// The cone after refraction by rough facets. A facet tilted by a small angle turns reflected directions by twice that angle,
    /// and refracted ones by |1 - eta| times it.
    #[inline]
    pub fn roughen_refracted(self, roughness: f32, eta: f32) -> Self {
        let turn = 0.5 * (1.0 - eta);
        let lobe = turn * turn * lobe_variance(roughness);
        RayCone { rough_spread: (self.rough_spread * self.rough_spread + lobe).sqrt(), ..self }
    }

    /// Width (m) of the cone, from both spreads.
    #[inline]
    pub fn total_width(self) -> f32 {
        (self.width * self.width + self.rough_width * self.rough_width).sqrt()
    }

    /// Radius (m) of the disc whose area is the cone's footprint on a surface met at `cos`, times `radius_px`. It is never below
    /// 4 ulp of the position's largest coordinate.
    ///
    /// The first derivative of convex mirrors and lenses widens a cone without end at grazing angles. The width is therefore at
    /// most 32 times `direct_width` (m), the width of a cone that came straight. A thousand times the area is a thousand times
    /// the photons.
    ///
    /// Mirrors and lenses also focus a cone, in this one number to a point, although the pixel's footprint shrinks to a line
    /// there at most. A photon on a disc without area would be infinitely bright, so behind a curved surface the width is at
    /// least a quarter of `direct_width`. Both bounds apply before `radius_px` scales the width. Width from roughness has no
    /// bound.
    #[shared]
    pub fn radius(self, cos: f32, radius_px: f32, position: Vec3, direct_width: f32) -> f32 {
        let min_width = if self.is_distorted { direct_width * MIN_FOOTPRINT_WIDENING } else { 0.0 };
        let width = self.width.abs().max(min_width).min(direct_width * MAX_FOOTPRINT_WIDENING);
        let total = (width * width + self.rough_width * self.rough_width).sqrt();
        let radius = radius_px * total * (INV_PI / cos.abs().max(MIN_COS)).sqrt();
        // An ulp is at most 2^-23 of the coordinate. The last term keeps the radius of a point at the origin above 0.
        radius.max(max_abs(position) * (4.0 / 8_388_608.0)).max(1.0e-30)
    }
}

/// Variance of a mirrored direction (rad^2) at this perceptual roughness.
#[inline]
pub fn lobe_variance(roughness: f32) -> f32 {
    let square = roughness * roughness;
    let s = (square * square).min(0.99);
    0.5 * s / (1.0 - s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_seen_straight_has_the_pixels_area() {
        let cone = RayCone::at_eye(0.01).advance(2.0);
        let radius = cone.radius(1.0, 1.0, Vec3::ZERO, 0.02);
        assert!((core::f32::consts::PI * radius * radius - 0.02 * 0.02).abs() < 1e-9);
    }

    #[test]
    fn a_plane_mirror_changes_nothing_and_a_flat_slab_narrows_the_spread() {
        let cone = RayCone::at_eye(0.01).advance(2.0);
        assert_eq!(cone.reflect(0.0, 0.7), cone);
        let inside = cone.refract(0.0, 1.0, 1.0, 1.0 / 1.5);
        assert!((inside.spread - 0.01 / 1.5).abs() < 1e-8 && inside.width == cone.width);
    }

    #[test]
    fn a_concave_mirror_focuses_at_half_its_radius() {
        // Parallel cone of width 0.1 onto a concave mirror of radius 2: width 0 after 1 m.
        let cone =
            RayCone { width: 0.1, spread: 0.0, rough_width: 0.0, rough_spread: 0.0, is_distorted: true };
        assert!(cone.reflect(-0.5, 1.0).advance(1.0).width.abs() < 1e-7);
    }

    #[test]
    fn a_disc_is_at_most_32_times_as_wide_as_in_a_direct_view() {
        let at = |width| {
            let cone =
                RayCone { width, spread: 0.0, rough_width: 0.0, rough_spread: 0.0, is_distorted: false };
            cone.radius(1.0, 1.0, Vec3::ZERO, 0.01)
        };
        let direct = at(0.01);
        for (width, factor) in [(0.001, 0.1), (-0.03, 3.0), (1.0e4, 32.0)] {
            assert!((at(width) / direct - factor).abs() < 1.0e-6, "{width}");
        }
    }

    /// Behind a concave mirror of radius 2 m the width passes through zero and grows again; behind planes it has no lower bound.
    #[test]
    fn a_disc_behind_a_curved_surface_is_at_least_a_quarter_as_wide_as_in_a_direct_view() {
        let radius = |cone: RayCone, radius_px| cone.radius(1.0, radius_px, Vec3::ZERO, 0.01);
        let direct = radius(RayCone::at_eye(0.01).advance(1.0), 1.0);
        let wide = RayCone { width: 0.02, ..RayCone::at_eye(0.0) };
        let mirrored = wide.reflect(-0.5, 1.0);
        let mut min_width = f32::MAX;
        for step in 0..=200 {
            let cone = mirrored.advance(0.01 * step as f32);
            let expected = cone.width.abs().max(0.25 * 0.01) / 0.01;
            for radius_px in [1.0, 0.01] {
                let found = radius(cone, radius_px) / (radius_px * direct);
                assert!((found - expected).abs() < 1.0e-5, "{step}: {found} {expected}");
                min_width = min_width.min(found);
            }
            assert!(
                radius(cone.refract(0.0, 1.0, 1.0, 0.7), 1.0) >= 0.2499 * direct,
                "a plane forgets nothing"
            );
        }
        assert!((min_width - 0.25).abs() < 1.0e-5, "the test has lost its subject: {min_width}");
        // A plane mirror or a slab, of any index and at any angle, does not widen a narrow cone.
        let narrow = RayCone { width: 0.001, ..RayCone::at_eye(0.0) };
        let planes = [narrow, narrow.reflect(0.0, 0.3), narrow.refract(0.0, 0.6, 0.6, 0.4)];
        assert!(planes.iter().all(|cone| (radius(*cone, 1.0) / direct - 0.1).abs() < 1.0e-6));
    }

    #[test]
    fn roughness_survives_a_focus() {
        let cone =
            RayCone { width: 0.1, spread: 0.0, rough_width: 0.0, rough_spread: 0.0, is_distorted: true };
        let rough = cone.reflect(-0.5, 1.0).roughen(0.3).advance(1.0);
        assert!(rough.radius(1.0, 1.0, Vec3::ZERO, 1.0e-3) > 0.01);
    }
}
