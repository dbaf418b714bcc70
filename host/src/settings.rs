//! The settings of a run, and those of a frame that they make of a scene.

use caustics_kernels::denoiser::{self, Denoiser};
use caustics_kernels::emission::{self, Emission};
use caustics_kernels::gather::variant::Variant;
use caustics_kernels::history::auxiliary::AUXILIARY_LAYERS;
use caustics_kernels::history::path::PATH_HISTORY;
use caustics_kernels::history::{self, History};
use caustics_kernels::interface::balance::{FIRST_PATHS, MAX_PATHS};
use caustics_kernels::interface::caster::Casters;
use caustics_kernels::interface::choice::{
    Caustics, Fireflies, LightSampler, PathHistory, PixelFilter, Sampler, TextureFilter,
};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::{FrameParams, Window};
use caustics_kernels::interface::history::validation_paths;
use caustics_kernels::interface::sequence::Sequence;
use caustics_kernels::method::{Method, Parts, Stages};
use caustics_kernels::pass::balance::BALANCE;
use caustics_kernels::pass::bound::BOUND;
use caustics_kernels::pass::widen::WIDEN;
use glam::Vec3;

use caustics_scene::{Scene, SceneCamera};

/// Light paths of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paths {
    /// The method shoots none.
    None,
    /// This many.
    Count(u32),
    /// This many a pixel.
    PerPixel(f64),
    /// As many as a frame of this time has (ms); they are searched for, from one a pixel on.
    Time(f64),
    /// As many as serve the image best, by what earlier frames cost and left to noise.
    Auto,
}

impl Paths {
    /// How many in a frame of this size, at most.
    pub fn count(&self, width: u32, height: u32) -> u32 {
        let pixels = f64::from(width) * f64::from(height);
        match *self {
            Paths::None => 0,
            Paths::Count(count) => count,
            Paths::PerPixel(paths) => (paths * pixels).round().max(1.0) as u32,
            Paths::Time(_) => pixels as u32,
            Paths::Auto => pixels as u32 * MAX_PATHS,
        }
    }
}

/// Times that a frame may be asked to take (ms): up to ten minutes, of which a search renders some twenty frames.
const TIME_MS: std::ops::RangeInclusive<f64> = 1e-3..=6e5;

/// Value that earlier frames decide.
pub const AUTO: &str = "auto";

/// The light paths of a text: `p0.5` a pixel, `n1024` a frame, `t33ms` as many as take so long, `auto`, or none at all.
impl std::str::FromStr for Paths {
    type Err = String;
    fn from_str(text: &str) -> Result<Paths, String> {
        let number =
            |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
        if text.is_empty() {
            Ok(Paths::None)
        } else if text == AUTO {
            Ok(Paths::Auto)
        } else if let Some(count) = text.strip_prefix('n') {
            let count = count.parse().ok().filter(|count| *count > 0);
            count.map(Paths::Count).ok_or_else(|| "it must be auto or a whole number, at least 1".into())
        } else if let Some(ms) = text.strip_prefix('t').and_then(|text| text.strip_suffix("ms")) {
            let ms = number(ms).filter(|ms| TIME_MS.contains(ms)).map(Paths::Time);
            ms.ok_or_else(|| format!("it must be {} to {} ms", TIME_MS.start(), TIME_MS.end()))
        } else {
            let paths = number(text.strip_prefix('p').unwrap_or(text)).filter(|paths| *paths <= 4096.0);
            paths.map(Paths::PerPixel).ok_or_else(|| "it must be more than 0, at most 4096".into())
        }
    }
}

impl std::fmt::Display for Paths {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Paths::None => Ok(()),
            Paths::Auto => formatter.write_str(AUTO),
            Paths::Count(count) => write!(formatter, "n{count}"),
            Paths::PerPixel(paths) => write!(formatter, "p{paths}"),
            Paths::Time(ms) => write!(formatter, "t{ms}ms"),
        }
    }
}

/// Radius of collection points relative to the disc of the pixel's footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius {
    /// This.
    Px(f32),
    /// 1, and up to three times as wide where the last frame's photons were few.
    Auto,
}

impl Radius {
    /// Radius of every disc (px); where it is `Auto`, the smallest.
    pub fn px(self) -> f32 {
        if let Radius::Px(px) = self { px } else { 1.0 }
    }
}

impl std::str::FromStr for Radius {
    type Err = String;
    fn from_str(text: &str) -> Result<Radius, String> {
        if text == AUTO {
            return Ok(Radius::Auto);
        }
        let radius = text.parse().ok().filter(|radius: &f32| radius.is_finite() && *radius > 0.0);
        radius.map(Radius::Px).ok_or_else(|| "it must be auto or a positive number".into())
    }
}

impl std::fmt::Display for Radius {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Radius::Px(px) => write!(formatter, "{px}"),
            Radius::Auto => formatter.write_str(AUTO),
        }
    }
}

