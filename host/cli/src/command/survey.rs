//! `caustics scene survey`: finds the files of a folder that can be rendered, and the causes that prevent the others.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use anyhow::Context;
use caustics::image_file::Channels;
use caustics::text::cut;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};

use self::alone::{Ended, run_alone};
use self::cause::{cause, kind};
use super::console::{bar, print};
use super::options::duration;
use crate::cli;

mod alone;
mod cause;

/// Arguments of a small render that shows whether a file can be rendered.
const RENDER: [&str; 14] = [
    "render",
    "--width",
    "32",
    "--height",
    "18",
    "--frames",
    "2",
    "--light-paths",
    "2000",
    "--runner",
    "cpu",
    "--threads",
    "1",
    "-o",
];

/// Outcome of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
enum Outcome {
    /// The file loads as it is.
    Loads,
    /// The file loads with something left out.
    Warns,
    /// The file does not load, or gives no valid image.
    Fails,
}

impl Outcome {
    fn name(self) -> &'static str {
        match self {
            Outcome::Loads => "loads",
            Outcome::Warns => "warns",
            Outcome::Fails => "fails",
        }
    }
}

/// A file of the survey.
#[derive(Debug, Serialize)]
struct FileRecord {
    file: String,
    outcome: Outcome,
    /// Reason for the failure.
    error: Option<String>,
    warnings: Vec<String>,
    triangles: u64,
    seconds: f64,
}

