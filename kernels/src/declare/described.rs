//! A pass as data.

use std::fmt;

use super::{BufferError, Call};
use crate::interface::frame::FrameParams;

/// A pass: its name, invocations, buffers, and code for the CPU.
pub struct Pass {
    /// Name of its entry points, in profiles and in errors.
    pub name: &'static str,
    /// Kind of work.
    pub work: Work,
    /// Whether it traces rays, and so has an entry point for each tracer.
    pub traces: bool,
    /// Number of invocations in a frame with these settings.
    pub over: fn(&FrameParams) -> u32,
    /// Buffers that it binds. With ray queries, a structure replaces the buffers of the software tracer.
    pub buffers: &'static [Bound],
    /// Code for the CPU; `None` for a pass that needs ray queries.
    pub cpu: Option<OnCpu>,
}

/// CPU code of a pass, compiled twice from one source. Both give the same bits.
#[derive(Clone, Copy)]
pub struct OnCpu {
    /// Code for any CPU.
    pub any: fn(&Call<'_>) -> Result<(), BufferError>,
    /// Code for a CPU that [`has_avx2`](crate::trace::on_cpu::has_avx2) accepts.
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
    /// Access of the pass.
    pub access: Access,
    /// Number of elements needed in a frame with these settings; 0: other passes decide.
    pub len: fn(&FrameParams) -> u32,
}

impl Bound {
    /// Size that the buffer must have in a frame with these settings (bytes).
    pub fn bytes(&self, params: &FrameParams) -> usize {
        self.stride * (self.len)(params) as usize
    }
}

/// Access of a pass to a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Reads it.
    Read,
    /// Reads a table of the scene.
    Table,
    /// Writes its slots, and reads those that it writes.
    Slots,
    /// Adds to its words, or writes them one by one.
    Words,
}

/// Kinds of work: the rate that the time of a pass counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Work {
    /// Traces camera paths.
    Camera,
    /// Smooths light of camera paths.
    Denoiser,
    /// Traces light paths that deposit.
    Light,
    /// Guides light paths: chooses their starts.
    Guide,
    /// Builds the index of a gather.
    Index,
    /// Brings photons and collection points together.
    Gather,
    /// Brings photons to pixels, not to collection points.
    Splat,
    /// Writes layers for other tools.
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
    /// Buffers that the pass writes.
    pub fn written(&self) -> impl Iterator<Item = &'static Bound> {
        self.buffers.iter().filter(|bound| matches!(bound.access, Access::Slots | Access::Words))
    }
}

impl fmt::Debug for Pass {
    /// Prints the name: addresses of functions differ from process to process.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Pass {
    fn eq(&self, other: &Pass) -> bool {
        self.name == other.name
    }
}
