//! A pass as data.

use std::fmt;

use super::{BufferError, Call};
use crate::interface::frame::FrameParams;

/// A pass: what it is called, what it runs over, what it binds.
pub struct Pass {
    /// Name: of its entry points, in profiles, in errors.
    pub name: &'static str,
    /// What kind of work it does.
    pub work: Work,
    /// Whether it traces rays, and so has an entry point for each tracer.
    pub traces: bool,
    /// Its invocations in a frame with these settings.
    pub over: fn(&FrameParams) -> u32,
    /// The buffers that it binds; on hardware a structure takes the place of those of the software tracer.
    pub buffers: &'static [Bound],
    /// Runs it on the CPU; none of a pass that needs ray queries.
    pub cpu: Option<OnCpu>,
}

/// A pass as the CPU calls it, compiled twice from one source; its results are the same bits.
#[derive(Clone, Copy)]
pub struct OnCpu {
    /// For any CPU.
    pub any: fn(&Call<'_>) -> Result<(), BufferError>,
    /// For one that has what [`has_avx2`](crate::trace::on_cpu::has_avx2) asks for.
    #[cfg(target_arch = "x86_64")]
    pub avx2: unsafe fn(&Call<'_>) -> Result<(), BufferError>,
}

/// A buffer that a pass binds.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// Name of the buffer and of the parameter.
    pub name: &'static str,
    /// Size of an element (bytes).
    pub stride: usize,
    /// What the pass does with it.
    pub access: Access,
    /// Elements that it must have in a frame with these settings; 0: as many as others say.
    pub len: fn(&FrameParams) -> u32,
}

impl Bound {
    /// Size that the buffer must have in a frame with these settings (bytes).
    pub fn bytes(&self, params: &FrameParams) -> usize {
        self.stride * (self.len)(params) as usize
    }
}

/// What a pass does with a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Reads it.
    Read,
    /// Reads it: a table of the scene.
    Table,
    /// Writes its slots, and reads those that it writes.
    Slots,
    /// Adds to its words, or writes them one by one.
    Words,
}

/// Kinds of work: which rate the time of a pass counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Work {
    /// Traces camera paths.
    Camera,
    /// Smooths what camera paths saw.
    Denoiser,
    /// Traces light paths that deposit.
    Light,
    /// Chooses where light paths start.
    Guide,
    /// Builds what a gather searches.
    Index,
    /// Brings photons and collection points together.
    Gather,
    /// Brings photons to pixels, not to collection points.
    Splat,
    /// Says what pixels show, for other tools.
    Auxiliary,
    /// Judges light of the previous frame, and reuses it.
    Reuse,
    /// Turns sums into radiance.
    Resolve,
    /// Turns radiance into colours.
    Display,
    /// A single step, for tests.
    Step,
}

impl Pass {
    /// The buffers that it writes.
    pub fn written(&self) -> impl Iterator<Item = &'static Bound> {
        self.buffers.iter().filter(|bound| matches!(bound.access, Access::Slots | Access::Words))
    }
}

impl fmt::Debug for Pass {
    /// Its name: addresses of functions differ from process to process.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Pass {
    fn eq(&self, other: &Pass) -> bool {
        self.name == other.name
    }
}
