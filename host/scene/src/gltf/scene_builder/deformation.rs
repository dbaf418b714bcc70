//! Skins and morph targets, which deform meshes.

use glam::{DAffine3, DMat4};
use gltf::json::Index;

use super::mesh;
use super::node::{WorldMesh, WorldNodes};
use super::texture::Mapping;
use crate::SceneError;
use crate::deformation::Deformation;
use crate::gltf::accessor::AccessorReader;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::decoding::model::Model;
use crate::gltf::document::Document;
use crate::gltf::document::sections::JsonSkin;

mod surface;

/// Memory of a joint of a mesh, while its matrix is read and in the scene (bytes).
const JOINT_BYTES: u64 = 400;

/// A deformed mesh.
pub struct DeformedMesh {
    /// Its deformation.
    pub deformation: Deformation,
    /// Materials of the triangles.
    pub materials: Vec<u32>,
    /// Whether the deformation changes with time.
    pub moves: bool,
}

/// Reads a mesh that a skin or morph targets deform; `None` without either.
pub fn read(
    model: &Model,
    context: &mut ImportContext<'_>,
    world: &WorldNodes,
    instance: &WorldMesh,
    mappings: &[Option<Mapping>],
) -> Result<Option<DeformedMesh>, SceneError> {
    let joints = match instance.skin {
        Some(skin) => joints(model, context, world, skin, &instance.node)?,
        None => Vec::new(),
    };
    let morph = &world.rig.joints[instance.joint].morph;
    let is_morphed = !morph.channels.is_empty() || morph.weights.iter().any(|&weight| weight != 0.0);
    if joints.is_empty() && !is_morphed {
        return Ok(None);
    }
    let moves = !morph.channels.is_empty() || joints.iter().any(|(joint, _)| world.rig.joints[*joint].moves);
    let targets = if is_morphed { morph.weights.len() } else { 0 };
    let mut deformation = Deformation {
        node: instance.joint,
        joints,
        targets: vec![Vec::new(); targets],
        ..Deformation::default()
    };
    let mut materials = Vec::new();
    mesh::for_each_surface(model, context, instance, mappings, |context, surface| {
        surface::add(context, surface, &mut deformation)?;
        materials.resize(deformation.faces.len(), surface.material as u32);
        Ok(())
    })?;
    Ok(Some(DeformedMesh { deformation, materials, moves }))
}

/// Nodes of a skin's joints, each with its inverse bind matrix. `None`, with a warning, if the skin is not usable.
fn joints(
    document: &Document,
    context: &mut ImportContext<'_>,
    world: &WorldNodes,
    skin: usize,
    owner: &str,
) -> Result<Vec<(usize, DAffine3)>, SceneError> {
    let missing = JsonSkin::default();
    let value = document.sections.skins.get(skin).unwrap_or(&missing);
    // Each mesh has joints of its own, even if several nodes share a skin.
    let count = value.joints.len();
    context.take(count as u64 * JOINT_BYTES, format_args!("the {count} joints of {owner}"))?;
    let label = label("skin", skin, value.name.as_deref());
    let unusable = |context: &mut ImportContext<'_>, what: &str| {
        let what = format!("its {label} {what}");
        context.replace(owner, &what, "shown undeformed", context.node_error(owner, &what))?;
        Ok(Vec::new())
    };
    let nodes = value.joints.iter().map(|node| world.joint_of.get(node).copied());
    let Some(nodes) = nodes.collect::<Option<Vec<usize>>>() else {
        return unusable(context, "names a joint that is no node of the scene");
    };
    if nodes.is_empty() {
        return unusable(context, "has no joints");
    }
    let Some(index) = value.inverse_bind_matrices else {
        return Ok(nodes.into_iter().map(|node| (node, DAffine3::IDENTITY)).collect());
    };
    let accessors = AccessorReader::new(document, context, &label);
    let matrices = accessors.numbers::<16>(Index::new(index))?;
    let matrix = |m: &[f32; 16]| DAffine3::from_mat4(DMat4::from_cols_array(&m.map(f64::from)));
    let bound: Vec<DAffine3> = matrices.iter().map(matrix).collect();
    if bound.len() < nodes.len() || !bound.iter().all(DAffine3::is_finite) {
        return unusable(context, "has too few inverse bind matrices, or some that are not finite");
    }
    Ok(nodes.into_iter().zip(bound).collect())
}
