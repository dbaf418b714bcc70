//! Transforms and morph weights of nodes.

use glam::{DAffine3, DMat4, DQuat, DVec3, Vec3};
use gltf::json::scene::Node as JsonNode;

use crate::animation::{Channel, Local, Morph};
use crate::gltf::document::Document;

/// Transform of a node relative to its parent, with the channels that set it.
pub fn local(node: &JsonNode, channels: Vec<Channel>) -> Local {
    if let Some(matrix) = node.matrix {
        let matrix = DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        // A singular matrix has no rotation.
        let rotation = if rotation.is_finite() { rotation.normalize() } else { DQuat::IDENTITY };
        return Local { translation, rotation, scale, matrix: Some(matrix.matrix3), ..Local::default() };
    }
    Local {
        translation: node.translation.map_or(DVec3::ZERO, |vector| Vec3::from(vector).as_dvec3()),
        rotation: DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from)),
        scale: node.scale.map_or(DVec3::ONE, |vector| Vec3::from(vector).as_dvec3()),
        channels,
        ..Local::default()
    }
}

/// Weights of the morph targets of a node's mesh, and the channels that set them.
pub fn morph(document: &Document, node: &JsonNode, channels: Vec<Channel>) -> Morph {
    let mesh = node.mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
    let Some(count) = mesh.and_then(|mesh| mesh.primitives.first()?.targets.as_ref()).map(Vec::len) else {
        return Morph::default();
    };
    let set = node.weights.as_ref().or(mesh.and_then(|mesh| mesh.weights.as_ref()));
    let mut weights: Vec<f64> = set.iter().flat_map(|all| all.iter()).map(|&weight| weight.into()).collect();
    weights.resize(count, 0.0);
    Morph { weights, channels }
}

/// Memory of a node's weights and keys (bytes).
pub fn bytes(morph: &Morph) -> u64 {
    let keys = morph.channels.iter().map(|channel| 8 * channel.times.len() + 32 * channel.values.len());
    (16 * morph.weights.len() + keys.sum::<usize>()) as u64
}
