//! Configuration of a run: every setting, its default, and values derived from it. `params` derives the parameters of a
//! frame for the kernels.

use std::collections::BTreeMap;

use caustics_kernels::denoiser::{self, Denoiser};
use caustics_kernels::emission::{self, Emission};
use caustics_kernels::gather::variant::{self, Variant};
use caustics_kernels::history::auxiliary::AUXILIARY_LAYERS;
use caustics_kernels::history::path::PATH_HISTORY;
use caustics_kernels::history::{self, History};
use caustics_kernels::interface::balance::FIRST_PATHS;
use caustics_kernels::interface::choice::{
    Caustics, Fireflies, IndirectEnd, IndirectShare, LightSampler, PathHistory, PixelFilter, Sampler,
    TextureFilter, ThinWalls,
};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::sequence::Sequence;
use caustics_kernels::method::{self, Method, Parts, Stages};
use caustics_kernels::pass::balance::BALANCE;
use caustics_kernels::pass::bound::BOUND;
use caustics_kernels::pass::more_points::MORE_POINTS;
use caustics_kernels::pass::radiance_cache::RADIANCE_CACHE;
use caustics_kernels::pass::share::SHARE;
use caustics_kernels::pass::widen::WIDEN;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::named::{by_name, by_name_if_any};
use crate::oidn::OIDN;
use caustics_scene::Scene;

mod params;
mod value;

pub use params::with_light_paths;
use value::as_text;
pub use value::{AUTO, FeatureChoice, Paths, Radius};

/// Settings of a run, without its scene and runner. The defaults are those of the talk, with a smaller image. A new field
/// requires decisions in [`RenderConfig::with_image_of`] and [`RenderConfig::expected_image`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderConfig {
    /// Method: the steps of a frame.
    #[serde(with = "by_name")]
    pub method: &'static Method,
    /// Gather of photons at collection points. `None` selects the runner's default, or none if the method does not choose.
    #[serde(with = "by_name_if_any")]
    pub gather: Option<&'static Variant>,
    /// Features that are compiled into the kernels.
    #[serde(with = "by_name")]
    pub features: FeatureChoice,
    /// Image width (px).
    pub width: u32,
    /// Image height (px).
    pub height: u32,
    /// Number of tiles, which are rendered one after another. `None` selects the smallest number that the device's bindings
    /// allow.
    pub tiles: Option<u32>,
    /// Light paths of a frame. With `Paths::Auto` frames depend on each other (`caustics_kernels::pass::balance`), but each
    /// is unbiased.
    #[serde(with = "as_text")]
    pub light_paths: Paths,
    /// Maximum number of scattering vertices between eye and light.
    pub max_bounces: u32,
    /// Radius of collection points.
    #[serde(with = "as_text")]
    pub radius: Radius,
    /// Maximum number of collection points of a pixel. With several, frames depend on each other
    /// (`caustics_kernels::pass::more_points`), but each is unbiased.
    pub collection_points: u32,
    /// Maximum roughness of specular reflection lobes.
    pub specular_roughness: f32,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Positions in a pixel that camera rays pass through.
    #[serde(with = "by_name")]
    pub pixel_filter: PixelFilter,
    /// Texture level of a camera prefix. `None` selects the method's level.
    #[serde(with = "by_name_if_any")]
    pub texture_filter: Option<TextureFilter>,
    /// Exposure of the PNG (stops).
    pub exposure: f32,
    /// Background radiance (W m^-2 sr^-1), which lights nothing. `None` selects the scene's background.
    pub background: Option<[f32; 3]>,
    /// Reuse of light from the previous frame. Averaged frames must be independent: `history::NONE`.
    #[serde(with = "by_name")]
    pub history: &'static History,
    /// Denoiser of the path-traced light. It leaves caustics unchanged. With [`OIDN`] the caller denoises the finished image.
    #[serde(with = "by_name")]
    pub denoiser: &'static Denoiser,
    /// Emission of light paths. Frames do not depend on each other with the default here. The program's default is
    /// `emission::GUIDED`, with which a frame depends on those before it.
    #[serde(with = "by_name")]
    pub emission: &'static Emission,
    /// Light that belongs to the light paths.
    #[serde(with = "by_name")]
    pub caustics: Caustics,
    /// Treatment of thin walls. Passing is an event, as published, where caustics are published ones, too
    /// ([`RenderConfig::passes_thin_walls`]).
    #[serde(with = "by_name")]
    pub thin_walls: ThinWalls,
    /// Choice of lights for next-event estimation.
    #[serde(with = "by_name")]
    pub light_sampler: LightSampler,
    /// Source of the random numbers of camera paths. With the default here, frames are independent samples. The program's
    /// default is `Sampler::Sobol`, with which frames of one batch are not.
    #[serde(with = "by_name")]
    pub sampler: Sampler,
    /// Number of independent sequences of the sampler that frames take turns in. Variance of averaged frames requires
    /// several (`Accumulation::in_batches`).
    pub batches: u32,
    /// Reuse of path-traced light from the previous frame, in methods that do not converge.
    #[serde(with = "by_name")]
    pub path_history: PathHistory,
    /// Sharing of indirect light between collection points. `None` selects the method's, which is the program's default. References
    /// share none.
    #[serde(with = "by_name_if_any")]
    pub indirect_share: Option<IndirectShare>,
    /// Ends of camera paths behind the collection point. `None` selects the method's. References never use the cache, with which
    /// frames depend on each other.
    #[serde(with = "by_name_if_any")]
    pub indirect_end: Option<IndirectEnd>,
    /// Treatment of fireflies, in methods that do not converge.
    #[serde(with = "by_name")]
    pub fireflies: Fireflies,
    /// Whether an image has the layers of [`Auxiliary`](caustics_files::rendered_image::Auxiliary), which other tools ask for.
    pub auxiliary: bool,
}

