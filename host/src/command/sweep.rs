//! `caustics sweep`: the cells of a file, measured where they are missing.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use caustics::experiment::plan::{ErrorPlan, Plan};
use caustics::experiment::reference::References;
use caustics::experiment::result::CellResult;
use caustics::experiment::store;
use caustics::experiment::sweep::config::Config;
use caustics::experiment::sweep::expand::{Expanded, Part};
use caustics::experiment::sweep::merge::merge;
use caustics::experiment::sweep::shard::Shard;
use caustics::experiment::table::cells_csv;
use caustics::file::read_text;
use caustics::output::target::{Target, remove};
use caustics::settings::Settings;

use super::bench::cache;
use super::interrupt;
use super::pick::pick;
use super::say::say;
use super::sweep_cell::{Desk, Task};
use super::sweep_group::measure_all;
use crate::cli::{Common, Sweep, Usage, runner_and_tracer};

/// Measures, or tells, or merges. 130 after Ctrl-C, with what was done written.
pub fn run(options: &Sweep) -> anyhow::Result<ExitCode> {
    let output = options.output.as_deref();
    if let (false, Some(out)) = (options.merge.is_empty(), output) {
        return join(options, out);
    }
    let file = options.experiment.as_deref().context("there is no experiment")?;
    let text = read_text(file).with_context(|| format!("cannot read {}", file.display()))?;
    let wrong = |what: String| Usage(format!("{}: {what}", file.display()));
    let config = Config::parse(&text).map_err(wrong)?;
    let environment = |name: &str| std::env::var(name).ok();
    let shard = Shard::find(options.shard.as_deref(), options.shards, &environment).map_err(Usage)?;

    let named = || file.display().to_string();
    let Expanded { parts, skipped } = expand(options, &config).with_context(named)?;
    for line in skipped {
        tell!("{line}");
    }
    for warning in parts.iter().flat_map(|part| &part.scene.warnings) {
        tell!("warning: {warning}");
    }
    let tasks: Vec<Task> = parts.iter().flat_map(|part| Task::all(&config, part)).collect();
    if tasks.is_empty() {
        return Err(wrong("no cell is left to measure".into()).into());
    }
    for task in &tasks {
        check(&config, task).map_err(wrong)?;
    }
    let mine = &tasks[shard.part(tasks.len())];
    if options.dry_run {
        return tell(options, &config, mine);
    }
    let folder = output.context("there is no folder")?;
    store::create(folder)?;
    if options.force {
        for task in mine {
            remove(&store::file(folder, &task.identity))?;
        }
    }
    // What a report names as the source of the folder's cells.
    Target::claim(&folder.join("experiment.toml"), true)?.finish(text.as_bytes())?;
    let stopped = interrupt::watch()?;
    let missing = mine.iter().filter(|task| !is_done(&config, Some(folder), task)).count();
    let of = if shard.count > 1 {
        format!(" in part {} of {}", shard.index + 1, shard.count)
    } else {
        String::new()
    };
    tell!("{} cells{of}, {missing} to measure", mine.len());
    let desk =
        Desk { config: &config, folder, cache: cache()?, stopped: &stopped, found: Default::default() };
    if !measure_all(&desk, mine)? {
        tell!("interrupted; the same command goes on");
        return Ok(ExitCode::from(130));
    }
    write_table(folder)?;
    Ok(ExitCode::SUCCESS)
}

fn expand(options: &Sweep, config: &Config) -> anyhow::Result<Expanded> {
    let mut known = BTreeMap::new();
    let mut runner = |name: &str| {
        if let Some(choice) = known.get(name) {
            return Ok(Clone::clone(choice));
        }
        let (runner, tracer) = runner_and_tracer(name, crate::cli::Tracer::Auto);
        let common =
            Common { device: options.device.clone(), threads: options.threads, ..Common::of(runner, tracer) };
        // A device belongs to the runners that have one.
        let common = if name == "cpu" { Common { device: None, ..common } } else { common };
        let (choice, _, reason) = pick(&common, None)?;
        tell!("runner {name}: {reason}");
        known.insert(name.to_string(), choice.clone());
        Ok(choice)
    };
    Expanded::new(config, &mut runner)
}

