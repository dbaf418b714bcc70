//! The steps of a frame, and the buffers that they need.

use std::collections::BTreeMap;

use super::{Access, Pass, Work};
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::point::Side;

/// One step of a frame. Every step sees all that earlier steps wrote.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Runs a pass.
    Dispatch {
        /// Pass that runs.
        pass: &'static Pass,
        /// Name of the stage, behind the name of the pass; empty for a pass without stages.
        stage: &'static str,
        /// Position of the dispatch in its pass.
        dispatch: Dispatch,
    },
    /// Fills a buffer with zeros.
    Clear {
        /// Name of the buffer.
        buffer: &'static str,
    },
    /// Builds the acceleration structure `neighbour_structure` over the boxes in `index_0`.
    Structure {
        /// Elements with boxes: all pixels, or the photons of the frame.
        side: Side,
        /// Maximum number of boxes.
        count: u32,
    },
}

impl Step {
    /// Dispatches all invocations that a pass has in a frame.
    pub fn new(pass: &'static Pass, params: &FrameParams) -> Step {
        Step::dispatch(pass, Dispatch { count: (pass.over)(params), ..Dispatch::default() })
    }

    /// Dispatches `count` invocations of a pass at a level.
    pub fn level(pass: &'static Pass, level: u32, count: u32) -> Step {
        Step::dispatch(pass, Dispatch { level, count, ..Dispatch::default() })
    }

    /// Dispatches a pass without stages.
    pub const fn dispatch(pass: &'static Pass, dispatch: Dispatch) -> Step {
        Step::Dispatch { pass, stage: "", dispatch }
    }

    /// Name in profiles and messages.
    pub fn label(&self) -> String {
        match *self {
            Step::Dispatch { pass, stage: "", .. } => pass.name.into(),
            Step::Dispatch { pass, stage, .. } => format!("{}.{stage}", pass.name),
            Step::Clear { buffer } => format!("clear.{buffer}"),
            Step::Structure { side: Side::Points, .. } => "build.points".into(),
            Step::Structure { side: Side::Photons, .. } => "build.photons".into(),
        }
    }

    /// Kind of work; `None` for clearing a buffer that is not part of an index.
    pub fn work(&self) -> Option<Work> {
        match self {
            Step::Dispatch { pass, .. } => Some(pass.work),
            Step::Clear { buffer } => INDEX.contains(buffer).then_some(Work::Index),
            Step::Structure { .. } => Some(Work::Index),
        }
    }
}

/// Buffers of a gather's index.
pub const INDEX: [&str; 4] = ["index_0", "index_1", "index_2", "index_3"];

/// A buffer of a plan, by the name that entry points bind it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSpec {
    /// Name of the buffer and of the entry points' parameter.
    pub name: &'static str,
    /// Size (bytes).
    pub bytes: usize,
}

/// Buffers that steps bind or clear, without the tables of the scene. The size of each is the maximum over its passes; it is
/// empty if no pass gives it a size.
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
