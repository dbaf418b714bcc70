//! Options that split a run over processes or machines.

use caustics::shard::Shard;
use clap::Args;

use super::Usage;

/// Which part of a run this process does.
#[derive(Args, Clone, Debug)]
pub struct Sharding {
    /// Do one of n parts, such as 2/8 [default: all]
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Number of parts, where the environment says which this is: PARALLEL_SEQ of GNU parallel, or a Slurm array
    #[arg(long, value_name = "N", conflicts_with = "shard", value_parser = clap::value_parser!(u32).range(1..))]
    pub shards: Option<u32>,
}

impl Sharding {
    /// The part that is asked for, else all.
    pub fn asked(&self) -> Result<Shard, Usage> {
        // A task of an array may have a whole run of its own.
        if self.shard.is_none() && self.shards.is_none() { Ok(Shard::WHOLE) } else { self.found() }
    }

    /// The part that is asked for, else that of a Slurm array's task, else all.
    pub fn found(&self) -> Result<Shard, Usage> {
        let environment = |name: &str| std::env::var(name).ok();
        Shard::find(self.shard.as_deref(), self.shards, &environment).map_err(Usage)
    }
}
