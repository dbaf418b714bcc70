//! Meshes: primitives as triangles with corners in the world.

use glam::DAffine3;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::node::WorldMesh;
use super::texture::Mapping;
use crate::SceneError;
use crate::corner::Corner;
use crate::gltf::accessor::AccessorReader;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::decoding::atlas::Atlas;
use crate::gltf::decoding::model::Model;
use crate::gltf::document::Document;
use crate::gltf::primitive::{self, triangle_mode};

pub use self::extent::{Extent, extent};

mod extent;
mod vertices;

/// Triangles of one primitive.
pub struct MeshPrimitive {
    /// Index of their material.
    pub material: usize,
    /// Whether it emits.
    pub emits: bool,
    /// Their corners, counter-clockwise seen from the front.
    pub triangles: Vec<[Corner; 3]>,
}

/// Whether a primitive's material emits.
pub fn emits(document: &Document, primitive: &Primitive) -> bool {
    let material = primitive.material.and_then(|material| document.root.materials.get(material.value()));
    material.is_some_and(|material| material.emissive_factor.0 != [0.0; 3])
}

/// Primitive with triangles.
pub struct Surface<'a> {
    model: &'a Model,
    /// The primitive.
    pub primitive: &'a Primitive,
    /// Its name in messages.
    pub owner: String,
    /// Index of its material.
    pub material: usize,
    mode: Mode,
    mapping: Option<Mapping>,
    atlas: Option<Atlas>,
}

/// Calls a function with every primitive of an instance that has triangles.
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

/// Corners of a triangle whose front a mirror turns over.
pub fn turned_over([a, b, c]: [Corner; 3], is_mirrored: bool) -> [Corner; 3] {
    if is_mirrored { [a, c, b] } else { [a, b, c] }
}

impl Surface<'_> {
    /// Reader of its accessors.
    pub fn accessors<'a>(&'a self, context: &ImportContext<'a>) -> AccessorReader<'a> {
        AccessorReader::new(self.model, context, &self.owner)
    }

    /// Reads the corners of its triangles, counter-clockwise, each one of so many vertices.
    pub fn faces(&self, context: &ImportContext<'_>, vertices: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let indices = primitive::indices(self.model, context, self.primitive, vertices, &self.owner)?;
        Ok(primitive::faces(&indices, self.mode).collect())
    }

    /// Whether corners of its triangles have coordinates of their own, which no vertex has.
    pub fn is_coloured(&self) -> bool {
        self.atlas.is_some()
    }

    /// Gives the corners of a triangle their coordinates on an image of vertex colours, if there is one.
    pub fn colour(&self, face: usize, [a, b, c]: &mut [Corner; 3]) {
        if let Some(atlas) = self.atlas {
            [a.uv, b.uv, c.uv] = atlas.corners(face);
        }
    }

    /// Reads its vertices, placed.
    pub fn vertices(
        &self,
        context: &mut ImportContext<'_>,
        to_world: &DAffine3,
    ) -> Result<Vec<Corner>, SceneError> {
        vertices::read(self, context, to_world)
    }
}
