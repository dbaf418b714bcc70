//! A method is data: the buffers and the ordered list of steps that every runner executes.

use caustics_kernels::gather::variant::{Side, Variant};
use caustics_kernels::interface::frame::FrameParams;

pub mod basic;
pub mod filter;
pub mod gather;
pub mod history;
pub mod kim2019;
pub mod path;
pub mod progressive;
pub mod settings;
pub mod yang2021;

use filter::Filter;
use history::History;
use settings::TextureFilter;

/// A way to render: what a frame consists of.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Whether it makes collection points that deposits are brought to; else all its light is in one layer.
    pub gathers: bool,
    /// Whether a gather variant is chosen for it; else it brings deposits and points together in its own way.
    pub chooses_gather: bool,
    /// Which level of its textures a camera prefix sees where nobody asks for another.
    pub texture_filter: TextureFilter,
    /// Buffers of its own in which something outlives its frame, those of histories aside.
    pub keeps: &'static [&'static str],
    /// The settings of the frame of this index, made of those of the run.
    pub frame: fn(FrameParams, u32) -> FrameParams,
    /// The steps of a frame.
    pub steps: fn(Parts, FrameParams) -> Vec<Step>,
    /// The buffers of a frame, scene tables aside.
    pub buffers: fn(Parts, &FrameParams) -> Vec<BufferSpec>,
}

/// The parts of a frame that can be exchanged.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    /// How deposits and collection points meet.
    pub gather: &'static Variant,
    /// What the frame before lends.
    pub history: &'static History,
    /// What smooths the path-traced part.
    pub filter: &'static Filter,
}

impl From<&'static Variant> for Parts {
    /// A gather without history and filter.
    fn from(gather: &'static Variant) -> Parts {
        Parts { gather, history: &history::NONE, filter: &filter::NONE }
    }
}

/// Every method.
pub const ALL: &[&Method] = &[
    &basic::BASIC,
    &progressive::PROGRESSIVE,
    &path::PATH,
    &kim2019::KIM2019,
    &kim2019::KIM2019_FACING,
    &yang2021::YANG2021,
];

/// The method of this name.
pub fn find(name: &str) -> Option<&'static Method> {
    ALL.iter().find(|method| method.name == name).copied()
}

/// One step of a frame. Every step sees all that earlier steps wrote.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Runs the pass of this name once for each index below `count`.
    Dispatch {
        /// Name of the pass: entry point, profiler scope, debug label, column.
        pass: &'static str,
        /// Invocations.
        count: u32,
        /// Its push constants.
        params: FrameParams,
    },
    /// Fills a buffer with zeros.
    Clear {
        /// Name of the buffer.
        buffer: &'static str,
    },
    /// Runs a stage of building a gather's index.
    Index {
        /// The gather.
        gather: &'static Variant,
        /// The stage's name behind that of the pass.
        stage: &'static str,
        /// Invocations, at most: `params` say how many.
        count: u32,
        /// Its push constants.
        params: FrameParams,
    },
    /// Builds the acceleration structure `neighbour_structure` over the boxes in `index_0`.
    Structure {
        /// Over what: the boxes are of all pixels, or of the deposits there are.
        side: Side,
        /// Boxes, at most.
        count: u32,
    },
    /// Brings deposits and points together.
    Gather {
        /// How.
        gather: &'static Variant,
        /// Invocations.
        count: u32,
        /// Its push constants.
        params: FrameParams,
    },
}

impl Step {
    /// Its name in profiles and messages.
    pub fn label(&self) -> String {
        match *self {
            Step::Dispatch { pass, .. } => pass.into(),
            Step::Clear { buffer } => format!("clear.{buffer}"),
            Step::Index { gather, stage, .. } => format!("{}.{stage}", gather.index_pass),
            Step::Structure { side: Side::Points, .. } => "build.points".into(),
            Step::Structure { side: Side::Photons, .. } => "build.photons".into(),
            Step::Gather { gather, .. } => gather.gather_pass.into(),
        }
    }
}

/// A buffer of a plan, by the name that entry points bind it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSpec {
    /// Name of the buffer and of the entry points' parameter.
    pub name: &'static str,
    /// Size [bytes].
    pub bytes: usize,
}
