//! Primitives with triangles.

use gltf::json::mesh::{Mode, Primitive};

use crate::SceneError;
use crate::corner::Corner;
use crate::gltf::accessor::AccessorReader;
use crate::gltf::context::ImportContext;
use crate::gltf::decoding::atlas::Atlas;
use crate::gltf::decoding::model::Model;
use crate::gltf::primitive;
use crate::gltf::scene_builder::texture::Mapping;

/// A primitive with triangles.
pub struct Surface<'a> {
    pub(super) model: &'a Model,
    /// The primitive.
    pub primitive: &'a Primitive,
    /// Name in messages.
    pub owner: String,
    /// Index of the material.
    pub material: usize,
    pub(super) mode: Mode,
    pub(super) mapping: Option<Mapping>,
    pub(super) atlas: Option<Atlas>,
}

impl Surface<'_> {
    /// Reader of the primitive's accessors.
    pub fn accessors<'a>(&'a self, context: &ImportContext<'a>) -> AccessorReader<'a> {
        AccessorReader::new(self.model, context, &self.owner)
    }

    /// Reads the corners of its triangles, counter-clockwise; checks that each is below the number of vertices.
    pub fn faces(&self, context: &ImportContext<'_>, vertices: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let indices = primitive::indices(self.model, context, self.primitive, vertices, &self.owner)?;
        Ok(primitive::faces(&indices, self.mode).collect())
    }

    /// Whether corners have their own coordinates, on an image of vertex colours.
    pub fn is_coloured(&self) -> bool {
        self.atlas.is_some()
    }

    /// Sets a triangle's coordinates on an image of vertex colours, if there is one.
    pub fn colour(&self, face: usize, [a, b, c]: &mut [Corner; 3]) {
        if let Some(atlas) = self.atlas {
            [a.uv, b.uv, c.uv] = atlas.corners(face);
        }
    }
}
