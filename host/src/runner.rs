//! A runner executes steps over named buffers: the CPU, or a Vulkan device.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use caustics_kernels::interface::frame::FrameParams;

use caustics_kernels::declare::Step;
use caustics_scene::instanced::InstanceTransform;

pub(crate) mod cpu;
mod error;
pub mod gpu;

pub use self::error::RunError;

/// Time that one step took.
#[derive(Clone, Debug)]
pub struct StepTime {
    /// Name of the pass (`build.points`, `clear.<buffer>` for the steps that are no dispatch).
    pub pass: String,
    /// Wall time on the CPU runner, time between device timestamps on a GPU.
    pub time: Duration,
}

/// Executes steps over named buffers. Scene tables are buffers like the others.
///
/// # Errors
///
/// Everything fails on names or sizes that the runner does not have, and where the device does.
pub trait Runner {
    /// Device and driver, for people and for provenance.
    fn device(&self) -> String;
    /// Overwrites the head of a buffer.
    fn write(&mut self, buffer: &str, bytes: &[u8]) -> Result<(), RunError> {
        self.write_at(buffer, 0, bytes)
    }
    /// Overwrites a buffer from an offset on (bytes).
    fn write_at(&mut self, buffer: &str, offset: usize, bytes: &[u8]) -> Result<(), RunError>;
    /// Brings instances to where they stand, and meshes that were deformed, by their index, to what their rows say now, for structures
    /// that are not buffers.
    fn set_instances(
        &mut self,
        instance_transforms: &[InstanceTransform],
        deformed: &[usize],
    ) -> Result<(), RunError>;
    /// A whole buffer.
    fn read(&mut self, buffer: &str) -> Result<Vec<u8>, RunError>;
    /// Shows a whole buffer, without a copy where it is memory of the host.
    fn show(&mut self, buffer: &str, to: &mut dyn FnMut(&[u8])) -> Result<(), RunError> {
        to(&self.read(buffer)?);
        Ok(())
    }
    /// From now on the flag ends steps that run, with [`RunError::Stopped`] and buffers that are half written. Runners that cannot be
    /// stopped run them to their end.
    fn stop_by(&mut self, _flag: &Arc<AtomicBool>) {}
    /// Executes the steps of a frame with these settings in order and returns the time of each.
    fn run(&mut self, params: &FrameParams, steps: &[Step]) -> Result<Vec<StepTime>, RunError>;
}
