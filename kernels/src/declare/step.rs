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
        /// Over what: the boxes are of all pixels, or of the photons there are.
        side: Side,
        /// Boxes, at most.
        count: u32,
    },
}

impl Step {
    /// All invocations that a pass has in a frame.
    pub fn new(pass: &'static Pass, params: &FrameParams) -> Step {
        Step::dispatch(pass, Dispatch { count: (pass.over)(params), ..Dispatch::default() })
    }

    /// So many invocations of a pass at a level.
    pub fn level(pass: &'static Pass, level: u32, count: u32) -> Step {
        Step::dispatch(pass, Dispatch { level, count, ..Dispatch::default() })
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
    pub fn work(&self) -> Option<Work> {
        match self {
            Step::Dispatch { pass, .. } => Some(pass.work),
            Step::Clear { buffer } => INDEX.contains(buffer).then_some(Work::Index),
            Step::Structure { .. } => Some(Work::Index),
        }
    }
}

/// The words of a gather's index.
pub const INDEX: [&str; 4] = ["index_0", "index_1", "index_2", "index_3"];

/// A buffer of a plan, by the name that entry points bind it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSpec {
    /// Name of the buffer and of the entry points' parameter.
    pub name: &'static str,
    /// Size (bytes).
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
