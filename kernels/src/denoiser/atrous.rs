//! `denoise.guide` and `denoise.atrous`: an edge-stopping a-trous wavelet over the path-traced part [Dammertz et al. 2010],
//! as an exchange of light between pairs of pixels: what one gives the other takes, so the picture keeps its energy.
//!
//! Filtered is the light that arrives at collection points (direct and from behind). What a path saw before its point
//! stays: lights seen, highlights of mirrors, emission. Pairs are told by the features of their points, which
//! both read alike: another camera vertex, material or instance, another plane or direction, and nothing is exchanged.
//! Shadows have no edge in the features, so levels from the third on also compare brightness. Both of a pair see one
//! contrast, hence the energy stays; and the first two levels, which do not compare, have spread every sample over 13
//! pixels a side by then: what is compared is no longer noise, and a rare bright sample does not stay alone.
//!
//! Cost: a level reads 60 bytes of itself and of 24 neighbours (1500 B a pixel from caches, 60 from memory) and
//! writes 12; the guide reads 120 and writes 72. Wrong: shadows blur by 2 pixels (standard deviation) and a bit more.

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
use crate::seam::Slots;
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Smallest and largest factor of light that is divided out: their ratio is finite.
const SHARES: (f32, f32) = (1.0e-12, 1.0e12);
/// Reflectance of a coat at normal incidence: what a texture does not tint.
const COAT: f32 = 0.04;
/// Distance of a point from another's plane at which exchange ends (radii), and how it grows with the pixels between.
const PLANE: (f32, f32) = (1.0, 0.1);
/// The first step that compares brightness (px).
const COMPARED_RADII: f32 = 4.0;
/// Square of the contrast (a - b) / (a + b) that quarters an exchange one pixel apart; it falls with the step, as noise
/// does with each level. Of 0.3 to 1 and falls of 0 to 1 the error of `mirror-room` and `glossy-room` was least.
const CONTRAST: f32 = 0.25;

#[cfg(not(target_arch = "spirv"))]
/// See the head of the file.
pub const ATROUS: Denoiser = Denoiser {
    name: "atrous",
    about: "an edge-stopping wavelet, guided by the collection points; it keeps the energy",
    cost: "five levels of 60 bytes a pixel from memory and 1500 from caches",
    wrong: "shadows blur by two pixels (standard deviation) and a bit more",
    steps: |params| {
        let level = |level| Step::level(&LEVEL, level, params.pixel_count());
        std::iter::once(Step::of(&GUIDE, params)).chain((0..DENOISER_LEVELS).map(level)).collect()
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
    mut seen_radiance: Slots<'_, Vec3>,
    mut filter_guides: Slots<'_, DenoiserGuide>,
    mut filter_light: Slots<'_, Vec3>,
) {
    let i = pixel as usize;
    let (radiance, seen) = (path_radiance[i], seen_radiance.read(pixel));
    let start = start(radiance, seen, &point_geometry[i], &point_shading[i], materials, features);
    seen_radiance.write(pixel, start.seen);
    filter_guides.write(pixel, start.guide);
    filter_light.write(pixel, start.light);
}

/// One level; even levels read `filter_light` and write `path_radiance`, odd ones the other way.
#[pass(name = "denoise.atrous", over = params.pixel_count(), work = Denoiser)]
pub fn level(
    pixel: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    filter_guides: &[DenoiserGuide],
    seen_radiance: &[Vec3],
    mut filter_light: Slots<'_, Vec3>,
    mut path_radiance: Slots<'_, Vec3>,
) {
    let number = dispatch.level;
    if number.is_multiple_of(2) {
        let mut light = smoothed(pixel, number, params, filter_guides, &filter_light);
        if number + 1 == DENOISER_LEVELS {
            light = seen_radiance[pixel as usize] + light;
        }
        path_radiance.write(pixel, light);
    } else {
        filter_light.write(pixel, smoothed(pixel, number, params, filter_guides, &path_radiance));
    }
}

/// What a pixel starts with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Its features.
    pub guide: DenoiserGuide,
    /// Radiance that is filtered (W m^-2 sr^-1).
    pub light: Vec3,
    /// Radiance that is not (W m^-2 sr^-1).
    pub seen: Vec3,
}

