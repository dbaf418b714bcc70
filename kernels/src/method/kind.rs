//! What a method is.

use crate::declare::{Denoiser, Emission, History, Step, named};
use crate::gather::variant::Variant;
use crate::history::auxiliary::AUXILIARY;
use crate::history::path;
use crate::interface::choice::TextureFilter;
use crate::interface::frame::FrameParams;
use crate::pass::{balance, weigh, widen};
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
    /// Whether a history may reuse light of its points in the next frame: discs that shrink from frame to frame, and what
    /// is spread by other kernels than discs, have nothing to reuse.
    pub supports_history: bool,
    /// Whether a gather variant is chosen for it; else it brings photons and points together in its own way.
    pub chooses_gather: bool,
    /// Whether an emission is chosen for it; else it starts light paths in its own way, or has none.
    pub chooses_emission: bool,
    /// Whether its frames are averaged towards the reference: nothing is bounded in them.
    pub converges: bool,
    /// Which level of its textures a camera prefix sees where nobody asks for another.
    pub texture_filter: TextureFilter,
    /// Buffers of its own in which something outlives its frame, those of histories aside.
    pub keeps: &'static [&'static str],
    /// The settings of the frame of this index, made of those of the run.
    pub frame: fn(FrameParams, u32) -> FrameParams,
    /// The steps of a frame; what they bind is what is allocated.
    pub steps: fn(Parts, &FrameParams) -> Vec<Step>,
}

impl Method {
    /// The buffers in which something of a frame made of these parts outlives it; empty: frames do not depend on each other.
    pub fn kept(&self, parts: Parts) -> impl Iterator<Item = &'static str> + use<> {
        let none: &'static [&'static str] = &[];
        let weighs = if parts.weighs() { &weigh::KEPT } else { none };
        let balances = if parts.balances { &balance::KEPT } else { none };
        let widens = if parts.widens { &widen::KEPT } else { none };
        let path = if parts.keeps_path { &path::KEPT } else { none };
        let all = [self.keeps, parts.history.keeps, parts.emission.keeps, weighs, balances, widens, path];
        all.into_iter().flatten().copied()
    }

    /// The steps of a frame made of these parts, with what it leaves to other tools.
    pub fn frame_steps(&self, parts: Parts, params: &FrameParams) -> Vec<Step> {
        let mut steps = (self.steps)(parts, params);
        if parts.auxiliary {
            steps.push(Step::new(&AUXILIARY, params));
        }
        steps
    }

    /// Whether its light paths can start so.
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
    /// What smooths the path-traced part.
    pub denoiser: &'static Denoiser,
    /// How light paths start.
    pub emission: &'static Emission,
    /// Whether frames say how many light paths those after them shoot (`pass::balance`).
    pub balances: bool,
    /// Whether rare bright samples of camera paths are bounded (`pass::bound`).
    pub bounds: bool,
    /// Whether path-traced light outlives its frame (`history::path`).
    pub keeps_path: bool,
    /// Whether discs are wider where photons were few (`pass::widen`).
    pub widens: bool,
    /// Whether it is said what pixels show (`history::auxiliary`).
    pub auxiliary: bool,
}

impl Parts {
    /// Whether it is weighed how much an error of each pixel counts.
    pub fn weighs(&self) -> bool {
        self.balances || self.emission.weighs
    }

    /// Whether somebody takes path-traced light apart (`Features::PARTS`).
    pub fn takes_apart(&self) -> bool {
        self.bounds || self.keeps_path || *self.denoiser != denoiser::NONE
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
            balances: false,
            bounds: false,
            keeps_path: false,
            widens: false,
            auxiliary: false,
        }
    }
}

named!(Method);
