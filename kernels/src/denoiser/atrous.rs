//! `denoise.guide` and `denoise.atrous`: an edge-stopping a-trous wavelet filter of path-traced light [Dammertz et al. 2010],
//! guided by measured variance [Schied et al. 2017]. Pairs of pixels exchange light: one takes exactly the light that the other
//! gives, so the image keeps its energy.
//!
//! The filter smooths light that arrives at collection points (direct and from the camera suffix). Light that a path met before
//! its point stays: lights seen, highlights of mirrors, emission. The features of two points decide about their exchange, and
//! both pixels read them alike. There is no exchange with another camera vertex, material or instance, or with another plane or
//! direction.
//!
//! Shadows have no edge in the features, so the filter also compares brightness, relative to its noise. The measure is the
//! square of the difference over the sum of both variances. It is symmetric, so the energy stays. A history of path-traced light
//! knows a pixel's variance from its frames, or from the changes between few of them. The longer the history, the less is
//! exchanged, and a sharp shadow is sharp again. Without a history, the first level compares no brightness and estimates the
//! variance from the pixels around.
//!
//! Cost: a level reads 64 bytes of itself and of 8 neighbours (600 B a pixel from caches, 64 from memory) and writes 16. The
//! guide reads 120 and writes 76. Limitations: without a history shadows blur by a pixel or two.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{Denoiser, Step};
use crate::interface::NONE;
use crate::interface::denoiser::{DENOISER_LEVELS, DenoiserGuide};
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::material::{FLAG_COLOR_TEXTURE, Material};
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::is_finite;
use crate::platform::Slots;
use crate::surface::textured::material_of;
use spirv_std::glam::{Vec3, Vec4};

/// Bounds of the factor that light is divided by, so that ratios of two factors are finite.
const SHARES: (f32, f32) = (1.0e-12, 1.0e12);
/// Reflectance of a coat at normal incidence, which no texture tints.
const COAT: f32 = 0.04;
/// Distance of a point from another's plane at which exchange ends (radii), and its increase per pixel of distance.
const PLANE: (f32, f32) = (1.0, 0.1);
/// Square of a difference of brightness, in variances, that quarters an exchange. Of 4 to 64, this gave the smallest error of
/// `mirror-room`.
const NOISE: f32 = 16.0;

#[cfg(not(target_arch = "spirv"))]
/// Edge-stopping wavelet filter of the path-traced part.
pub const ATROUS: Denoiser = Denoiser {
    name: "atrous",
    description: "edge-stopping wavelet, guided by collection points and measured variance; keeps the energy",
    cost: "five levels of 64 bytes a pixel from memory and 600 from caches",
    limitations: "without --path-history shadows blur by a pixel or two",
    steps: |params| {
        let level = |level| Step::level(&LEVEL, level, params.pixel_count());
        std::iter::once(Step::new(&GUIDE, params)).chain((0..DENOISER_LEVELS).map(level)).collect()
    },
};

/// Computes the features of a pixel, and the light to be filtered.
#[pass(name = "denoise.guide", over = params.pixel_count(), work = Denoiser)]
pub fn guide(
    pixel: u32,
    features: Features,
    path_radiance: &[Vec3],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    materials: &[Material],
    #[len = params.pixel_count()] path_noise: &[f32],
    mut prefix_radiance: Slots<'_, Vec3>,
    mut filter_guides: Slots<'_, DenoiserGuide>,
    mut filter_light: Slots<'_, Vec4>,
) {
    let i = pixel as usize;
    let (radiance, prefix) = (path_radiance[i], prefix_radiance.read(pixel));
    let start = start(radiance, prefix, &point_geometry[i], &point_shading[i], materials, features);
    let mut variance = UNKNOWN;
    if path_noise[i] > 0.0 {
        let brightness = brightness(start.light, &start.guide);
        variance = (path_noise[i] - 1.0) * brightness * brightness;
    }
    prefix_radiance.write(pixel, start.prefix);
    filter_guides.write(pixel, start.guide);
    filter_light.write(pixel, start.light.extend(variance));
}

