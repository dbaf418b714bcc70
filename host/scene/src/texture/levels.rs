//! Levels of a texture: each has half the width and height of the one before, averaged over the area of a texel.

use super::parts::{Image, Role};
use super::srgb;

/// Number of levels, down to a single texel.
pub fn count(width: u32, height: u32) -> u32 {
    width.max(height).ilog2() + 1
}

/// Sizes of the levels (texels).
fn sizes(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..count(width, height)).map(move |level| ((width >> level).max(1), (height >> level).max(1)))
}

/// Number of texels of all levels.
pub fn texels(width: u32, height: u32) -> u64 {
    sizes(width, height).map(|(width, height)| u64::from(width) * u64::from(height)).sum()
}

/// Appends the texels of all levels of an image.
pub fn append(words: &mut Vec<u32>, image: &Image, role: Role) {
    words.extend(image.texels.iter().map(|&texel| u32::from_le_bytes(texel)));
    let decode = Decoder::new(role);
    let (mut width, mut height) = (image.width as usize, image.height as usize);
    // Read the finest level from bytes: its floats would take four times the memory.
    let mut coarser: Option<Vec<[f32; 4]>> = None;
    for (next_width, next_height) in sizes(image.width, image.height).skip(1) {
        let (next_width, next_height) = (next_width as usize, next_height as usize);
        let next = match &coarser {
            None => halve(width, height, next_width, next_height, |at| decode.texel(image.texels[at])),
            Some(level) => halve(width, height, next_width, next_height, |at| level[at]),
        };
        words.extend(next.iter().map(|&texel| u32::from_le_bytes(encode(role, texel))));
        (width, height) = (next_width, next_height);
        coarser = Some(next);
    }
}

/// Averages over the areas of the coarser texels, with fractional weights for odd sizes.
fn halve(
    width: usize,
    height: usize,
    next_width: usize,
    next_height: usize,
    texel: impl Fn(usize) -> [f32; 4],
) -> Vec<[f32; 4]> {
    let (columns, rows) = (weights(width, next_width), weights(height, next_height));
    let mut level = Vec::with_capacity(next_width * next_height);
    for (top, row_weights) in &rows {
        for (left, column_weights) in &columns {
            let mut sum = [0.0; 4];
            for (row, row_weight) in row_weights.iter().enumerate() {
                for (column, column_weight) in column_weights.iter().enumerate() {
                    let weight = row_weight * column_weight;
                    // Weights beyond the last texel are zero.
                    let at = (top + row).min(height - 1) * width + (left + column).min(width - 1);
                    let texel = texel(at);
                    (0..4).for_each(|channel| sum[channel] += weight * texel[channel]);
                }
            }
            level.push(sum);
        }
    }
    level
}

/// For each coarser texel of a line: the first finer texel below it, and the weights of this one and the next two.
fn weights(size: usize, next: usize) -> Vec<(usize, [f32; 3])> {
    let ratio = size as f64 / next as f64;
    let range = |texel: usize| {
        let (from, to) = (texel as f64 * ratio, (texel + 1) as f64 * ratio);
        let first = (from + 1e-9) as usize;
        let share = |k: usize| {
            let (low, high) = ((first + k) as f64, (first + k + 1) as f64);
            ((to.min(high) - from.max(low)).max(0.0) / ratio) as f32
        };
        (first, [share(0), share(1), share(2)])
    };
    (0..next).map(range).collect()
}

/// Decodes bytes to linear numbers.
struct Decoder {
    color: [f32; 256],
    alpha: [f32; 256],
}

impl Decoder {
    fn new(role: Role) -> Self {
        let share = |byte: usize| byte as f64 / 255.0;
        let color = |byte: usize| match role {
            Role::Color => srgb::linear(share(byte)),
            Role::Data => share(byte),
            Role::Normal => (byte as f64 - 128.0) / 127.0,
        };
        Decoder {
            color: std::array::from_fn(|byte| color(byte) as f32),
            alpha: std::array::from_fn(|byte| share(byte) as f32),
        }
    }

    fn texel(&self, [red, green, blue, alpha]: [u8; 4]) -> [f32; 4] {
        let color = |byte: u8| self.color[usize::from(byte)];
        [color(red), color(green), color(blue), self.alpha[usize::from(alpha)]]
    }
}

fn encode(role: Role, [red, green, blue, alpha]: [f32; 4]) -> [u8; 4] {
    let byte = |share: f32| (share * 255.0).round().clamp(0.0, 255.0) as u8;
    let [red, green, blue] = match role {
        Role::Data => [red, green, blue].map(byte),
        Role::Color => [red, green, blue].map(|linear| byte(srgb::encoded(linear))),
        Role::Normal => {
            let mean = glam::Vec3::new(red, green, blue).try_normalize().unwrap_or(glam::Vec3::Z);
            mean.to_array().map(|part| (part * 127.0 + 128.0).round().clamp(0.0, 255.0) as u8)
        }
    };
    [red, green, blue, byte(alpha)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_levels_cover_every_texel_once() {
        for (size, next) in [(1, 1), (2, 1), (3, 1), (5, 2), (7, 3), (8, 4), (4097, 2048)] {
            let mut covered = vec![0.0; size + 3];
            for (first, shares) in weights(size, next) {
                assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{size} to {next}");
                (0..3).for_each(|k| covered[first + k] += shares[k] * size as f32 / next as f32);
            }
            assert!(covered[..size].iter().all(|c| (c - 1.0).abs() < 1e-3), "{size} to {next}: {covered:?}");
            assert!(covered[size..].iter().all(|&c| c < 1e-3));
        }
    }

    #[test]
    fn levels_keep_the_mean_in_linear_light() {
        let (width, height) = (37, 20);
        let texels: Vec<[u8; 4]> =
            (0..width * height).map(|i| [(i * 89 % 256) as u8, (i % 2 * 255) as u8, 7, 255]).collect();
        let mut words = Vec::new();
        append(&mut words, &Image { width, height, texels }, Role::Color);
        assert_eq!(words.len() as u64, super::texels(width, height));
        let decode = Decoder::new(Role::Color);
        let mut rest = &words[..];
        let mut first = None;
        for (w, h) in sizes(width, height) {
            let (level, after) = rest.split_at((w * h) as usize);
            let mean = |channel: usize| {
                let values = level.iter().map(|word| decode.texel(word.to_le_bytes())[channel]);
                values.sum::<f32>() / level.len() as f32
            };
            let means = [0, 1, 2, 3].map(mean);
            let first = *first.get_or_insert(means);
            // A texel is rounded to a byte; at 0.5 a byte of sRGB is a step of 0.007.
            for channel in 0..4 {
                assert!((means[channel] - first[channel]).abs() < 0.004, "{w} x {h}: {means:?} {first:?}");
            }
            rest = after;
        }
        assert!(rest.is_empty());
    }

    #[test]
    fn normals_are_averaged_as_vectors() {
        let texels = vec![[255, 128, 128, 255], [128, 128, 255, 255]];
        let mut words = Vec::new();
        append(&mut words, &Image { width: 2, height: 1, texels }, Role::Normal);
        let [x, y, z, _] = words[2].to_le_bytes();
        // The mean of x and z: (1, 0, 1) / sqrt 2.
        assert_eq!((x, y, z), (218, 128, 218));
    }
}
