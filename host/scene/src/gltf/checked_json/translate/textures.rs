//! EXT_texture_webp, KHR_texture_basisu: images of other formats.

use serde_json::{Value, json};

use super::element::{elements, take_extension};

/// Gives every texture without a PNG or JPEG the image of an extension.
pub fn choose_sources(document: &mut Value) {
    for texture in elements(document, "textures") {
        for extension in ["EXT_texture_webp", "KHR_texture_basisu"] {
            let Some(source) = take_extension(texture, extension).and_then(|named| named["source"].as_u64())
            else {
                continue;
            };
            if texture["source"].is_null() {
                texture["source"] = json!(source);
            }
        }
    }
}