impl Default for RenderConfig {
    fn default() -> Self {
        RenderConfig {
            method: &method::BASIC,
            gather: None,
            features: FeatureChoice::Scene,
            width: 960,
            height: 540,
            tiles: None,
            light_paths: Paths::Count(1024 * 1024),
            max_bounces: 5,
            radius: Radius::Px(1.0),
            collection_points: 1,
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
            thin_walls: ThinWalls::Passed,
            light_sampler: LightSampler::Resampled,
            sampler: Sampler::Independent,
            batches: 1,
            path_history: PathHistory::None,
            indirect_share: Some(IndirectShare::None),
            indirect_end: Some(IndirectEnd::Path),
            fireflies: Fireflies::Kept,
            auxiliary: false,
        }
    }
}

impl RenderConfig {
    /// Returns the configuration with the image settings of another: size, tiles, filters, exposure, background, seed and
    /// the like. All settings that a sweep varies stay.
    #[must_use]
    pub fn with_image_of(&self, image: &RenderConfig) -> RenderConfig {
        // No `..` here: a new setting requires a decision whether it belongs to the image or a sweep varies it.
        let RenderConfig {
            width,
            height,
            tiles,
            specular_roughness,
            seed,
            pixel_filter,
            texture_filter,
            exposure,
            background,
            batches,
            auxiliary,
            method: _,
            gather: _,
            features: _,
            light_paths: _,
            max_bounces: _,
            radius: _,
            collection_points: _,
            history: _,
            denoiser: _,
            emission: _,
            caustics: _,
            thin_walls: _,
            light_sampler: _,
            sampler: _,
            path_history: _,
            indirect_share: _,
            indirect_end: _,
            fireflies: _,
        } = *image;
        RenderConfig {
            width,
            height,
            tiles,
            specular_roughness,
            seed,
            pixel_filter,
            texture_filter,
            exposure,
            background,
            batches,
            auxiliary,
            ..self.clone()
        }
    }

