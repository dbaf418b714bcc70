//! Runs steps on the CPU: the kernels' own functions, mapped over indices with rayon.

use std::time::Instant;

use anyhow::{Context, bail};
use caustics_kernels::interface::needs::Needs;

use super::{Runner, StepTime};
use crate::method::{BufferSpec, Step};
use crate::scene::motion::Placement;
use memory::Memory;

mod counters;
mod memory;
mod passes;

/// The CPU with a scene's tables and a plan's buffers.
pub struct CpuRunner {
    memory: Memory,
    needs: Needs,
    pool: rayon::ThreadPool,
}

impl CpuRunner {
    /// Allocates the buffers with zeros in them and copies the tables. `threads` 0 takes every core.
    pub fn new(
        threads: usize,
        needs: Needs,
        buffers: &[BufferSpec],
        tables: &[(&'static str, &[u8])],
    ) -> anyhow::Result<CpuRunner> {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start threads")?;
        let mut memory = Memory::default();
        for spec in buffers {
            memory.add(spec.name, spec.bytes);
        }
        for (name, bytes) in tables {
            memory.add(name, bytes.len());
            memory.write(name, 0, bytes)?;
        }
        Ok(CpuRunner { memory, needs, pool })
    }
}

impl Runner for CpuRunner {
    fn device(&self) -> String {
        format!("CPU, {} threads", self.pool.current_num_threads())
    }

    fn write_at(&mut self, buffer: &str, offset: usize, bytes: &[u8]) -> anyhow::Result<()> {
        self.memory.write(buffer, offset, bytes)
    }

    fn place(&mut self, _: &[Placement]) -> anyhow::Result<()> {
        // The tree is a buffer.
        Ok(())
    }

    fn read(&mut self, buffer: &str) -> anyhow::Result<Vec<u8>> {
        self.memory.bytes(buffer)
    }

    fn run(&mut self, steps: &[Step]) -> anyhow::Result<Vec<StepTime>> {
        let CpuRunner { memory, needs, pool } = self;
        let mut times = Vec::with_capacity(steps.len());
        for step in steps {
            let start = Instant::now();
            let call = |count, params| passes::Call { memory, count, params, needs: *needs };
            let run = |pass: &(dyn Fn() -> anyhow::Result<()> + Sync)| {
                pool.install(pass).with_context(|| format!("pass {}", step.label()))
            };
            match step {
                Step::Dispatch { pass, count, params } => {
                    let found =
                        passes::find(pass).with_context(|| format!("the CPU runner has no pass {pass:?}"))?;
                    run(&|| found(&call(*count, params)))?;
                }
                Step::Clear { buffer } => memory.clear(buffer)?,
                Step::Index { gather, count, params, .. } => {
                    run(&|| passes::gather::build(&call(*count, params), gather))?;
                }
                Step::Gather { gather, count, params } => {
                    run(&|| passes::gather::gather(&call(*count, params), gather))?;
                }
                Step::Structure { .. } => bail!("the CPU runner has no ray queries"),
            }
            times.push(StepTime { pass: step.label(), time: start.elapsed() });
        }
        Ok(times)
    }
}
