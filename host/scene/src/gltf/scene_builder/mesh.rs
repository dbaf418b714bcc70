//! Meshes: primitives as triangles with corners in the world.

use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;

use self::extent::emits;
use super::node::WorldMesh;
use super::texture::Mapping;
use crate::SceneError;
use crate::corner::Corner;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::decoding::model::Model;
use crate::gltf::primitive::triangle_mode;

pub use self::extent::{Extent, extent};
pub use self::surface::Surface;

mod extent;
mod surface;
mod vertices;

/// Triangles of a primitive.
pub struct MeshPrimitive {
    /// Index of the material.
    pub material: usize,
    /// Whether the material emits.
    pub emits: bool,
    /// Corners, counter-clockwise seen from the front.
    pub triangles: Vec<[Corner; 3]>,
}

/// Calls a function for every primitive of an instance that has triangles.
pub fn for_each_surface(
    model: &Model,
    context: &mut ImportContext<'_>,
    instance: &WorldMesh,
    mappings: &[Option<Mapping>],
    mut then: impl FnMut(&mut ImportContext<'_>, &Surface<'_>) -> Result<(), SceneError>,
) -> Result<(), SceneError> {
    let materials = &model.root.materials;
    let mesh = context.get(&model.root.meshes, instance.mesh, "mesh", &instance.node)?;
    let label = label("mesh", instance.mesh.value(), mesh.name.as_deref());
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let owner = format!("{label}, primitive {index}");
        let material = match primitive.material {
            Some(material) => {
                context.get(materials, material, "material", &owner)?;
                material.value()
            }
            None => materials.len(),
        };
        let Some(mode) = triangle_mode(primitive) else {
            context.warn(&owner, "points and lines are not supported; rendered without them");
            continue;
        };
        if !primitive.attributes.contains_key(&Checked::Valid(Semantic::Positions)) {
            let what = "has no POSITION";
            context.replace(&owner, what, "left out", context.mesh_error(&owner, what))?;
            continue;
        }
        let atlas = model.atlas(material);
        let mapping = mappings.get(material).copied().flatten().filter(|_| atlas.is_none());
        then(context, &Surface { model, primitive, owner, material, mode, mapping, atlas })?;
    }
    Ok(())
}

/// Reads the triangles of every primitive of an instance.
pub fn read(
    model: &Model,
    context: &mut ImportContext<'_>,
    instance: &WorldMesh,
    mappings: &[Option<Mapping>],
) -> Result<Vec<MeshPrimitive>, SceneError> {
    let is_mirrored = instance.to_world.matrix3.determinant() < 0.0;
    let mut read = Vec::new();
    for_each_surface(model, context, instance, mappings, |context, surface| {
        let vertices = surface.vertices(context, &instance.to_world)?;
        let faces = surface.faces(context, vertices.len())?;
        let triangle = |(face, ids): (usize, [u32; 3])| {
            let mut corners = ids.map(|id| vertices[id as usize]);
            surface.colour(face, &mut corners);
            turned_over(corners, is_mirrored)
        };
        let triangles = faces.into_iter().enumerate().map(triangle).collect();
        let emits = emits(model, surface.primitive);
        read.push(MeshPrimitive { material: surface.material, emits, triangles });
        Ok(())
    })?;
    Ok(read)
}

/// Swaps two corners of a triangle if a mirror flips its front.
pub fn turned_over([a, b, c]: [Corner; 3], is_mirrored: bool) -> [Corner; 3] {
    if is_mirrored { [a, c, b] } else { [a, b, c] }
}
