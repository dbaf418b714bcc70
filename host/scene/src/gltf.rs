//! Reads glTF 2.0 (.gltf, .glb) into [`SceneParts`]. Imports the crate gltf's document types.
//!
//! The document is walked by checked look-ups only: whatever a file holds, it gives a scene or an error. Photometric
//! values are taken as radiometric ones, number for number.

use std::path::Path;

use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;

use self::document::Document;
use self::geometry::Geometry;
use self::node::WorldMesh;
use self::options::LoadOptions;
use self::sharing::Sharing;
use super::motion::Motion;
use super::{Scene, SceneError, SceneParts};
use caustics_files::file::read_file;

mod accessor;
mod animation;
mod atlas;
mod buffer;
mod colors;
mod deformation;
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
mod required;
mod shape;
mod sharing;
#[cfg(test)]
mod tests;
mod texture;
mod translate;
mod unsupported;
mod version;
mod warning;

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
pub fn read_alone(bytes: &[u8]) -> Result<Scene, SceneError> {
    read("scene", bytes, Path::new("/no folder"), &LoadOptions::default())
}

/// Reads a scene from a file's bytes; other files are looked for in `folder`.
fn read(file: &str, bytes: &[u8], folder: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let document = Document::read(file, bytes, folder, options)?;
    let lack = document.lack.clone();
    scene_of(document).map_err(|error| required::without(lack, error))
}

/// What a document shows.
fn scene_of(mut document: Document) -> Result<Scene, SceneError> {
    let file = &document.file.clone();
    meshopt::decompress(&mut document)?;
    draco::decompress(&mut document)?;
    colors::bake(&mut document)?;
    let world = node::read(&mut document)?;

    // Take memory before anything large is decoded; textures say what a mesh has to carry.
    let sharing = Sharing::plan(&mut document, &world.meshes)?;
    let texture::Read { mut parts, mappings } = texture::read(&mut document)?;
    let mut geometry = Geometry::read(&mut document, &world, &mappings, &sharing)?;

    if geometry.is_empty() {
        return Err(nothing_to_see(&document, &world.meshes));
    }

    // Bring everything into a world around its origin.
    let origin = geometry.centre(&world.nodes);
    let (triangles, surfaces) = geometry.triangle_records(origin);
    if !parts.textures.is_empty() {
        parts.coordinates = geometry.coordinates();
    }
    let (lights, cameras) = (world.lights_around(file, origin)?, world.cameras_around(origin));
    let (materials, material_names) = material::read_all(&mut document)?;
    material::name_blended_media(&mut document, &materials, &material_names, &parts);
    let moves = world.rig.joints.iter().any(|joint| joint.moves || !joint.morph.channels.is_empty());
    let motion = moves.then_some(Motion { file: file.into(), cameras: world.cameras, lights: world.lights });

    let textures = parts;
    let name = file.clone();
    let (owners, dropped) = (geometry.owners().collect(), geometry.dropped);
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
        owners,
        instanced: geometry.into_instanced(),
        rig: world.rig,
        motion,
        bounds: None,
        bvh: document.options.bvh.clone(),
    };
    let has_floor = document.options.floor && !parts.is_empty();
    if has_floor {
        parts.add_floor();
    }
    let mut scene = parts.build()?;
    if has_floor {
        scene.additions.insert("floor", "a Lambertian square of albedo 0.5 under the bounds".into());
    }
    scene.dropped_triangles += dropped;
    if let Some(map) = environment::read(&mut document)? {
        scene.set_environment(map)?;
    }
    let warnings = document.warnings.lines(file).into_iter().chain(scene.warnings).collect();
    Ok(Scene { background: document.background, warnings, ..scene })
}

/// The error of a document without triangles.
fn nothing_to_see(document: &Document, meshes: &[WorldMesh]) -> SceneError {
    let modes = meshes.iter().filter_map(|mesh| document.root.meshes.get(mesh.mesh.value()));
    let mut modes = modes.flat_map(|mesh| &mesh.primitives).map(|primitive| primitive.mode);
    let is_thin = modes.any(|mode| {
        matches!(mode, Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip))
    });
    let (what, remedy) = match () {
        () if is_thin => (
            "has no triangles: points and lines are not rendered",
            "make surfaces of them where they come from (in Blender: lines become curves with a bevel, points instances of a \
             sphere; then convert them to meshes)",
        ),
        () if document.root.meshes.is_empty() => ("has no mesh", "export it with its objects"),
        () => ("has no triangles", "add a mesh of triangles"),
    };
    SceneError::NothingToSee { file: document.file.clone(), what: what.into(), remedy }
}
