//! What a measure is a measure of: a text of all that decides what is expected to be seen.

use caustics::kernels;
use caustics::scene::{Scene, SceneError};
use caustics::settings::Settings;

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
pub fn view(scene: &Scene, camera: &str, settings: &Settings) -> String {
    // Without dots: whoever adds a setting decides whether another image is expected.
    let Settings {
        width,
        height,
        tiles: _,
        light_paths,
        max_bounces,
        radius,
        specular_roughness,
        pixel_filter,
        texture_filter,
        background,
        seed: _,
        exposure: _,
        history: _,
        denoiser: _,
        emission: _,
        caustics,
        light_sampler: _,
        sampler: _,
        batches: _,
        path_history: _,
        fireflies: _,
        auxiliary: _,
    } = settings;
    let viewpoint = scene.camera(Some(camera)).ok();
    format!(
        "scene {} {} origin {:?} camera {viewpoint:?} {width}x{height} paths {} {caustics:?} bounces {max_bounces} radius \
         {} specular {specular_roughness} filter {} textures {texture_filter:?} background {:?} kernels {}\n",
        scene.name,
        scene.fingerprint(),
        scene.origin,
        light_paths.count(*width, *height),
        radius.px(),
        *pixel_filter as u32,
        background.unwrap_or(scene.background),
        kernels::SOURCES
    )
}
