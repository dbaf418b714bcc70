//! Cells: the run configurations that an experiment holds against each other.

use caustics_kernels::denoiser::Denoiser;
use caustics_kernels::emission::Emission;
use caustics_kernels::gather::variant::{self, Variant};
use caustics_kernels::history::History;
use caustics_kernels::interface::balance::MAX_PATHS;
use caustics_kernels::interface::choice::{Caustics, Fireflies, LightSampler, PathHistory, Sampler};
use caustics_kernels::interface::features::Features;
use caustics_kernels::method::{Method, Parts};

use caustics::scene::Scene;
use caustics::session::RunnerChoice;
use caustics::settings::Settings;

/// A run configuration: all that can vary in an experiment.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Its name in tables, as `name_all` gives it.
    pub name: String,
    /// What a frame consists of.
    pub method: &'static Method,
    /// How photons and points meet; none where the method chooses no gather.
    pub gather: Option<&'static Variant>,
    /// How light paths start.
    pub emission: &'static Emission,
    /// Which light is the light paths'.
    pub caustics: Caustics,
    /// How camera paths find lights.
    pub light_sampler: LightSampler,
    /// Where the numbers of camera paths come from.
    pub sampler: Sampler,
    /// Path-traced light of the previous frame that is reused.
    pub path_history: PathHistory,
    /// What is done about rare bright samples of camera paths.
    pub fireflies: Fireflies,
    /// Light of the previous frame that is reused.
    pub history: &'static History,
    /// What smooths the path-traced part.
    pub denoiser: &'static Denoiser,
    /// Light paths of a frame.
    pub paths: Paths,
    /// Radius of collection points.
    pub radius: Radius,
    /// Scattering vertices between eye and light, at most.
    pub max_bounces: u32,
    /// Where it runs.
    pub runner: RunnerChoice,
    /// The runner that was asked for, by its name.
    pub asked_runner: &'static str,
    /// Kernel code that is compiled in.
    pub features: FeatureChoice,
}

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

/// Radius of collection points relative to the disc of the pixel's footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius {
    /// This.
    Px(f32),
    /// 1, and up to three times as wide where the last frame's photons were few.
    Auto,
}

impl Radius {
    /// The least.
    pub fn px(self) -> f32 {
        if let Radius::Px(px) = self { px } else { 1.0 }
    }
}

/// Kernel code that is compiled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureChoice {
    /// What the scene needs.
    Scene,
    /// All of it.
    All,
}

impl FeatureChoice {
    /// Both.
    pub const ALL: &[FeatureChoice] = &[FeatureChoice::Scene, FeatureChoice::All];

    /// That of this name.
    pub fn find(name: &str) -> Option<FeatureChoice> {
        Self::ALL.iter().copied().find(|choice| choice.name() == name)
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            FeatureChoice::Scene => "scene",
            FeatureChoice::All => "all",
        }
    }

    /// What it is.
    pub fn description(self) -> &'static str {
        match self {
            FeatureChoice::Scene => "What the scene needs",
            FeatureChoice::All => "All of it",
        }
    }
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

impl Cell {
    /// Name of its gather; empty where the method chooses none.
    pub fn gather_name(&self) -> &'static str {
        self.gather.map_or("", |gather| gather.name)
    }

    /// Its parts as a session takes them.
    pub fn parts(&self) -> Parts {
        self.settings(&Settings::default()).parts(self.method, self.variant())
    }

    /// Its gather; where its method chooses none, one that every runner has.
    pub fn variant(&self) -> &'static Variant {
        self.gather.unwrap_or(&variant::PHOTONS_GRID)
    }

    /// Settings of all cells made its own.
    pub fn settings(&self, common: &Settings) -> Settings {
        Settings {
            light_paths: self.paths.count(common.width, common.height),
            balances: self.paths == Paths::Auto,
            radius_px: self.radius.px(),
            widens: self.radius == Radius::Auto,
            max_bounces: self.max_bounces,
            emission: self.emission,
            caustics: self.caustics,
            light_sampler: self.light_sampler,
            sampler: self.sampler,
            path_history: self.path_history,
            fireflies: self.fireflies,
            history: self.history,
            denoiser: self.denoiser,
            ..common.clone()
        }
    }

    /// Kernel code for a scene as it is posed.
    pub fn features(&self, scene: &Scene, specular_roughness: f32) -> Features {
        match self.features {
            FeatureChoice::Scene => scene.features(specular_roughness),
            FeatureChoice::All => Features::ALL,
        }
    }
}

/// `cpu`, `gpu-hardware` or `gpu-software`.
pub fn runner_name(runner: &RunnerChoice) -> &'static str {
    match runner {
        RunnerChoice::Cpu { .. } => "cpu",
        RunnerChoice::Gpu { hardware: true, .. } => "gpu-hardware",
        RunnerChoice::Gpu { hardware: false, .. } => "gpu-software",
    }
}