/// What a person sets for a run; the defaults are the talk's, at a smaller image.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Image width (px).
    pub width: u32,
    /// Image height (px).
    pub height: u32,
    /// Tiles that the image is rendered in, one after another; `None` takes as few as the device's bindings allow.
    pub tiles: Option<u32>,
    /// Light paths of a frame. With `Paths::Auto` frames depend on each other (`caustics_kernels::pass::balance`); every one stays
    /// unbiased.
    pub light_paths: Paths,
    /// Scattering vertices between eye and light, at most.
    pub max_bounces: u32,
    /// Radius of collection points.
    pub radius: Radius,
    /// Reflection lobes of at most this roughness are specular.
    pub specular_roughness: f32,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Positions in a pixel that camera rays pass through.
    pub pixel_filter: PixelFilter,
    /// Level of its textures that a camera prefix sees; `None` takes that of the method.
    pub texture_filter: Option<TextureFilter>,
    /// Exposure of the PNG (stops).
    pub exposure: f32,
    /// Radiance behind everything (W m^-2 sr^-1), seen and lighting nothing; `None` takes what the scene says.
    pub background: Option<Vec3>,
    /// Light of the previous frame that a frame reuses. Frames that are averaged must be independent: `history::NONE`.
    pub history: &'static History,
    /// What smooths the path-traced light; caustics are left as they are.
    pub denoiser: &'static Denoiser,
    /// How light paths start. The program's default is `emission::GUIDED`, with which a frame depends on those before it; here
    /// frames do not depend on each other.
    pub emission: &'static Emission,
    /// Which light is the light paths'.
    pub caustics: Caustics,
    /// How camera paths find lights.
    pub light_sampler: LightSampler,
    /// Where the numbers of camera paths come from. The program's default is `Sampler::Sobol`, with which frames of one batch are no
    /// independent samples; here they are.
    pub sampler: Sampler,
    /// Sequences of the sampler that frames take in turns: who averages frames and wants to know their variance takes several
    /// (`Accumulation::in_batches`).
    pub batches: u32,
    /// Path-traced light of the previous frame that is reused, in methods that do not converge.
    pub path_history: PathHistory,
    /// What is done about rare bright samples of camera paths, in methods that do not converge.
    pub fireflies: Fireflies,
    /// Whether an image has the layers of [`Auxiliary`](caustics_files::rendered_image::Auxiliary), which other tools ask for.
    pub auxiliary: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            width: 960,
            height: 540,
            tiles: None,
            light_paths: Paths::Count(1024 * 1024),
            max_bounces: 5,
            radius: Radius::Px(1.0),
            specular_roughness: 0.25,
            seed: 0,
            pixel_filter: PixelFilter::Centre,
            texture_filter: None,
            exposure: 0.0,
            background: None,
            history: &history::NONE,
            denoiser: &denoiser::NONE,
            emission: &emission::POWER,
            caustics: Caustics::First,
            light_sampler: LightSampler::Resampled,
            sampler: Sampler::Independent,
            batches: 1,
            path_history: PathHistory::None,
            fireflies: Fireflies::Kept,
            auxiliary: false,
        }
    }
}

/// Largest buffer that is asked for (bytes): what lavapipe grants.
const MAX_BUFFER: u32 = 128 << 20;
/// Bytes of a row of `photon_geometry` or `photon_light`.
const PHOTON_BYTES: u32 = 32;
/// Light paths a pixel that validation paths are made for, where frames decide how many there are.
const VALIDATED_PATHS: u32 = 2;
/// Most cells of the hash grid.
const MAX_CELLS: u32 = 1 << 20;

impl Settings {
    /// These settings, with the method's choice wherever a field is `None` that a method decides.
    pub fn for_method(self, method: &Method) -> Settings {
        Settings { texture_filter: self.texture_filter.or(Some(method.texture_filter)), ..self }
    }

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
            background: self.background.unwrap_or(scene.background),
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

    /// Where the numbers of camera paths of a frame stand in their sequences.
    pub fn sequence(&self, frame: u32) -> Sequence {
        match self.sampler {
            Sampler::Independent => Sequence::default(),
            Sampler::Sobol => Sequence::sobol(self.seed, self.batches, frame),
            Sampler::Blue => Sequence::moved(self.seed, self.batches, frame, self.width),
        }
    }

    /// Batches that frames of these settings are averaged in (`Accumulation::in_batches`).
    pub fn batches_of_frames(&self) -> u32 {
        match self.sampler {
            Sampler::Independent => 0,
            Sampler::Sobol | Sampler::Blue => self.batches,
        }
    }

    /// The parts of a method's frames, less what the method has no use for: without collection points nothing is balanced, what
    /// it splats knows no disc, and what converges has no bounds and takes no path-traced light from the frame before.
    pub fn parts(&self, method: &Method, gather: &'static Variant) -> Parts {
        let Settings { history, denoiser, emission, .. } = *self;
        let keeps_path = self.path_history == PathHistory::Validated;
        let stages = Stages::NONE
            .with(&BALANCE, self.light_paths == Paths::Auto && method.gathers)
            .with(&WIDEN, self.radius == Radius::Auto && method.chooses_gather)
            .with(&BOUND, self.fireflies == Fireflies::Bounded && !method.converges)
            .with(&PATH_HISTORY, keeps_path && method.gathers && !method.converges)
            .with(&AUXILIARY_LAYERS, self.auxiliary);
        Parts { gather, history, denoiser, emission, stages }
    }

    /// Largest number of light paths of a frame.
    pub fn max_light_paths(&self) -> u32 {
        self.light_paths.count(self.width, self.height)
    }

    /// Light paths of a frame of so many pixels before which nothing is known.
    pub fn first_light_paths(&self, pixels: u32) -> u32 {
        let (first, max) = (pixels as f32 * FIRST_PATHS, self.max_light_paths());
        if self.light_paths == Paths::Auto { max.min(first as u32).max(1) } else { max }
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
