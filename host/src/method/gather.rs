//! The steps of a gather variant.

use caustics_kernels::gather::variant::{Over, Side, Stage, Variant};
use caustics_kernels::interface::frame::{Dispatch, FrameParams};
use caustics_kernels::pass::shoot::SHOOT_STORE;

use super::Step;

/// The words of an index.
pub const INDEX: [&str; 4] = ["index_0", "index_1", "index_2", "index_3"];

/// Light paths whose deposits the deposit buffers hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batch {
    /// The first.
    pub first: u32,
    /// So many.
    pub count: u32,
}

impl Batch {
    /// The dispatch of a pass over them.
    pub fn dispatch(self) -> Dispatch {
        Dispatch { first: self.first, count: self.count, ..Dispatch::default() }
    }
}

/// Once a frame, after `collect`.
pub fn prepare(gather: &'static Variant, params: &FrameParams) -> Vec<Step> {
    gather.frame.iter().map(|&stage| step(gather, stage, params)).collect()
}

/// For each batch of light paths: shoots them, builds what is built over deposits, gathers.
pub fn batch(gather: &'static Variant, params: &FrameParams, batch: Batch) -> Vec<Step> {
    let mut steps = shoot(batch);
    steps.extend(gather.batch.iter().map(|&stage| step(gather, stage, params)));
    steps.push(Step::dispatch(gather.gather, over(gather.side.searchers(), params)));
    steps
}

/// Shoots a batch of light paths and stores their deposits.
pub fn shoot(batch: Batch) -> Vec<Step> {
    vec![Step::Clear { buffer: "deposit_state" }, Step::dispatch(&SHOOT_STORE, batch.dispatch())]
}

/// The batches of a frame's light paths.
pub fn batches(params: &FrameParams) -> impl Iterator<Item = Batch> {
    let (count, most) = (params.light_path_count, params.light_path_batch.max(1));
    (0..count).step_by(most as usize).map(move |first| Batch { first, count: most.min(count - first) })
}

/// A dispatch over so much; over deposits, over those that there are.
pub fn over(over: Over, params: &FrameParams) -> Dispatch {
    let stored = u32::from(over == Over::Deposits);
    Dispatch { count: over.extent(params), stored, ..Dispatch::default() }
}

fn step(gather: &'static Variant, stage: Stage, params: &FrameParams) -> Step {
    match stage {
        Stage::Run(level, stage, of) => {
            Step::Dispatch { pass: gather.index, stage, dispatch: Dispatch { level, ..over(of, params) } }
        }
        Stage::Clear(words) => Step::Clear { buffer: INDEX[words as usize] },
        Stage::Structure(side) => {
            let over = if side == Side::Points { Over::Pixels } else { Over::Deposits };
            Step::Structure { side, count: over.extent(params) }
        }
    }
}
