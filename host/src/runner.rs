//! A runner executes steps over named buffers: the CPU, or a Vulkan device.

use std::time::Duration;

use caustics_kernels::interface::frame::FrameParams;

use crate::scene::motion::Placement;
use caustics_kernels::declare::Step;

pub mod cpu;
pub mod gpu;

/// Time that one step took.
#[derive(Clone, Debug)]
pub struct StepTime {
    /// Name of the pass (`build.points`, `clear.<buffer>` for the steps that are no dispatch).
    pub pass: String,
    /// Wall time on the CPU runner, time between device timestamps on a GPU.
    pub time: Duration,
}

/// Executes steps over named buffers. Scene tables are buffers like the others.
pub trait Runner {
    /// Device and driver, for people and for provenance.
    fn device(&self) -> String;
    /// Overwrites the head of a buffer.
    fn write(&mut self, buffer: &str, bytes: &[u8]) -> anyhow::Result<()> {
        self.write_at(buffer, 0, bytes)
    }
    /// Overwrites a buffer from an offset on (bytes).
    fn write_at(&mut self, buffer: &str, offset: usize, bytes: &[u8]) -> anyhow::Result<()>;
    /// Brings meshes that move to where they stand, for structures that are not buffers.
    fn place(&mut self, placements: &[Placement]) -> anyhow::Result<()>;
    /// A whole buffer.
    fn read(&mut self, buffer: &str) -> anyhow::Result<Vec<u8>>;
    /// Executes the steps of a frame with these settings in order and returns the time of each.
    fn run(&mut self, params: &FrameParams, steps: &[Step]) -> anyhow::Result<Vec<StepTime>>;
}
