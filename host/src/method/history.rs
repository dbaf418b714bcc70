//! Histories: what the frame before lends to the collection points of this one. A history is data: the steps and buffers
//! that it adds to a frame.

use caustics_kernels::gather::variant::{Over, Work};

/// A way to lend light from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct History {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Once a frame, after `collect`, before anything is built over the frame's points.
    pub before: &'static [Work],
    /// The pass that turns a point's sum into radiance, instead of `resolve`, and what follows it.
    pub resolve: &'static [Work],
    /// Its buffers: name, element size [bytes], elements.
    pub buffers: &'static [(&'static str, usize, Over)],
}

/// Every history.
pub const ALL: &[&History] = &[&NONE];

/// The history of this name.
pub fn find(name: &str) -> Option<&'static History> {
    ALL.iter().find(|history| history.name == name).copied()
}

/// OurBasic: no light outlives its frame.
pub const NONE: History = History {
    name: "none",
    about: "no light outlives its frame: OurBasic",
    before: &[],
    resolve: &[Work::Pass("resolve", Over::Pixels)],
    buffers: &[],
};