    /// Returns a text of the settings that decide the expected image of a scene. Settings that change only noise, time or
    /// error are left out, so that one reference serves all configurations of a sweep.
    pub fn expected_image(&self, scene: &Scene) -> String {
        // No `..` here: a new setting requires a decision whether it changes the expected image.
        let RenderConfig {
            width,
            height,
            light_paths,
            max_bounces,
            radius,
            specular_roughness,
            pixel_filter,
            texture_filter,
            background,
            caustics,
            collection_points: _,
            thin_walls: _,
            method: _,
            gather: _,
            features: _,
            tiles: _,
            seed: _,
            exposure: _,
            history: _,
            denoiser: _,
            emission: _,
            light_sampler: _,
            sampler: _,
            batches: _,
            path_history: _,
            indirect_share: _,
            indirect_end: _,
            fireflies: _,
            auxiliary: _,
        } = *self;
        // Passed walls are no bounces.
        let has_walls = scene.features(specular_roughness).has(Features::THIN_WALLS);
        let walls = if has_walls && !self.passes_thin_walls() { " thin walls event" } else { "" };
        format!(
            "{width}x{height} paths {} {caustics:?} bounces {max_bounces} radius {} specular {specular_roughness} filter {} \
             textures {texture_filter:?} background {:?}{walls}",
            light_paths.count(width, height),
            radius.px(),
            pixel_filter as u32,
            background.map_or(scene.background, Vec3::from),
        )
    }

    /// Returns every setting by its name, except the exposure, which does not change the sums. It identifies a run. Light
    /// paths per pixel are converted to a number.
    pub fn run_identity(&self) -> BTreeMap<String, String> {
        let Value::Object(mut settings) = json!(self) else {
            unreachable!("a struct is an object in JSON");
        };
        settings.remove("exposure");
        if let Paths::Count(_) | Paths::PerPixel(_) = self.light_paths {
            settings.insert("light_paths".into(), self.max_light_paths().into());
        }
        // Rename `tiles`, which is a standard attribute of EXR.
        if let Some(tiles) = settings.remove("tiles") {
            settings.insert("tile_count".into(), tiles);
        }
        let text = |value| match value {
            Value::Null => "default".into(),
            Value::String(text) => text,
            other => other.to_string(),
        };
        settings.into_iter().map(|(name, value)| (name, text(value))).collect()
    }

    /// Returns the configuration with the method's choice for each unset field that the method decides.
    #[must_use]
    pub fn with_defaults_of_method(self) -> RenderConfig {
        let method = self.method;
        let share = if method.shares_indirect { IndirectShare::Points } else { IndirectShare::None };
        let end = if method.uses_cache { IndirectEnd::Cache } else { IndirectEnd::Path };
        RenderConfig {
            texture_filter: self.texture_filter.or(Some(method.texture_filter)),
            indirect_share: self.indirect_share.or(Some(share)),
            indirect_end: self.indirect_end.or(Some(end)),
            ..self
        }
    }

    /// Returns the texture filter that a mean of frames needs, if not that of its method. Where rays over the whole pixel are averaged, the
    /// finest level is exact. A footprint's level differs from it: averaged normals reflect a narrower part of the scene (+19 % in
    /// a region of a normal-mapped mirror).
    pub fn texture_filter_of_means(pixel_filter: PixelFilter) -> Option<TextureFilter> {
        (pixel_filter == PixelFilter::Box).then_some(TextureFilter::Finest)
    }

    /// Whether light passes thin walls without a scattering event.
    pub fn passes_thin_walls(&self) -> bool {
        self.thin_walls == ThinWalls::Passed && self.can_pass_thin_walls()
    }

    /// Whether `thin_walls` applies. Published methods, and light paths that carry light of any specular event, count passing as an
    /// event.
    pub fn can_pass_thin_walls(&self) -> bool {
        self.caustics == Caustics::First && self.method.passes_thin_walls
    }

    /// Whether `collection_points` applies: to discs whose light no history reuses.
    pub fn can_add_points(&self) -> bool {
        self.method.chooses_gather && *self.history == history::NONE
    }

