//! Fresnel reflectance: exact for dielectrics, Schlick's approximation for metals and coats.

use crate::math::clamp;
use spirv_std::glam::Vec3;
#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Schlick's weight (1 - cos)^5.
#[inline]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = clamp(1.0 - cos, 0.0, 1.0);
    let square = m * m;
    square * square * m
}

/// Schlick's approximation from the reflectance at normal incidence.
#[inline]
pub fn schlick(f0: Vec3, cos: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * schlick_weight(cos)
}

/// Fresnel reflectance of a dielectric, unpolarised (pbrt: `FrDielectric`, whose `eta` is the reciprocal): `eta` = index before / index
/// behind, `cos` before. 1 for total reflection.
#[inline]
pub fn dielectric_reflectance(cos: f32, eta: f32) -> f32 {
    let sin2_behind = eta * eta * (1.0 - cos * cos).max(0.0);
    if sin2_behind >= 1.0 {
        return 1.0;
    }
    let cos_behind = (1.0 - sin2_behind).sqrt();
    let s = (eta * cos - cos_behind) / (eta * cos + cos_behind);
    let p = (cos - eta * cos_behind) / (cos + eta * cos_behind);
    0.5 * (s * s + p * p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_reflects_4_percent_at_normal_incidence_and_all_at_grazing() {
        assert!((dielectric_reflectance(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        assert!((dielectric_reflectance(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((dielectric_reflectance(0.0, 1.0 / 1.5) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn brewster_angle_reflects_only_the_s_part() {
        let angle = 1.5f32.atan();
        let (n, c) = (1.5f32, angle.cos());
        let s = ((1.0 - n * n) / (1.0 + n * n)).powi(2);
        assert!((dielectric_reflectance(c, 1.0 / n) - 0.5 * s).abs() < 1e-6);
    }

    #[test]
    fn both_sides_reflect_alike_and_totally_beyond_the_critical_angle() {
        let cos = 0.8f32;
        let cos_behind = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
        assert!(
            (dielectric_reflectance(cos, 1.0 / 1.5) - dielectric_reflectance(cos_behind, 1.5)).abs() < 1e-6
        );
        assert_eq!(dielectric_reflectance(0.5, 1.5), 1.0);
    }
}
