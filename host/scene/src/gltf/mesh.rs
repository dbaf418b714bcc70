//! Meshes: primitives as triangles with corners in the world.

use glam::{DAffine3, Vec2, Vec3};
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::atlas::Atlas;
use super::document::Document;
use super::node::WorldMesh;
use super::texture::Mapping;
use super::{accessor, unsupported};
use crate::SceneError;
use crate::corner::{Corner, placed, turned};

/// The triangles of one primitive.
pub struct MeshPrimitive {
    /// Index of their material.
    pub material: usize,
    /// Whether it emits.
    pub emits: bool,
    /// Their corners, counter-clockwise seen from the front.
    pub triangles: Vec<[Corner; 3]>,
}

/// How much of a mesh there is to read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extent {
    /// Triangles.
    pub triangles: u64,
    /// Triangles of those that emit.
    pub emitting: u64,
    /// Vertices of the largest primitive.
    pub vertices: u64,
}

/// The extent of a mesh, by its accessors: none of their elements is read.
pub fn extent(document: &Document, instance: &WorldMesh) -> Result<Extent, SceneError> {
    let mesh = document.get(&document.root.meshes, instance.mesh, "mesh", &instance.node)?;
    let label = unsupported::label("mesh", instance.mesh.value(), mesh.name.as_deref());
    let mut extent = Extent::default();
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let owner = format!("{label}, primitive {index}");
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
        let vertices = positions.map_or(Ok(0), |positions| accessor::count(document, positions, &owner))?;
        let indices = primitive.indices;
        let corners =
            indices.map_or(Ok(vertices), |indices| accessor::integer_count(document, indices, &owner))?;
        let triangles = match primitive.mode {
            Checked::Valid(Mode::Triangles) => corners / 3,
            Checked::Valid(Mode::TriangleStrip | Mode::TriangleFan) => corners.saturating_sub(2),
            _ => 0,
        };
        extent.triangles = extent.triangles.saturating_add(triangles);
        if emits(document, primitive) {
            extent.emitting = extent.emitting.saturating_add(triangles);
        }
        extent.vertices = extent.vertices.max(vertices);
    }
    Ok(extent)
}

/// Whether a primitive's material emits.
pub fn emits(document: &Document, primitive: &Primitive) -> bool {
    let material = primitive.material.and_then(|material| document.root.materials.get(material.value()));
    material.is_some_and(|material| material.emissive_factor.0 != [0.0; 3])
}

/// A primitive that is read.
pub struct Surface<'a> {
    /// The primitive.
    pub primitive: &'a Primitive,
    /// How messages call it.
    pub owner: String,
    /// Index of its material.
    pub material: usize,
    mode: Mode,
    mapping: Option<Mapping>,
    atlas: Option<Atlas>,
}

/// Calls a function with every primitive of an instance that has triangles.
pub fn for_each_surface(
    document: &mut Document,
    instance: &WorldMesh,
    mappings: &[Option<Mapping>],
    mut then: impl FnMut(&mut Document, &Surface<'_>) -> Result<(), SceneError>,
) -> Result<(), SceneError> {
    let mesh = document.get(&document.root.meshes, instance.mesh, "mesh", &instance.node)?.clone();
    let label = unsupported::label("mesh", instance.mesh.value(), mesh.name.as_deref());
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let owner = format!("{label}, primitive {index}");
        let material = match primitive.material {
            Some(material) => {
                document.get(&document.root.materials, material, "material", &owner)?;
                material.value()
            }
            None => document.root.materials.len(),
        };
        let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) =
            primitive.mode
        else {
            document.warn(&owner, "points and lines are not supported; rendered without them");
            continue;
        };
        if !primitive.attributes.contains_key(&Checked::Valid(Semantic::Positions)) {
            let (file, mesh, what) = (document.file.clone(), owner.clone(), "has no POSITION".to_string());
            let error = SceneError::Mesh { file, mesh, what: what.clone() };
            document.replace(&owner, &what, "left out", error)?;
            continue;
        }
        let atlas = document.atlases.get(&material).copied();
        let mapping = mappings.get(material).copied().flatten().filter(|_| atlas.is_none());
        then(document, &Surface { primitive, owner, material, mode, mapping, atlas })?;
    }
    Ok(())
}

