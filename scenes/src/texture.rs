//! Texture images, computed by functions of the position and encoded as PNG.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

/// A PNG of `size` x `size` texels; `texel` gives the bytes at the texels' centres, (0, 0) to (1, 1) from the top left.
pub fn draw(size: u32, texel: impl Fn(f64, f64) -> [u8; 4]) -> Vec<u8> {
    let at = |texel: u32| (f64::from(texel) + 0.5) / f64::from(size);
    let texels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
    let bytes: Vec<u8> = texels.flat_map(|(x, y)| texel(at(x), at(y))).collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(&bytes, size, size, ExtendedColorType::Rgba8)
        .expect("an image in memory can be written");
    png
}

/// A pseudorandom number in [0, 1) for a pair of numbers.
pub fn noise(x: u32, y: u32) -> f64 {
    let mut hash = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77);
    hash = (hash ^ hash >> 15).wrapping_mul(0x2C1B_3C6D);
    hash = (hash ^ hash >> 12).wrapping_mul(0x297A_2D39);
    f64::from(hash ^ hash >> 15) / 4_294_967_296.0
}

/// Quantises a number to a byte; clamps to 0 to 1.
pub fn byte(share: f64) -> u8 {
    (share * 255.0).round().clamp(0.0, 255.0) as u8
}

/// Normal map texel of a surface with these slopes to the right and up the image.
pub fn normal(rise_right: f64, rise_up: f64) -> [u8; 4] {
    let scale = 127.0 / (1.0 + rise_right * rise_right + rise_up * rise_up).sqrt();
    let part = |value: f64| (128.0 + value * scale).round().clamp(0.0, 255.0) as u8;
    [part(-rise_right), part(-rise_up), part(1.0), 255]
}
