//! The environment that a scene's extras ask for: `{ "uri": "sky.hdr" }` or `{ "color": [r, g, b] }`, with `rotation` (degrees) and
//! `scale`. Without them, that of EXT_lights_image_based.

use super::document::{Document, radiance};
use super::{buffer, image_based};
use crate::{EnvironmentMap, SceneError};

/// The environment of the default scene, if it asks for one.
pub fn read(document: &mut Document) -> Result<Option<EnvironmentMap>, SceneError> {
    if document.environment.is_null() {
        return image_based::read(document);
    }
    let extras = &document.environment;
    let wrong = |what: String| SceneError::Environment { file: document.file.clone(), what };
    let map = match (extras["uri"].as_str(), radiance(&extras["color"])) {
        (Some(uri), _) => buffer::fetch(uri, &document.folder, u64::MAX)
            .and_then(|bytes| EnvironmentMap::decode(&bytes))
            .map_err(|what| wrong(format!("its image {what}")))?,
        (None, Some(color)) => EnvironmentMap::constant(color),
        (None, None) => {
            return Err(wrong(format!(
                "the scene's extras.environment is {extras} and should have a uri, or a color of three radiances"
            )));
        }
    };
    let number = |key: &str, default: f32| match &extras[key] {
        value if value.is_null() => Ok(default),
        value => value
            .as_f64()
            .map(|number| number as f32)
            .ok_or_else(|| wrong(format!("the scene's extras.environment has a {key} {value}, no number"))),
    };
    Ok(Some(map.placed(number("scale", 1.0)?, number("rotation", 0.0)?)))
}
