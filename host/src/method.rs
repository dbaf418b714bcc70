//! A method is data: the buffers and the ordered list of steps that every runner executes.

use caustics_kernels::gather::variant::{Over, Variant, Work};
use caustics_kernels::interface::frame::FrameParams;

pub mod basic;
pub mod filter;
pub mod history;
pub mod path;
pub mod progressive;
pub mod settings;

use filter::Filter;
use history::History;

/// A way to render: what a frame consists of.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Whether it makes collection points and gathers deposits; else all its light is in one layer.
    pub gathers: bool,
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
pub const ALL: &[&Method] = &[&basic::BASIC, &progressive::PROGRESSIVE, &path::PATH];

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
    /// Builds the acceleration structure `points_structure` over `count` boxes of the buffer `point_boxes`.
    BuildPoints {
        /// Boxes.
        count: u32,
    },
}

impl Step {
    /// The step of a piece of work of a gather variant.
    fn of(work: Work, params: FrameParams) -> Step {
        match work {
            Work::Pass(pass, over) => Step::Dispatch { pass, count: extent(over, &params), params },
            Work::Clear(buffer) => Step::Clear { buffer },
            Work::BuildPoints => Step::BuildPoints { count: params.pixel_count() },
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

/// Elements of what a pass runs over.
fn extent(over: Over, params: &FrameParams) -> u32 {
    match over {
        Over::Pixels => params.pixel_count(),
        Over::LightPaths => params.light_path_batch,
        Over::Deposits => params.deposit_capacity,
        Over::Cells => params.cell_mask + 1,
        Over::One => 1,
    }
}

/// Buffers by name, size of an element [bytes] and elements.
fn extent_buffers(
    rows: &'static [(&'static str, usize, Over)],
    params: &FrameParams,
) -> impl Iterator<Item = BufferSpec> {
    let spec = |&(name, size, over)| BufferSpec { name, bytes: size * extent(over, params) as usize };
    rows.iter().map(spec)
}
