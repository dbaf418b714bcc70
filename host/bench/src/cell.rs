//! Cells: the run configurations that an experiment holds against each other.

use caustics_kernels::gather::variant::{self, Variant};
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
    /// Settings that parameters vary; those of the image are of [`Cell::settings`].
    pub settings: Settings,
    /// Where it runs.
    pub runner: RunnerChoice,
    /// The runner that was asked for, by its name.
    pub asked_runner: &'static str,
    /// Kernel code that is compiled in.
    pub features: FeatureChoice,
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

    /// The cell with changed settings.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Settings)) -> Cell {
        change(&mut self.settings);
        self
    }

    /// Its settings of an image that has those of `common`.
    pub fn settings(&self, common: &Settings) -> Settings {
        // Without dots: whoever adds a setting decides whether cells differ in it.
        let Settings {
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
        } = *common;
        Settings {
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
            ..self.settings
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
