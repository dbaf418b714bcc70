//! One texel: wrapped, found in its chunk, decoded.

use crate::interface::scene::TextureTables;
use crate::interface::texture::{
    CHUNK_TEXELS, ENCODING_NORMAL, ENCODING_SRGB, Texture, WRAP_MIRRORED, WRAP_REPEAT,
};
use crate::texture::srgb;
use spirv_std::glam::Vec4;

/// The word at `index`, counted through all chunks.
#[inline(always)]
fn word(tables: TextureTables<'_>, index: u32) -> u32 {
    let (chunk, within) = (index / CHUNK_TEXELS, (index % CHUNK_TEXELS) as usize);
    if chunk == 0 {
        tables.texels_0[within]
    } else if chunk == 1 {
        tables.texels_1[within]
    } else if chunk == 2 {
        tables.texels_2[within]
    } else {
        tables.texels_3[within]
    }
}

/// The texel at `index`, decoded: linear light, a share, or a vector's component.
#[inline(always)]
pub fn texel(tables: TextureTables<'_>, encoding: u32, index: u32) -> Vec4 {
    let word = word(tables, index);
    let bytes = Vec4::new(
        (word & 255) as f32,
        ((word >> 8) & 255) as f32,
        ((word >> 16) & 255) as f32,
        (word >> 24) as f32,
    );
    if encoding == ENCODING_NORMAL {
        return (bytes - Vec4::splat(128.0)) * (1.0 / 127.0);
    }
    let shares = bytes * (1.0 / 255.0);
    if encoding == ENCODING_SRGB {
        return Vec4::new(
            srgb::to_linear(shares.x),
            srgb::to_linear(shares.y),
            srgb::to_linear(shares.z),
            shares.w,
        );
    }
    shares
}

/// Largest integer not above.
#[inline]
pub fn floor(x: f32) -> i32 {
    let toward_zero = x as i32;
    if toward_zero as f32 > x { toward_zero - 1 } else { toward_zero }
}

/// A coordinate brought to where the texels next to it are at most one off the range that `wrapped` folds.
#[inline]
pub fn reduced(coordinate: f32, wrap: u32) -> f32 {
    if wrap == WRAP_REPEAT {
        coordinate - floor(coordinate) as f32
    } else if wrap == WRAP_MIRRORED {
        coordinate - 2.0 * floor(0.5 * coordinate) as f32
    } else {
        coordinate.clamp(-1.0, 2.0)
    }
}

/// The texel of a row (or column) of `size` that a texel in [-1, 2 size] stands for.
#[inline]
pub fn wrapped(texel: i32, size: i32, wrap: u32) -> u32 {
    let mut inside = texel;
    if wrap == WRAP_REPEAT {
        if texel < 0 {
            inside = texel + size;
        }
        if texel >= size {
            inside = texel - size;
        }
    } else if wrap == WRAP_MIRRORED && texel >= size {
        inside = 2 * size - 1 - texel;
    }
    // Also the border of a clamped texture, and whatever rounding does elsewhere.
    inside.clamp(0, size - 1) as u32
}

/// Width, height and first texel of a level.
#[inline(always)]
pub fn level(texture: &Texture, level: u32) -> (u32, u32, u32) {
    let (mut width, mut height, mut offset) = (texture.width, texture.height, texture.offset);
    let mut finer = 0;
    while finer < level {
        offset += width * height;
        width = (width / 2).max(1);
        height = (height / 2).max(1);
        finer += 1;
    }
    (width, height, offset)
}
