//! Kinds of variants that frames consist of. A variant is a file, and a line in the list of its kind.

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
    /// Limitations: where it is wrong or has no effect.
    pub limitations: &'static str,
    /// Settings; `None`: nothing is reused.
    pub settings: Option<HistorySettings>,
    /// Steps of a frame after `collect`, before anything is built over the frame's points.
    pub before: fn(&FrameParams) -> Vec<Step>,
    /// The pass that turns a point's sum into radiance.
    pub resolve: &'static Pass,
    /// Buffers cleared in a frame without light, so that nothing is reused; empty: such a frame is like any other.
    pub forget: &'static [&'static str],
    /// Buffers whose contents outlive their frame.
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
    /// Limitations: where it is wrong or has no effect.
    pub limitations: &'static str,
    /// Steps of a frame after `collect`.
    pub steps: fn(&FrameParams) -> Vec<Step>,
}

/// Calls back with the [`Emit`] of a frame with these settings, made of the scene and of the buffers that `shoot` reads beside
/// its tables.
pub type Starts = fn(
    SceneTables<'_>,
    &FrameParams,
    Features,
    &Buffers,
    &mut dyn FnMut(&(dyn Emit + Sync)),
) -> Result<(), BufferError>;

/// Steps of a frame with these settings.
pub type Steps = fn(&FrameParams) -> Vec<Step>;

/// Light paths that a stage learns from before the other paths of a frame start. After something moved, they are the first eighth
/// of the frame's paths. Before the first frame, they are training paths, whose light is not shown.
#[derive(Clone, Copy, Debug)]
pub struct Pilot {
    /// Paths that this frame has gathered so far (eighths of its number of light paths).
    pub gathered: u32,
    /// Whether pixels had weights that knew of caustics when the paths started. Else the scores of the paths mean nothing.
    pub has_weights: bool,
}

/// A stage of a frame: steps that are switched on together, by the slots of the frame that they run in. Frames without light
/// paths are dark: they skip `before_light`, `after_gather`, `after_resolve` and `gather_again`.
#[derive(Clone, Copy)]
pub struct FrameStage {
    /// Name of the stage.
    pub name: &'static str,
    /// Start of a frame before which something moved, with the settings of the last frame, in the scene of this one.
    pub look_back: Steps,
    /// Before the camera paths.
    pub before_collect: Steps,
    /// After the camera paths.
    pub after_collect: Steps,
    /// After `after_collect` of all stages, before the denoiser.
    pub before_denoise: Steps,
    /// Before the first light path.
    pub before_light: Steps,
    /// After each pilot, before other light paths start; `None`: there is none.
    pub after_pilot: Option<fn(&FrameParams, Pilot) -> Vec<Step>>,
    /// After the last photon is gathered.
    pub after_gather: Steps,
    /// After the sums of collection points have become radiance.
    pub after_resolve: Steps,
    /// After `after_resolve` of all stages, if all photons of the frame are still stored. Gets the steps that gather them.
    pub gather_again: fn(&FrameParams, &[Step]) -> Vec<Step>,
    /// Before the image is displayed, in dark frames, too.
    pub before_display: Steps,
    /// At the end of every frame.
    pub at_end: Steps,
    /// Buffers whose contents outlive their frame.
    pub keeps: &'static [&'static str],
    /// Features that camera paths need for what it reads of them.
    pub features: Features,
    /// Stages that it needs.
    pub needs: &'static [&'static FrameStage],
}

impl FrameStage {
    /// A stage without steps.
    pub const fn new(name: &'static str) -> FrameStage {
        const NO_STEPS: Steps = |_| Vec::new();
        FrameStage {
            name,
            look_back: NO_STEPS,
            before_collect: NO_STEPS,
            after_collect: NO_STEPS,
            before_denoise: NO_STEPS,
            before_light: NO_STEPS,
            after_pilot: None,
            after_gather: NO_STEPS,
            after_resolve: NO_STEPS,
            gather_again: |_, _| Vec::new(),
            before_display: NO_STEPS,
            at_end: NO_STEPS,
            keeps: &[],
            features: Features(0),
            needs: &[],
        }
    }
}

/// An emission: starts light paths.
#[derive(Clone, Copy)]
pub struct Emission {
    /// Name on the command line.
    pub name: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Cost of a frame.
    pub cost: &'static str,
    /// Limitations: where it is wrong or has no effect.
    pub limitations: &'static str,
    /// Whether it reads the casters of the frame's settings.
    pub uses_casters: bool,
    /// The pass that shoots a batch of light paths and stores their photons.
    pub shoot: &'static Pass,
    /// Starts of these light paths, for callers that trace some of them again on a CPU.
    pub starts: Starts,
    /// Steps before the light paths, and what it learns from a pilot.
    pub stage: FrameStage,
}

/// Compares and prints variants by name, which is unique: addresses of functions differ from process to process.
macro_rules! equal_by_name {
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

equal_by_name!(History Denoiser Emission FrameStage);
pub(crate) use equal_by_name;
