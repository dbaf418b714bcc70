//! Warps from the unit square to the sets that light transport samples, with their pdfs.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::math::trig::sin_cos_turns;
use crate::math::{INV_PI, clamp};
use caustics_kernel_macros::shared;
use spirv_std::glam::{Vec2, Vec3};

/// Uniform direction; pdf_solid_angle = 1 / (4 pi).
#[inline]
pub fn uniform_sphere(u: f32, v: f32) -> Vec3 {
    let z = 1.0 - 2.0 * u;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    Vec3::new(r * cos, r * sin, z)
}

/// Uniform direction around z, with 1 - cos of the angle up to `versine`; pdf_solid_angle = 1 / (2 pi versine). Angles are stored
/// as 1 - cos: for a narrow cone, cosines near 1 have few bits.
#[shared]
pub fn uniform_cone(versine: f32, u: f32, v: f32) -> Vec3 {
    let from_axis = u * versine;
    let sin = (from_axis * (2.0 - from_axis)).max(0.0).sqrt();
    let (y, x) = sin_cos_turns(v);
    Vec3::new(sin * x, sin * y, 1.0 - from_axis)
}

/// Cosine-distributed direction around z; pdf_solid_angle = `cosine_hemisphere_pdf(z)`.
#[inline]
pub fn cosine_hemisphere(u: f32, v: f32) -> Vec3 {
    let r = u.sqrt();
    let (sin, cos) = sin_cos_turns(v);
    Vec3::new(r * cos, r * sin, (1.0 - u).sqrt())
}

/// pdf_solid_angle of `cosine_hemisphere`.
#[inline]
pub fn cosine_hemisphere_pdf(cos: f32) -> f32 {
    cos.max(0.0) * INV_PI
}

/// Barycentric weights (of corners b and c) of a uniform point on a triangle; pdf_area = 1 / area.
#[shared]
pub fn uniform_triangle(u: f32, v: f32) -> Vec2 {
    let root = u.sqrt();
    Vec2::new(root * (1.0 - v), root * v)
}

/// Visible microfacet normal of GGX of width `alpha` seen from `to_viewer` (local, z > 0), by a uniform spherical
/// cap [Dupuy and Benyoub 2023].
#[inline]
pub fn visible_ggx_normal(to_viewer: Vec3, alpha: f32, u: f32, v: f32) -> Vec3 {
    let stretched = Vec3::new(alpha * to_viewer.x, alpha * to_viewer.y, to_viewer.z).normalize();
    let z = (1.0 - u) * (1.0 + stretched.z) - stretched.z;
    let r = clamp(1.0 - z * z, 0.0, 1.0).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    let cap = Vec3::new(r * cos, r * sin, z) + stretched;
    Vec3::new(alpha * cap.x, alpha * cap.y, cap.z.max(0.0)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::*;

    fn samples() -> impl Iterator<Item = (f32, f32)> {
        (0..200_000).map(|path| {
            let u = Rng::new(Stream::Light, 5, path, 0).next4();
            (u.x, u.y)
        })
    }

    #[test]
    fn the_sphere_is_uniform() {
        let n = 200_000.0f64;
        let (mut mean, mut second) = (Vec3::ZERO, Vec3::ZERO);
        for (u, v) in samples() {
            let d = uniform_sphere(u, v);
            assert!((d.length() - 1.0).abs() < 1e-5);
            mean += d;
            second += d * d;
        }
        // Each coordinate is uniform in [-1, 1]: variance 1/3, fourth moment 1/5.
        for component in 0..3 {
            assert!(f64::from(mean[component]).abs() / n < 4.0 * (1.0 / (3.0 * n)).sqrt());
            assert!(
                (f64::from(second[component]) / n - 1.0 / 3.0).abs() < 4.0 * (4.0 / (45.0 * n)).sqrt() + 1e-4
            );
        }
    }

    #[test]
    fn the_hemisphere_follows_the_cosine() {
        // Under a cosine pdf, cos^2 is uniform in [0, 1].
        let mut bins = [0u32; 20];
        for (u, v) in samples() {
            let d = cosine_hemisphere(u, v);
            bins[((d.z * d.z * 20.0) as usize).min(19)] += 1;
        }
        let expected = 10_000.0f64;
        let chi_square: f64 = bins.iter().map(|&b| (f64::from(b) - expected).powi(2) / expected).sum();
        assert!(chi_square < 43.8, "chi-square of 19 degrees of freedom beyond 0.1 %: {chi_square}");
    }

    #[test]
    fn the_triangle_is_uniform() {
        // The four congruent sub-triangles of the midpoints hold a quarter each.
        let mut bins = [0u32; 4];
        for (u, v) in samples() {
            let b = uniform_triangle(u, v);
            assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0 + 1e-6);
            let corner = if b.x > 0.5 {
                0
            } else if b.y > 0.5 {
                1
            } else if b.x + b.y < 0.5 {
                2
            } else {
                3
            };
            bins[corner] += 1;
        }
        for bin in bins {
            assert!((f64::from(bin) - 50_000.0).abs() < 4.0 * (200_000.0f64 * 0.25 * 0.75).sqrt());
        }
    }
}
