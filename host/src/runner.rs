//! Runners, which execute steps over named buffers: the CPU, or a Vulkan device.

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

/// Time of one step.
#[derive(Clone, Debug)]
pub struct StepTime {
    /// Name of the pass. Steps that are no dispatch are called `build.points` or `clear.<buffer>`.
    pub pass: String,
    /// Wall time on the CPU runner, time between device timestamps on a GPU.
    pub time: Duration,
}

/// Executor of steps over named buffers. Scene tables are buffers too.
///
/// # Errors
///
/// All functions fail on unknown names and on ranges outside of a buffer, and if the device fails.
pub trait Runner {
    /// Returns the names of device and driver, for messages and for provenance.
    fn device(&self) -> String;
    /// Overwrites the beginning of a buffer.
    fn write(&mut self, buffer: &str, bytes: &[u8]) -> Result<(), RunError> {
        self.write_at(buffer, 0, bytes)
    }
    /// Overwrites a buffer from an offset on (bytes).
    fn write_at(&mut self, buffer: &str, offset: usize, bytes: &[u8]) -> Result<(), RunError>;
    /// Updates acceleration structures that are not buffers: the instances' transforms, and the deformed meshes with these
    /// indices. Meshes are read from their tables.
    fn set_instances(
        &mut self,
        instance_transforms: &[InstanceTransform],
        deformed: &[usize],
    ) -> Result<(), RunError>;
    /// Returns a whole buffer.
    fn read(&mut self, buffer: &str) -> Result<Vec<u8>, RunError>;
    /// Passes a whole buffer to a function, without a copy if the buffer is in host memory.
    fn show(&mut self, buffer: &str, to: &mut dyn FnMut(&[u8])) -> Result<(), RunError> {
        to(&self.read(buffer)?);
        Ok(())
    }
    /// Sets a flag that stops running steps with [`RunError::Stopped`] and leaves buffers half written. Runners that cannot
    /// be stopped ignore it.
    fn stop_by(&mut self, _flag: &Arc<AtomicBool>) {}
    /// Executes the steps of a frame with these parameters in order and returns the time of each.
    fn run(&mut self, params: &FrameParams, steps: &[Step]) -> Result<Vec<StepTime>, RunError>;
}
