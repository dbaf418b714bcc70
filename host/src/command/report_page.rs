//! `caustics report`: a page made of folders of results.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use caustics::output::target::{Target, TargetError};
use caustics::report::{self, Request, report};

use crate::cli::{Report, Usage};

/// Reads, draws and writes.
pub fn run(options: &Report) -> anyhow::Result<ExitCode> {
    let files = folder(&options.output)?;
    // Claimed first: nobody waits for pictures to be read only to hear that a file exists.
    let page = Target::claim(&options.output, options.force)?;
    let request = Request {
        folders: options.folders.clone(),
        baseline: options.baseline.clone(),
        title: options.title.clone(),
        pictures: options.pictures,
        output: options.output.clone(),
    };
    let report = report(&request)?;
    for warning in &report.warnings {
        tell!("warning: {warning}");
    }
    let was_there = files.exists();
    std::fs::create_dir_all(&files).with_context(|| format!("cannot create {}", files.display()))?;
    let written = write(&report, page, &files, options.force);
    if written.is_err() && !was_there {
        // What the error says matters more than a failure to tidy up.
        let _ = std::fs::remove_dir_all(&files);
    }
    written?;
    let (page, count) = (options.output.display(), report.files.len());
    tell!(
        "{page}: {} cells, {:.1} MB; {count} files in {}",
        report.cells,
        report.html.len() as f64 / 1e6,
        files.display()
    );
    Ok(ExitCode::SUCCESS)
}

/// Writes the files, then the page.
fn write(report: &report::Report, page: Target, files: &Path, force: bool) -> Result<(), TargetError> {
    let claim = |(name, _): &(String, _)| Target::claim(&files.join(name), force);
    let targets: Vec<Target> = report.files.iter().map(claim).collect::<Result<_, _>>()?;
    for (target, (_, bytes)) in targets.into_iter().zip(&report.files) {
        target.finish(bytes)?;
    }
    page.finish(report.html.as_bytes())
}

/// The folder beside the page: `report_files` of `report.html`.
fn folder(output: &Path) -> Result<PathBuf, Usage> {
    match output.file_stem() {
        Some(stem) if !output.is_dir() => {
            let mut name = stem.to_os_string();
            name.push("_files");
            Ok(output.with_file_name(name))
        }
        _ => Err(Usage(format!("-o {}: name a file, report.html for instance", output.display()))),
    }
}
