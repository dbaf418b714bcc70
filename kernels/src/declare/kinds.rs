//! What a frame can be made of: kinds of variants, each a file and a line in the list of its kind.

use std::fmt;

use super::{Pass, Step};
use crate::gather::variant::Variant;
use crate::interface::frame::FrameParams;
use crate::interface::history::HistorySettings;

/// A way to render: what a frame consists of.
#[derive(Clone, Copy)]
pub struct Method {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// What a frame pays for it.
    pub cost: &'static str,
    /// Where it is wrong, or gives nothing.
    pub wrong: &'static str,
    /// Whether it makes collection points that deposits are brought to; else all its light is in one layer.
    pub gathers: bool,
    /// Whether a gather variant is chosen for it; else it brings deposits and points together in its own way.
    pub chooses_gather: bool,
    /// Which level of its textures a camera prefix sees where nobody asks for another.
    pub texture_filter: TextureFilter,
    /// Buffers of its own in which something outlives its frame, those of histories aside.
    pub keeps: &'static [&'static str],
    /// The settings of the frame of this index, made of those of the run.
    pub frame: fn(FrameParams, u32) -> FrameParams,
    /// The steps of a frame; what they bind is what is allocated.
    pub steps: fn(Parts, &FrameParams) -> Vec<Step>,
}

/// A way to lend light from frame to frame.
#[derive(Clone, Copy)]
pub struct History {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// What a frame pays for it.
    pub cost: &'static str,
    /// Where it is wrong, or gives nothing.
    pub wrong: &'static str,
    /// Its settings; none: nothing is lent.
    pub settings: Option<HistorySettings>,
    /// Once a frame, after `collect`, before anything is built over the frame's points.
    pub before: fn(&FrameParams) -> Vec<Step>,
    /// The pass that turns a point's sum into radiance.
    pub resolve: &'static Pass,
    /// What is filled with zeros in a frame without light, so that nothing is lent; empty: such a frame is like any other.
    pub forget: &'static [&'static str],
    /// Buffers in which something outlives its frame.
    pub keeps: &'static [&'static str],
}

/// A way to smooth the path-traced part.
#[derive(Clone, Copy)]
pub struct Filter {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// What a frame pays for it.
    pub cost: &'static str,
    /// Where it is wrong, or gives nothing.
    pub wrong: &'static str,
    /// Its steps, after `collect`.
    pub steps: fn(&FrameParams) -> Vec<Step>,
}

/// The parts of a frame that can be exchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        Parts { gather, history: &crate::history::none::NONE, filter: &crate::filter::none::NONE }
    }
}

/// Which level of its textures a camera prefix sees; every other path sees the finest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureFilter {
    /// That of the pixel's ray cone: one ray a pixel does not flicker, and materials are not what they are close by.
    Cone,
    /// The finest: rays over the whole pixel must average it, and then its picture is right.
    Finest,
}

impl TextureFilter {
    /// Both.
    pub const ALL: [TextureFilter; 2] = [TextureFilter::Cone, TextureFilter::Finest];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            TextureFilter::Cone => "cone",
            TextureFilter::Finest => "finest",
        }
    }
}

/// A name names one variant, and is what is printed: addresses of functions differ from process to process.
macro_rules! named {
    ($($kind:ident)*) => {
        $(
            impl fmt::Debug for $kind {
                fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    f.write_str(self.name)
                }
            }

            impl PartialEq for $kind {
                fn eq(&self, other: &$kind) -> bool {
                    self.name == other.name
                }
            }
        )*
    };
}

named!(Method History Filter);
