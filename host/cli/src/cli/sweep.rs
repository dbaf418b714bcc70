//! Options of `sweep`.

use std::path::PathBuf;

use clap::Args;

use super::Sharding;

/// Options of `sweep`.
#[derive(Args, Debug)]
#[command(before_help = "Examples:
  caustics sweep experiments/paths.toml -o paths
  caustics sweep experiments/paths.toml --dry-run
  caustics sweep experiments/paths.toml -o part-2 --shard 2/8
  caustics sweep --merge part-1 part-2 -o whole")]
#[command(mut_arg("shard", |arg| arg.help("Do one of n parts [default: the task of a Slurm array, else all]")))]
pub struct SweepOptions {
    /// Sweep file: what to measure
    #[arg(required_unless_present = "merge", value_name = "EXPERIMENT.toml")]
    pub experiment: Option<PathBuf>,
    /// Folder to write: cells/*.json with images, and cells.csv; results already in it are not measured again
    #[arg(short, long, required_unless_present = "dry_run")]
    pub output: Option<PathBuf>,
    /// Print the run configurations, which of them are done, and the number of references; measure nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Part to measure.
    #[command(flatten)]
    pub sharding: Sharding,
    /// Merge the results of these folders instead of measuring
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["experiment", "dry_run", "shard", "shards", "force"])]
    pub merge: Vec<PathBuf>,
    /// Vulkan device, by index or part of its name (default: the best)
    #[arg(long)]
    pub device: Option<String>,
    /// Threads of the CPU runner; 0 takes every core
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Measure everything again
    #[arg(long)]
    pub force: bool,
}
