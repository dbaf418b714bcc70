//! Filters of the path-traced part, before the caustics are added. A filter is data: the steps that it adds to a frame.

use std::fmt;

use caustics_kernels::interface::filter::FILTER_LEVELS;
use caustics_kernels::interface::frame::{Dispatch, FrameParams};
use caustics_kernels::pass::filter::{ATROUS as LEVEL, GUIDE};

use super::Step;

/// A way to smooth the path-traced part.
#[derive(Clone, Copy)]
pub struct Filter {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Its steps, after `collect`.
    pub steps: fn(&FrameParams) -> Vec<Step>,
}

/// Every filter.
pub const ALL: &[&Filter] = &[&NONE, &ATROUS];

/// The filter of this name.
pub fn find(name: &str) -> Option<&'static Filter> {
    ALL.iter().find(|filter| filter.name == name).copied()
}

/// Nothing is smoothed.
pub const NONE: Filter = Filter { name: "none", about: "nothing is smoothed", steps: |_| Vec::new() };

/// See `caustics_kernels::pass::filter`.
pub const ATROUS: Filter = Filter {
    name: "atrous",
    about: "an edge-stopping wavelet, guided by the collection points; it keeps the energy",
    steps: |params| {
        let count = params.pixel_count();
        let level = |level| Step::dispatch(&LEVEL, Dispatch { count, level, ..Dispatch::default() });
        std::iter::once(Step::of(&GUIDE, params)).chain((0..FILTER_LEVELS).map(level)).collect()
    },
};

impl PartialEq for Filter {
    fn eq(&self, other: &Filter) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for Filter {
    /// The name: addresses of functions differ from run to run, and a checkpoint knows its run by its settings.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Filter({})", self.name)
    }
}
