//! The configuration of a run: every setting once, its default, and what is derived from it. The settings of a frame, as kernels
//! get them, are derived in `params`.

use std::collections::BTreeMap;

use caustics_kernels::denoiser::{self, Denoiser};
use caustics_kernels::emission::{self, Emission};
use caustics_kernels::gather::variant::{self, Variant};
use caustics_kernels::history::auxiliary::AUXILIARY_LAYERS;
use caustics_kernels::history::path::PATH_HISTORY;
use caustics_kernels::history::{self, History};
use caustics_kernels::interface::balance::FIRST_PATHS;
use caustics_kernels::interface::choice::{
    Caustics, Fireflies, LightSampler, PathHistory, PixelFilter, Sampler, TextureFilter,
};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::sequence::Sequence;
use caustics_kernels::method::{self, Method, Parts, Stages};
use caustics_kernels::pass::balance::BALANCE;
use caustics_kernels::pass::bound::BOUND;
use caustics_kernels::pass::widen::WIDEN;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::named::{by_name, by_name_if_any};
use caustics_scene::Scene;

mod params;
mod value;

pub use params::with_light_paths;
use value::as_text;
pub use value::{AUTO, FeatureChoice, Paths, Radius};

/// All that a person sets for a run but its scene and where it runs; the defaults are the talk's, at a smaller image. A new field asks
/// for decisions in [`RenderConfig::with_image_of`] and [`RenderConfig::expected_image`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderConfig {
    /// What a frame consists of.
    #[serde(with = "by_name")]
    pub method: &'static Method,
    /// How photons and collection points meet; `None` takes the runner's default, or none where the method chooses none.
    #[serde(with = "by_name_if_any")]
    pub gather: Option<&'static Variant>,
    /// Kernel code that is compiled in.
    #[serde(with = "by_name")]
    pub features: FeatureChoice,
    /// Image width (px).
    pub width: u32,
    /// Image height (px).
    pub height: u32,
    /// Tiles that the image is rendered in, one after another; `None` takes as few as the device's bindings allow.
    pub tiles: Option<u32>,
    /// Light paths of a frame. With `Paths::Auto` frames depend on each other (`caustics_kernels::pass::balance`); every one stays
    /// unbiased.
    #[serde(with = "as_text")]
    pub light_paths: Paths,
    /// Scattering vertices between eye and light, at most.
    pub max_bounces: u32,
    /// Radius of collection points.
    #[serde(with = "as_text")]
    pub radius: Radius,
    /// Reflection lobes of at most this roughness are specular.
    pub specular_roughness: f32,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Positions in a pixel that camera rays pass through.
    #[serde(with = "by_name")]
    pub pixel_filter: PixelFilter,
    /// Level of its textures that a camera prefix sees; `None` takes that of the method.
    #[serde(with = "by_name_if_any")]
    pub texture_filter: Option<TextureFilter>,
    /// Exposure of the PNG (stops).
    pub exposure: f32,
    /// Radiance behind everything (W m^-2 sr^-1), seen and lighting nothing; `None` takes what the scene says.
    pub background: Option<[f32; 3]>,
    /// Light of the previous frame that a frame reuses. Frames that are averaged must be independent: `history::NONE`.
    #[serde(with = "by_name")]
    pub history: &'static History,
    /// What smooths the path-traced light; caustics are left as they are.
    #[serde(with = "by_name")]
    pub denoiser: &'static Denoiser,
    /// How light paths start. The program's default is `emission::GUIDED`, with which a frame depends on those before it; here
    /// frames do not depend on each other.
    #[serde(with = "by_name")]
    pub emission: &'static Emission,
    /// Which light is the light paths'.
    #[serde(with = "by_name")]
    pub caustics: Caustics,
    /// How camera paths find lights.
    #[serde(with = "by_name")]
    pub light_sampler: LightSampler,
    /// Where the numbers of camera paths come from. The program's default is `Sampler::Sobol`, with which frames of one batch are no
    /// independent samples; here they are.
    #[serde(with = "by_name")]
    pub sampler: Sampler,
    /// Sequences of the sampler that frames take in turns: who averages frames and wants to know their variance takes several
    /// (`Accumulation::in_batches`).
    pub batches: u32,
    /// Path-traced light of the previous frame that is reused, in methods that do not converge.
    #[serde(with = "by_name")]
    pub path_history: PathHistory,
    /// What is done about rare bright samples of camera paths, in methods that do not converge.
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

