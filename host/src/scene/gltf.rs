//! Reads glTF 2.0 (.gltf, .glb) into [`Scene::from_parts`]. Imports the crate gltf's document types.
//!
//! The document is walked by checked look-ups only: whatever a file holds, it gives a scene or an error. Photometric
//! values are taken as radiometric ones, number for number.

use std::path::Path;

use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DVec3, Vec3};

use self::document::Document;
use self::mesh::Corner;
use super::motion::Motion;
use super::moving::MovingMesh;
use super::texture::{CornerCoordinates, TextureParts};
use super::{Scene, SceneError, geometry};

mod accessor;
mod animation;
mod buffer;
mod document;
mod image;
mod material;
pub mod mesh;
mod node;
#[cfg(test)]
mod tests;
mod texture;
mod unsupported;

/// Triangles of a scene at most: ids have 31 bits, and this many fill the memory of a large machine.
const MOST_TRIANGLES: usize = 1 << 28;

impl Scene {
    /// Loads a .gltf or .glb file. Every error names the file and what to do.
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        let file = path.display().to_string();
        let bytes = buffer::read_file(path)
            .map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
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

/// Reads a scene from a file's bytes; other files are looked for in `folder`.
fn read(file: &str, bytes: &[u8], folder: &Path) -> Result<Scene, SceneError> {
    let mut document = Document::read(file, bytes, folder)?;
    let placed = node::place(&mut document)?;
    if placed.cameras.is_empty() {
        return Err(SceneError::NoCamera { file: file.into() });
    }

    let texture::Read { parts, mappings } = texture::read(&mut document)?;

    // Bring every mesh that stands still into the world in f64.
    let mut corners: Vec<[Corner; 3]> = Vec::new();
    let mut materials_of: Vec<usize> = Vec::new();
    let mut moving = Vec::new();
    let mut dropped = 0;
    let mut count = 0;
    for instance in &placed.meshes {
        let (mut own, mut own_materials) = (Vec::new(), Vec::new());
        for mesh::Part { material, triangles } in mesh::read(&mut document, instance, &mappings)? {
            count += triangles.len();
            if instance.moves {
                own_materials.resize(own_materials.len() + triangles.len(), material as u32);
                own.extend(triangles);
            } else {
                materials_of.resize(materials_of.len() + triangles.len(), material);
                corners.extend(triangles);
            }
        }
        if count > MOST_TRIANGLES {
            let what = format!("makes more than {MOST_TRIANGLES} triangles in all");
            return Err(SceneError::Mesh { file: file.into(), mesh: instance.node.clone(), what });
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
    let (lower, upper) = all.fold((DVec3::MAX, DVec3::MIN), |(lower, upper), p| (lower.min(p), upper.max(p)));
    let is_empty = corners.is_empty() && moving.is_empty();
    let origin = if is_empty { DVec3::ZERO } else { 0.5 * (lower + upper) };
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
    let warnings = document.warnings.into_iter().chain(scene.warnings).collect();
    Ok(Scene { origin, background: document.background, warnings, ..scene })
}

/// A vector of the file.
fn vector(values: [f32; 3]) -> DVec3 {
    Vec3::from(values).as_dvec3()
}
