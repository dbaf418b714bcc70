//! What extensions say in other words, in those that the rest of the loader reads. Works on plain JSON whose types are checked.

use serde_json::Value;

use self::element::elements;
use self::specular_glossiness::SOURCE;
use super::atlas::BAKED;
use super::options::LoadOptions;
use super::warning::Warnings;
use crate::SceneError;

mod cameras;
mod clearcoat;
mod element;
mod scenes;
pub mod specular_glossiness;
mod textures;
mod unlit;
mod variants;

/// Rewrites a document; what is lost is noted.
pub fn translate(
    file: &str,
    document: &mut Value,
    options: &LoadOptions,
    warnings: &mut Warnings,
) -> Result<(), SceneError> {
    // Members of images that only the loader itself sets.
    for image in elements(document, "images") {
        for member in [SOURCE, BAKED] {
            image.as_object_mut().and_then(|members| members.remove(member));
        }
    }
    cameras::reduce(document);
    scenes::complete(file, document, options, warnings)?;
    variants::choose(file, document, options.variant.as_deref())?;
    textures::choose_sources(document);
    specular_glossiness::translate(document, warnings);
    unlit::translate(document, warnings);
    clearcoat::translate(document, warnings);
    Ok(())
}
