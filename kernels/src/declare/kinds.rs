//! What a frame can be made of: kinds of variants, each a file and a line in the list of its kind.

use super::{BufferError, Buffers, Pass, Step};
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::HistorySettings;
use crate::interface::scene::SceneTables;
use crate::light::emit::Emit;

/// A history: reuse of light from frame to frame.
#[derive(Clone, Copy)]
pub struct History {
    /// Name on the command line.
    pub name: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Cost of a frame.
    pub cost: &'static str,
    /// Limitations: where it is wrong, or gives nothing.
    pub limitations: &'static str,
    /// Its settings; none: nothing is reused.
    pub settings: Option<HistorySettings>,
    /// Once a frame, after `collect`, before anything is built over the frame's points.
    pub before: fn(&FrameParams) -> Vec<Step>,
    /// The pass that turns a point's sum into radiance.
    pub resolve: &'static Pass,
    /// What is filled with zeros in a frame without light, so that nothing is reused; empty: such a frame is like any other.
    pub forget: &'static [&'static str],
    /// Buffers in which something outlives its frame.
    pub keeps: &'static [&'static str],
    /// Whether it traces validation paths.
    pub validates: bool,
}

/// A denoiser: smooths the path-traced part.
#[derive(Clone, Copy)]
pub struct Denoiser {
    /// Name on the command line.
    pub name: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Cost of a frame.
    pub cost: &'static str,
    /// Limitations: where it is wrong, or gives nothing.
    pub limitations: &'static str,
    /// Its steps, after `collect`.
    pub steps: fn(&FrameParams) -> Vec<Step>,
}

/// Hands on what starts the light paths of a frame with these settings: of the scene, and of what `shoot` reads beside its tables.
pub type Starts = fn(
    SceneTables<'_>,
    &FrameParams,
    Features,
    &Buffers,
    &mut dyn FnMut(&(dyn Emit + Sync)),
) -> Result<(), BufferError>;

/// An emission: starts light paths.
#[derive(Clone, Copy)]
pub struct Emission {
    /// Name on the command line.
    pub name: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Cost of a frame.
    pub cost: &'static str,
    /// Limitations: where it is wrong, or gives nothing.
    pub limitations: &'static str,
    /// Whether it reads the casters of the frame's settings.
    pub uses_casters: bool,
    /// Whether it goes by what an error of each pixel counts (`pass::weigh`).
    pub weighs: bool,
    /// Once a frame that shoots, before its first light path.
    pub prepare: fn(&FrameParams) -> Vec<Step>,
    /// The pass that shoots a batch of light paths and stores their photons.
    pub shoot: &'static Pass,
    /// The same starts, for who traces some of the paths again on a CPU.
    pub starts: Starts,
    /// What is learnt from the first eighth of the light paths before the others start, in a frame before which something
    /// moved; none: nothing is.
    pub pilot: Option<fn(&FrameParams) -> Vec<Step>>,
    /// What is filled with zeros in a frame without light, so that nothing is learnt from what is gone.
    pub forget: &'static [&'static str],
    /// Buffers in which something outlives its frame.
    pub keeps: &'static [&'static str],
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