/// Splits a pixel's radiance, of which `seen` came before its point, into what is filtered and what is not.
#[inline(always)]
pub fn start(
    radiance: Vec3,
    seen: Vec3,
    point: &PointGeometry,
    shading: &PointShading,
    materials: &[Material],
    features: Features,
) -> Start {
    let light = radiance - seen;
    let carried = shading.throughput.element_sum();
    if !point.exists() || !is_finite(light.element_sum()) || !is_finite(carried) {
        // All of it stays, to the bit.
        let guide = DenoiserGuide { material: NONE, ..DenoiserGuide::default() };
        return Start { guide, light: Vec3::ZERO, seen: radiance };
    }
    let mut share = shading.throughput;
    let material = material_of(shading, materials, features);
    if material.flags & FLAG_COLOR_TEXTURE != 0 {
        share *= material.base_color + Vec3::splat(COAT * material.specular);
    }
    let guide = DenoiserGuide {
        position: point.position,
        radius: point.radius,
        normal: point.normal,
        material: shading.material,
        share: share.clamp(Vec3::splat(SHARES.0), Vec3::splat(SHARES.1)),
        place: point.depth | shading.instance << 8,
    };
    Start { guide, light, seen }
}

/// One level: the light of a pixel after its exchange with 24 others,
/// l_i + sum k_j w_ij (l_j min(1, s_i / s_j) - l_i min(1, s_j / s_i)), s the shares of light at the point that are seen.
/// Each term is the negative of the other pixel's; where l is proportional to s all terms are 0; with k and w in [0, 1]
/// and sum k = 1 no light turns negative.
#[inline(always)]
pub fn smoothed(
    pixel: u32,
    number: u32,
    params: &FrameParams,
    guides: &[DenoiserGuide],
    light: &Slots<'_, Vec3>,
) -> Vec3 {
    let own = light.read(pixel);
    let guide = guides[pixel as usize];
    if guide.material == NONE {
        return own;
    }
    let step = 1 << number;
    let (width, height) = (params.width as i32, params.height as i32);
    let (column, row) = ((pixel % params.width) as i32, (pixel / params.width) as i32);
    let mut sum = Vec3::ZERO;
    let mut dy = -2;
    while dy <= 2 {
        let y = row + dy * step;
        let mut dx = -2;
        while dx <= 2 {
            let x = column + dx * step;
            let inside = x >= 0 && y >= 0 && x < width && y < height;
            if inside && (dx != 0 || dy != 0) {
                let other = (y * width + x) as u32;
                let k = spline(dx) * spline(dy);
                sum += exchange(&guide, own, &guides[other as usize], light.read(other), step as f32) * k;
            }
            dx += 1;
        }
        dy += 1;
    }
    own + sum
}

/// What a pixel gets from another less what it gives, `step` pixels apart by the kernel's unit.
#[inline(always)]
fn exchange(own: &DenoiserGuide, own_light: Vec3, other: &DenoiserGuide, light: Vec3, step: f32) -> Vec3 {
    let mut w = likeness(own, other, step);
    if w <= 0.0 {
        return Vec3::ZERO;
    }
    if step >= COMPARED_RADII {
        w *= evenness(brightness(own_light, own), brightness(light, other), step);
    }
    if (own.share - other.share).abs().element_sum() == 0.0 {
        // The same without divisions: most pairs of most scenes.
        return (light - own_light) * w;
    }
    let taken = light * (own.share / other.share).min(Vec3::ONE);
    let given = own_light * (other.share / own.share).min(Vec3::ONE);
    (taken - given) * w
}

/// How alike two points are, in [0, 1]; the same for both.
#[inline(always)]
pub fn likeness(a: &DenoiserGuide, b: &DenoiserGuide, step: f32) -> f32 {
    if a.material != b.material || a.place != b.place {
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
    light.element_sum() / guide.share.element_sum()
}

/// How alike two brightnesses are, in (0, 1].
#[inline(always)]
fn evenness(a: f32, b: f32, step: f32) -> f32 {
    let sum = a + b;
    if sum <= 0.0 {
        return 1.0;
    }
    let contrast = (a - b) / sum;
    let y = 1.0 / (1.0 + contrast * contrast * step / CONTRAST);
    y * y
}

/// The cubic B-spline at the integers.
#[inline(always)]
fn spline(d: i32) -> f32 {
    match d.abs() {
        0 => 0.375,
        1 => 0.25,
        _ => 0.0625,
    }
}