/// Triangles of every primitive of an instance.
pub fn read(
    document: &mut Document,
    instance: &WorldMesh,
    mappings: &[Option<Mapping>],
) -> Result<Vec<MeshPrimitive>, SceneError> {
    let mut read = Vec::new();
    for_each_surface(document, instance, mappings, |document, surface| {
        let vertices = surface.vertices(document, &instance.to_world)?;
        let faces = surface.faces(document, vertices.len())?;
        let is_mirrored = instance.to_world.matrix3.determinant() < 0.0;
        let triangle = |(face, ids): (usize, [u32; 3])| {
            let mut corners = ids.map(|id| vertices[id as usize]);
            surface.colour(face, &mut corners);
            turned_over(corners, is_mirrored)
        };
        let triangles = faces.into_iter().enumerate().map(triangle).collect();
        let emits = emits(document, surface.primitive);
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
    /// Corners of its triangles, counter-clockwise, each one of so many vertices.
    pub fn faces(&self, document: &Document, vertices: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let indices = indices(document, self.primitive, vertices, &self.owner)?;
        Ok(faces(&indices, self.mode).collect())
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

    /// Its vertices, placed.
    pub fn vertices(&self, document: &mut Document, to_world: &DAffine3) -> Result<Vec<Corner>, SceneError> {
        vertices(document, self.primitive, to_world, self.mapping, &self.owner)
    }
}

fn vertices(
    document: &mut Document,
    primitive: &Primitive,
    to_world: &DAffine3,
    mapping: Option<Mapping>,
    owner: &str,
) -> Result<Vec<Corner>, SceneError> {
    let file = document.file.clone();
    let wrong = |what: String| SceneError::Mesh { file: file.clone(), mesh: owner.into(), what };
    let attribute = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let positions = attribute(Semantic::Positions).ok_or_else(|| wrong("has no POSITION".into()))?;
    let positions = accessor::numbers::<3>(document, positions, owner)?;
    let normals = attribute(Semantic::Normals)
        .map(|normals| vertex_attribute::<3>(document, normals, positions.len(), "normals", owner))
        .transpose()?;

    let coordinates = mapping
        .map(|mapping| coordinates(document, primitive, mapping, positions.len(), owner))
        .transpose()?
        .unwrap_or_default();

    // Bring each vertex into the world.
    let turn = to_world.matrix3.inverse().transpose();
    let mut corners = Vec::with_capacity(positions.len());
    for (id, &position) in positions.iter().enumerate() {
        let position = to_world.transform_point3(Vec3::from(position).as_dvec3());
        if !position.is_finite() {
            return Err(wrong(format!("vertex {id} is not finite")));
        }
        let normal = match normals.as_ref().map(|normals| turned(&turn, normals[id])) {
            Some(Err(what)) => {
                let error = wrong(format!("normal {id} {what}"));
                let what = format!("a normal {what}");
                document.replace(owner, &what, "the face's is taken", error)?;
                None
            }
            Some(Ok(normal)) => normal,
            None => None,
        };
        let uv = coordinates.uvs.get(id).copied().unwrap_or_default();
        let tangent = coordinates.tangents.get(id).and_then(|&tangent| placed(to_world, tangent));
        corners.push(Corner { position, normal, uv, tangent });
    }

    Ok(corners)
}

/// Indices of a primitive of so many vertices, each of one that is there.
pub fn indices(
    document: &Document,
    primitive: &Primitive,
    vertices: usize,
    owner: &str,
) -> Result<Vec<u32>, SceneError> {
    let indices = match primitive.indices {
        Some(indices) => accessor::integers(document, indices, owner)?,
        None => (0..vertices as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
        let what = format!("index {index} is out of range, there are {vertices} vertices");
        return Err(SceneError::Mesh { file: document.file.clone(), mesh: owner.into(), what });
    }
    Ok(indices)
}

/// Texture coordinates and tangents of a primitive's vertices.
#[derive(Default)]
struct Coordinates {
    uvs: Vec<Vec2>,
    /// Empty where the file has none.
    tangents: Vec<[f32; 4]>,
}

fn coordinates(
    document: &mut Document,
    primitive: &Primitive,
    mapping: Mapping,
    count: usize,
    owner: &str,
) -> Result<Coordinates, SceneError> {
    let file = document.file.clone();
    let wrong = |what: String| SceneError::Mesh { file: file.clone(), mesh: owner.into(), what };
    let attribute = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let set = mapping.set;
    let Some(uvs) = attribute(Semantic::TexCoords(set)) else {
        let what = format!("has no TEXCOORD_{set}, which the textures of its material need");
        document.replace(owner, &what, "every vertex is at (0, 0) of them", wrong(what.clone()))?;
        return Ok(Coordinates { uvs: vec![Vec2::ZERO; count], tangents: Vec::new() });
    };
    let mut uvs: Vec<_> = vertex_attribute::<2>(document, uvs, count, "texture coordinates", owner)?
        .into_iter()
        .map(|uv| mapping.transformed(Vec2::from(uv)))
        .collect();
    let usable = |uv: &Vec2| uv.is_finite() && uv.abs().max_element() <= 1e6;
    if let Some(id) = uvs.iter().position(|uv| !usable(uv)) {
        let what = "is not finite or beyond 1e6";
        let error = wrong(format!("texture coordinate {id} {what}"));
        document.replace(owner, &format!("a texture coordinate {what}"), "taken as (0, 0)", error)?;
        uvs.iter_mut().filter(|uv| !usable(uv)).for_each(|uv| *uv = Vec2::ZERO);
    }
    let tangents = attribute(Semantic::Tangents)
        .filter(|_| mapping.has_normal_map)
        .map(|tangents| vertex_attribute::<4>(document, tangents, count, "tangents", owner))
        .transpose()?;
    let tangents = tangents.unwrap_or_default();
    Ok(Coordinates { uvs, tangents })
}

/// An attribute of as many elements as there are vertices; fewer or more are refused before they are read.
pub fn vertex_attribute<const N: usize>(
    document: &Document,
    index: Index<Accessor>,
    vertices: usize,
    what: &str,
    owner: &str,
) -> Result<Vec<[f32; N]>, SceneError> {
    let count = accessor::count(document, index, owner)?;
    if count != vertices as u64 {
        let what = format!("has {count} {what}, but {vertices} positions");
        return Err(SceneError::Mesh { file: document.file.clone(), mesh: owner.into(), what });
    }
    accessor::numbers(document, index, owner)
}

/// Corners of each triangle, counter-clockwise.
pub fn faces(indices: &[u32], mode: Mode) -> Box<dyn Iterator<Item = [u32; 3]> + '_> {
    let windows = indices.windows(3).enumerate();
    match mode {
        Mode::TriangleStrip => Box::new(windows.map(|(index, ids)| {
            if index % 2 == 0 { [ids[0], ids[1], ids[2]] } else { [ids[0], ids[2], ids[1]] }
        })),
        Mode::TriangleFan => {
            Box::new(windows.map(|(index, _)| [indices[index + 1], indices[index + 2], indices[0]]))
        }
        _ => Box::new(indices.as_chunks().0.iter().copied()),
    }
}