/// What no value by itself shows.
fn check(config: &Config, task: &Task) -> Result<(), String> {
    let sizes = [task.part.timed_size, config.error.as_ref().map(|error| (error.width.0, error.height.0))];
    for (width, height) in sizes.into_iter().flatten() {
        let paths = task.cell.paths.count(width, height).max(width * height);
        let rays = u64::from(paths) * u64::from(task.cell.max_bounces + 1);
        if rays > u64::from(u32::MAX) {
            let bounces = task.cell.max_bounces;
            return Err(format!(
                "{paths} light paths at {width}x{height} with max_bounces {bounces}: more than 2^32 rays a frame"
            ));
        }
    }
    Ok(())
}

/// Whether all that the file asks for was measured.
pub fn is_done(config: &Config, folder: Option<&Path>, task: &Task) -> bool {
    let result = folder.and_then(|folder| store::read(folder, &task.identity));
    let has = |result: &CellResult| {
        (config.time.is_none() || result.time.is_some()) && (config.error.is_none() || result.error.is_some())
    };
    result.as_ref().is_some_and(has)
}

/// Prints the cells and counts the references.
fn tell(options: &Sweep, config: &Config, tasks: &[Task]) -> anyhow::Result<ExitCode> {
    let mut done = 0;
    for task in tasks {
        let is_done = is_done(config, options.output.as_deref(), task) && !options.force;
        done += usize::from(is_done);
        let state = if is_done { "done   " } else { "missing" };
        say(format_args!("{state} {} {} {}", task.identity, task.part.scene.name, task.cell.name))?;
    }
    let (mut needed, mut kept) = (BTreeSet::new(), 0);
    if let Some(error) = &config.error {
        let cache = cache()?;
        let mut seen = BTreeSet::new();
        for task in tasks {
            if !seen.insert((std::ptr::from_ref(task.part), task.cell.max_bounces)) {
                continue;
            }
            let plan = error_plan(config, task.part).context("there is no table [error]")?;
            let references =
                References::new(&plan, &task.cell, &task.part.scene, error.reference_frames.0, &cache);
            for path in plan.frames.clone().map(|frame| references.path(frame)) {
                let is_kept = path.exists();
                kept += usize::from(needed.insert(path) && is_kept);
            }
        }
    }
    let (cells, references) = (tasks.len(), needed.len());
    say(format_args!("{cells} cells, {done} done; {references} references, {kept} kept"))?;
    Ok(ExitCode::SUCCESS)
}

/// The frames by which errors are measured.
pub fn error_plan(config: &Config, part: &Part) -> Option<Plan> {
    let error = config.error.as_ref()?;
    let plan = part.plan(config);
    let first = if part.scene.is_animated() { config.first_frame } else { 0 };
    let settings = Settings { width: error.width.0, height: error.height.0, ..plan.settings.clone() };
    let seeds = ErrorPlan { seeds: error.seeds.0, reference_frames: error.reference_frames.0 };
    Some(Plan { settings, frames: first..first + error.frames.0, error: Some(seeds), ..plan })
}

/// The frames by which times are measured.
pub fn time_plan(config: &Config, part: &Part) -> Option<Plan> {
    let time = config.time.as_ref()?;
    let plan = part.plan(config);
    let first = if part.scene.is_animated() { config.first_frame } else { 0 };
    let (width, height) = part.timed_size?;
    let settings = Settings { width, height, ..plan.settings.clone() };
    Some(Plan { settings, frames: first..first + time.frames.0, warm_up: time.warm_up, time: true, ..plan })
}

fn join(options: &Sweep, out: &Path) -> anyhow::Result<ExitCode> {
    let counts = merge(&options.merge, out)?;
    for (folder, joined) in options.merge.iter().zip(counts) {
        let (folder, caustics::experiment::sweep::merge::Joined { taken, equal, older }) =
            (folder.display(), joined);
        tell!("{folder}: {taken} taken, {equal} there already, {older} left out for fuller or newer ones");
    }
    write_table(out)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes `cells.csv`: all results of the folder.
fn write_table(folder: &Path) -> anyhow::Result<()> {
    let results = store::read_all(folder)?;
    Target::claim(&folder.join("cells.csv"), true)?.finish(&cells_csv(&results)?)?;
    tell!("{}: {} cells", folder.join("cells.csv").display(), results.len());
    Ok(())
}
