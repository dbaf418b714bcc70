//! What a person should know of a scene before it is rendered.

use caustics::scene::Scene;
use caustics::settings::Settings;
use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light;
use caustics_kernels::method::Method;

/// Says what will be missing.
pub fn warn(scene: &Scene, method: &Method, settings: &Settings) {
    for warning in &scene.warnings {
        message!("warning: {warning}");
    }
    let has_casters = scene.features(settings.specular_roughness).has(Features::CASTERS);
    // A path that leaves the scene finds the environment.
    let has_no_size = |light: &Light| light.triangle == NONE && light.kind != Features::ENVIRONMENT.0;
    if !method.gathers && has_casters && scene.lights.iter().any(has_no_size) {
        message!(
            "warning: no path finds a light without a size: caustics of point, spot and directional lights are \
             missing; render --method progressive sees them"
        );
    }
}
