//! Metallic-roughness images, converted from specular-glossiness images.

use glam::Vec3;

use super::encoded;
use super::reader::ImageReader;
use crate::gltf::checked_json::translate::specular_glossiness::{
    Converted, ConvertedImage, ConvertedPart, convert,
};
use crate::texture::{Image, srgb};

/// Size of the result: the larger of both images' sides.
pub fn size(reader: &ImageReader<'_>, image: &ConvertedImage) -> Result<(u32, u32), String> {
    let mut largest = (1, 1);
    for index in [image.diffuse, image.specular].into_iter().flatten() {
        let (width, height) = encoded::size(reader, &reader.get(index)?.content)?;
        largest = (largest.0.max(width), largest.1.max(height));
    }
    Ok(largest)
}

/// Converts one part. The smaller image is sampled at the nearest texel.
pub fn read(reader: &ImageReader<'_>, image: &ConvertedImage) -> Result<Image, String> {
    let (width, height) = size(reader, image)?;
    let source = |index: Option<usize>| {
        index.map(|index| encoded::read(reader, &reader.get(index)?.content)).transpose()
    };
    let (diffuse, specular) = (source(image.diffuse)?, source(image.specular)?);
    let linear = srgb::Decoder::default();
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for row in 0..height {
        for column in 0..width {
            let nearest = |image: &Option<Image>| match image {
                None => [255; 4],
                Some(image) => {
                    let along = |at: u32, length: u32, side: u32| {
                        (u64::from(at) * u64::from(side) / u64::from(length)) as usize
                    };
                    let (x, y) = (along(column, width, image.width), along(row, height, image.height));
                    image.texels[y * image.width as usize + x]
                }
            };
            texels.push(texel(image, &linear, nearest(&diffuse), nearest(&specular)));
        }
    }
    Ok(Image { width, height, texels })
}

/// Converts a texel of one part, from the texels of both images.
fn texel(image: &ConvertedImage, linear: &srgb::Decoder, diffuse: [u8; 4], specular: [u8; 4]) -> [u8; 4] {
    let color =
        |[red, green, blue, _]: [u8; 4]| Vec3::from([red, green, blue].map(|byte| linear.decode(byte)));
    let byte = |share: f32| (share * 255.0).round().clamp(0.0, 255.0) as u8;
    let factors = &image.factors;
    let Converted { base_color, metallic } =
        convert(factors.diffuse * color(diffuse), factors.specular * color(specular));
    match image.part {
        ConvertedPart::BaseColor => {
            let [red, green, blue] = base_color.to_array().map(|linear| byte(srgb::encoded(linear)));
            [red, green, blue, diffuse[3]]
        }
        ConvertedPart::MetallicRoughness => {
            let glossiness = factors.glossiness * f32::from(specular[3]) / 255.0;
            [255, byte(1.0 - glossiness), byte(metallic), 255]
        }
    }
}
