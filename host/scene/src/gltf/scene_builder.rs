//! Stage 4, the scene builder: places, reads and assembles the contents of a decoded document.

use gltf::json::mesh::Mode;
use gltf::json::validation::Checked;

use self::geometry::Geometry;
use self::node::{WorldMesh, WorldNodes};
use self::sharing::Sharing;
use self::texture::MaterialMaps;
use super::context::ImportContext;
use super::decoding::model::Model;
use crate::animation::NodeTree;
use crate::motion::{Motion, OnNode};
use crate::texture::TextureParts;
use crate::{PunctualLight, Scene, SceneCamera, SceneError, SceneParts};

mod animation;
mod deformation;
mod environment;
mod geometry;
mod huge;
mod image;
mod image_based;
mod instancing;
mod material;
mod mesh;
mod node;
pub mod sharing;
mod texture;

/// Builds the scene of a model.
pub fn build(model: &Model, context: &mut ImportContext<'_>) -> Result<Scene, SceneError> {
    // Place nodes, meshes, cameras and lights
    let world = node::read(model, context)?;

    // Reserve memory for all triangles before large data is decoded. Textures decide which attributes of vertices are needed
    let sharing = Sharing::plan(model, context, &world.meshes)?;
    let MaterialMaps { parts: textures, mappings } = texture::read(model, context)?;
    let geometry = Geometry::read(model, context, &world, &mappings, &sharing)?;
    if geometry.is_empty() {
        return Err(nothing_to_see(model, context, &world.meshes));
    }

    // Assemble the tables
    let dropped_triangles = geometry.dropped;
    let parts = assemble(model, context, world, geometry, textures)?;
    let mut scene = build_on_floor(parts, context)?;
    scene.dropped_triangles += dropped_triangles;

    // Add the environment
    if let Some(map) = environment::read(model, context)? {
        scene.set_environment(map)?;
    }
    let warnings = context.warning_lines().into_iter().chain(scene.warnings).collect();
    Ok(Scene { background: model.background, warnings, ..scene })
}

/// Assembles all tables in a world recentred to its origin.
fn assemble(
    model: &Model,
    context: &mut ImportContext<'_>,
    world: WorldNodes,
    mut geometry: Geometry,
    mut textures: TextureParts,
) -> Result<SceneParts, SceneError> {
    // Geometry
    let origin = geometry.centre(&world.nodes);
    let (triangles, surfaces) = geometry.triangle_records(origin);
    if !textures.textures.is_empty() {
        textures.coordinates = geometry.coordinates();
    }
    // Lights and cameras
    let (lights, cameras) = (world.lights_around(context, origin)?, world.cameras_around(origin));
    // Materials
    let (materials, material_names) = material::read_all(model, context)?;
    material::warn_of_media_with_alpha(context, &materials, &material_names, &textures);

    let motion = motion(&world.rig, world.cameras, world.lights, context);
    let owners = geometry.owners().collect();
    Ok(SceneParts {
        name: context.file.into(),
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
        bvh: context.options.bvh.clone(),
    })
}

/// Cameras and lights of a node tree with moving nodes.
fn motion(
    rig: &NodeTree,
    cameras: Vec<OnNode<SceneCamera>>,
    lights: Vec<OnNode<PunctualLight>>,
    context: &ImportContext<'_>,
) -> Option<Motion> {
    let moves = rig.joints.iter().any(|joint| joint.moves || !joint.morph.channels.is_empty());
    moves.then(|| Motion { file: context.file.into(), cameras, lights })
}

/// Builds a scene, with a floor if the caller asks for one.
fn build_on_floor(mut parts: SceneParts, context: &ImportContext<'_>) -> Result<Scene, SceneError> {
    let has_floor = context.options.floor && !parts.is_empty();
    if has_floor {
        parts.add_floor();
    }
    let mut scene = parts.build()?;
    if has_floor {
        scene.additions.insert("floor", "a Lambertian square of albedo 0.5 under the bounds".into());
    }
    Ok(scene)
}

/// Error of a model without triangles.
fn nothing_to_see(model: &Model, context: &ImportContext<'_>, meshes: &[WorldMesh]) -> SceneError {
    let meshes = meshes.iter().filter_map(|mesh| model.root.meshes.get(mesh.mesh.value()));
    let mut modes = meshes.flat_map(|mesh| &mesh.primitives).map(|primitive| primitive.mode);
    let is_thin = modes.any(|mode| {
        matches!(mode, Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip))
    });
    let (what, remedy) = match () {
        () if is_thin => (
            "has no triangles: points and lines are not rendered",
            "make surfaces of them where they come from (in Blender: lines become curves with a bevel, points instances of a \
             sphere; then convert them to meshes)",
        ),
        () if model.root.meshes.is_empty() => ("has no mesh", "export it with its objects"),
        () => ("has no triangles", "add a mesh of triangles"),
    };
    SceneError::NothingToSee { file: context.file.into(), what: what.into(), remedy }
}
