//! Options that split a run over processes or machines.

use caustics::shard::Shard;
use clap::Args;

use super::Usage;

/// Options that select the part of a run for this process.
#[derive(Args, Clone, Debug)]
pub struct Sharding {
    /// Part of the run to do, such as 2/8 [default: all]
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Number of parts, where the environment numbers this one: PARALLEL_SEQ of GNU parallel, or a Slurm array
    #[arg(long, value_name = "N", conflicts_with = "shard", value_parser = clap::value_parser!(u32).range(1..))]
    pub shards: Option<u32>,
}

impl Sharding {
    /// Returns the part that the options select, else the whole run.
    pub fn asked(&self) -> Result<Shard, Usage> {
        // Ignore the environment without options: a task of an array may be a whole run.
        if self.shard.is_none() && self.shards.is_none() { Ok(Shard::WHOLE) } else { self.found() }
    }

    /// Returns the part that the options select, else the part of a Slurm array's task, else the whole run.
    pub fn found(&self) -> Result<Shard, Usage> {
        let environment = |name: &str| std::env::var(name).ok();
        Shard::find(self.shard.as_deref(), self.shards, &environment).map_err(Usage)
    }
}
