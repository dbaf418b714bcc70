//! Checks of options that types cannot express, and the values that follow from them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use caustics::checkpoint;
use caustics::render_config::RenderConfig;
use caustics::rendered_image::Aov;
use caustics::scene::{self, CameraChoice, DefaultLight, EnvironmentMap, Radiance, Scene};
use caustics_bench::limits;
use caustics_bench::sweep::config::FPS;
use caustics_kernels::interface::choice::PixelFilter;
use clap::ValueEnum;
use glam::Vec3;
use serde_json::json;

use crate::cli::{Common, ImageOptions, Usage};

/// Checks the options, and returns the settings. Means of frames take the box filter by default.
pub fn config(options: &ImageOptions, config: &RenderConfig, frames: u32) -> Result<RenderConfig, Usage> {
    let (width, height) = (options.width, options.height);
    check_size(width, height)?;
    if frames == 0 {
        return Err(Usage("--frames 0: there is nothing to do; give at least 1".into()));
    }
    check_rays(config, width, height)?;
    if !(0.0..=1.0).contains(&options.specular_roughness) {
        return Err(Usage(format!("--specular-roughness {}: give 0 to 1", options.specular_roughness)));
    }
    let background = options.background.as_deref().map(color).transpose()?;
    // Means have no history, which needs the same positions again, and centres alone miss details below a pixel.
    let default = if frames > 1 { PixelFilter::Box } else { PixelFilter::Centre };
    let pixel_filter = options.pixel_filter.unwrap_or(default);
    let of_means = if frames > 1 { RenderConfig::texture_filter_of_means(pixel_filter) } else { None };
    Ok(config.with_image_of(&RenderConfig {
        width,
        height,
        tiles: options.tiles,
        specular_roughness: options.specular_roughness,
        seed: options.seed,
        pixel_filter,
        texture_filter: options.texture_filter.or(of_means),
        background: background.map(|color| color.to_array()),
        ..RenderConfig::default()
    }))
}

/// Refuses an environment that is neither a file nor a radiance, and a scale or rotation out of range.
pub fn check_environment(view: &ImageOptions) -> Result<(), Usage> {
    let ImageOptions { environment, environment_scale: scale, environment_rotation: rotation, .. } = view;
    let text = environment.as_deref().filter(|text| EnvironmentMap::file(text).is_none());
    if let Some((text, Err(wrong))) = text.map(|text| (text, text.parse::<Radiance>())) {
        return Err(Usage(format!("--environment {text}: {wrong}, or a file")));
    }
    if !(0.0..=1e30).contains(scale) {
        return Err(Usage(format!("--environment-scale {scale}: give 0 to 1e30")));
    }
    if !rotation.is_finite() {
        return Err(Usage(format!("--environment-rotation {rotation}: give a number of degrees")));
    }
    Ok(())
}

/// Refuses a frame rate out of range.
pub fn check_fps(fps: f64) -> Result<(), Usage> {
    if FPS.contains(&fps) {
        return Ok(());
    }
    Err(Usage(format!("--fps {fps}: give {} to {} frames a second", FPS.start(), FPS.end())))
}

/// Returns the environment of the options, if any.
pub fn environment(view: &ImageOptions) -> anyhow::Result<Option<EnvironmentMap>> {
    check_environment(view)?;
    let map = view.environment.as_deref().map(EnvironmentMap::named).transpose()?;
    Ok(map.map(|map| map.placed(view.environment_scale, view.environment_rotation)))
}

/// Refuses an image without pixels, or too large a one.
pub fn check_size(width: u32, height: u32) -> Result<(), Usage> {
    limits::check_size(width, height).map_err(Usage)
}

/// Refuses more rays a frame than the kernels count in 32 bits.
pub fn check_rays(config: &RenderConfig, width: u32, height: u32) -> Result<(), Usage> {
    limits::check_rays(config, width, height).map_err(Usage)
}

/// Parses the radiance of --background.
pub fn color(text: &str) -> Result<Vec3, Usage> {
    let Radiance(color) = text.parse().map_err(|wrong| Usage(format!("--background {text}: {wrong}")))?;
    Ok(color)
}

