//! KHR_lights_punctual: lights of nodes.

use glam::Vec3;
use gltf::json::Index;
use gltf::json::extensions::scene::khr_lights_punctual::Light;
use gltf::json::scene::Node as JsonNode;

use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;
use crate::{LightShape, PunctualLight, SceneError};

/// Index of the light of a node.
pub fn of_node(node: &JsonNode) -> Option<Index<Light>> {
    let extension = node.extensions.as_ref().and_then(|all| all.khr_lights_punctual.as_ref());
    extension.map(|extension| extension.light)
}

/// Reads a punctual light, before its transform; `None`, with a warning, if it is not usable.
pub fn read(
    document: &Document,
    context: &mut ImportContext<'_>,
    index: Index<Light>,
    label: &str,
) -> Result<Option<PunctualLight>, SceneError> {
    let extensions = document.root.extensions.as_ref();
    let lights = extensions.and_then(|all| all.khr_lights_punctual.as_ref()).map(|all| all.lights.as_slice());
    let light = context.get(lights.unwrap_or_default(), index, "light", label)?;
    let intensity = Vec3::from(light.color) * light.intensity;
    let shape = match LightShape::from_gltf(light) {
        Ok(shape) if intensity.is_finite() && intensity.min_element() >= 0.0 => Ok(shape),
        Ok(_) => Err("its light's intensity or colour is negative, infinite or not a number".into()),
        Err(what) => Err(format!("its light {what}")),
    };
    let shape = match shape {
        Ok(shape) => shape,
        Err(what) => {
            context.replace(label, &what, "left out", context.node_error(label, &what))?;
            return Ok(None);
        }
    };
    if light.range.is_some() {
        context.warn(label, "a light's range is not supported; it reaches everywhere");
    }
    Ok(Some(PunctualLight { position: Vec3::ZERO, intensity, shape }))
}
