//! Mathematics of light paths: random numbers, warps, frames, offsets, ray cones, the camera, sums in fixed point. Imports `interface`
//! and `platform` only.

pub mod cone;
pub mod differential;
pub mod face;
pub mod frame;
pub mod grid;
pub mod octahedral;
pub mod offset;
pub mod pencil;
pub mod pinhole;
pub mod quanta;
pub mod rng;
pub mod sampler;
pub mod spherical_triangle;
pub mod trig;
pub mod warp;

pub use core::f32::consts::PI;
/// 1 / pi.
pub const INV_PI: f32 = 1.0 / PI;
/// The largest number below one.
pub const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

use spirv_std::glam::Vec3;

/// Mean of the three channels.
#[inline]
pub fn mean(color: Vec3) -> f32 {
    (color.x + color.y + color.z) * (1.0 / 3.0)
}

/// MIS weight of the technique that sampled, by the balance heuristic [Veach and Guibas 1995, eq. 14], from the densities of both
/// techniques (same measure, `pdf` > 0).
#[inline(always)]
pub fn balance_heuristic(pdf: f32, other_pdf: f32) -> f32 {
    pdf / (pdf + other_pdf)
}

/// Largest of the three magnitudes.
#[inline]
pub fn max_abs(v: Vec3) -> f32 {
    larger(larger(v.x.abs(), v.y.abs()), v.z.abs())
}

/// Larger of two numbers, neither of them NaN: for NaN, `f32::max` costs two instructions more.
#[inline]
pub fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Limits `x` to `min` and `max`, with `min` <= `max`. The standard library's function may panic, so it cannot be `shared`.
#[inline]
pub fn clamp<T: PartialOrd>(x: T, min: T, max: T) -> T {
    if x < min {
        min
    } else if x > max {
        max
    } else {
        x
    }
}

/// Whether the value is neither infinite nor NaN, from its exponent bits (a GPU may fold `is_nan` away).
#[inline]
pub fn is_finite(value: f32) -> bool {
    value.to_bits() & 0x7f80_0000 != 0x7f80_0000
}
