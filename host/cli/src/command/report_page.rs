//! `caustics report`: a page from folders of results.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use caustics::output::target::{Target, TargetError};
use caustics_bench::report::{self, Request, report};
use caustics_bench::store;

use super::options::{check_ending, same_file};
use crate::cli::{ReportOptions, Usage};

/// Reads the results, draws the page and writes it.
pub fn run(options: &ReportOptions) -> anyhow::Result<ExitCode> {
    let files = folder(&options.output)?;
    check_inputs(options, &files)?;
    // Claim the file before reading images, so that an existing file is refused at once.
    let page = Target::claim(&options.output, options.force)?;
    let request = Request {
        folders: options.folders.clone(),
        baseline: options.baseline.clone(),
        title: options.title.clone(),
        images: options.images,
        output: options.output.clone(),
    };
    let report = report(&request)?;
    for warning in &report.warnings {
        message!("warning: {warning}");
    }
    let was_there = files.exists();
    std::fs::create_dir_all(&files).with_context(|| format!("cannot create {}", files.display()))?;
    let written = write(&report, page, &files, options.force);
    if written.is_err() && !was_there {
        // Report the first error, not a failure to clean up.
        let _ = std::fs::remove_dir_all(&files);
    }
    written?;
    let (page, count) = (options.output.display(), report.files.len());
    message!(
        "{page}: {} run configurations, {:.1} MB; {count} files in {}",
        report.runs,
        report.html.len() as f64 / 1e6,
        files.display()
    );
    Ok(ExitCode::SUCCESS)
}

/// Refuses to overwrite an input, a result or an image beside it, and to write among them.
fn check_inputs(options: &ReportOptions, files: &Path) -> Result<(), Usage> {
    let output = options.output.display();
    check_ending("-o", &options.output, "html")?;
    for folder in options.folders.iter().chain(&options.baseline) {
        let results = store::results_folder(folder);
        if [folder, &results].into_iter().any(|folder| same_file(folder, files)) {
            let (files, folder) = (files.display(), folder.display());
            return Err(Usage(format!(
                "-o {output}: its figures go into {files}, but {folder} is a folder of results that are read; give another name"
            )));
        }
        let read =
            [folder, &results].into_iter().filter_map(|folder| folder.read_dir().ok()).flatten().flatten();
        // An earlier page may lie beside the results that it shows.
        let is_read = |file: &PathBuf| {
            file.extension().is_none_or(|ending| ending != "html") && same_file(file, &options.output)
        };
        if let Some(file) = read.map(|entry| entry.path()).find(is_read) {
            let file = file.display();
            return Err(Usage(format!(
                "-o {output}: {file} is one of the results that are read; give another name"
            )));
        }
    }
    Ok(())
}

/// Writes the figures' files, then the page.
fn write(report: &report::Report, page: Target, files: &Path, force: bool) -> Result<(), TargetError> {
    let claim = |(name, _): &(String, _)| Target::claim(&files.join(name), force);
    let targets: Vec<Target> = report.files.iter().map(claim).collect::<Result<_, _>>()?;
    for (target, (_, bytes)) in targets.into_iter().zip(&report.files) {
        target.finish(bytes)?;
    }
    page.finish(report.html.as_bytes())
}

/// Folder beside the page: `report_files` for `report.html`.
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
