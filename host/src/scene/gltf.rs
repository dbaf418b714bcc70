//! Reads glTF 2.0 (.gltf, .glb) into [`Scene::from_parts`]. Imports the crate gltf's document types.
//!
//! The document is walked by checked look-ups only: whatever a file holds, it gives a scene or an error. Photometric
//! values are taken as radiometric ones, number for number.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DVec3, Vec3};

use self::document::Document;
use self::mesh::{Corner, Extent};
use self::node::MeshInstance;
use super::motion::Motion;
use super::moving::MovingMesh;
use super::texture::{CornerCoordinates, TextureParts};
use super::{Scene, SceneError, geometry};
use crate::file::read_file;

mod accessor;
mod animation;
mod buffer;
mod document;
pub mod files;
mod huge;
mod image;
mod material;
pub mod mesh;
mod node;
mod shape;
#[cfg(test)]
mod tests;
mod texture;
mod unsupported;
mod warning;

/// Triangles of a scene at most: ids have 31 bits, and this many fill the memory of a large machine.
const MAX_TRIANGLES: u64 = 1 << 28;
/// Memory that a triangle takes while its scene is read, at most (bytes). Measured as the growth of the peak of `scene info`
/// with triangles: 711 of plain ones, 806 to 832 with texture coordinates and tangents; 510 to 580 where they move.
const TRIANGLE_BYTES: u64 = 850;
/// Memory that a vertex of a primitive takes until its triangles are made (bytes). Measured the same way with vertices that one
/// triangle refers to: 104 of plain ones, 128 with texture coordinates and tangents.
const VERTEX_BYTES: u64 = 130;

impl Scene {
    /// Loads a .gltf or .glb file, at time 0 of its animations; [`resolve`](super::resolve) finds the file of a scene by name.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is damaged, requires an extension that is not supported, or would not fit into memory. Every
    /// error names the file and what to do. What is merely left out stands in [`Scene::warnings`].
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        let file = path.display().to_string();
        let bytes =
            read_file(path).map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
        let mut scene = read(&file, &bytes, path.parent().unwrap_or(Path::new("")))?;
        scene.name = scene_name(path);
        Ok(scene)
    }
}

/// The file's stem, or its folder's name where the stem says nothing.
fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let folder = path.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.unwrap_or(stem).to_string_lossy().into_owned()
}

/// Reads a scene that is one file, from its bytes.
pub(crate) fn read_alone(bytes: &[u8]) -> Result<Scene, SceneError> {
    read("scene", bytes, Path::new("/no folder"))
}

