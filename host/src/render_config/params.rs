//! Parameters of a frame for the kernels, derived from a configuration and a scene.

use caustics_kernels::gather::accumulator::QUANTA_PER_PATH;
use caustics_kernels::interface::caster::Casters;
use caustics_kernels::interface::choice::{LightSampler, TextureFilter, ThinWalls};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::{FrameParams, Window};
use caustics_kernels::interface::guide::LightGroups;
use caustics_kernels::interface::history::validation_paths;
use caustics_kernels::pass::more_points::MAX_POINTS;
use caustics_kernels::pass::radiance_cache::RADIANCE_CACHE;
use caustics_kernels::pass::share::{SHARE, SHARE_RADIUS_PX};
use caustics_scene::{Scene, SceneCamera};
use glam::Vec3;

use super::{Paths, RenderConfig};

/// Maximum size of a buffer (bytes): the limit of lavapipe.
const MAX_BUFFER: u32 = 128 << 20;
/// Size of an element of `photon_geometry` or `photon_light` (bytes).
const PHOTON_BYTES: u32 = 32;
/// Light paths per pixel that determine the number of validation paths, if frames choose their number of light paths.
const VALIDATED_PATHS: u32 = 2;
/// Maximum number of cells of the hash grid.
const MAX_CELLS: u32 = 1 << 20;

impl RenderConfig {
    /// Returns the parameters of frame `frame`. Without casters, receivers or light in the scene, no light path is shot.
    pub fn params(&self, scene: &Scene, camera: &SceneCamera, frame: u32) -> FrameParams {
        self.params_where(scene, camera, frame, !scene.lights.is_empty())
    }

    /// Returns parameters that shoot light paths if any frame of the scene does. Buffers are allocated for them.
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
            scene.casters(self.specular_roughness, self.passes_thin_walls())
        } else {
            Casters::default()
        };
        let thin_walls = if self.passes_thin_walls() { ThinWalls::Passed } else { ThinWalls::Event };
        let stages = self.parts().stages;
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
            light_groups: LightGroups::new(scene.light_keys.len() as u32, casters.count),
            sequence: self.sequence(frame),
            thin_walls: thin_walls as u32,
            share_radius_px: if stages.has(&SHARE) { SHARE_RADIUS_PX } else { 0.0 },
            cache_share: if stages.has(&RADIANCE_CACHE) { 1.0 } else { 0.0 },
            collection_points: self.collection_points.clamp(1, MAX_POINTS),
            light_bvh_share: if self.light_sampler == LightSampler::Bvh {
                scene.light_bvh_share()
            } else {
                0.0
            },
            ..FrameParams::default()
        };
        // With an adaptive number of light paths, the number of validation paths stays fixed.
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

/// Returns the parameters with another number of light paths from lights of this flux (W).
pub fn with_light_paths(params: FrameParams, light_paths: u32, flux: Vec3) -> FrameParams {
    // A path deposits a photon at most at every hit but the first. Only a path that passes partly diffuse thin walls may deposit more:
    // photons without room are counted as dropped.
    let photons_per_path = params.max_bounces.saturating_sub(1).max(1);
    let batch = light_paths.min((MAX_BUFFER / PHOTON_BYTES / photons_per_path).max(1));

    // Bound the flux of a light path. Lights are chosen by the mean of their channels, so a light of a single channel sends
    // three times the mean. The quantum is a power of two, so that scaling lights by a power of two changes no bit.
    let largest = flux.element_sum() / light_paths.max(1) as f32;
    FrameParams {
        light_path_count: light_paths,
        light_path_batch: batch,
        quantum: next_power_of_two(largest) / QUANTA_PER_PATH,
        photon_capacity: (batch * photons_per_path).max(1),
        cell_mask: batch.next_power_of_two().clamp(1024, MAX_CELLS) - 1,
        ..params
    }
}

/// Returns the power of two at or above a positive value; 1 if f32 cannot hold the power or its inverse.
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
