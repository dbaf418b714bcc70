//! Identity of an expected image: a text of everything that decides it.

use caustics::kernels;
use caustics::render_config::RenderConfig;
use caustics::scene::{Scene, SceneError};

/// Returns a scene posed at a time (s) and at rest: its previous pose is the same.
pub fn posed(scene: &Scene, time: f64) -> Result<Scene, SceneError> {
    let mut scene = scene.clone();
    pose(&mut scene, time)?;
    Ok(scene)
}

/// Poses a scene at a time (s) and at rest: its previous pose becomes the same.
pub fn pose(scene: &mut Scene, time: f64) -> Result<(), SceneError> {
    scene.pose(time)?;
    scene.pose(time)
}

/// Text of a posed scene, its view, the settings that decide the expected image, and the kernels.
pub fn view(scene: &Scene, camera: &str, config: &RenderConfig) -> String {
    let viewpoint = scene.camera(Some(camera)).ok();
    format!(
        "scene {} {} origin {:?} camera {viewpoint:?} {} kernels {}\n",
        scene.name,
        scene.fingerprint(),
        scene.origin,
        config.expected_image(scene),
        kernels::SOURCES
    )
}