/// Reads a scene from a file's bytes; other files are looked for in `folder`.
fn read(file: &str, bytes: &[u8], folder: &Path) -> Result<Scene, SceneError> {
    let mut document = Document::read(file, bytes, folder)?;
    let placed = node::place(&mut document)?;
    if placed.cameras.is_empty() {
        return Err(SceneError::NoCamera { file: file.into() });
    }

    let triangle_count = take_triangles(&mut document, &placed.meshes)?;
    let texture::Read { parts, mappings } = texture::read(&mut document)?;

    // Bring every mesh that stands still into the world in f64.
    let mut corners: Vec<[Corner; 3]> = Vec::new();
    if !placed.meshes.iter().any(|mesh| mesh.moves) {
        corners.reserve_exact(triangle_count);
    }
    let mut materials_of: Vec<usize> = Vec::new();
    let mut moving = Vec::new();
    let mut dropped = 0;
    for instance in &placed.meshes {
        let (mut own, mut own_materials) = (Vec::new(), Vec::new());
        for mesh::Part { material, triangles } in mesh::read(&mut document, instance, &mappings)? {
            if instance.moves {
                own_materials.resize(own_materials.len() + triangles.len(), material as u32);
                own.extend(triangles);
            } else {
                materials_of.resize(materials_of.len() + triangles.len(), material);
                corners.extend(triangles);
            }
        }
        let (mesh, lost) = MovingMesh::new(instance.joint, own, own_materials);
        dropped += lost;
        if !mesh.corners.is_empty() {
            moving.push(mesh);
        }
    }

    // Recentre, so that f32 is finest where the scene is.
    let still = corners.iter().flatten().map(|corner| corner.position);
    let all = still.chain(moving.iter().flat_map(|mesh| mesh.world(&placed.places[mesh.joint])));
    let all: Vec<DVec3> = all.collect();
    let details = huge::details(all.as_chunks().0.iter().copied());
    let (lower, upper) =
        all.iter().fold((DVec3::MAX, DVec3::MIN), |(lower, upper), &p| (lower.min(p), upper.max(p)));
    let origin = match details.first() {
        Some(smallest) => smallest.centre,
        None if all.is_empty() => DVec3::ZERO,
        None => 0.5 * (lower + upper),
    };
    huge::split(&details, &mut corners, &mut materials_of);
    let local = |position: DVec3| (position - origin).as_vec3();

    let (triangles, surfaces) = corners
        .iter()
        .zip(&materials_of)
        .map(|([a, b, c], &material)| {
            let triangle = Triangle { a: local(a.position), b: local(b.position), c: local(c.position) };
            let face = geometry::face_normal(&triangle);
            let normal = |corner: &Corner| corner.normal.unwrap_or(face);
            let surface = TriangleSurface {
                normal_a: normal(a),
                normal_b: normal(b),
                normal_c: normal(c),
                material: material as u32,
                ..TriangleSurface::default()
            };
            (triangle, surface)
        })
        .unzip();
    let coordinates = if parts.textures.is_empty() {
        Vec::new()
    } else {
        let row = |corners: &[Corner; 3]| {
            let [a, b, c] = corners.map(|corner| corner.tangent);
            let tangents = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
            CornerCoordinates { uv: corners.map(|corner| corner.uv), tangents }
        };
        corners.iter().map(row).collect()
    };
    let parts = TextureParts { coordinates, ..parts };
    let places = |joint: usize| &placed.places[joint];
    let mut lights = Vec::new();
    for mounted in &placed.lights {
        match mounted.what.placed(places(mounted.joint), origin) {
            Some(light) => lights.push(light),
            None if mounted.moves => {}
            None => {
                let node = placed.rig.joints[mounted.joint].label.clone();
                let what = "its light has no direction (a scale of zero)".into();
                return Err(SceneError::Node { file: file.into(), node, what });
            }
        }
    }
    let cameras =
        placed.cameras.iter().map(|mounted| mounted.what.placed(places(mounted.joint), origin)).collect();

    let (materials, names) = material::read_all(&mut document);
    let moves = placed.rig.joints.iter().any(|joint| joint.moves);
    let motion = moves.then_some(Motion {
        file: file.into(),
        rig: placed.rig,
        cameras: placed.cameras,
        lights: placed.lights,
        meshes: moving,
        ..Motion::default()
    });
    let mut scene =
        Scene::assemble(file, triangles, surfaces, materials, names, lights, cameras, parts, origin, motion)?;
    scene.dropped_triangles += dropped;
    if scene.lights.is_empty() && !scene.motion.as_ref().is_some_and(Motion::has_light) {
        return Err(SceneError::NoLight { file: file.into() });
    }
    let warnings = document.warnings.lines(file).into_iter().chain(scene.warnings).collect();
    Ok(Scene { origin, background: document.background, warnings, ..scene })
}

/// Takes memory for all triangles, by the accessors of every mesh and the nodes that place it. How many there are.
fn take_triangles(document: &mut Document, meshes: &[MeshInstance]) -> Result<usize, SceneError> {
    let mut extents: HashMap<usize, Extent> = HashMap::new();
    let (mut triangles, mut vertices) = (0_u64, 0_u64);
    for instance in meshes {
        let extent = match extents.entry(instance.mesh.value()) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(entry) => *entry.insert(mesh::extent(document, instance)?),
        };
        triangles = triangles.saturating_add(extent.triangles);
        vertices = vertices.max(extent.vertices);
        if triangles > MAX_TRIANGLES {
            let what = format!("makes more than {MAX_TRIANGLES} triangles in all");
            return Err(SceneError::Mesh { file: document.file.clone(), mesh: instance.node.clone(), what });
        }
    }
    let bytes = triangles * TRIANGLE_BYTES + vertices.saturating_mul(VERTEX_BYTES);
    document.take(bytes, format_args!("its {triangles} triangles"))?;
    Ok(triangles as usize)
}

/// A vector of the file.
fn vector(values: [f32; 3]) -> DVec3 {
    Vec3::from(values).as_dvec3()
}