/// Checks that the output files are different files.
pub fn check_outputs(options: &Common) -> Result<(), Usage> {
    let folder = |path: &&PathBuf| path.is_dir();
    if let Some(path) = [Some(&options.output), options.png.as_ref()].into_iter().flatten().find(folder) {
        return Err(Usage(format!("{} is a folder; name a file in it", path.display())));
    }
    let checkpoint = checkpoint::path_of(&options.output);
    if checkpoint.is_dir() || options.png.as_ref().is_some_and(|png| same_file(png, &checkpoint)) {
        return Err(Usage(format!(
            "{} is where the checkpoint goes; give another name",
            checkpoint.display()
        )));
    }
    if options.png.as_ref().is_some_and(|png| same_file(png, &options.output)) {
        let path = options.output.display();
        return Err(Usage(format!("--png {path}: this is the file of -o; give another name")));
    }
    check_ending("-o", &options.output, "exr")?;
    options.png.as_ref().map_or(Ok(()), |png| check_ending("--png", png, "png"))
}

/// Refuses a file name with the extension of another kind of file.
pub fn check_ending(flag: &str, path: &Path, ending: &str) -> Result<(), Usage> {
    match path.extension() {
        Some(other) if !other.eq_ignore_ascii_case(ending) => Err(Usage(format!(
            "{flag} {}: the file will be {}; give a name that ends in .{ending}",
            path.display(),
            ending.to_uppercase()
        ))),
        _ => Ok(()),
    }
}

/// Returns the files that a scene consists of: its own, and those of `--environment` and `--edits`.
pub fn scene_files(scene: &Path, options: &Common) -> Vec<PathBuf> {
    let environment = options.view.environment.as_deref().and_then(EnvironmentMap::file);
    let others = environment.map(Into::into).into_iter().chain(options.edits.clone());
    scene::files(scene).into_iter().chain(others).collect()
}

/// Refuses to overwrite a file of the scene; `flag` names the output.
pub fn check_scene_files(scene: &[PathBuf], flag: &str, output: &Path) -> Result<(), Usage> {
    match scene.iter().find(|file| same_file(file, output)) {
        Some(file) => {
            let (file, output) = (file.display(), output.display());
            Err(Usage(format!("{flag} {output}: {file} is a file of the scene; give another name")))
        }
        None => Ok(()),
    }
}

/// Whether two paths name one file, through links too. The files need not exist.
pub fn same_file(a: &Path, b: &Path) -> bool {
    let folder = |path: &Path| match path.parent() {
        Some(parent) if parent != Path::new("") => parent.canonicalize().ok(),
        _ => Path::new(".").canonicalize().ok(),
    };
    let is_same_path = a.file_name() == b.file_name() && folder(a).is_some() && folder(a) == folder(b);
    a == b || is_same_path || is_one_file(a, b)
}

/// Whether two paths lead to one file that exists.
#[cfg(unix)]
fn is_one_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |path: &Path| path.metadata().map(|data| (data.dev(), data.ino())).ok();
    id(a).is_some() && id(a) == id(b)
}

/// Whether two paths lead to one file that exists.
#[cfg(not(unix))]
fn is_one_file(a: &Path, b: &Path) -> bool {
    a.canonicalize().ok().is_some_and(|a| Some(a) == b.canonicalize().ok())
}

/// Condition under which a scene gets the default light.
pub fn default_light(view: &ImageOptions) -> DefaultLight {
    match view {
        ImageOptions { no_default_light: true, .. } => DefaultLight::Never,
        ImageOptions { default_light: true, .. } => DefaultLight::Always,
        _ => DefaultLight::Auto,
    }
}

/// Camera that the options select.
pub fn camera(view: &ImageOptions) -> Result<CameraChoice, Usage> {
    let ImageOptions { camera, from, look_at, fov, .. } = view;
    CameraChoice::from_options(camera.as_deref(), *from, *look_at, *fov)
        .map_err(|wrong| Usage(format!("--{wrong}")))
}

/// Converts an option's seconds to a duration.
pub fn duration(flag: &str, seconds: f64) -> Result<Duration, Usage> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|_| Usage(format!("{flag} {seconds}: give a number of seconds")))
}

/// Names of layers, in a fixed order.
pub fn layer_names(layers: &[Aov]) -> String {
    let layers: BTreeSet<Aov> = layers.iter().copied().collect();
    layers.into_iter().map(Aov::name).collect::<Vec<_>>().join(",")
}

/// Returns the layers of these names.
pub fn layers_named(names: &str) -> Vec<Aov> {
    names.split(',').filter_map(|name| Aov::from_str(name, false).ok()).collect()
}

/// Attributes of a file's layers: their names, and the names of the materials.
pub fn layer_attributes(layers: &[Aov], scene: &Scene) -> Vec<(String, String)> {
    let mut attributes = Vec::new();
    if !layers.is_empty() {
        attributes.push(("aov".into(), layer_names(layers)));
    }
    if layers.contains(&Aov::Material) {
        attributes.push(("materials".into(), json!(scene.material_names).to_string()));
    }
    attributes
}
