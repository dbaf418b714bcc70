//! Filtered texels: bilinear in a level, linear between two [Williams 1983].

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::scene::TextureTables;
use crate::interface::texture::Texture;
use crate::texture::fetch::{floor, level, reduced, texel, wrapped};
use spirv_std::glam::{Vec2, Vec4};

/// The texture at `uv`, over a footprint of this width in uv (0: the finest level).
#[inline(always)]
pub fn sample(tables: TextureTables<'_>, texture: u32, uv: Vec2, footprint: f32) -> Vec4 {
    let texture = tables.textures[texture as usize];
    let lod = level_of(&texture, footprint);
    let finer = lod as u32;
    let blend = lod - finer as f32;
    let (u, v) = (reduced(uv.x, texture.wrap_u), reduced(uv.y, texture.wrap_v));

    // One loop over the levels and one over the corners: each copy of the innermost lines is long code on a GPU.
    let mut sum = Vec4::ZERO;
    let level_count = if blend > 0.0 { 2 } else { 1 };
    let mut step = 0;
    while step < level_count {
        let share = if step == 0 { 1.0 - blend } else { blend };
        let (width, height, offset) = level(&texture, finer + step);
        // Texel centres lie at halves.
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (left, top) = (floor(x), floor(y));
        let along_x = weight(x - left as f32, texture.nearest);
        let along_y = weight(y - top as f32, texture.nearest);
        let mut corner = 0;
        while corner < 4 {
            let (right, below) = (corner & 1, corner >> 1);
            let column = wrapped(left + right, width as i32, texture.wrap_u);
            let row = wrapped(top + below, height as i32, texture.wrap_v);
            let weight_x = if right == 1 { along_x } else { 1.0 - along_x };
            let weight_y = if below == 1 { along_y } else { 1.0 - along_y };
            let texel = texel(tables, texture.encoding, offset + row * width + column);
            sum += texel * (weight_x * weight_y * share);
            corner += 1;
        }
        step += 1;
    }
    sum
}

/// Weight of the second of two texels this far along; all or nothing for the nearest.
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

/// The level whose texels are as wide as the footprint: 0 is the finest, and each next has texels twice as wide.
#[inline]
pub fn level_of(texture: &Texture, footprint: f32) -> f32 {
    let texels = footprint * ((texture.width as f32) * (texture.height as f32)).sqrt();
    if texels > 1.0 {
        texels.log2().clamp(0.0, (texture.level_count - 1) as f32)
    } else {
        // Also where the footprint is not a number.
        0.0
    }
}
