//! No history: OurBasic [Moreau and Doggett 2022].

#[cfg(not(target_arch = "spirv"))]
use crate::declare::History;
#[cfg(not(target_arch = "spirv"))]
use crate::pass::resolve::RESOLVE;

/// No history: no light outlives its frame.
#[cfg(not(target_arch = "spirv"))]
pub const NONE: History = History {
    name: "none",
    description: "no reuse: OurBasic",
    cost: "nothing",
    limitations: "noise: every frame starts from nothing",
    settings: None,
    before: |_| Vec::new(),
    resolve: &RESOLVE,
    forget: &[],
    keeps: &[],
    validates: false,
};
