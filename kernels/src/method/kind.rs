//! Methods as data: settings, and the parts and stages of a frame.

use crate::declare::{Denoiser, Emission, FrameStage, History, Step, Steps, equal_by_name};
use crate::gather::variant::Variant;
use crate::history::auxiliary::AUXILIARY_LAYERS;
use crate::history::path::PATH_HISTORY;
use crate::interface::choice::TextureFilter;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::pass::balance::BALANCE;
use crate::pass::bound::BOUND;
use crate::pass::more_points::MORE_POINTS;
use crate::pass::radiance_cache::RADIANCE_CACHE;
use crate::pass::share::SHARE;
use crate::pass::weigh::WEIGH;
use crate::pass::widen::WIDEN;
use crate::{denoiser, emission, history};

/// A rendering method: what a frame consists of.
#[derive(Clone, Copy)]
pub struct Method {
    /// Name on the command line.
    pub name: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Cost of a frame.
    pub cost: &'static str,
    /// Limitations: where it is wrong, or gives nothing.
    pub limitations: &'static str,
    /// Whether it makes collection points that photons are brought to; else all its light is in one layer.
    pub gathers: bool,
    /// Whether a history may reuse light of its points in the next frame. Discs that shrink from frame to frame, and photons that
    /// are spread by other kernels than discs, give it nothing to reuse.
    pub supports_history: bool,
    /// Whether a gather variant is chosen for it; else it brings photons and points together in its own way.
    pub chooses_gather: bool,
    /// Whether an emission is chosen for it; else it starts light paths in its own way, or has none.
    pub chooses_emission: bool,
    /// Whether its frames are averaged towards the reference: nothing is bounded in them.
    pub converges: bool,
    /// Texture filter of a camera prefix, unless the user chooses another.
    pub texture_filter: TextureFilter,
    /// Whether its collection points share indirect light, unless the user chooses otherwise.
    pub shares_indirect: bool,
    /// Whether its camera paths end in the radiance cache, unless the user chooses otherwise.
    pub uses_cache: bool,
    /// Whether its paths pass thin walls; else passing is an event, as published.
    pub passes_thin_walls: bool,
    /// Buffers of its own that outlive a frame, without those of histories.
    pub keeps: &'static [&'static str],
    /// The settings of the frame of this index, made of those of the run.
    pub frame: fn(FrameParams, u32) -> FrameParams,
    /// Steps of a frame. The host allocates the buffers that they bind.
    pub steps: fn(Parts, &FrameParams) -> Vec<Step>,
}

impl Method {
    /// Buffers that outlive a frame made of these parts; empty if frames do not depend on each other.
    pub fn kept(&self, parts: Parts) -> impl Iterator<Item = &'static str> + use<> {
        let of_stages = parts.all_stages().flat_map(|stage| stage.keeps);
        [self.keeps, parts.history.keeps].into_iter().flatten().chain(of_stages).copied()
    }

    /// The steps of a frame made of these parts.
    pub fn frame_steps(&self, parts: Parts, params: &FrameParams) -> Vec<Step> {
        let mut steps = (self.steps)(parts, params);
        steps.extend(parts.steps(|stage| stage.at_end, params));
        steps
    }

    /// Whether its light paths can start by this emission.
    pub fn takes_emission(&self, emission: &Emission) -> bool {
        self.chooses_emission || *emission == emission::POWER
    }
}

/// The parts of a frame that can be exchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// How photons and collection points meet.
    pub gather: &'static Variant,
    /// Light of the previous frame that is reused.
    pub history: &'static History,
    /// Filter that smooths the path layer.
    pub denoiser: &'static Denoiser,
    /// How light paths start.
    pub emission: &'static Emission,
    /// Stages beside them.
    pub stages: Stages,
}

/// Stages that can be switched on, in the order in which they run within a slot.
pub const STAGES: &[&FrameStage] = &[
    &PATH_HISTORY,
    &BOUND,
    &WIDEN,
    &WEIGH,
    &BALANCE,
    &MORE_POINTS,
    &RADIANCE_CACHE,
    &SHARE,
    &AUXILIARY_LAYERS,
];

/// A set of [`STAGES`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stages(u32);

impl Stages {
    /// No stage.
    pub const NONE: Stages = Stages(0);
    /// All stages.
    pub const ALL: Stages = Stages((1 << STAGES.len()) - 1);

    /// Adds a stage of [`STAGES`], if it is on.
    #[must_use]
    pub fn with(self, stage: &FrameStage, is_on: bool) -> Stages {
        Stages(self.0 | u32::from(is_on) << index(stage))
    }

    /// Whether a stage of [`STAGES`] is among them.
    pub fn has(self, stage: &FrameStage) -> bool {
        self.0 & 1 << index(stage) != 0
    }
}

fn index(stage: &FrameStage) -> usize {
    STAGES.iter().position(|known| *known == stage).expect("a stage of the list")
}

impl Parts {
    /// All stages of a frame, in the order in which they run within a slot. They are those that are switched on, those that these
    /// need, and the emission's.
    pub fn all_stages(&self) -> impl Iterator<Item = &'static FrameStage> + use<> {
        let is_on = |stage: &FrameStage| self.stages.has(stage);
        let emission = &self.emission.stage;
        let needed = STAGES.iter().copied().filter(|stage| is_on(stage)).chain([emission]);
        let needed: Vec<&FrameStage> = needed.flat_map(|stage| stage.needs).copied().collect();
        let own: Vec<&FrameStage> =
            STAGES.iter().copied().filter(|stage| is_on(stage) || needed.contains(stage)).collect();
        own.into_iter().chain([emission])
    }

    /// The steps of a slot of all stages.
    pub fn steps(&self, slot: impl Fn(&FrameStage) -> Steps, params: &FrameParams) -> Vec<Step> {
        self.all_stages().flat_map(|stage| slot(stage)(params)).collect()
    }

    /// Features that camera paths need for what stages and the denoiser read of them.
    pub fn features(&self) -> Features {
        let of_denoiser = if *self.denoiser == denoiser::NONE { Features(0) } else { Features::PARTS };
        self.all_stages().fold(of_denoiser, |features, stage| features | stage.features)
    }
}

impl From<&'static Variant> for Parts {
    /// A gather of light paths that start by power, without history and denoiser.
    fn from(gather: &'static Variant) -> Parts {
        Parts {
            gather,
            history: &history::NONE,
            denoiser: &denoiser::NONE,
            emission: &emission::POWER,
            stages: Stages::NONE,
        }
    }
}

equal_by_name!(Method);
