//! Images of metallic-roughness, made of those of specular-glossiness.

use glam::Vec3;
use serde_json::Value;

use super::encoded;
use crate::gltf::document::Document;
use crate::gltf::translate::specular_glossiness::{Converted, Factors, convert};
use crate::texture::{Image, srgb};

/// The larger of both images' sides.
pub fn size(document: &Document, source: &Value) -> Result<(u32, u32), String> {
    let mut largest = (1, 1);
    for name in ["diffuse", "specular"] {
        if let Some(index) = source[name].as_u64() {
            let (width, height) = encoded::size(document, encoded::described(document, index)?)?;
            largest = (largest.0.max(width), largest.1.max(height));
        }
    }
    Ok(largest)
}

/// The image of one part; of the smaller image the nearest texel is taken.
pub fn read(document: &Document, source: &Value) -> Result<Image, String> {
    let (width, height) = size(document, source)?;
    let image = |name: &str| {
        let index = source[name].as_u64();
        index.map(|index| encoded::read(document, encoded::described(document, index)?)).transpose()
    };
    let (diffuse, specular) = (image("diffuse")?, image("specular")?);
    let factors = Factors::from_extension(source);
    let is_color = source["part"] == "baseColor";
    let linear = srgb::Decoder::default();
    let color =
        |[red, green, blue, _]: [u8; 4]| Vec3::from([red, green, blue].map(|byte| linear.decode(byte)));
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for row in 0..height {
        for column in 0..width {
            let texel = |image: &Option<Image>| match image {
                None => [255; 4],
                Some(image) => {
                    let along = |at: u32, length: u32, side: u32| {
                        (u64::from(at) * u64::from(side) / u64::from(length)) as usize
                    };
                    let (x, y) = (along(column, width, image.width), along(row, height, image.height));
                    image.texels[y * image.width as usize + x]
                }
            };
            let (diffuse, specular) = (texel(&diffuse), texel(&specular));
            let Converted { base_color, metallic } =
                convert(factors.diffuse * color(diffuse), factors.specular * color(specular));
            let byte = |share: f32| (share * 255.0).round().clamp(0.0, 255.0) as u8;
            texels.push(if is_color {
                let [red, green, blue] = base_color.to_array().map(|linear| byte(srgb::encoded(linear)));
                [red, green, blue, diffuse[3]]
            } else {
                let glossiness = factors.glossiness * f32::from(specular[3]) / 255.0;
                [255, byte(1.0 - glossiness), byte(metallic), 255]
            });
        }
    }
    Ok(Image { width, height, texels })
}
