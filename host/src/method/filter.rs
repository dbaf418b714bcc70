//! Filters of the path-traced part, before the caustics are added. A filter is data: the steps and buffers that it adds to
//! a frame.

use caustics_kernels::interface::frame::FrameParams;

use super::{BufferSpec, Step};

/// A way to smooth the path-traced part.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Its steps, after `collect`.
    pub steps: fn(FrameParams) -> Vec<Step>,
    /// Its buffers.
    pub buffers: fn(&FrameParams) -> Vec<BufferSpec>,
}

/// Every filter.
pub const ALL: &[&Filter] = &[&NONE];

/// The filter of this name.
pub fn find(name: &str) -> Option<&'static Filter> {
    ALL.iter().find(|filter| filter.name == name).copied()
}

/// Nothing is smoothed.
pub const NONE: Filter =
    Filter { name: "none", about: "nothing is smoothed", steps: |_| Vec::new(), buffers: |_| Vec::new() };

impl PartialEq for Filter {
    fn eq(&self, other: &Filter) -> bool {
        self.name == other.name
    }
}
