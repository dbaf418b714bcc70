//! A method is data: the buffers and the ordered list of steps that every runner executes.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use caustics_kernels::declare::{Access, Pass, Work};
use caustics_kernels::gather::variant::{self, Side, Variant};
use caustics_kernels::interface::frame::{Dispatch, FrameParams};

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
    /// The steps of a frame; what they bind is what is allocated.
    pub steps: fn(Parts, &FrameParams) -> Vec<Step>,
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
    /// Runs a pass.
    Dispatch {
        /// Which.
        pass: &'static Pass,
        /// Name behind that of the pass, where it has stages; else empty.
        stage: &'static str,
        /// Where this dispatch stands in its pass.
        dispatch: Dispatch,
    },
    /// Fills a buffer with zeros.
    Clear {
        /// Name of the buffer.
        buffer: &'static str,
    },
    /// Builds the acceleration structure `neighbour_structure` over the boxes in `index_0`.
    Structure {
        /// Over what: the boxes are of all pixels, or of the deposits there are.
        side: Side,
        /// Boxes, at most.
        count: u32,
    },
}

impl Step {
    /// All invocations that a pass has in a frame.
    pub fn of(pass: &'static Pass, params: &FrameParams) -> Step {
        Step::dispatch(pass, Dispatch { count: (pass.over)(params), ..Dispatch::default() })
    }

    /// A dispatch of a pass without stages.
    pub const fn dispatch(pass: &'static Pass, dispatch: Dispatch) -> Step {
        Step::Dispatch { pass, stage: "", dispatch }
    }

    /// Its name in profiles and messages.
    pub fn label(&self) -> String {
        match *self {
            Step::Dispatch { pass, stage: "", .. } => pass.name.into(),
            Step::Dispatch { pass, stage, .. } => format!("{}.{stage}", pass.name),
            Step::Clear { buffer } => format!("clear.{buffer}"),
            Step::Structure { side: Side::Points, .. } => "build.points".into(),
            Step::Structure { side: Side::Photons, .. } => "build.photons".into(),
        }
    }

    /// What kind of work it does; none of one that clears what no index consists of.
    fn work(&self) -> Option<Work> {
        match self {
            Step::Dispatch { pass, .. } => Some(pass.work),
            Step::Clear { buffer } => gather::INDEX.contains(buffer).then_some(Work::Index),
            Step::Structure { .. } => Some(Work::Index),
        }
    }
}

/// What kind of work the step of a label does, of all that frames can consist of.
pub fn work(label: &str) -> Option<Work> {
    static WORK: LazyLock<BTreeMap<String, Work>> =
        LazyLock::new(|| all_steps().iter().filter_map(|step| Some((step.label(), step.work()?))).collect());
    WORK.get(label).copied()
}

/// The steps of frames of every method with every gather, history and filter.
fn all_steps() -> Vec<Step> {
    let params = FrameParams {
        width: 1,
        height: 1,
        light_path_count: 1,
        light_path_batch: 1,
        deposit_capacity: 1,
        light_count: 1,
        ..FrameParams::default()
    };
    let mut steps = Vec::new();
    for method in ALL {
        for gather in variant::ALL {
            for history in history::ALL {
                for filter in filter::ALL {
                    steps.extend((method.steps)(
                        Parts { gather, history, filter },
                        &(method.frame)(params, 0),
                    ));
                }
            }
        }
    }
    steps
}

/// A buffer of a plan, by the name that entry points bind it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSpec {
    /// Name of the buffer and of the entry points' parameter.
    pub name: &'static str,
    /// Size [bytes].
    pub bytes: usize,
}

/// The buffers that steps bind or clear, scene tables aside: as large as the pass says that needs most. What nobody gives a
/// size is empty.
pub fn buffers(steps: &[Step], params: &FrameParams) -> Vec<BufferSpec> {
    let mut sizes: BTreeMap<&'static str, usize> = BTreeMap::new();
    for step in steps {
        match *step {
            Step::Dispatch { pass, .. } => {
                for bound in pass.buffers.iter().filter(|bound| bound.access != Access::Table) {
                    let size = sizes.entry(bound.name).or_default();
                    *size = bound.bytes(params).max(*size);
                }
            }
            Step::Clear { buffer } => {
                sizes.entry(buffer).or_default();
            }
            Step::Structure { .. } => {}
        }
    }
    sizes.into_iter().map(|(name, bytes)| BufferSpec { name, bytes }).collect()
}

/// The buffers of a frame of a method.
pub fn frame_buffers(method: &Method, parts: Parts, params: &FrameParams) -> Vec<BufferSpec> {
    let params = (method.frame)(*params, 0);
    buffers(&(method.steps)(parts, &params), &params)
}
