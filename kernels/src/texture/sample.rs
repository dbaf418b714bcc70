//! Filtered texels: bilinear in a level, linear between two [Williams 1983].

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::scene::TextureTables;
use crate::interface::texture::Texture;
use crate::math::clamp;
use crate::texture::fetch::{Level, decoded, floor, level, reduced, word, wrapped};
use caustics_kernel_macros::shared;
use spirv_std::glam::{Vec2, Vec4};

/// Filtered texel of a texture at `uv`, over a footprint of a width in uv (0: the finest level).
#[inline(always)]
pub fn sample(tables: TextureTables<'_>, texture: u32, uv: Vec2, footprint: f32) -> Vec4 {
    let texture = tables.textures[texture as usize];
    let lod = level_of(texture, footprint);
    let finer = lod as u32;
    let blend = lod - finer as f32;
    let at = reduced(texture, uv);

    let mut sum = Vec4::ZERO;
    let level_count = if blend > 0.0 { 2 } else { 1 };
    let mut step = 0;
    while step < level_count {
        let share = if step == 0 { 1.0 - blend } else { blend };
        let quad = Quad::new(texture, finer + step, at);
        let mut number = 0;
        while number < 4 {
            let corner = quad.corner(number);
            sum += decoded(texture.encoding, word(tables, corner.index)) * (corner.weight * share);
            number += 1;
        }
        step += 1;
    }
    sum
}

/// Four texels around a position in a level.
#[derive(Clone, Copy)]
struct Quad {
    texture: Texture,
    level: Level,
    left: i32,
    top: i32,
    along_x: f32,
    along_y: f32,
}

/// One of the four texels.
#[derive(Clone, Copy)]
struct Corner {
    /// Index of the texel, among all.
    index: u32,
    /// Weight in the sum.
    weight: f32,
}

impl Quad {
    #[shared]
    fn new(texture: Texture, number: u32, at: Vec2) -> Quad {
        let level = level(texture, number);
        // Texel centres lie at halves.
        let (x, y) = (at.x * level.width as f32 - 0.5, at.y * level.height as f32 - 0.5);
        let (left, top) = (floor(x), floor(y));
        let along_x = weight(x - left as f32, texture.nearest);
        let along_y = weight(y - top as f32, texture.nearest);
        Quad { texture, level, left, top, along_x, along_y }
    }

    #[shared]
    fn corner(self, number: i32) -> Corner {
        let (right, below) = (number & 1, number >> 1);
        let Level { width, height, offset } = self.level;
        let column = wrapped(self.left + right, width as i32, self.texture.wrap_u);
        let row = wrapped(self.top + below, height as i32, self.texture.wrap_v);
        let weight_x = if right == 1 { self.along_x } else { 1.0 - self.along_x };
        let weight_y = if below == 1 { self.along_y } else { 1.0 - self.along_y };
        Corner { index: offset + row * width + column, weight: weight_x * weight_y }
    }
}

/// Weight of the second of two texels, at a position between them; 0 or 1 for the nearest texel.
#[inline]
fn weight(along: f32, nearest: u32) -> f32 {
    if nearest == 0 {
        along
    } else if along < 0.5 {
        0.0
    } else {
        1.0
    }
}

/// Level whose texels are as wide as the footprint: 0 is the finest, and each further level has texels twice as wide.
#[shared]
pub fn level_of(texture: Texture, footprint: f32) -> f32 {
    let texels = footprint * ((texture.width as f32) * (texture.height as f32)).sqrt();
    if texels > 1.0 {
        clamp(texels.log2(), 0.0, (texture.level_count - 1) as f32)
    } else {
        // A footprint that is NaN also gives the finest level.
        0.0
    }
}
