//! CPU runner: executes the kernels' own passes over indices with rayon.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use caustics_kernels::declare::{Buffers, Call};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;

use super::{RunError, Runner, StepTime};
use crate::threads;
use caustics_kernels::declare::{BufferSpec, Step};
use caustics_scene::instanced::InstanceTransform;

/// CPU runner with the tables of a scene and the buffers of a plan.
pub struct CpuRunner {
    buffers: Buffers,
    features: Features,
    /// Own thread pool. `None` if the system allows no more threads; then the process's pool computes.
    pool: Option<rayon::ThreadPool>,
    stop: Arc<AtomicBool>,
}

impl CpuRunner {
    /// Allocates zeroed buffers and copies the tables. With `threads` 0 it uses every core.
    pub fn new(
        threads: usize,
        features: Features,
        specs: &[BufferSpec],
        tables: &[(&'static str, &[u8])],
    ) -> Result<CpuRunner, RunError> {
        let pool = threads::pool(threads);
        let mut buffers = Buffers::default();
        for spec in specs {
            buffers.add(spec.name, spec.bytes)?;
        }
        for (name, bytes) in tables {
            buffers.add(name, bytes.len())?;
            buffers.write(name, 0, bytes)?;
        }
        Ok(CpuRunner { buffers, features, pool, stop: Arc::default() })
    }
}

impl Runner for CpuRunner {
    fn device(&self) -> String {
        let threads = self
            .pool
            .as_ref()
            .map_or_else(rayon::current_num_threads, rayon::ThreadPool::current_num_threads);
        format!("CPU, {threads} threads")
    }

    fn write_at(&mut self, buffer: &str, offset: usize, bytes: &[u8]) -> Result<(), RunError> {
        Ok(self.buffers.write(buffer, offset, bytes)?)
    }

    fn stop_by(&mut self, flag: &Arc<AtomicBool>) {
        self.stop = Arc::clone(flag);
    }

    fn set_instances(&mut self, _: &[InstanceTransform], _: &[usize]) -> Result<(), RunError> {
        // Nothing to do: the BVH is a buffer.
        Ok(())
    }

    fn read(&mut self, buffer: &str) -> Result<Vec<u8>, RunError> {
        Ok(self.buffers.read::<u8>(buffer)?.to_vec())
    }

    fn show(&mut self, buffer: &str, to: &mut dyn FnMut(&[u8])) -> Result<(), RunError> {
        to(&self.buffers.read::<u8>(buffer)?);
        Ok(())
    }

    fn run(&mut self, params: &FrameParams, steps: &[Step]) -> Result<Vec<StepTime>, RunError> {
        let mut times = Vec::with_capacity(steps.len());
        for step in steps {
            if self.stop.load(Ordering::Relaxed) {
                return Err(RunError::Stopped);
            }
            let start = Instant::now();
            match *step {
                Step::Dispatch { pass, dispatch, .. } => {
                    let no_run = || RunError::RayQueries { step: pass.name.into() };
                    let on_cpu = pass.cpu.ok_or_else(no_run)?;
                    let (buffers, features, stop) = (&self.buffers, self.features, &*self.stop);
                    let call = Call { buffers, params, dispatch, features, stop };
                    let done = match &self.pool {
                        Some(pool) => pool.install(|| on_cpu.run(&call)),
                        None => on_cpu.run(&call),
                    };
                    done.map_err(|source| RunError::Pass { pass: step.label(), source })?;
                }
                Step::Clear { buffer } => self.buffers.clear(buffer)?,
                Step::Structure { .. } => return Err(RunError::RayQueries { step: step.label() }),
            }
            times.push(StepTime { pass: step.label(), time: start.elapsed() });
        }
        if self.stop.load(Ordering::Relaxed) {
            return Err(RunError::Stopped);
        }
        Ok(times)
    }
}
