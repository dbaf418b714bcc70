//! What a measure is a measure of: a text of all that decides it, and the text's hash.

use std::fmt::Write;

use super::cell::Cell;
use super::plan::Plan;
use crate::hash::fnv1a;
use crate::kernels;
use crate::scene::{Scene, SceneError};
use crate::settings::Settings;

/// What is seen at a time (s), whatever was seen before: a scene whose previous pose is that of the time too.
pub fn posed(scene: &Scene, time: f64) -> Result<Scene, SceneError> {
    let mut scene = scene.clone();
    scene.pose(time)?;
    scene.pose(time)?;
    Ok(scene)
}

/// Hash of all that cells of a plan share and of the cell: rows of one identity belong together. The scene is posed at
/// the first frame. The last frame is not in it: a run may grow.
pub fn of_cell(plan: &Plan, cell: &Cell, scene: &Scene) -> String {
    let mut text = view(scene, &plan.camera, &cell.settings(&plan.settings));
    let Plan { frames, fps, warm_up, time, error, moment, .. } = plan;
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "cell {} seed {} exposure {} from {} fps {fps} at {moment:?} warm-up {warm_up} time {time} error {error:?}",
        cell.key(),
        plan.settings.seed,
        plan.settings.exposure,
        frames.start
    );
    fnv1a(text.bytes())
}

/// Text of a scene as it is posed, its view and the settings that decide the expected picture, and of the kernels.
pub fn view(scene: &Scene, camera: &str, settings: &Settings) -> String {
    let Settings { width, height, light_paths, max_bounces, radius_px, .. } = settings;
    let Settings { specular_roughness, pixel_filter, texture_filter, background, .. } = settings;
    let viewpoint = scene.cameras.iter().find(|known| known.name == camera);
    format!(
        "scene {} {} origin {:?} camera {viewpoint:?} {width}x{height} paths {light_paths} bounces {max_bounces} radius \
         {radius_px} specular {specular_roughness} filter {pixel_filter} textures {texture_filter:?} background {:?} kernels {}\n",
        scene.name,
        scene.fingerprint(),
        scene.origin,
        background.unwrap_or(scene.background),
        kernels::SOURCES
    )
}
