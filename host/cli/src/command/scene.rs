//! `caustics scene list|info|make`.

use std::path::Path;
use std::process::ExitCode;

use caustics::output::target::TargetError;
use caustics::scene::{self, Scene};
use caustics::text::cut;
use caustics_kernels::interface::features::Features;
use serde_json::json;

use super::console::print;
use crate::cli;

/// Runs a command on scenes.
pub fn run(command: cli::SceneCommand) -> anyhow::Result<ExitCode> {
    match command {
        cli::SceneCommand::List => list()?,
        cli::SceneCommand::Info { scene, specular_roughness, loading, json } => {
            info(&scene, specular_roughness, &loading, json)?;
        }
        cli::SceneCommand::Survey(options) => return super::survey::run(&options),
        cli::SceneCommand::Make { name, output, force } => make(&name, output.as_deref(), force)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Makes one scene, or all committed scenes.
fn make(name: &str, output: Option<&Path>, force: bool) -> anyhow::Result<()> {
    let committed = &caustics_scenes::NAMES[..];
    let known = [committed, &caustics_scenes::ON_DEMAND].concat();
    if name != "all" && !known.contains(&name) {
        let known = known.join(", ");
        return Err(cli::Usage(format!("no scene {name:?} can be made; known are {known}, all")).into());
    }
    let wanted = if name == "all" { committed } else { &[name] };
    let on_demand = caustics_scenes::ON_DEMAND.contains(&name);
    let output = output.unwrap_or(Path::new(if on_demand { scene::MADE } else { "scenes" }));
    // Make all or none.
    let there = wanted.iter().map(|scene| output.join(scene).join("scene.gltf"));
    if let Some(file) = there.into_iter().find(|file| !force && file.exists()) {
        return Err(TargetError::Exists(file).into());
    }
    for scene in wanted {
        print(caustics_scenes::make(scene, output, force)?.display())?;
    }
    Ok(())
}

fn list() -> std::io::Result<()> {
    let there = scene::names();
    let is_there = |name: &str| there.iter().any(|n| n == name);
    let description = |name: &str| caustics_scenes::description(name).unwrap_or_default();
    for name in caustics_scenes::NAMES {
        let missing = if is_there(name) { "" } else { " (not made yet: caustics scene make)" };
        print(format_args!("{name:14} {}{missing}", description(name)))?;
    }
    for name in caustics_scenes::ON_DEMAND {
        let how = if is_there(name) { String::new() } else { format!(": caustics scene make {name}") };
        print(format_args!("{name:14} {} (made on demand{how})", description(name)))?;
    }
    let known = [&caustics_scenes::NAMES[..], &caustics_scenes::ON_DEMAND].concat();
    for name in there.iter().filter(|name| !known.contains(&name.as_str())) {
        print(name)?;
    }
    Ok(())
}

fn info(
    argument: &str,
    specular_roughness: f32,
    loading: &cli::Loading,
    as_json: bool,
) -> anyhow::Result<()> {
    let file = scene::resolve(argument)?;
    let scene = Scene::load_with(&file, &loading.options())?;
    let features = scene.features(specular_roughness);
    let depth = useful_bounces(features);
    if as_json {
        let info = json!({
            "name": scene.name,
            "file": file,
            "triangles": scene.triangles.len(),
            "instances": scene.instanced.instances.len(),
            "dropped_triangles": scene.dropped_triangles,
            "materials": scene.material_names,
            "textures": scene.textures.textures.len(),
            "texels": scene.textures.texels.len(),
            "background": scene.background.to_array(),
            "lights": scene.lights.len(),
            "flux_w": scene.flux.to_array(),
            "cameras": scene.cameras.iter().map(|camera| &camera.name).collect::<Vec<_>>(),
            "duration_s": scene.duration(),
            "moving": scene.moving_nodes(),
            "bvh_nodes": scene.nodes.len(),
            "features": feature_names(features),
            "deepest_useful_prefix": depth,
            "warnings": scene.warnings,
        });
        print(serde_json::to_string_pretty(&info)?)?;
        return Ok(());
    }
    print(format_args!("{} ({})", scene.name, file.display()))?;
    print(format_args!(
        "triangles  {} ({} without an area dropped)",
        scene.triangles.len(),
        scene.dropped_triangles
    ))?;
    let (meshes, instances) = (scene.instanced.meshes.len(), scene.instanced.instances.len());
    if instances > 0 {
        print(format_args!(
            "instances  {instances} of {meshes} meshes with {} of the triangles",
            scene.instanced.triangle_count()
        ))?;
    }
    print(format_args!("materials  {}", joined(scene.material_names.iter().map(String::as_str))))?;
    let texels = scene.textures.texels.len();
    print(format_args!("textures   {}, {texels} texels with all levels", scene.textures.textures.len()))?;
    print(format_args!(
        "lights     {}, {:.4} W in all channels",
        scene.lights.len(),
        scene.flux.element_sum()
    ))?;
    print(format_args!("cameras    {}", joined(scene.cameras.iter().map(|camera| camera.name.as_str()))))?;
    if scene.is_animated() {
        print(format_args!(
            "animation  {:.3} s, moves {}",
            scene.duration(),
            joined(scene.moving_nodes().into_iter())
        ))?;
    }
    print(format_args!("bvh        {} nodes, {} leaves", scene.nodes.len(), scene.blocks.len()))?;
    print(format_args!("features   {}", feature_names(features).join(", ")))?;
    let unlimited = "as many as --max-bounces allows".to_string();
    print(format_args!(
        "prefix     {}",
        depth.map_or(unlimited, |depth| format!("{depth} vertex, nothing is specular"))
    ))?;
    for warning in &scene.warnings {
        print(format_args!("warning    {}", cut(warning, 1200)))?;
    }
    Ok(())
}

/// Joins names from the file on one line, each cut to a length.
fn joined<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let shown = |name: &str| cut(name, 80).replace('\n', "\\n");
    names.map(shown).collect::<Vec<_>>().join(", ")
}

/// Names of the features that a scene needs.
pub fn feature_names(features: Features) -> Vec<&'static str> {
    Features::NAMES.iter().filter(|(bit, _)| features.has(*bit)).map(|(_, name)| *name).collect()
}

/// Maximum number of vertices of a camera prefix: one where nothing is specular, else the bounce limit decides.
fn useful_bounces(features: Features) -> Option<u32> {
    (!features.has(Features::CASTERS)).then_some(1)
}
