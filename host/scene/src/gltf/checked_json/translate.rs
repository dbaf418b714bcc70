//! Translates extensions into others, which later stages read. Works on plain JSON whose types are checked.

use serde_json::Value;

use self::element::elements;
use self::specular_glossiness::SOURCE;
use crate::SceneError;
use crate::gltf::context::ImportContext;

mod cameras;
mod clearcoat;
mod element;
mod scenes;
pub mod specular_glossiness;
mod textures;
mod unlit;
mod variants;

/// Rewrites a document, with warnings of the losses.
pub fn translate(document: &mut Value, context: &mut ImportContext<'_>) -> Result<(), SceneError> {
    // Only the import itself may set this member of images.
    for image in elements(document, "images") {
        image.as_object_mut().and_then(|members| members.remove(SOURCE));
    }
    cameras::reduce(document);
    scenes::complete(document, context)?;
    variants::choose(document, context)?;
    textures::choose_sources(document);
    specular_glossiness::translate(document, context);
    unlit::translate(document, context);
    clearcoat::translate(document, context);
    Ok(())
}
