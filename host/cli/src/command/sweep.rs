//! `caustics sweep`: measures the missing run configurations of a file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use caustics::file::read_text;
use caustics::output::target::{Target, TargetError, remove};
use caustics::scene::{self, EnvironmentMap};
use caustics_bench::reference::References;
use caustics_bench::store::{self, Results};
use caustics_bench::sweep::config::SweepConfig;
use caustics_bench::sweep::expand::Expanded;
use caustics_bench::sweep::merge::{Joined, merge};
use caustics_bench::sweep::task::{SweepContext, Task};
use caustics_bench::table::{frames_csv, passes_csv, runs_csv};

use super::console::print;
use super::interrupt;
use super::options::{check_rays, check_scene_files};
use super::pick::pick;
use crate::cli::{self, Machine, Tracer, Usage};

/// Measures, lists or merges. Returns exit code 130 after Ctrl-C; finished results are written.
pub fn run(options: &cli::SweepOptions) -> anyhow::Result<ExitCode> {
    let output = options.output.as_deref();
    if let (false, Some(out)) = (options.merge.is_empty(), output) {
        return join(options, out);
    }
    let file = options.experiment.as_deref().context("there is no experiment")?;
    let text = read_text(file).with_context(|| format!("cannot read {}", file.display()))?;
    let wrong = |what: String| Usage(format!("{}: {what}", file.display()));
    let config = SweepConfig::parse(&text).map_err(wrong)?;
    output.map_or(Ok(()), |folder| check_tables(folder, &config, &[file]))?;
    let shard = options.sharding.found()?;
    let machine = Machine {
        tracer: Tracer::Auto,
        device: options.device.clone(),
        threads: options.threads,
        debug: None,
        kernels: None,
    };
    let expanded = expand(&config, &machine).with_context(|| file.display().to_string())?;
    let tasks = tasks(&config, &expanded).map_err(|error| wrong(error.0))?;
    let mine = &tasks[shard.part(tasks.len())];
    if options.dry_run {
        return dry_run(options, &config, mine);
    }
    let folder = output.context("there is no folder")?;
    store::create(folder)?;
    if options.force {
        forget(folder, mine)?;
    }
    // A report names this file as the source of the folder's results.
    Target::claim(&folder.join("experiment.toml"), true)?.finish(text.as_bytes())?;
    let part_note = if shard.is_part() {
        format!(" in part {} of {}", shard.index + 1, shard.count)
    } else {
        String::new()
    };
    let results = Results::new(Some(folder))?;
    if !measure(&config, mine, &results, &part_note)? {
        return Ok(ExitCode::from(130));
    }
    write_tables(folder)?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the run configurations of a sweep with their runners. Prints those left out, and the scenes' warnings.
pub fn expand(config: &SweepConfig, machine: &Machine) -> anyhow::Result<Expanded> {
    let mut known = BTreeMap::new();
    let mut runner = |name: &str| {
        if let Some(choice) = known.get(name) {
            return Ok(Clone::clone(choice));
        }
        // Device, tracer and validation layer do not apply to the CPU.
        let of_cpu = Machine { tracer: Tracer::Auto, device: None, debug: None, ..machine.clone() };
        let (choice, _, reason) = pick(name, if name == "cpu" { &of_cpu } else { machine }, None)?;
        message!("runner {name}: {reason}");
        known.insert(name.to_string(), choice.clone());
        Ok(choice)
    };
    let expanded = Expanded::new(config, &mut runner)?;
    for line in &expanded.skipped {
        message!("{line}");
    }
    // A scene has a part for each of its sizes.
    let notes: BTreeSet<&String> = expanded.parts.iter().flat_map(|part| &part.notes).collect();
    for note in notes {
        message!("{note}");
    }
    for warning in expanded.parts.iter().flat_map(|part| &part.scene.warnings) {
        message!("warning: {warning}");
    }
    Ok(expanded)
}

/// Returns all run configurations, after checks across settings.
pub fn tasks<'a>(config: &SweepConfig, expanded: &'a Expanded) -> Result<Vec<Task<'a>>, Usage> {
    let tasks: Vec<Task> = expanded.parts.iter().flat_map(|part| Task::all(config, part)).collect();
    if tasks.is_empty() {
        let why = expanded.skipped.join("; ");
        return Err(Usage(format!("no run configuration is left to measure: {why}")));
    }
    for task in &tasks {
        let sizes =
            [task.part.timed_size, config.error.as_ref().map(|error| (error.width.0, error.height.0))];
        for (width, height) in sizes.into_iter().flatten() {
            check_rays(&task.run.config, width, height)?;
        }
    }
    Ok(tasks)
}

