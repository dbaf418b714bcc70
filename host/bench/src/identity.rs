//! What a measure is a measure of: a text of all that decides what is expected to be seen.

use caustics::kernels;
use caustics::render_config::RenderConfig;
use caustics::scene::{Scene, SceneError};

/// What is seen at a time (s), whatever was seen before: a scene whose previous pose is that of the time too.
pub fn posed(scene: &Scene, time: f64) -> Result<Scene, SceneError> {
    let mut scene = scene.clone();
    pose(&mut scene, time)?;
    Ok(scene)
}

/// Poses a scene at a time (s), as if it had always been there.
pub fn pose(scene: &mut Scene, time: f64) -> Result<(), SceneError> {
    scene.pose(time)?;
    scene.pose(time)
}

/// Text of a scene as it is posed, its view and the settings that decide the expected image, and of the kernels.
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
