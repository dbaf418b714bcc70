//! A method is data: the ordered list of steps that every runner executes.

use caustics_kernels::interface::frame::FrameParams;

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
    /// Builds the acceleration structure `points_structure` over `count` boxes of the buffer `point_boxes`.
    BuildPoints {
        /// Boxes.
        count: u32,
    },
}

/// A buffer of a plan, by the name that entry points bind it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSpec {
    /// Name of the buffer and of the entry points' parameter.
    pub name: &'static str,
    /// Size [bytes].
    pub bytes: usize,
}
