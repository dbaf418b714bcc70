//! Builds the scene that a decoded document shows.

use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;

use self::geometry::Geometry;
use self::node::WorldMesh;
use self::sharing::Sharing;
use super::decoding;
use super::document::Document;
use crate::motion::Motion;
use crate::{Scene, SceneError, SceneParts};

mod animation;
mod deformation;
mod environment;
mod geometry;
mod huge;
mod image;
mod image_based;
mod instancing;
mod material;
pub mod mesh;
mod node;
pub mod sharing;
mod texture;

/// What a document shows.
pub fn scene_of(mut document: Document) -> Result<Scene, SceneError> {
    let file = &document.file.clone();
    decoding::decode(&mut document)?;
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
