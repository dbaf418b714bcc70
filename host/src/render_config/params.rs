//! The settings of a frame, as kernels get them, of a configuration and a scene.

use caustics_kernels::interface::caster::Casters;
use caustics_kernels::interface::choice::TextureFilter;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::{FrameParams, Window};
use caustics_kernels::interface::history::validation_paths;
use caustics_scene::{Scene, SceneCamera};
use glam::Vec3;

use super::{Paths, RenderConfig};

/// Largest buffer that is asked for (bytes): what lavapipe grants.
const MAX_BUFFER: u32 = 128 << 20;
/// Bytes of a row of `photon_geometry` or `photon_light`.
const PHOTON_BYTES: u32 = 32;
/// Light paths a pixel that validation paths are made for, where frames decide how many there are.
const VALIDATED_PATHS: u32 = 2;
/// Most cells of the hash grid.
const MAX_CELLS: u32 = 1 << 20;

impl RenderConfig {
    /// The settings of frame `frame` as kernels get them. Without casters, receivers or light in the scene no light path is
    /// shot, whatever code is compiled in.
    pub fn params(&self, scene: &Scene, camera: &SceneCamera, frame: u32) -> FrameParams {
        self.params_where(scene, camera, frame, !scene.lights.is_empty())
    }

    /// Settings of a frame that shoots if any frame of the scene does: buffers are allocated for it.
    pub fn largest(&self, scene: &Scene, camera: &SceneCamera) -> FrameParams {
        let can_be_lit = scene.lights_up();
        self.params_where(scene, camera, 0, can_be_lit || !scene.lights.is_empty())
    }

    fn params_where(&self, scene: &Scene, camera: &SceneCamera, frame: u32, is_lit: bool) -> FrameParams {
        let features = scene.features(self.specular_roughness);
        let caustics = features.has(Features::CASTERS) && features.has(Features::RECEIVERS);
        let shoots = caustics && is_lit && self.max_bounces > 1;
        let texture_filter = self.texture_filter.unwrap_or(TextureFilter::Cone);
        let casters = if shoots && self.emission.uses_casters {
            scene.casters(self.specular_roughness)
        } else {
            Casters::default()
        };
        let params = FrameParams {
            camera: camera.camera(self.width, self.height),
            previous_camera: camera.camera(self.width, self.height),
            width: self.width,
            height: self.height,
            window: Window::all(self.width, self.height),
            seed: self.seed,
            frame,
            max_bounces: self.max_bounces,
            filters: FrameParams::filters(self.pixel_filter, texture_filter),
            specular_roughness: self.specular_roughness,
            radius_px: self.radius.px(),
            pixel_spread: camera.pixel_spread(self.width, self.height),
            light_count: scene.lights.len() as u32,
            exposure: self.exposure.exp2(),
            background: self.background.map_or(scene.background, Vec3::from),
            history: self.history.settings.unwrap_or_default(),
            caustics: self.caustics as u32,
            light_sampler: self.light_sampler as u32,
            moved: 1,
            casters,
            sequence: self.sequence(frame),
            ..FrameParams::default()
        };
        // As many as for the usual number of light paths, where it changes from frame to frame.
        let light_paths = self.max_light_paths();
        let validated = if self.light_paths == Paths::Auto {
            self.width * self.height * VALIDATED_PATHS
        } else {
            light_paths
        };
        let validates = shoots && self.history.validates;
        let validation_path_count = if validates { validation_paths(validated) } else { 0 };
        let params = FrameParams { validation_path_count, ..params };
        let params = with_light_paths(params, light_paths, scene.flux);
        if shoots {
            params
        } else {
            FrameParams { quantum: params.quantum, ..with_light_paths(params, 0, scene.flux) }
        }
    }
}

/// The same settings of a frame with so many light paths of lights of this flux (W).
pub fn with_light_paths(params: FrameParams, light_paths: u32, flux: Vec3) -> FrameParams {
    // A batch never overflows the photon buffers: a path deposits at every hit but the first, at most.
    let photons_per_path = params.max_bounces.saturating_sub(1).max(1);
    let batch = light_paths.min((MAX_BUFFER / PHOTON_BYTES / photons_per_path).max(1));

    // The largest flux of a light path: lights are chosen by the mean of their channels, so one of a single channel
    // sends three times the mean. A power of two, so that scaling lights by one changes no bit.
    let largest = flux.element_sum() / light_paths.max(1) as f32;
    FrameParams {
        light_path_count: light_paths,
        light_path_batch: batch,
        quantum: next_power_of_two(largest) * 2.0f32.powi(-24),
        photon_capacity: (batch * photons_per_path).max(1),
        cell_mask: batch.next_power_of_two().clamp(1024, MAX_CELLS) - 1,
        ..params
    }
}

/// The power of two at or above a positive value; 1 where there is none that an f32 and its inverse hold.
fn next_power_of_two(value: f32) -> f32 {
    let exponent = f64::from(value).log2().ceil();
    if (-80.0..=120.0).contains(&exponent) { exponent.exp2() as f32 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_bound_their_value() {
        for (value, power) in [(1.0, 1.0), (1.1, 2.0), (0.3, 0.5), (0.0, 1.0), (f32::INFINITY, 1.0)] {
            assert_eq!(next_power_of_two(value), power);
        }
    }
}
