//! `denoise.guide` and `denoise.atrous`: an edge-stopping a-trous wavelet over the path-traced part [Dammertz et al. 2010],
//! guided by measured variance [Schied et al. 2017], as an exchange of light between pairs of pixels: what one gives the other
//! takes, so the image keeps its energy.
//!
//! Filtered is the light that arrives at collection points (direct and from behind). What a path saw before its point
//! stays: lights seen, highlights of mirrors, emission. Pairs are told by the features of their points, which
//! both read alike: another camera vertex, material or instance, another plane or direction, and nothing is exchanged.
//! Shadows have no edge in the features, so brightness is compared too, by what its noise is: the square of the difference over
//! the sum of both variances, in which both of a pair agree, hence the energy stays. A history of path-traced light knows the
//! variance of a pixel by its frames: the longer it is, the less is exchanged, and a sharp shadow is sharp again. Where
//! none does, the first level compares nothing and takes the variance of the pixels around.
//!
//! Cost: a level reads 64 bytes of itself and of 8 neighbours (600 B a pixel from caches, 64 from memory) and
//! writes 16; the guide reads 120 and writes 76. Limitations: without a history shadows blur by a pixel or two.

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

/// Smallest and largest factor of light that is divided out: their ratio is finite.
const SHARES: (f32, f32) = (1.0e-12, 1.0e12);
/// Reflectance of a coat at normal incidence: what a texture does not tint.
const COAT: f32 = 0.04;
/// Distance of a point from another's plane at which exchange ends (radii), and how it grows with the pixels between.
const PLANE: (f32, f32) = (1.0, 0.1);
/// Variances of a difference of brightness whose square quarters an exchange. Of 4 to 64 the error of `mirror-room` was least.
const NOISE: f32 = 16.0;

#[cfg(not(target_arch = "spirv"))]
/// See the head of the file.
pub const ATROUS: Denoiser = Denoiser {
    name: "atrous",
    description: "an edge-stopping wavelet, guided by collection points and measured variance; it keeps the energy",
    cost: "five levels of 64 bytes a pixel from memory and 600 from caches",
    limitations: "without --path-history shadows blur by a pixel or two",
    steps: |params| {
        let level = |level| Step::level(&LEVEL, level, params.pixel_count());
        std::iter::once(Step::new(&GUIDE, params)).chain((0..DENOISER_LEVELS).map(level)).collect()
    },
};

/// Features of the pixels, and the light that is filtered.
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

/// One level; even levels read `filter_light` and write `filter_next`, odd ones the other way; the last one writes `path_radiance`.
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

/// What a pixel starts with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterInput {
    /// Its features.
    pub guide: DenoiserGuide,
    /// Radiance that is filtered (W m^-2 sr^-1).
    pub light: Vec3,
    /// Radiance that is not (W m^-2 sr^-1).
    pub prefix: Vec3,
}

/// Splits a pixel's radiance, of which `prefix` came before its point, into what is filtered and what is not.
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
        // All of it stays, to the bit.
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

/// A number that no two kinds of surface share but with a probability of one in two thousand million.
#[inline(always)]
fn surface(depth: u32, instance: u32, material: u32) -> u32 {
    let hash = (instance.wrapping_mul(0x9e37_79b1) ^ depth).wrapping_mul(0x85eb_ca6b);
    ((hash ^ hash >> 15) ^ material.wrapping_mul(0xc2b2_ae35)) & (NONE >> 1)
}

/// One level: the light of a pixel after its exchange with 8 others, and the variance of its brightness,
/// l_i + sum k_j w_ij (l_j min(1, s_i / s_j) - l_i min(1, s_j / s_i)), s the shares of light at the point that are seen.
/// Each term is the negative of the other pixel's; where l is proportional to s all terms are 0; with k and w in [0, 1]
/// and sum k = 1 no light turns negative.
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

/// A variance that nobody knows.
const UNKNOWN: f32 = -1.0;
/// Weight of a pixel in its own mean.
const OWN: f32 = 0.25;

/// The variance of a mean of brightness, by what is known of the parts of that mean, or by how they differ.
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
    /// Of one pixel.
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

    /// With another pixel, of such a variance.
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

    /// The variance of the mean, as if its parts were independent.
    #[inline(always)]
    fn variance(&self) -> f32 {
        let own = 1.0 - self.weights;
        if self.own >= 0.0 {
            return own * own * self.own + self.variances;
        }
        // That of a part, by all parts with the weights of the kernel.
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

/// What a pixel would get from another less what it would give, were they alike.
#[inline(always)]
fn exchange(own: &DenoiserGuide, own_light: Vec3, other: &DenoiserGuide, light: Vec3) -> Vec3 {
    if (own.share - other.share).abs().element_sum() == 0.0 {
        // The same without divisions: most pairs of most scenes.
        return light - own_light;
    }
    let taken = light * (own.share / other.share).min(Vec3::ONE);
    let given = own_light * (other.share / own.share).min(Vec3::ONE);
    taken - given
}

/// How alike two points are, in [0, 1]; the same for both.
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

/// Brightness of the light at a point, whatever its share.
#[inline(always)]
fn brightness(light: Vec3, guide: &DenoiserGuide) -> f32 {
    light.element_sum() * guide.inverse_share
}

/// How alike two brightnesses are that differ so much, in [0, 1], by their variances; alike, where one is not known.
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