/// Runs one level. Even levels read `filter_light` and write `filter_next`, odd levels the other way. The last one writes
/// `path_radiance`.
#[pass(name = "denoise.atrous", over = params.pixel_count(), work = Denoiser)]
pub fn level(
    pixel: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    filter_guides: &[DenoiserGuide],
    prefix_radiance: &[Vec3],
    mut filter_light: Slots<'_, Vec4>,
    mut filter_next: Slots<'_, Vec4>,
    mut path_radiance: Slots<'_, Vec3>,
) {
    let number = dispatch.level;
    if !number.is_multiple_of(2) {
        filter_light.write(pixel, smoothed(pixel, number, params, filter_guides, &filter_next));
        return;
    }
    let light = smoothed(pixel, number, params, filter_guides, &filter_light);
    if number + 1 < DENOISER_LEVELS {
        filter_next.write(pixel, light);
    } else {
        path_radiance.write(pixel, prefix_radiance[pixel as usize] + light.truncate());
    }
}

/// Input of the filter at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterInput {
    /// Features.
    pub guide: DenoiserGuide,
    /// Radiance to be filtered (W m^-2 sr^-1).
    pub light: Vec3,
    /// Radiance that stays as it is (W m^-2 sr^-1).
    pub prefix: Vec3,
}

/// Splits a pixel's radiance into a filtered and an unfiltered part; `prefix` is its radiance from before its point.
#[inline(always)]
pub fn start(
    radiance: Vec3,
    prefix: Vec3,
    point: &PointGeometry,
    shading: &PointShading,
    materials: &[Material],
    features: Features,
) -> FilterInput {
    let light = radiance - prefix;
    let carried = shading.throughput.element_sum();
    if !point.exists() || !is_finite(light.element_sum()) || !is_finite(carried) {
        // Keep all of it, to the bit.
        let guide = DenoiserGuide { surface: NONE, ..DenoiserGuide::default() };
        return FilterInput { guide, light: Vec3::ZERO, prefix: radiance };
    }
    let mut share = shading.throughput;
    let material = material_of(shading, materials, features);
    if material.flags & FLAG_COLOR_TEXTURE != 0 {
        share *= material.base_color + Vec3::splat(COAT * material.specular);
    }
    let share = share.clamp(Vec3::splat(SHARES.0), Vec3::splat(SHARES.1));
    let guide = DenoiserGuide {
        position: point.position,
        radius: point.radius,
        normal: point.normal,
        surface: surface(point.depth, shading.instance, shading.material),
        share,
        inverse_share: 1.0 / share.element_sum(),
    };
    FilterInput { guide, light, prefix }
}

/// Hash of a kind of surface; two kinds share it with a probability of one in two thousand million.
#[inline(always)]
fn surface(depth: u32, instance: u32, material: u32) -> u32 {
    let hash = (instance.wrapping_mul(0x9e37_79b1) ^ depth).wrapping_mul(0x85eb_ca6b);
    ((hash ^ hash >> 15) ^ material.wrapping_mul(0xc2b2_ae35)) & (NONE >> 1)
}

/// Runs one level: returns the light of a pixel after its exchange with 8 others, and the variance of its brightness.
///
/// The light is `l_i + sum k_j w_ij (l_j min(1, s_i / s_j) - l_i min(1, s_j / s_i))`, with s the seen share of light at the
/// point. Each term is the negative of the other pixel's. All terms are 0 where l is proportional to s. With k and w in [0, 1]
/// and sum k = 1, no light turns negative.
#[inline(always)]
pub fn smoothed(
    pixel: u32,
    number: u32,
    params: &FrameParams,
    guides: &[DenoiserGuide],
    light: &Slots<'_, Vec4>,
) -> Vec4 {
    let own = light.read(pixel);
    let guide = guides[pixel as usize];
    if guide.surface == NONE {
        return own;
    }
    let step = 1 << number;
    let (width, height) = (params.width as i32, params.height as i32);
    let (column, row) = ((pixel % params.width) as i32, (pixel / params.width) as i32);
    let own_brightness = brightness(own.truncate(), &guide);
    let mut sum = Vec3::ZERO;
    let mut noise = Noise::new(own.w, own_brightness);
    let mut dy = -1;
    while dy <= 1 {
        let y = row + dy * step;
        let mut dx = -1;
        while dx <= 1 {
            let x = column + dx * step;
            let inside = x >= 0 && y >= 0 && x < width && y < height;
            if inside && (dx != 0 || dy != 0) {
                let other = (y * width + x) as u32;
                let other_guide = &guides[other as usize];
                let mut weight = likeness(&guide, other_guide, step as f32);
                if weight > 0.0 {
                    let other = light.read(other);
                    let brightness = brightness(other.truncate(), other_guide);
                    weight *= spline(dx) * spline(dy) * evenness(own_brightness - brightness, own.w, other.w);
                    noise.add(weight, brightness, other.w);
                    sum += exchange(&guide, own.truncate(), other_guide, other.truncate()) * weight;
                }
            }
            dx += 1;
        }
        dy += 1;
    }
    (own.truncate() + sum).extend(noise.variance())
}

