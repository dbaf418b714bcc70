//! Options of `report`.

use std::path::PathBuf;

use clap::Args;

/// Options of `report`.
#[derive(Args, Debug)]
#[command(before_help = "Examples:
  caustics report results -o report.html
  caustics report results/rooms results/animations -o report.html --title 'Histories' --images 4 --force")]
pub struct ReportOptions {
    /// Folders of results, as written by `sweep` and `bench` (cells/*.json in each)
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Earlier results: a table shows how each run configuration differs from them, and whether by more than noise
    #[arg(long, value_name = "DIR")]
    pub baseline: Vec<PathBuf>,
    /// HTML file to write; SVG and CSV files of its figures go into a folder beside it (report_files)
    #[arg(short, long)]
    pub output: PathBuf,
    /// Title of the page
    #[arg(long, default_value = "Speed against accuracy")]
    pub title: String,
    /// Maximum number of images of each scene: one of each method, gather, history and filter
    #[arg(long, default_value_t = 12)]
    pub images: usize,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}