    /// Whether `indirect_share` applies: to collection points whose path-traced light nothing else smooths, bounds or reuses.
    pub fn can_share_indirect(&self) -> bool {
        let keeps_path = self.path_history == PathHistory::Validated && !self.method.converges;
        let bounds = self.fireflies == Fireflies::Bounded && !self.method.converges;
        self.method.chooses_gather && *self.denoiser == denoiser::NONE && !keeps_path && !bounds
    }

    /// Whether the finished image is denoised, and not its frames.
    pub fn denoises_image(&self) -> bool {
        *self.denoiser == OIDN
    }

    /// Whether `indirect_end` applies: to paths that no history traces again.
    pub fn can_use_cache(&self) -> bool {
        let keeps_path = self.path_history == PathHistory::Validated && !self.method.converges;
        self.method.chooses_gather && !keeps_path
    }

    /// Returns the features to compile into the kernels for a scene in its pose.
    pub fn features(&self, scene: &Scene) -> Features {
        self.features.features(scene, self.specular_roughness)
    }

    /// Returns the positions of a frame's camera paths in the sampler's sequences.
    pub fn sequence(&self, frame: u32) -> Sequence {
        match self.sampler {
            Sampler::Independent => Sequence::default(),
            Sampler::Sobol => Sequence::sobol(self.seed, self.batches, frame),
            Sampler::Blue => Sequence::moved(self.seed, self.batches, frame, self.width),
        }
    }

    /// Returns the number of batches for averaging frames of these settings (`Accumulation::in_batches`).
    pub fn batches_of_frames(&self) -> u32 {
        match self.sampler {
            Sampler::Independent => 0,
            Sampler::Sobol | Sampler::Blue => self.batches,
        }
    }