/// Marks an unknown variance.
const UNKNOWN: f32 = -1.0;
/// Weight of a pixel in its own mean.
const OWN: f32 = 0.25;

/// Variance of a mean of brightness: from the variances of the parts of that mean, or from the differences of the parts.
struct Noise {
    own: f32,
    own_brightness: f32,
    /// Sum of weights of other pixels, and of their squares.
    weights: f32,
    squares: f32,
    /// Sum of squared weights times variances.
    variances: f32,
    /// Sums of weights times differences of brightness, and times their squares.
    differences: f32,
    square_differences: f32,
}

impl Noise {
    /// Starts with one pixel.
    #[inline(always)]
    fn new(own: f32, own_brightness: f32) -> Noise {
        Noise {
            own,
            own_brightness,
            weights: 0.0,
            squares: 0.0,
            variances: 0.0,
            differences: 0.0,
            square_differences: 0.0,
        }
    }

    /// Adds another pixel with its variance.
    #[inline(always)]
    fn add(&mut self, weight: f32, brightness: f32, variance: f32) {
        let variance = if variance < 0.0 { self.own } else { variance };
        let difference = brightness - self.own_brightness;
        self.weights += weight;
        self.squares += weight * weight;
        self.variances += weight * weight * variance;
        self.differences += weight * difference;
        self.square_differences += weight * difference * difference;
    }

    /// Variance of the mean, for independent parts.
    #[inline(always)]
    fn variance(&self) -> f32 {
        let own = 1.0 - self.weights;
        if self.own >= 0.0 {
            return own * own * self.own + self.variances;
        }
        // Estimate the variance of a part from all parts, with the weights of the kernel.
        let all = OWN + self.weights;
        let share = (OWN * OWN + self.squares) / (all * all);
        if share >= 1.0 {
            return UNKNOWN;
        }
        let mean = self.differences / all;
        let of_one = (self.square_differences / all - mean * mean).max(0.0) / (1.0 - share);
        of_one * (own * own + self.squares)
    }
}

/// Light that a pixel takes from another less the light that it gives, before weighting.
#[inline(always)]
fn exchange(own: &DenoiserGuide, own_light: Vec3, other: &DenoiserGuide, light: Vec3) -> Vec3 {
    if (own.share - other.share).abs().element_sum() == 0.0 {
        // Most pairs of most scenes have equal shares: do without divisions.
        return light - own_light;
    }
    let taken = light * (own.share / other.share).min(Vec3::ONE);
    let given = own_light * (other.share / own.share).min(Vec3::ONE);
    taken - given
}

/// Likeness of two points, in [0, 1]; symmetric.
#[inline(always)]
pub fn likeness(a: &DenoiserGuide, b: &DenoiserGuide, step: f32) -> f32 {
    if a.surface != b.surface {
        return 0.0;
    }
    let cos = a.normal.dot(b.normal);
    if cos <= 0.0 {
        return 0.0;
    }
    let along = b.position - a.position;
    let off = along.dot(a.normal).abs() + along.dot(b.normal).abs();
    let bound = (a.radius + b.radius) * (PLANE.0 + PLANE.1 * step);
    let x = 1.0 - off / bound;
    if x <= 0.0 {
        return 0.0;
    }
    // cos^64.
    let c2 = cos * cos;
    let c4 = c2 * c2;
    let c8 = c4 * c4;
    let c16 = c8 * c8;
    let c32 = c16 * c16;
    (x * c32 * c32).min(1.0)
}

/// Brightness of the light at a point, independent of the point's share.
#[inline(always)]
fn brightness(light: Vec3, guide: &DenoiserGuide) -> f32 {
    light.element_sum() * guide.inverse_share
}

/// Likeness of two brightnesses, in [0, 1], by their difference and their variances; 1 if a variance is unknown.
#[inline(always)]
fn evenness(difference: f32, a: f32, b: f32) -> f32 {
    let square = difference * difference;
    if square <= 0.0 || a < 0.0 || b < 0.0 {
        return 1.0;
    }
    let noise = (NOISE * (a + b)).min(f32::MAX);
    let y = noise / (noise + square);
    y * y
}

/// The linear B-spline at the integers.
#[inline(always)]
fn spline(d: i32) -> f32 {
    if d == 0 { 0.5 } else { 0.25 }
}
