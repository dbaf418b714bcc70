//! Image of an environment: read from a file, reduced to a size that the tables hold.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use image::{ImageFormat, ImageReader};

use caustics_files::caught::decoded;
use caustics_files::file::read_file;
use caustics_files::image_file::Channels;

/// Maximum width (texels). At 2:1 the texels take 96 MiB, which every Vulkan device can bind.
const MAX_WIDTH: u32 = 4096;
/// Maximum height (texels).
const MAX_HEIGHT: u32 = 2048;
/// Maximum radiance; larger values are clamped (W m^-2 sr^-1).
const MAX_RADIANCE: f32 = 1e15;
/// First bytes of a Radiance HDR file.
const HDR_MAGIC: &[u8] = b"#?";
/// Maximum side of a Radiance HDR file (texels); a texel takes 12 bytes, and twice that while it is read.
const MAX_SIDE: u32 = 16_384;

/// Radiance by direction, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentImage {
    /// Width (texels).
    pub width: u32,
    /// Height (texels).
    pub height: u32,
    /// Radiances (W m^-2 sr^-1).
    pub texels: Arc<[Vec3]>,
}

impl EnvironmentImage {
    /// Creates an image from radiances, which are made usable for light sampling. The image is halved until the tables hold it.
    pub fn new(width: u32, height: u32, texels: Vec<Vec3>) -> EnvironmentImage {
        assert!(!texels.is_empty() && texels.len() as u64 == u64::from(width) * u64::from(height));
        let mut image = EnvironmentImage { width, height, texels: texels.into_iter().map(usable).collect() };
        while image.width > MAX_WIDTH || image.height > MAX_HEIGHT {
            image = image.half();
        }
        image
    }

    /// Reads an image file; an error describes the fault.
    pub fn read(path: &Path) -> Result<EnvironmentImage, String> {
        EnvironmentImage::decode(
            &read_file(path).map_err(|error| format!("cannot be read ({error}); check the path"))?,
        )
    }

    /// Decodes the bytes of an image file.
    pub fn decode(bytes: &[u8]) -> Result<EnvironmentImage, String> {
        let (width, height, texels) =
            if bytes.starts_with(HDR_MAGIC) { radiance_hdr(bytes)? } else { open_exr(bytes)? };
        if texels.is_empty() {
            return Err("has no texels".into());
        }
        Ok(EnvironmentImage::new(width, height, texels))
    }

    /// Halves width and height. Each texel is the mean of four; an odd last one counts twice.
    fn half(&self) -> EnvironmentImage {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let at = |x: u32, y: u32| {
            self.texels[(y.min(self.height - 1) * self.width + x.min(self.width - 1)) as usize]
        };
        let mean = |index: u32| {
            let (x, y) = (2 * (index % width), 2 * (index / width));
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        };
        EnvironmentImage { width, height, texels: (0..width * height).map(mean).collect() }
    }
}

/// Makes a radiance usable for light sampling: negative values and NaN become 0, infinity the maximum.
fn usable(radiance: Vec3) -> Vec3 {
    Vec3::from_array(
        radiance.to_array().map(|channel| if channel > 0.0 { channel.min(MAX_RADIANCE) } else { 0.0 }),
    )
}

fn radiance_hdr(bytes: &[u8]) -> Result<(u32, u32, Vec<Vec3>), String> {
    let wrong = |error: image::ImageError| format!("cannot be read as Radiance HDR: {error}");
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Hdr);
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    // The texels are copied once.
    limits.max_alloc = caustics_files::memory::available().map(|bytes| bytes / 2);
    reader.limits(limits);
    let image =
        decoded(|| reader.decode().map_err(wrong), "cannot be read as Radiance HDR: its data are damaged")?
            .into_rgb32f();
    let (width, height) = image.dimensions();
    Ok((width, height, image.pixels().map(|texel| Vec3::from_array(texel.0)).collect()))
}

fn open_exr(bytes: &[u8]) -> Result<(u32, u32, Vec<Vec3>), String> {
    let other = |what: String| format!("is no latitude-longitude image: {what}; give Radiance HDR or EXR");
    let channels = Channels::decode(bytes).map_err(other)?;
    if channels.encoding != caustics_files::image_file::Encoding::Linear {
        return Err("holds display colours and no radiance; give Radiance HDR or EXR".into());
    }
    if channels.width.max(channels.height) > MAX_SIDE as usize {
        return Err(format!("has a side of more than {MAX_SIDE} texels"));
    }
    let [red, green, blue] = channels.layer("").ok_or("has no channels R, G and B")?;
    let texels = red.iter().zip(green).zip(blue).map(|((&r, &g), &b)| Vec3::new(r, g, b)).collect();
    Ok((channels.width as u32, channels.height as u32, texels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_keep_the_mean_of_images_of_even_size() {
        let texels = (0..32).map(|i| Vec3::splat(i as f32)).collect();
        let half = EnvironmentImage { width: 8, height: 4, texels }.half();
        assert_eq!((half.width, half.height), (4, 2));
        assert_eq!(half.texels[0], Vec3::splat((0.0 + 1.0 + 8.0 + 9.0) / 4.0));
        assert_eq!(half.texels.iter().sum::<Vec3>() / 8.0, Vec3::splat(15.5));
    }

    #[test]
    fn negative_and_nan_radiances_become_zero() {
        let odd = Vec3::new(-1.0, f32::NAN, f32::INFINITY);
        assert_eq!(usable(odd), Vec3::new(0.0, 0.0, MAX_RADIANCE));
    }
}
