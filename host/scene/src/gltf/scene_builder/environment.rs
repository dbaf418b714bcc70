//! Environment of a scene's extras: `{ "uri": "sky.hdr" }` or `{ "color": [r, g, b] }`, with `rotation` (degrees) and `scale`.
//! Without extras, the light of EXT_lights_image_based.

use super::image_based;
use crate::gltf::context::ImportContext;
use crate::gltf::decoding::model::Model;
use crate::gltf::document::{buffer, radiance};
use crate::{EnvironmentMap, SceneError};

/// Reads the environment of the default scene, if it has one.
pub fn read(model: &Model, context: &mut ImportContext<'_>) -> Result<Option<EnvironmentMap>, SceneError> {
    let extras = &model.environment;
    if extras.is_null() {
        return image_based::read(model, context);
    }
    let wrong = |what: String| context.environment_error(what);
    let map = match (extras["uri"].as_str(), radiance(&extras["color"])) {
        (Some(uri), _) => buffer::fetch(uri, context.folder, u64::MAX)
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
