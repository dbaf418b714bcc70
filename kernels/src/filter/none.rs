//! No filter.

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Filter;

/// Nothing is smoothed.
#[cfg(not(target_arch = "spirv"))]
pub const NONE: Filter = Filter {
    name: "none",
    about: "nothing is smoothed",
    cost: "nothing",
    wrong: "noise: one path a pixel",
    steps: |_| Vec::new(),
};
