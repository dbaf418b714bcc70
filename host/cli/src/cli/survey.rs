//! Options of `scene survey`.

use std::path::PathBuf;

use clap::Args;

/// Options of `scene survey`.
#[derive(Args, Debug)]
#[command(before_help = "Examples:
  caustics scene survey path/to/models
  caustics scene survey path/to/models --render --json > survey.json")]
pub struct Survey {
    /// Folder to search, subfolders included
    pub folder: PathBuf,
    /// Also render each file, 32 by 18 px on the CPU; values that are not finite and a black image are failures
    #[arg(long)]
    pub render: bool,
    /// Maximum time to load a file, and again to render it (s)
    #[arg(long, default_value_t = 60.0)]
    pub time_limit: f64,
    /// Exit with 1 if a file fails
    #[arg(long)]
    pub fail: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
