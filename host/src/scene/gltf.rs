//! Reads glTF 2.0 (.gltf, .glb) into [`SceneParts`]. Imports the crate gltf's document types.
//!
//! The document is walked by checked look-ups only: whatever a file holds, it gives a scene or an error. Photometric
//! values are taken as radiometric ones, number for number.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use self::document::Document;
use self::geometry::Geometry;
use self::mesh::Extent;
use self::node::MeshInstance;
use self::options::LoadOptions;
use super::motion::Motion;
use super::{Scene, SceneError, SceneParts};
use crate::file::read_file;

mod accessor;
mod animation;
mod atlas;
mod buffer;
mod colors;
mod document;
mod draco;
mod environment;
mod extension;
pub mod files;
mod geometry;
mod huge;
mod image;
mod image_based;
mod instancing;
mod material;
mod mesh;
mod meshopt;
mod node;
pub mod options;
mod shape;
#[cfg(test)]
mod tests;
mod texture;
mod translate;
mod unsupported;
mod warning;

/// Triangles of a scene at most: ids have 31 bits, and this many fill the memory of a large machine.
const MAX_TRIANGLES: u64 = 1 << 28;
/// Vertices that are read at most, those of a mesh once for each node that places it: a minute's work.
const MAX_VERTICES: u64 = 1 << 31;
/// Memory that a triangle takes while its scene is read, at most (bytes). Measured as the growth of the peak of `scene info`
/// with triangles: 711 of plain ones, 806 to 832 with texture coordinates and tangents; 510 to 580 where they move.
const TRIANGLE_BYTES: u64 = 850;
/// Memory that a vertex of a primitive takes until its triangles are made (bytes). Measured the same way with vertices that one
/// triangle refers to: 104 of plain ones, 128 with texture coordinates and tangents.
const VERTEX_BYTES: u64 = 130;

impl Scene {
    /// Loads a .gltf or .glb file, at time 0 of its animations; it may be dark and have no camera ([`Scene::add_default_light`],
    /// [`Scene::place_camera`]). [`resolve`](super::resolve) finds the file of a scene by name.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is damaged, requires an extension that is not supported, or would not fit into memory. Every
    /// error names the file and what to do. What is merely left out stands in [`Scene::warnings`].
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        Scene::load_with(path, &LoadOptions::default())
    }

    /// Loads a .gltf or .glb file in a way of the caller's; what [`Scene::load`] says holds else.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::load`], and with [`LoadOptions::strict`] where something would be replaced.
    pub fn load_with(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
        let file = path.display().to_string();
        let bytes =
            read_file(path).map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
        let mut scene = read(&file, &bytes, path.parent().unwrap_or(Path::new("")), options)?;
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
    read("scene", bytes, Path::new("/no folder"), &LoadOptions::default())
}

/// Reads a scene from a file's bytes; other files are looked for in `folder`.
fn read(file: &str, bytes: &[u8], folder: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let mut document = Document::read(file, bytes, folder, options)?;
    meshopt::decompress(&mut document)?;
    draco::decompress(&mut document)?;
    colors::bake(&mut document)?;
    let placed = node::place(&mut document)?;

    // Take memory before anything large is decoded; textures say what a mesh has to carry.
    let triangle_count = take_triangles(&mut document, &placed.meshes)?;
    let texture::Read { mut parts, mappings } = texture::read(&mut document)?;
    let mut geometry = Geometry::read(&mut document, &placed, &mappings, triangle_count)?;

    // Bring everything into a world around its origin.
    let origin = geometry.centre(&placed.places);
    let (triangles, surfaces) = geometry.rows(origin);
    if !parts.textures.is_empty() {
        parts.coordinates = geometry.coordinates();
    }
    let (lights, cameras) = (placed.lights_around(file, origin)?, placed.cameras_around(origin));
    let (materials, material_names) = material::read_all(&mut document)?;
    material::name_blended_media(&mut document, &materials, &material_names, &parts);
    let moves = placed.rig.joints.iter().any(|joint| joint.moves);
    let motion = moves.then_some(Motion {
        file: file.into(),
        rig: placed.rig,
        cameras: placed.cameras,
        lights: placed.lights,
        meshes: geometry.moving,
        ..Motion::default()
    });

    let textures = parts;
    let name = file.into();
    let mut parts = SceneParts {
        name,
        triangles,
        surfaces,
        materials,
        material_names,
        lights,
        cameras,
        textures,
        origin,
        motion,
        bounds: None,
    };
    let has_floor = options.floor && !parts.is_empty();
    if has_floor {
        parts.add_floor();
    }
    let mut scene = parts.build()?;
    if has_floor {
        scene.additions.insert("floor", "a Lambertian square of albedo 0.5 under the bounds".into());
    }
    scene.dropped_triangles += geometry.dropped;
    if let Some(map) = environment::read(&mut document)? {
        scene.set_environment(map)?;
    }
    let warnings = document.warnings.lines(file).into_iter().chain(scene.warnings).collect();
    Ok(Scene { background: document.background, warnings, ..scene })
}

/// Takes memory for all triangles, by the accessors of every mesh and the nodes that place it. How many there are.
fn take_triangles(document: &mut Document, meshes: &[MeshInstance]) -> Result<usize, SceneError> {
    let mut extents: HashMap<usize, Extent> = HashMap::new();
    let (mut triangles, mut vertices, mut read) = (0_u64, 0_u64, 0_u64);
    for instance in meshes {
        let extent = match extents.entry(instance.mesh.value()) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(entry) => *entry.insert(mesh::extent(document, instance)?),
        };
        triangles = triangles.saturating_add(extent.triangles);
        vertices = vertices.max(extent.vertices);
        read = read.saturating_add(extent.vertices);
        if read > MAX_VERTICES {
            let what = format!("reads more than {MAX_VERTICES} vertices in all");
            return Err(SceneError::Mesh { file: document.file.clone(), mesh: instance.node.clone(), what });
        }
        if triangles > MAX_TRIANGLES {
            let what = format!("makes more than {MAX_TRIANGLES} triangles in all");
            return Err(SceneError::Mesh { file: document.file.clone(), mesh: instance.node.clone(), what });
        }
    }
    let bytes = triangles * TRIANGLE_BYTES + vertices.saturating_mul(VERTEX_BYTES);
    document.take(bytes, format_args!("its {triangles} triangles"))?;
    Ok(triangles as usize)
}
