//! Vertices of a primitive with the joints and the morph targets that deform them.

use glam::{DAffine3, Vec3};
use gltf::json::mesh::Semantic;

use crate::SceneError;
use crate::corner::Corner;
use crate::deformation::{Deformation, Delta, MAX_PULLS, Pull};
use crate::gltf::context::ImportContext;
use crate::gltf::primitive::attribute;
use crate::gltf::scene_builder::mesh::Surface;

/// Memory of a vertex with its joints (bytes).
const VERTEX_BYTES: u64 = (size_of::<Corner>() + size_of::<Pull>() + 64) as u64;
/// Memory of a vertex's displacement by a morph target, while it is read and in the scene (bytes).
const DELTA_BYTES: u64 = 2 * size_of::<Delta>() as u64;

/// Appends the vertices of a primitive, with the joints and targets that deform them.
pub fn add(
    context: &mut ImportContext<'_>,
    surface: &Surface<'_>,
    deformation: &mut Deformation,
) -> Result<(), SceneError> {
    let vertices = surface.vertices(context, &DAffine3::IDENTITY)?;
    let faces = surface.faces(context, vertices.len())?;
    let count = if surface.is_coloured() { 3 * faces.len() } else { vertices.len() } as u64;
    let targets = deformation.targets.len() as u64;
    let bytes = count.saturating_mul(VERTEX_BYTES + targets.saturating_mul(DELTA_BYTES));
    context.take(bytes, format_args!("the skin and the morph targets of {}", surface.owner))?;
    let pulls = match deformation.is_skinned() {
        true => pulls(context, surface, vertices.len(), deformation.joints.len())?,
        false => Vec::new(),
    };
    let deltas: Vec<Vec<Delta>> = (0..deformation.targets.len())
        .map(|target| deltas(context, surface, target, vertices.len()))
        .collect::<Result<_, _>>()?;

    // Map vertices of the mesh to those of the file. With vertex colours every corner is a vertex, with coordinates of its own
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

/// Reads the joints and weights of a primitive's vertices.
fn pulls(
    context: &mut ImportContext<'_>,
    surface: &Surface<'_>,
    vertices: usize,
    joints: usize,
) -> Result<Vec<Pull>, SceneError> {
    let owner = &surface.owner;
    let accessors = surface.accessors(context);
    let attribute = |semantic: Semantic| attribute(surface.primitive, semantic);
    let mut pulls = vec![Pull::default(); vertices];
    for set in 0..(MAX_PULLS / 4) as u32 {
        let (Some(joint_ids), Some(weights)) =
            (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)))
        else {
            break;
        };
        let joint_ids = accessors.vertex_attribute::<4>(joint_ids, vertices, "joints")?;
        let weights = accessors.vertex_attribute::<4>(weights, vertices, "weights of joints")?;
        let all = pulls.iter_mut().zip(joint_ids).zip(weights).enumerate();
        for (vertex, ((pull, joint_ids), weights)) in all {
            for (at, (joint, weight)) in joint_ids.into_iter().zip(weights).enumerate() {
                // Files leave any joint index where the weight is zero.
                if weight == 0.0 {
                    continue;
                }
                if let Err(what) = check_pull(joint, weight, joints) {
                    return Err(context.mesh_error(owner, format!("its vertex {vertex} {what}")));
                }
                let slot = 4 * set as usize + at;
                (pull.joints[slot], pull.weights[slot]) = (joint as u16, weight);
            }
        }
    }
    if attribute(Semantic::Joints((MAX_PULLS / 4) as u32)).is_some() {
        context.warn(owner, format_args!("only {MAX_PULLS} joints pull a vertex; the others are left out"));
    }
    Ok(pulls)
}

/// Refuses a joint that the skin does not have, and a weight that is not positive and finite.
fn check_pull(joint: f32, weight: f32, joints: usize) -> Result<(), String> {
    if !(weight.is_finite() && weight > 0.0) {
        return Err(format!("has the weight {weight} of a joint, and weights are 0 to 1"));
    }
    if !(joint >= 0.0 && (joint as usize) < joints) {
        return Err(format!("is pulled by joint {joint}, but its skin has {joints}, the first of them 0"));
    }
    Ok(())
}

/// Reads the displacements of the vertices of a primitive by a morph target.
fn deltas(
    context: &ImportContext<'_>,
    surface: &Surface<'_>,
    target: usize,
    vertices: usize,
) -> Result<Vec<Delta>, SceneError> {
    let Some(target) = surface.primitive.targets.as_ref().and_then(|targets| targets.get(target)) else {
        return Ok(vec![Delta::default(); vertices]);
    };
    let accessors = surface.accessors(context);
    let read = |index: Option<_>, name: &str| -> Result<Vec<Vec3>, SceneError> {
        let Some(index) = index else { return Ok(vec![Vec3::ZERO; vertices]) };
        let all = accessors.vertex_attribute::<3>(index, vertices, name)?;
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
