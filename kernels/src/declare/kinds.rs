//! What a frame can be made of: kinds of variants, each a file and a line in the list of its kind.

use super::{Pass, Step};
use crate::interface::frame::FrameParams;
use crate::interface::history::HistorySettings;

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
    /// Whether it traces validation paths.
    pub validates: bool,
}

/// A way to smooth the path-traced part.
#[derive(Clone, Copy)]
pub struct Denoiser {
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

/// A way to start light paths.
#[derive(Clone, Copy)]
pub struct Emission {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// What a frame pays for it.
    pub cost: &'static str,
    /// Where it is wrong, or gives nothing.
    pub wrong: &'static str,
    /// Whether it reads the casters of the frame's settings.
    pub aims: bool,
    /// Whether it goes by what an error of each pixel counts (`pass::weigh`).
    pub weighs: bool,
    /// Once a frame that shoots, before its first light path.
    pub prepare: fn(&FrameParams) -> Vec<Step>,
    /// The pass that shoots a batch of light paths and stores their deposits.
    pub shoot: &'static Pass,
    /// What is learnt from the first eighth of the light paths before the others start, in a frame before which something
    /// moved; none: nothing is.
    pub pilot: Option<fn(&FrameParams) -> Vec<Step>>,
    /// What is filled with zeros in a frame without light, so that nothing is learnt from what is gone.
    pub forget: &'static [&'static str],
    /// Buffers in which something outlives its frame.
    pub keeps: &'static [&'static str],
}

/// Which light is a caustic, and so the light paths'; all other is found from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caustics {
    /// What meets a specular lobe first. Light of diffuse surfaces that meets one later is found by connections to those
    /// surfaces, with far less noise, unless what is lit first is small and bright.
    First,
    /// What meets a specular lobe anywhere, as published [Moreau and Doggett 2022].
    Any,
}

impl Caustics {
    /// Both.
    pub const ALL: [Caustics; 2] = [Caustics::First, Caustics::Any];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Caustics::First => "first",
            Caustics::Any => "any",
        }
    }

    /// What it is, in one line.
    pub fn about(self) -> &'static str {
        match self {
            Caustics::First => "light whose first surface is specular; the camera finds the rest",
            Caustics::Any => "light that met anything specular before its collection point, as published",
        }
    }
}

/// How camera paths find lights at their first vertices, up to the collection point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connections {
    /// All lights where they are few, else the best of some.
    Resampled,
    /// One light a vertex, drawn by its power, as published.
    Power,
}

impl Connections {
    /// Both.
    pub const ALL: [Connections; 2] = [Connections::Resampled, Connections::Power];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Connections::Resampled => "resampled",
            Connections::Power => "power",
        }
    }

    /// What it is, in one line.
    pub fn about(self) -> &'static str {
        match self {
            Connections::Resampled => {
                "all of up to four lights, else one of eight candidates by what they would give"
            }
            Connections::Power => "one light, drawn by its power",
        }
    }
}

/// What is done about rare bright samples of camera paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fireflies {
    /// Nothing: frames are right in the mean.
    Kept,
    /// They are bounded by the pixels around, and their energy is lost.
    Bounded,
}

impl Fireflies {
    /// Both.
    pub const ALL: [Fireflies; 2] = [Fireflies::Kept, Fireflies::Bounded];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Fireflies::Kept => "kept",
            Fireflies::Bounded => "bounded",
        }
    }

    /// What it is, in one line.
    pub fn about(self) -> &'static str {
        match self {
            Fireflies::Kept => "nothing: frames are right in the mean",
            Fireflies::Bounded => {
                "at most eight times the mean around, which loses one or two hundredths of the light"
            }
        }
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
            impl std::fmt::Debug for $kind {
                fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
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

named!(History Denoiser Emission);
pub(crate) use named;