/// Surveys a folder. Returns exit code 1 with `--fail` if a file fails.
pub fn run(options: &cli::Survey) -> anyhow::Result<ExitCode> {
    let limit = duration("--time-limit", options.time_limit)?;
    let mut files = Vec::new();
    find(&options.folder, &mut files)
        .with_context(|| format!("cannot read the folder {}", options.folder.display()))?;
    files.sort();
    let program = std::env::current_exe().context("this program has no file")?;
    let (bar, done) = (bar(), AtomicU64::new(0));
    let total = bar.length().unwrap_or(1);
    let records: Vec<FileRecord> = files
        .par_iter()
        .map(|file| {
            let record = survey(&program, file, &options.folder, options.render, limit);
            bar.set_position(total * (done.fetch_add(1, Ordering::Relaxed) + 1) / files.len() as u64);
            record
        })
        .collect();
    bar.finish_and_clear();
    if options.json {
        print(serde_json::to_string_pretty(&json!({ "files": records, "summary": summary(&records) }))?)?;
    } else {
        print(table(&records).trim_end())?;
    }
    let fails = records.iter().any(|record| record.outcome == Outcome::Fails);
    Ok(if options.fail && fails { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Finds the scenes below a folder. Does not follow links to folders, which may form cycles.
fn find(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in folder.read_dir()? {
        let entry = entry?;
        let path = entry.path();
        if entry.file_type()?.is_dir() {
            find(&path, files)?;
        } else if path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("gltf") || end.eq_ignore_ascii_case("glb"))
        {
            files.push(path);
        }
    }
    Ok(())
}

/// Loads a file, and renders it if the options ask for it.
fn survey(
    program: &Path,
    file: &Path,
    folder: &Path,
    renders: bool,
    limit: std::time::Duration,
) -> FileRecord {
    let start = Instant::now();
    let name = file.strip_prefix(folder).unwrap_or(file).display().to_string();
    let mut record = FileRecord {
        file: name,
        outcome: Outcome::Loads,
        error: None,
        warnings: Vec::new(),
        triangles: 0,
        seconds: 0.0,
    };
    let info = run_alone(program, &["scene", "info", "--json", "--"], file, limit);
    let tried = info.and_then(|ended| read_info(&ended, &mut record)).and_then(|()| match renders {
        true => render(program, file, limit),
        false => Ok(()),
    });
    record.outcome = match &tried {
        Err(_) => Outcome::Fails,
        Ok(()) if record.warnings.is_empty() => Outcome::Loads,
        Ok(()) => Outcome::Warns,
    };
    record.error = tried.err().map(|error| cause(&error, file));
    record.seconds = (100.0 * start.elapsed().as_secs_f64()).round() / 100.0;
    record
}

/// Adds the output of `scene info --json` to a record.
fn read_info(ended: &Ended, record: &mut FileRecord) -> Result<(), String> {
    ended.fault().map_or(Ok(()), Err)?;
    let info: Value = serde_json::from_slice(&ended.stdout).map_err(|error| error.to_string())?;
    record.triangles = info["triangles"].as_u64().unwrap_or(0);
    let warnings = info["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str);
    record.warnings = warnings.map(Into::into).collect();
    Ok(())
}

/// Renders a file; an image that is black or not finite is a failure.
fn render(program: &Path, file: &Path, limit: std::time::Duration) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let out = folder.path().join("out.exr");
    let mut arguments = RENDER.to_vec();
    let path = out.to_string_lossy();
    arguments.extend([&*path, "--"]);
    run_alone(program, &arguments, file, limit)?.fault().map_or(Ok(()), Err)?;
    let image = Channels::read(&out).map_err(|error| format!("{error:#}"))?;
    fault_of(image.layer("").into_iter().flatten().flatten())
}

/// Checks the values of an image; the error says what is wrong.
fn fault_of<'a>(values: impl Iterator<Item = &'a f32> + Clone) -> Result<(), String> {
    if !values.clone().all(|value| value.is_finite()) {
        return Err("its image has values that are not finite".into());
    }
    if !values.clone().any(|value| *value > 0.0) {
        return Err("its image is black".into());
    }
    Ok(())
}

/// Number of files that fail and warn, by cause.
fn summary(records: &[FileRecord]) -> Value {
    let mut causes: BTreeMap<(&str, String), usize> = BTreeMap::new();
    for record in records {
        if let Some(error) = &record.error {
            *causes.entry(("fails", kind(error))).or_default() += 1;
        }
        let mut kinds: Vec<String> =
            record.warnings.iter().map(|warning| kind(&cause(warning, Path::new(&record.file)))).collect();
        kinds.sort();
        kinds.dedup();
        for kind in kinds {
            *causes.entry(("warns", kind)).or_default() += 1;
        }
    }
    let count = |outcome| records.iter().filter(|record| record.outcome == outcome).count();
    let mut causes: Vec<_> = causes.into_iter().collect();
    causes.sort_by(|((a, _), m), ((b, _), n)| a.cmp(b).then(n.cmp(m)));
    let causes: Vec<Value> = causes
        .into_iter()
        .map(|((what, cause), files)| json!({ "what": what, "cause": cause, "files": files }))
        .collect();
    json!({
        "files": records.len(), "loads": count(Outcome::Loads), "warns": count(Outcome::Warns),
        "fails": count(Outcome::Fails), "causes": causes,
    })
}

/// Table of the survey for the user.
fn table(records: &[FileRecord]) -> String {
    let mut text = String::new();
    for record in records {
        let more = match (&record.error, record.warnings.len()) {
            (Some(error), _) => format!(": {}", cut(error, 200).replace('\n', " ")),
            (None, 0) => String::new(),
            (None, 1) => ": 1 warning".into(),
            (None, count) => format!(": {count} warnings"),
        };
        let file = cut(&record.file, 120).replace('\n', "\\n");
        let _ = writeln!(text, "{} {:7.2} s  {file}{more}", record.outcome.name(), record.seconds);
    }
    let summary = summary(records);
    let _ = writeln!(
        text,
        "\n{} files: {} load, {} load with warnings, {} fail",
        summary["files"], summary["loads"], summary["warns"], summary["fails"]
    );
    for cause in summary["causes"].as_array().into_iter().flatten() {
        let words = cut(cause["cause"].as_str().unwrap_or_default(), 160).replace('\n', " ");
        let _ = writeln!(text, "{:6} {} {words}", cause["files"], cause["what"].as_str().unwrap_or_default());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_that_show_nothing_are_failures() {
        assert_eq!(fault_of([0.0, 0.5].iter()), Ok(()));
        assert!(fault_of([0.0, 0.0].iter()).unwrap_err().contains("black"));
        assert!(fault_of([0.5, f32::NAN].iter()).unwrap_err().contains("finite"));
        assert!(fault_of([].iter()).is_err());
    }

    #[test]
    fn a_file_counts_once_for_each_kind_of_warning() {
        let record = |error: Option<&str>, warnings: &[&str]| FileRecord {
            file: "a.gltf".into(),
            outcome: if error.is_some() { Outcome::Fails } else { Outcome::Warns },
            error: error.map(Into::into),
            warnings: warnings.iter().map(|warning| (*warning).into()).collect(),
            triangles: 1,
            seconds: 0.5,
        };
        let records = [
            record(
                None,
                &["x/a.gltf: node \"u\": its skin is left out", "x/a.gltf: node 3: its skin is left out"],
            ),
            record(None, &["x/a.gltf: node 7: its skin is left out"]),
            record(Some("accessor 3 is too short"), &[]),
        ];
        let summary = summary(&records);
        assert_eq!((&summary["warns"], &summary["fails"]), (&json!(2), &json!(1)));
        let causes = json!([
            { "what": "fails", "cause": "accessor N is too short", "files": 1 },
            { "what": "warns", "cause": "its skin is left out", "files": 2 },
        ]);
        assert_eq!(summary["causes"], causes);
        assert!(table(&records).contains("3 files: 0 load, 2 load with warnings, 1 fail"));
    }
}
