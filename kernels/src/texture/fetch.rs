//! One texel: wrapped, found in its chunk, decoded.

use crate::interface::scene::TextureTables;
use crate::interface::texture::{
    CHUNK_TEXELS, ENCODING_NORMAL, ENCODING_SRGB, Texture, WRAP_MIRRORED, WRAP_REPEAT,
};
use crate::math::clamp;
use crate::texture::srgb;
use caustics_kernel_macros::shared;
use spirv_std::glam::{Vec2, Vec4};

/// Word at `index`, which counts through all chunks.
#[inline(always)]
pub fn word(tables: TextureTables<'_>, index: u32) -> u32 {
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

/// Decodes a word to a texel: linear light, shares, or components of a vector.
#[shared]
pub fn decoded(encoding: u32, word: u32) -> Vec4 {
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

/// Largest integer not above `x`.
#[inline]
pub fn floor(x: f32) -> i32 {
    let toward_zero = x as i32;
    if toward_zero as f32 > x { toward_zero - 1 } else { toward_zero }
}

/// Reduces coordinates so that the texels next to them are at most one off the range that `wrapped` accepts.
#[shared]
pub fn reduced(texture: Texture, uv: Vec2) -> Vec2 {
    Vec2::new(reduced_along(uv.x, texture.wrap_u), reduced_along(uv.y, texture.wrap_v))
}

#[inline]
fn reduced_along(coordinate: f32, wrap: u32) -> f32 {
    if wrap == WRAP_REPEAT {
        coordinate - floor(coordinate) as f32
    } else if wrap == WRAP_MIRRORED {
        coordinate - 2.0 * floor(0.5 * coordinate) as f32
    } else {
        clamp(coordinate, -1.0, 2.0)
    }
}

/// Index in a row (or column) of `size` texels, for a texel in [-1, 2 size].
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
    // Clamp at the border of a clamped texture, and after any rounding elsewhere.
    clamp(inside, 0, size - 1) as u32
}

/// A level of a texture.
#[derive(Clone, Copy)]
pub struct Level {
    /// Width (texels).
    pub width: u32,
    /// Height (texels).
    pub height: u32,
    /// Index of its first texel, among all.
    pub offset: u32,
}

/// Level of a number; 0 is the finest.
#[inline(always)]
pub fn level(texture: Texture, number: u32) -> Level {
    let Texture { width, height, offset, .. } = texture;
    let mut level = Level { width, height, offset };
    let mut finer = 0;
    while finer < number {
        level.offset += level.width * level.height;
        level.width = (level.width / 2).max(1);
        level.height = (level.height / 2).max(1);
        finer += 1;
    }
    level
}
