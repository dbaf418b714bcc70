//! Skins and morph targets: what deforms a mesh.

use glam::{DAffine3, DMat4, Vec3};
use gltf::json::Index;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;

use super::document::Document;
use super::mesh::{self, Surface};
use super::node::{WorldMesh, WorldNodes};
use super::texture::Mapping;
use super::{accessor, unsupported};
use crate::SceneError;
use crate::corner::Corner;
use crate::deformation::{Deformation, Delta, MAX_PULLS, Pull};

/// Memory of a vertex with its joints, and of what a target adds to one (bytes).
const VERTEX_BYTES: u64 = (size_of::<Corner>() + size_of::<Pull>() + 64) as u64;
/// What a morph target adds to a vertex, as it is read and kept (bytes).
const DELTA_BYTES: u64 = 2 * size_of::<Delta>() as u64;

/// Memory of a joint of a mesh, with its matrix as it is read and kept (bytes).
const JOINT_BYTES: u64 = 400;

/// A mesh that is deformed.
pub struct DeformedMesh {
    /// Its deformation.
    pub deformation: Deformation,
    /// Materials of its triangles.
    pub materials: Vec<u32>,
    /// Whether that changes with time.
    pub moves: bool,
}

/// Reads a mesh that a skin or morph targets deform; none if nothing does.
pub fn read(
    document: &mut Document,
    world: &WorldNodes,
    instance: &WorldMesh,
    mappings: &[Option<Mapping>],
) -> Result<Option<DeformedMesh>, SceneError> {
    let joints = match instance.skin {
        Some(skin) => joints(document, world, skin, &instance.node)?,
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
    mesh::for_each_surface(document, instance, mappings, |document, surface| {
        add(document, surface, &mut deformation)?;
        materials.resize(deformation.faces.len(), surface.material as u32);
        Ok(())
    })?;
    Ok(Some(DeformedMesh { deformation, materials, moves }))
}

/// Nodes of a skin, each with the way from the mesh to where it was bound; none, with a warning, if the skin cannot be used.
fn joints(
    document: &mut Document,
    world: &WorldNodes,
    skin: usize,
    owner: &str,
) -> Result<Vec<(usize, DAffine3)>, SceneError> {
    // Each mesh has joints of its own, however many nodes have one skin.
    let count =
        document.sections.skins.get(skin).and_then(|skin| skin["joints"].as_array()).map_or(0, Vec::len);
    document.take(count as u64 * JOINT_BYTES, format_args!("the {count} joints of {owner}"))?;
    let value = document.sections.skins.get(skin).cloned().unwrap_or_default();
    let label = unsupported::label("skin", skin, value["name"].as_str());
    let unusable = |document: &mut Document, what: &str| {
        let file = document.file.clone();
        let error = SceneError::Node { file, node: owner.into(), what: format!("its {label} {what}") };
        document.replace(owner, &format!("its {label} {what}"), "shown undeformed", error)?;
        Ok(Vec::new())
    };
    let listed = value["joints"].as_array().into_iter().flatten();
    let nodes = listed.map(|node| world.joint_of.get(&(node.as_u64()? as usize)).copied());
    let Some(nodes) = nodes.collect::<Option<Vec<usize>>>() else {
        return unusable(document, "names a joint that is no node of the scene");
    };
    if nodes.is_empty() {
        return unusable(document, "has no joints");
    }
    let Some(index) = value["inverseBindMatrices"].as_u64() else {
        return Ok(nodes.into_iter().map(|node| (node, DAffine3::IDENTITY)).collect());
    };
    let index = Index::new(u32::try_from(index).unwrap_or(u32::MAX));
    let matrices = accessor::numbers::<16>(document, index, &label)?;
    let matrix = |m: &[f32; 16]| DAffine3::from_mat4(DMat4::from_cols_array(&m.map(f64::from)));
    let bound: Vec<DAffine3> = matrices.iter().map(matrix).collect();
    if bound.len() < nodes.len() || !bound.iter().all(DAffine3::is_finite) {
        return unusable(document, "has too few inverse bind matrices, or some that are not finite");
    }
    Ok(nodes.into_iter().zip(bound).collect())
}

/// Appends the vertices of a primitive, with what deforms them.
fn add(
    document: &mut Document,
    surface: &Surface<'_>,
    deformation: &mut Deformation,
) -> Result<(), SceneError> {
    let vertices = surface.vertices(document, &DAffine3::IDENTITY)?;
    let faces = surface.faces(document, vertices.len())?;
    let count = if surface.is_coloured() { 3 * faces.len() } else { vertices.len() } as u64;
    let targets = deformation.targets.len() as u64;
    let bytes = count.saturating_mul(VERTEX_BYTES + targets.saturating_mul(DELTA_BYTES));
    document.take(bytes, format_args!("the skin and the morph targets of {}", surface.owner))?;
    let pulls = match deformation.is_skinned() {
        true => pulls(document, surface, vertices.len(), deformation.joints.len())?,
        false => Vec::new(),
    };
    let deltas: Vec<Vec<Delta>> = (0..deformation.targets.len())
        .map(|target| deltas(document, surface, target, vertices.len()))
        .collect::<Result<_, _>>()?;

    // Which vertex of the file each is: where corners have coordinates of their own, every corner is a vertex.
    let first = deformation.rest.len() as u32;
    let sources: Vec<u32> = if surface.is_coloured() {
        for (face, ids) in faces.iter().enumerate() {
            let mut corners = ids.map(|id| vertices[id as usize]);
            surface.colour(face, &mut corners);
            deformation.rest.extend(corners);
        }
        deformation
            .faces
            .extend((0..faces.len() as u32).map(|face| [0, 1, 2].map(|at| first + 3 * face + at)));
        faces.into_flattened()
    } else {
        deformation.faces.extend(faces.into_iter().map(|face| face.map(|id| first + id)));
        deformation.rest.extend(&vertices);
        (0..vertices.len() as u32).collect()
    };
    if deformation.is_skinned() {
        deformation.pulls.extend(sources.iter().map(|&id| pulls[id as usize]));
    }
    for (all, deltas) in deformation.targets.iter_mut().zip(&deltas) {
        all.extend(sources.iter().map(|&id| deltas[id as usize]));
    }
    Ok(())
}

/// Which joints pull the vertices of a primitive.
fn pulls(
    document: &mut Document,
    surface: &Surface<'_>,
    vertices: usize,
    joints: usize,
) -> Result<Vec<Pull>, SceneError> {
    let owner = &surface.owner;
    let attribute = |semantic: Semantic| surface.primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let mut pulls = vec![Pull::default(); vertices];
    for set in 0..(MAX_PULLS / 4) as u32 {
        let (Some(joint_ids), Some(weights)) =
            (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)))
        else {
            break;
        };
        let joint_ids = mesh::vertex_attribute::<4>(document, joint_ids, vertices, "joints", owner)?;
        let weights = mesh::vertex_attribute::<4>(document, weights, vertices, "weights of joints", owner)?;
        for (vertex, ((pull, joint_ids), weights)) in pulls.iter_mut().zip(joint_ids).zip(weights).enumerate()
        {
            for at in 0..4 {
                let (joint, weight) = (joint_ids[at], weights[at]);
                // Where nothing pulls, files leave any number.
                if weight == 0.0 {
                    continue;
                }
                let what = if !(weight.is_finite() && weight > 0.0) {
                    format!("its vertex {vertex} has the weight {weight} of a joint, and weights are 0 to 1")
                } else if !(joint >= 0.0 && (joint as usize) < joints) {
                    format!(
                        "its vertex {vertex} is pulled by joint {joint}, but its skin has {joints}, the first of them 0"
                    )
                } else {
                    String::new()
                };
                if !what.is_empty() {
                    let (file, mesh) = (document.file.clone(), owner.clone());
                    return Err(SceneError::Mesh { file, mesh, what });
                }
                let slot = 4 * set as usize + at;
                (pull.joints[slot], pull.weights[slot]) = (joint as u16, weight);
            }
        }
    }
    if attribute(Semantic::Joints((MAX_PULLS / 4) as u32)).is_some() {
        document.warn(owner, format_args!("only {MAX_PULLS} joints pull a vertex; the others are left out"));
    }
    Ok(pulls)
}

/// What a morph target adds to the vertices of a primitive.
fn deltas(
    document: &mut Document,
    surface: &Surface<'_>,
    target: usize,
    vertices: usize,
) -> Result<Vec<Delta>, SceneError> {
    let Some(target) = surface.primitive.targets.as_ref().and_then(|targets| targets.get(target)) else {
        return Ok(vec![Delta::default(); vertices]);
    };
    let read = |index: Option<_>, what: &str| -> Result<Vec<Vec3>, SceneError> {
        let Some(index) = index else { return Ok(vec![Vec3::ZERO; vertices]) };
        let all = mesh::vertex_attribute::<3>(document, index, vertices, what, &surface.owner)?;
        Ok(all.into_iter().map(Vec3::from).collect())
    };
    let (positions, normals, tangents) = (
        read(target.positions, "displacements of a morph target")?,
        read(target.normals, "normals of a morph target")?,
        read(target.tangents, "tangents of a morph target")?,
    );
    let all = positions.into_iter().zip(normals).zip(tangents);
    Ok(all.map(|((position, normal), tangent)| Delta { position, normal, tangent }).collect())
}