/// Measures what the tasks lack. Returns `false` after Ctrl-C.
pub fn measure(
    config: &SweepConfig,
    tasks: &[Task],
    results: &Results,
    part_note: &str,
) -> anyhow::Result<bool> {
    let stopped = interrupt::watch()?;
    let missing = tasks.iter().filter(|task| !task.is_done(config, results)).count();
    message!("{} run configurations{part_note}, {missing} to measure", tasks.len());
    let cache = if config.error.is_some() { cache()? } else { PathBuf::new() };
    let message = |line: &str| message!("{line}");
    let sweep = SweepContext {
        config,
        results,
        cache,
        stopped: &stopped,
        on_message: &message,
        found: Default::default(),
    };
    let is_done = sweep.measure_all(tasks)?;
    if !is_done {
        message!("interrupted; the same command resumes");
    }
    Ok(is_done)
}

/// Removes the results of tasks.
pub fn forget(folder: &Path, tasks: &[Task]) -> Result<(), TargetError> {
    tasks.iter().try_for_each(|task| remove(&store::file(folder, &task.identity)))
}

/// Folder of the references.
fn cache() -> Result<PathBuf, Usage> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("CAUSTICS_CACHE")
        .or_else(|| Some(set("HOME")?.join(".cache/caustics")))
        .ok_or_else(|| Usage("references need a folder: set the environment variable CAUSTICS_CACHE".into()))
}

/// Prints the run configurations and the number of references.
fn dry_run(options: &cli::SweepOptions, config: &SweepConfig, tasks: &[Task]) -> anyhow::Result<ExitCode> {
    let known = |task: &Task| store::read(options.output.as_deref()?, &task.identity);
    let mut done = 0;
    for task in tasks {
        let is_done = known(task).is_some_and(|result| task.is_whole(config, &result)) && !options.force;
        done += usize::from(is_done);
        let state = if is_done { "done   " } else { "missing" };
        print(format_args!("{state} {} {} {}", task.identity, task.part.scene.name, task.run.name))?;
    }
    let (mut needed, mut kept) = (BTreeSet::new(), 0);
    if let Some(error) = &config.error {
        let cache = cache()?;
        let mut seen = BTreeSet::new();
        for task in tasks {
            if !seen.insert((std::ptr::from_ref(task.part), task.run.config.max_bounces)) {
                continue;
            }
            let plan = task.part.error_plan(config, &task.run).context("there is no table [error]")?;
            let references =
                References::new(&plan, &task.run, &task.part.scene, error.reference_frames.0, &cache);
            for frame in plan.frames.clone().filter(|frame| plan.compares(*frame)) {
                let path = references.path(frame);
                let is_kept = path.exists();
                kept += usize::from(needed.insert(path) && is_kept);
            }
        }
    }
    let (runs, references) = (tasks.len(), needed.len());
    print(format_args!("{runs} run configurations, {done} done; {references} references, {kept} kept"))?;
    Ok(ExitCode::SUCCESS)
}

fn join(options: &cli::SweepOptions, out: &Path) -> anyhow::Result<ExitCode> {
    let counts = merge(&options.merge, out)?;
    for (folder, joined) in options.merge.iter().zip(counts) {
        let (folder, Joined { taken, equal, older }) = (folder.display(), joined);
        message!("{folder}: {taken} taken, {equal} there already, {older} left out for fuller or newer ones");
    }
    write_tables(out)?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses tables of a folder that would overwrite an input.
pub fn check_tables(folder: &Path, config: &SweepConfig, others: &[&Path]) -> Result<(), Usage> {
    let scenes = config.matrix.iter().flat_map(|matrix| &matrix.get_ref().scene);
    let scenes: BTreeSet<PathBuf> = scenes.filter_map(|name| scene::resolve(name).ok()).collect();
    let mut read: Vec<PathBuf> = scenes.iter().flat_map(|scene| scene::files(scene)).collect();
    let environment = config.environment.as_ref().and_then(|table| EnvironmentMap::file(&table.source));
    read.extend(environment.into_iter().chain(others.iter().copied()).map(Path::to_path_buf));
    let tables = ["cells.csv", "passes.csv", "frames.csv"].map(|name| folder.join(name));
    tables.iter().try_for_each(|table| check_scene_files(&read, "-o", table))
}

/// Writes all results of the folder to `cells.csv`, `passes.csv` and, where scenes move, `frames.csv`.
pub fn write_tables(folder: &Path) -> anyhow::Result<()> {
    let results = store::read_all(folder)?;
    let write = |name: &str, table: Vec<u8>| Target::claim(&folder.join(name), true)?.finish(&table);
    write("cells.csv", runs_csv(&results)?)?;
    write("passes.csv", passes_csv(&results)?)?;
    if let Some(frames) = frames_csv(&results)? {
        write("frames.csv", frames)?;
    }
    message!("{}: {} run configurations", folder.join("cells.csv").display(), results.len());
    Ok(())
}
