//! Cameras of nodes.

use std::f32::consts::PI;

use glam::Vec3;
use gltf::json::scene::Node;
use gltf::json::{Camera, Index};

use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;
use crate::{SceneCamera, SceneError};

/// Reads a perspective camera, before its transform; `None`, with a warning, for other cameras.
pub fn read(
    document: &Document,
    context: &mut ImportContext<'_>,
    index: Index<Camera>,
    node: &Node,
    label: &str,
) -> Result<Option<SceneCamera>, SceneError> {
    let camera = context.get(&document.root.cameras, index, "camera", label)?;
    let Some(lens) = &camera.perspective else {
        context.warn(label, "only perspective cameras are supported; left out");
        return Ok(None);
    };
    if !(lens.yfov > 1e-4 && lens.yfov < PI - 1e-4) {
        let what = format!("its camera's yfov is {} rad and should be between 0 and pi", lens.yfov);
        context.replace(label, &what, "left out", context.node_error(label, &what))?;
        return Ok(None);
    }
    let name = node.name.as_ref().or(camera.name.as_ref());
    Ok(Some(SceneCamera {
        name: name.cloned().unwrap_or_else(|| format!("camera {}", index.value())),
        position: Vec3::ZERO,
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        fov_y: lens.yfov,
        aspect: lens.aspect_ratio.filter(|aspect| aspect.is_finite() && *aspect > 0.0),
    }))
}