impl RenderConfig {
    /// The configuration with the image of another: its size, what of the scene a pixel sees, its seed. All that a sweep varies stays.
    #[must_use]
    pub fn with_image_of(&self, image: &RenderConfig) -> RenderConfig {
        // Without dots: whoever adds a setting decides whether it is the image's, or a sweep varies it.
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
            history: _,
            denoiser: _,
            emission: _,
            caustics: _,
            light_sampler: _,
            sampler: _,
            path_history: _,
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

    /// Text of the settings that decide which image is expected of a scene. What only decides how noisy it is, how long it takes or
    /// which error it may have is left out on purpose, so that one reference serves all configurations of a sweep.
    pub fn expected_image(&self, scene: &Scene) -> String {
        // Without dots: whoever adds a setting decides whether another value gives another expected image.
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
            fireflies: _,
            auxiliary: _,
        } = *self;
        format!(
            "{width}x{height} paths {} {caustics:?} bounces {max_bounces} radius {} specular {specular_roughness} filter {} \
             textures {texture_filter:?} background {:?}",
            light_paths.count(width, height),
            radius.px(),
            pixel_filter as u32,
            background.map_or(scene.background, Vec3::from),
        )
    }

    /// Every setting by its name, but the exposure, which touches no sum: what tells one run from another. Light paths a pixel are
    /// a number of them.
    pub fn run_identity(&self) -> BTreeMap<String, String> {
        let Value::Object(mut settings) = json!(self) else {
            unreachable!("a struct is an object in JSON");
        };
        settings.remove("exposure");
        if let Paths::Count(_) | Paths::PerPixel(_) = self.light_paths {
            settings.insert("light_paths".into(), self.max_light_paths().into());
        }
        // The standard of EXR has an attribute `tiles`.
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

    /// The configuration with the method's choice wherever a field is `None` that a method decides.
    #[must_use]
    pub fn with_defaults_of_method(self) -> RenderConfig {
        RenderConfig { texture_filter: self.texture_filter.or(Some(self.method.texture_filter)), ..self }
    }

    /// Kernel code that is compiled in for a scene as it is posed.
    pub fn features(&self, scene: &Scene) -> Features {
        self.features.features(scene, self.specular_roughness)
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

    /// How photons and collection points meet; where none is chosen, in a way that every runner has.
    pub fn variant(&self) -> &'static Variant {
        self.gather.unwrap_or(&variant::PHOTONS_GRID)
    }

    /// The parts of the method's frames, less what the method has no use for: without collection points nothing is balanced, what
    /// it splats knows no disc, and what converges has no bounds and takes no path-traced light from the frame before.
    pub fn parts(&self) -> Parts {
        let RenderConfig { method, history, denoiser, emission, .. } = *self;
        let keeps_path = self.path_history == PathHistory::Validated;
        let stages = Stages::NONE
            .with(&BALANCE, self.light_paths == Paths::Auto && method.gathers)
            .with(&WIDEN, self.radius == Radius::Auto && method.chooses_gather)
            .with(&BOUND, self.fireflies == Fireflies::Bounded && !method.converges)
            .with(&PATH_HISTORY, keeps_path && method.gathers && !method.converges)
            .with(&AUXILIARY_LAYERS, self.auxiliary);
        Parts { gather: self.variant(), history, denoiser, emission, stages }
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
    fn a_configuration_is_read_as_it_was_written() {
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
    fn every_setting_but_the_exposure_tells_runs_apart() {
        let [usual, other] = [RenderConfig::default(), full()].map(|config| json!(config));
        let identity =
            |value: &Value| serde_json::from_value::<RenderConfig>(value.clone()).unwrap().run_identity();
        let others =
            [("width", json!(8)), ("height", json!(8)), ("max_bounces", json!(2)), ("seed", json!(1))];
        let others = others.into_iter().chain([
            ("specular_roughness", json!(0.5)),
            ("pixel_filter", json!("box")),
            ("exposure", json!(1.0)),
            ("caustics", json!("any")),
            ("light_sampler", json!("uniform")),
            ("sampler", json!("blue")),
            ("batches", json!(4)),
            ("path_history", json!("validated")),
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
    fn light_paths_are_one_run_however_their_number_is_given() {
        let config = |light_paths| RenderConfig { width: 96, height: 54, light_paths, ..Default::default() };
        let identity = |light_paths| config(light_paths).run_identity();
        assert_eq!(identity(Paths::PerPixel(1.0)), identity(Paths::Count(96 * 54)));
        assert_ne!(identity(Paths::PerPixel(2.0)), identity(Paths::Count(96 * 54)));
        let max = config(Paths::Auto).max_light_paths();
        assert_ne!(identity(Paths::Auto), identity(Paths::Count(max)));
    }

    /// Results of sweeps and references that were kept before are known by this text.
    #[test]
    fn the_text_of_an_expected_image_is_as_it_was() {
        let config = RenderConfig { texture_filter: Some(TextureFilter::Cone), ..RenderConfig::default() };
        let text = "960x540 paths 1048576 First bounces 5 radius 1 specular 0.25 filter 0 textures Some(Cone) \
                    background Vec3(0.0, 0.0, 0.0)";
        assert_eq!(config.expected_image(&Scene::default()), text);
    }
}
