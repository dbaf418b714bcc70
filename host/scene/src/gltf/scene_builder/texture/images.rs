//! Images of textures. Their headers give the required memory before any is decoded.

use std::collections::HashSet;

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::texture::MaterialTextures;

use crate::SceneError;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::decoding::model::Model;
use crate::gltf::scene_builder::image::ImageReader;
use crate::texture::{self, Image, ImageTexture};

/// Replacement of a missing texture, in messages.
pub const FLAT: &str = "its factor alone is rendered";

/// Loads the images of textures, given their indices in the document. Records of materials lose textures without an image.
pub fn load(
    model: &Model,
    context: &mut ImportContext<'_>,
    images: &[usize],
    textures: &[ImageTexture],
    records: &mut [MaterialTextures],
) -> Result<Vec<Image>, SceneError> {
    let reader = ImageReader { document: model, folder: context.folder };
    let mut missing = HashSet::new();

    // Reserve memory
    let mut sizes = read_each(&reader, context, images, &mut missing, ImageReader::size)?;
    missing.iter().for_each(|&image: &usize| sizes[image] = (1, 1));
    let used: HashSet<_> = textures.iter().map(|texture| (texture.image, texture.role)).collect();
    let count = texture::check_texels(context.file, used.into_iter().map(|(image, _)| sizes[image]))?;
    // Four bytes a texel each in the images, in the table and in the runner. The largest image is decoded from eight bytes a
    // texel to four, and its levels are computed in floats.
    let areas = || sizes.iter().map(|&(width, height)| u64::from(width) * u64::from(height));
    let bytes = 4 * areas().sum::<u64>() + 8 * count + 12 * areas().max().unwrap_or(0);
    context.take(bytes, format_args!("its {} images", sizes.len()))?;

    // Decode
    let mut read = read_each(&reader, context, images, &mut missing, ImageReader::read)?;
    leave_out(&missing, &mut read, textures, records);
    Ok(read)
}

/// Applies a function to every image; gives a default, with a warning, if an image is not available.
fn read_each<'a, T: Default>(
    reader: &ImageReader<'a>,
    context: &mut ImportContext<'_>,
    images: &[usize],
    missing: &mut HashSet<usize>,
    read: impl Fn(&ImageReader<'a>, usize) -> Result<T, String>,
) -> Result<Vec<T>, SceneError> {
    let mut all = Vec::with_capacity(images.len());
    for (image, &source) in images.iter().enumerate() {
        let found = if missing.contains(&image) { Ok(T::default()) } else { read(reader, source) };
        all.push(match found {
            Ok(found) => found,
            Err(what) => {
                let name = reader.document.sections.images[source].name.as_deref();
                let owner = label("image", source, name);
                context.replace(&owner, &what, FLAT, context.image_error(source, &what))?;
                missing.insert(image);
                T::default()
            }
        });
    }
    Ok(all)
}

/// Removes the textures of missing images from the records. A single texel replaces the image; no look-up reads it.
fn leave_out(
    missing: &HashSet<usize>,
    images: &mut [Image],
    textures: &[ImageTexture],
    records: &mut [MaterialTextures],
) {
    for &image in missing {
        images[image] = Image { width: 1, height: 1, texels: vec![[255; 4]] };
    }
    let is_missing =
        |texture: u32| textures.get(texture as usize).is_some_and(|texture| missing.contains(&texture.image));
    for record in records {
        let slots = [
            &mut record.base_color,
            &mut record.metallic_roughness,
            &mut record.emissive,
            &mut record.normal,
        ];
        for slot in slots.into_iter().filter(|slot| is_missing(**slot)) {
            *slot = NONE;
        }
    }
}
