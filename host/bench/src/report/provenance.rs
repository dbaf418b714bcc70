//! Provenance of the measures: programs, devices, seeds and times of all run configurations, and the commands that repeat
//! them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use maud::{Markup, html};

use super::load::Measured;
use crate::result::Provenance;
use caustics::program::program;
use caustics::shell;
use caustics::text::printable;

/// Distinct values of each field of the provenance, with the number of run configurations that have each.
fn distinct(runs: &[Measured]) -> Vec<(&'static str, BTreeMap<String, usize>)> {
    let count = |field: fn(&Provenance) -> String| {
        let mut counts = BTreeMap::new();
        // Keep values printable: a reader may copy them from the page.
        let values = runs.iter().map(|run| printable(&field(&run.result.provenance)));
        for value in values.filter(|value| !value.is_empty()) {
            *counts.entry(value).or_insert(0) += 1;
        }
        counts
    };
    let all = [
        ("commit", count(|provenance| provenance.commit.clone())),
        ("kernels", count(|provenance| provenance.kernels.clone())),
        ("device and driver", count(|provenance| provenance.device.clone())),
        ("machine and compiler", count(|provenance| provenance.machine.clone())),
        ("first seed", count(|provenance| provenance.seed.to_string())),
    ];
    all.into_iter().filter(|(_, values)| !values.is_empty()).collect()
}

/// Duration of all measurements, and the times of the first and the last one.
fn times(runs: &[Measured]) -> (String, Option<String>) {
    let wall: f64 = runs.iter().map(|run| run.result.provenance.wall_s).filter(|wall| wall.is_finite()).sum();
    let wall = humantime::format_duration(Duration::from_secs(wall.max(0.0).round() as u64)).to_string();
    let known = || runs.iter().map(|run| run.result.provenance.unix_s).filter(|at| *at > 0);
    let day = |seconds: u64| {
        let time = SystemTime::UNIX_EPOCH.checked_add(Duration::from_secs(seconds))?;
        // Skip times after the year 9999: humantime refuses them.
        (seconds < 253_402_300_800).then(|| {
            humantime::format_rfc3339_seconds(time).to_string().replace(['T', 'Z'], " ").trim().to_string()
        })
    };
    let span = known().min().zip(known().max()).and_then(|(first, last)| {
        let (first, last) = (day(first)?, day(last)?);
        Some(if first == last { first } else { format!("{first} to {last}") })
    });
    (wall, span)
}

/// Commands that repeat the folders' measurements and this report.
pub fn commands(runs: &[Measured], folders: &[PathBuf], output: &Path) -> Vec<String> {
    let mut commits: Vec<&String> = runs.iter().map(|run| &run.result.provenance.commit).collect();
    commits.sort();
    commits.dedup();
    let mut commands = Vec::new();
    if let [commit] = commits[..]
        && let Some(hash) = shell::commit(commit.trim_end_matches("-dirty"))
    {
        commands.push(format!("git checkout {hash}"));
    }
    // Quoting fails only for a NUL, which no path has.
    for folder in folders {
        let experiment = folder.join("experiment.toml");
        if experiment.exists()
            && let (Some(experiment), Some(folder)) = (shell::path(&experiment), shell::path(folder))
        {
            commands.push(format!("caustics sweep {experiment} -o {folder}"));
        }
    }
    let folders: Vec<String> = folders.iter().filter_map(shell::path).collect();
    if let Some(output) = shell::path(output) {
        commands.push(format!("caustics report {} -o {output}", folders.join(" ")));
    }
    commands
}

/// The provenance as a block for the page.
pub fn inline(runs: &[Measured], commands: &[String]) -> Markup {
    let (wall, span) = times(runs);
    html! {
        dl .provenance {
            dt { "run configurations" } dd { (runs.len()) }
            @for (name, values) in distinct(runs) {
                dt { (name) }
                dd {
                    @for (value, count) in &values {
                        div { code { (value) } @if values.len() > 1 { " " span .dim { (count) @if *count == 1 { " configuration" } @else { " configurations" } } } }
                    }
                }
            }
            dt { "measuring took" } dd { (wall) }
            @if let Some(span) = span { dt { "measured (UTC)" } dd { (span) } }
            dt { "report made by" } dd { code { "caustics " (program().version) ", " (program().commit) } }
        }
        h3 { "To make it again" }
        pre tabindex="0" { code { (commands.join("\n")) } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::RunResult;

    fn run(commit: &str, wall_s: f64, unix_s: u64) -> Measured {
        let provenance = Provenance { commit: commit.into(), wall_s, unix_s, ..Provenance::default() };
        Measured { result: RunResult { provenance, ..RunResult::default() }, folder: "".into() }
    }

    #[test]
    fn every_value_is_counted_and_times_add_up() {
        let runs = [run("a", 60.0, 1_700_000_000), run("b", 30.4, 1_700_003_600), run("a", 0.0, 0)];
        let values = distinct(&runs);
        assert_eq!(values[0], ("commit", BTreeMap::from([("a".into(), 2), ("b".into(), 1)])));
        assert_eq!(values.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["commit", "first seed"]);
        let (wall, span) = times(&runs);
        assert_eq!(
            (wall.as_str(), span.unwrap().as_str()),
            ("1m 30s", "2023-11-14 22:13:20 to 2023-11-14 23:13:20")
        );
        assert_eq!(times(&[run("a", f64::INFINITY, u64::MAX)]).1, None);
    }

    #[test]
    fn commands_to_repeat_a_report_quote_its_paths() {
        let folders = ["my results".into(), "it's".into(), "-f".into(), "a\x03\nb".into()];
        let commands = commands(&[run("0123abc-dirty", 0.0, 0)], &folders, "r.html".as_ref());
        let report = r#"caustics report 'my results' "it's" ./-f $'a\003\012b' -o r.html"#;
        assert_eq!(commands, ["git checkout 0123abc", report]);
    }

    #[test]
    fn a_commit_that_is_no_hash_is_in_no_command() {
        for text in ["main; touch OWNED #", "--force", "0123ab", "0123abc\n", "0123abg", &"0".repeat(65), ""]
        {
            let commands = commands(&[run(text, 0.0, 0)], &["r".into()], "r.html".as_ref());
            assert_eq!(commands, ["caustics report r -o r.html"], "{text:?}");
        }
    }
}
