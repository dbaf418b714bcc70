//! Vertices of primitives, transformed to the world.

use glam::{DAffine3, DMat3, Vec2, Vec3};
use gltf::json::mesh::Semantic;

use super::surface::Surface;
use crate::SceneError;
use crate::corner::{Corner, placed, turned};
use crate::gltf::context::ImportContext;
use crate::gltf::primitive::attribute;
use crate::gltf::scene_builder::texture::Mapping;

/// Maximum texture coordinate.
const MAX_COORDINATE: f32 = 1e6;

/// Texture coordinates and tangents of a primitive's vertices.
#[derive(Default)]
struct Coordinates {
    uvs: Vec<Vec2>,
    /// Empty if the file has none.
    tangents: Vec<[f32; 4]>,
}

impl Surface<'_> {
    /// Reads the vertices and transforms them.
    pub fn vertices(
        &self,
        context: &mut ImportContext<'_>,
        to_world: &DAffine3,
    ) -> Result<Vec<Corner>, SceneError> {
        let (primitive, owner) = (self.primitive, &self.owner);
        let accessors = self.accessors(context);
        let positions = attribute(primitive, Semantic::Positions)
            .ok_or_else(|| context.mesh_error(owner, "has no POSITION"))?;
        let positions = accessors.numbers::<3>(positions)?;
        let normals = attribute(primitive, Semantic::Normals)
            .map(|normals| accessors.vertex_attribute::<3>(normals, positions.len(), "normals"))
            .transpose()?;
        let coordinates = match self.mapping {
            Some(mapping) => coordinates(self, context, mapping, positions.len())?,
            None => Coordinates::default(),
        };

        // Transform vertices to the world
        let turn = to_world.matrix3.inverse().transpose();
        let mut corners = Vec::with_capacity(positions.len());
        for (id, &position) in positions.iter().enumerate() {
            let position = to_world.transform_point3(Vec3::from(position).as_dvec3());
            if !position.is_finite() {
                return Err(context.mesh_error(owner, format!("vertex {id} is not finite")));
            }
            let normal = match &normals {
                Some(normals) => normal(context, &turn, normals[id], id, owner)?,
                None => None,
            };
            let uv = coordinates.uvs.get(id).copied().unwrap_or_default();
            let tangent = coordinates.tangents.get(id).and_then(|&tangent| placed(to_world, tangent));
            corners.push(Corner { position, normal, uv, tangent });
        }
        Ok(corners)
    }
}

/// Normal of a vertex; `None`, with a warning, if it is not usable.
fn normal(
    context: &mut ImportContext<'_>,
    turn: &DMat3,
    normal: [f32; 3],
    id: usize,
    owner: &str,
) -> Result<Option<Vec3>, SceneError> {
    match turned(turn, normal) {
        Ok(normal) => Ok(normal),
        Err(what) => {
            let error = context.mesh_error(owner, format!("normal {id} {what}"));
            context.replace(owner, &format!("a normal {what}"), "the face's is taken", error)?;
            Ok(None)
        }
    }
}

/// Reads texture coordinates and tangents.
fn coordinates(
    surface: &Surface<'_>,
    context: &mut ImportContext<'_>,
    mapping: Mapping,
    count: usize,
) -> Result<Coordinates, SceneError> {
    let (primitive, owner, set) = (surface.primitive, &surface.owner, mapping.set);
    let accessors = surface.accessors(context);
    let Some(uvs) = attribute(primitive, Semantic::TexCoords(set)) else {
        let what = format!("has no TEXCOORD_{set}, which the textures of its material need");
        let error = context.mesh_error(owner, &what);
        context.replace(owner, &what, "every vertex is at (0, 0) of them", error)?;
        return Ok(Coordinates { uvs: vec![Vec2::ZERO; count], tangents: Vec::new() });
    };
    let mut uvs: Vec<_> = accessors
        .vertex_attribute::<2>(uvs, count, "texture coordinates")?
        .into_iter()
        .map(|uv| mapping.transformed(Vec2::from(uv)))
        .collect();
    let usable = |uv: &Vec2| uv.is_finite() && uv.abs().max_element() <= MAX_COORDINATE;
    if let Some(id) = uvs.iter().position(|uv| !usable(uv)) {
        let what = "is not finite or beyond 1e6";
        let error = context.mesh_error(owner, format!("texture coordinate {id} {what}"));
        context.replace(owner, &format!("a texture coordinate {what}"), "taken as (0, 0)", error)?;
        uvs.iter_mut().filter(|uv| !usable(uv)).for_each(|uv| *uv = Vec2::ZERO);
    }
    let tangents = attribute(primitive, Semantic::Tangents)
        .filter(|_| mapping.has_normal_map)
        .map(|tangents| accessors.vertex_attribute::<4>(tangents, count, "tangents"))
        .transpose()?;
    Ok(Coordinates { uvs, tangents: tangents.unwrap_or_default() })
}