    /// Returns the gather. The default runs on every runner.
    pub fn variant(&self) -> &'static Variant {
        self.gather.unwrap_or(&variant::PHOTONS_GRID)
    }

    /// Returns the parts of the method's frames, without stages that do not apply. Balance needs collection points, and an
    /// automatic radius needs discs. Firefly bounds and path history apply only to methods that do not converge.
    pub fn parts(&self) -> Parts {
        let RenderConfig { method, history, emission, .. } = *self;
        let denoiser = if self.denoises_image() { &denoiser::NONE } else { self.denoiser };
        let keeps_path = self.path_history == PathHistory::Validated;
        let stages = Stages::NONE
            .with(&BALANCE, self.light_paths == Paths::Auto && method.gathers)
            .with(&WIDEN, self.radius == Radius::Auto && method.chooses_gather)
            .with(&MORE_POINTS, self.collection_points > 1 && self.can_add_points())
            .with(&SHARE, self.indirect_share == Some(IndirectShare::Points) && self.can_share_indirect())
            .with(&RADIANCE_CACHE, self.indirect_end == Some(IndirectEnd::Cache) && self.can_use_cache())
            .with(&BOUND, self.fireflies == Fireflies::Bounded && !method.converges)
            .with(&PATH_HISTORY, keeps_path && method.gathers && !method.converges)
            .with(&AUXILIARY_LAYERS, self.auxiliary);
        Parts { gather: self.variant(), history, denoiser, emission, stages }
    }

    /// Returns the maximum number of light paths of a frame.
    pub fn max_light_paths(&self) -> u32 {
        self.light_paths.count(self.width, self.height)
    }

    /// Returns the number of light paths of a first frame with this number of pixels.
    pub fn first_light_paths(&self, pixels: u32) -> u32 {
        let (first, max) = (pixels as f32 * FIRST_PATHS, self.max_light_paths());
        if self.light_paths == Paths::Auto { max.min(first as u32).max(1) } else { max }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> RenderConfig {
        RenderConfig {
            method: &method::PROGRESSIVE,
            gather: Some(&variant::BRUTE),
            features: FeatureChoice::All,
            tiles: Some(3),
            light_paths: Paths::PerPixel(0.1),
            radius: Radius::Auto,
            texture_filter: Some(TextureFilter::Finest),
            background: Some([0.1, 1.0, 1e-3]),
            history: &history::VALIDATED,
            denoiser: &denoiser::ATROUS,
            emission: &emission::GUIDED,
            ..RenderConfig::default()
        }
    }

    #[test]
    fn a_denoiser_of_images_takes_no_part_in_frames_which_share_no_light() {
        let config = RenderConfig { denoiser: &OIDN, indirect_share: Some(IndirectShare::Points), ..full() };
        assert!(config.denoises_image() && !full().denoises_image());
        assert_eq!((config.parts().denoiser, config.parts().stages.has(&SHARE)), (&denoiser::NONE, false));
        assert_eq!(config.run_identity()["denoiser"], OIDN.name);
    }

    #[test]
    fn a_configuration_is_read_back_unchanged() {
        for config in [RenderConfig::default(), full()] {
            let text = serde_json::to_string(&config).unwrap();
            assert_eq!(serde_json::from_str::<RenderConfig>(&text).unwrap(), config, "{text}");
        }
        let some: RenderConfig = serde_json::from_str(r#"{"method": "path", "radius": "auto"}"#).unwrap();
        assert_eq!(some, RenderConfig { method: &method::PATH, radius: Radius::Auto, ..Default::default() });
        for (wrong, says) in [
            (r#"{"method": "basik"}"#, "yang2021"),
            (r#"{"light_paths": "many"}"#, "at most 4096"),
            (r#"{"colour": 1}"#, "unknown field"),
        ] {
            let error = serde_json::from_str::<RenderConfig>(wrong).unwrap_err();
            assert!(error.to_string().contains(says), "{error}");
        }
    }

    #[test]
    fn every_setting_but_the_exposure_changes_the_run_identity() {
        let [usual, other] = [RenderConfig::default(), full()].map(|config| json!(config));
        let identity =
            |value: &Value| serde_json::from_value::<RenderConfig>(value.clone()).unwrap().run_identity();
        let others =
            [("width", json!(8)), ("height", json!(8)), ("max_bounces", json!(2)), ("seed", json!(1))];
        let others = others.into_iter().chain([
            ("collection_points", json!(4)),
            ("specular_roughness", json!(0.5)),
            ("pixel_filter", json!("box")),
            ("exposure", json!(1.0)),
            ("caustics", json!("any")),
            ("thin_walls", json!("event")),
            ("light_sampler", json!("uniform")),
            ("sampler", json!("blue")),
            ("batches", json!(4)),
            ("path_history", json!("validated")),
            ("indirect_share", json!("points")),
            ("indirect_end", json!("cache")),
            ("fireflies", json!("bounded")),
            ("auxiliary", json!(true)),
        ]);
        let others: BTreeMap<&str, Value> = others.collect();
        for (name, value) in usual.as_object().unwrap() {
            let mut changed = usual.clone();
            changed[name] = others.get(&name[..]).unwrap_or(&other[name]).clone();
            assert_ne!(changed[name], *value, "{name} has another value");
            assert_eq!(identity(&changed) == identity(&usual), name == "exposure", "{name}");
        }
    }

    #[test]
    fn light_paths_per_pixel_and_as_a_count_identify_the_same_run() {
        let config = |light_paths| RenderConfig { width: 96, height: 54, light_paths, ..Default::default() };
        let identity = |light_paths| config(light_paths).run_identity();
        assert_eq!(identity(Paths::PerPixel(1.0)), identity(Paths::Count(96 * 54)));
        assert_ne!(identity(Paths::PerPixel(2.0)), identity(Paths::Count(96 * 54)));
        let max = config(Paths::Auto).max_light_paths();
        assert_ne!(identity(Paths::Auto), identity(Paths::Count(max)));
    }

    /// Stored results of sweeps and references are identified by this text.
    #[test]
    fn the_text_of_an_expected_image_is_stable() {
        let config = RenderConfig { texture_filter: Some(TextureFilter::Cone), ..RenderConfig::default() };
        let text = "960x540 paths 1048576 First bounces 5 radius 1 specular 0.25 filter 0 textures Some(Cone) \
                    background Vec3(0.0, 0.0, 0.0)";
        assert_eq!(config.expected_image(&Scene::default()), text);
    }
}
