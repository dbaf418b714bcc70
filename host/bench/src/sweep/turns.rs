//! Turns: run configurations of one scene and runner take turns while they are timed, then each is compared with the
//! reference.

use anyhow::Context;

use super::equal_time::{EqualTimeResult, TOLERANCE, held, is_met, search};
use super::errors::measure_error;
use super::task::{SweepContext, Task, joined};
use crate::cost::costs;
use crate::identity::posed;
use crate::measure::measure;
use crate::memory::memory;
use crate::parameter::PATHS_PER_PIXEL;
use crate::plan::MeasurementPlan;
use crate::record::FrameRecord;
use crate::result::{FrameResult, TimeResult};
use crate::run_config::RunConfig;
use crate::store::provenance;
use crate::timing::{quartiles, time_result};
use caustics::render_config::Paths;
use caustics::scene::Scene;
use caustics::trace_rate::closest_hits_per_second;

/// Maximum number of run configurations that take turns, besides the group's first one. An interruption loses their
/// measurements.
const MAX_TURNS: usize = 8;
/// Maximum memory of all configurations that take turns (bytes).
const MAX_MEMORY: usize = 6 << 30;
/// Number of frames of a trial.
const TRIAL_FRAMES: u32 = 5;
/// Maximum number of rounds in which light paths are corrected: beside others, a configuration is slower than by itself.
const MAX_CORRECTIONS: u32 = 6;
/// Maximum number of light paths a pixel to try.
const MAX_PER_PIXEL: u64 = 4096;

/// A run configuration whose light paths are known.
struct Ready<'a> {
    task: &'a Task<'a>,
    run: RunConfig,
}

impl SweepContext<'_> {
    /// Measures the missing tasks. Returns `false` where the run was stopped.
    ///
    /// # Errors
    ///
    /// If a frame fails, or a file cannot be written.
    pub fn measure_all(&self, tasks: &[Task]) -> anyhow::Result<bool> {
        let missing: Vec<&Task> =
            tasks.iter().filter(|task| !task.is_done(self.config, self.results)).collect();
        let is_one = |a: &&Task, b: &&Task| std::ptr::eq(a.part, b.part) && a.run.runner == b.run.runner;
        for group in missing.chunk_by(is_one) {
            if !measure_group(self, group)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Measures everything that is missing of tasks of one scene and runner. Returns `false` where the run was stopped.
fn measure_group(sweep: &SweepContext, group: &[&Task]) -> anyhow::Result<bool> {
    let has_time = |task: &Task| {
        sweep.config.time.is_none()
            || sweep.results.read(&task.identity).is_some_and(|result| result.time.is_some())
    };
    let (timed, untimed): (Vec<&Task>, Vec<&Task>) = group.iter().partition(|task| has_time(task));
    // Measure the errors of tasks whose times are known.
    for task in timed {
        let Some(ready) = find_paths(sweep, task)? else { return Ok(false) };
        if !measure_error(sweep, task, &ready.run)? {
            return Ok(false);
        }
    }
    let Some(plan) = untimed.first().and_then(|task| task.part.time_plan(sweep.config)) else {
        return Ok(true);
    };
    let mut rest = &untimed[..];
    while let Some(task) = rest.first() {
        let part = task.part;
        // Give the first configuration of the scene on this runner a turn too: ratios refer to it, whichever process
        // measures it.
        let first = part.runs.iter().find(|run| run.runner == task.run.runner).unwrap_or(&task.run);
        let first = Task::new(sweep.config, part, first);
        let Some(first) = find_paths(sweep, &first)? else { return Ok(false) };
        let scene = posed(&part.scene, plan.time_of(plan.frames.start))?;
        let tables: usize = scene.buffers().iter().map(|(_, bytes)| bytes.len()).sum();
        let size =
            |run: &RunConfig| tables + memory(&plan, run, &scene).map_or(0, |memory| memory.total_bytes);
        let (mut turns, mut bytes) = (Vec::new(), size(&first.run));
        while let Some(task) = rest.first() {
            let Some(ready) = find_paths(sweep, task)? else { return Ok(false) };
            bytes += size(&ready.run);
            if !turns.is_empty() && (turns.len() == MAX_TURNS || bytes > MAX_MEMORY) {
                break;
            }
            turns.push(ready);
            rest = &rest[1..];
        }
        let tasks: Vec<&Task> = turns.iter().map(|ready| ready.task).collect();
        if !take_turns(sweep, &plan, &first, turns, MAX_CORRECTIONS)? {
            return Ok(false);
        }
        for task in tasks {
            let Some(ready) = find_paths(sweep, task)? else { return Ok(false) };
            if !measure_error(sweep, task, &ready.run)? {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// A run configuration that was timed.
struct Timed<'a> {
    ready: Ready<'a>,
    time: TimeResult,
    frames: Vec<FrameResult>,
    device: String,
}

/// Times run configurations and writes their results. Configurations with a target time take their turns again, with
/// corrected light paths, while one of them misses it.
fn take_turns<'a>(
    sweep: &SweepContext,
    plan: &MeasurementPlan,
    first: &Ready,
    turns: Vec<Ready<'a>>,
    corrections: u32,
) -> anyhow::Result<bool> {
    let Some(part) = turns.first().map(|ready| ready.task.part) else { return Ok(true) };
    let mut runs = vec![first.run.clone()];
    runs.extend(turns.iter().map(|ready| ready.run.clone()).filter(|run| run.name != first.run.name));
    (sweep.on_message)(&format!(
        "{}: {} run configurations take turns for {} frames",
        part.scene.name,
        runs.len(),
        plan.frames.len()
    ));
    let mut records: Vec<FrameRecord> = Vec::new();
    let mut each = |new| {
        records.extend(new);
        Ok(())
    };
    let outcomes = measure(plan, &part.scene, &runs, None, sweep.stopped, &mut each)?;
    let Some(outcomes) = outcomes else { return Ok(false) };
    let scene = posed(&part.scene, plan.time_of(plan.frames.start))?;
    let has_rate = sweep.config.time.as_ref().is_some_and(|time| time.tracer_rate);
    let hits_per_s = if has_rate { Some(tracer_rate(plan, &scene, &first.run)?) } else { None };
    let time = |run: &RunConfig| -> anyhow::Result<TimeResult> {
        let time = time_result(plan, &scene, run, &first.run, &records).context("no frame was timed")?;
        let own: Vec<&FrameRecord> = records.iter().filter(|record| record.run == run.name).collect();
        let costs = hits_per_s.and_then(|rate| costs(plan, &scene, run, &own, rate)).unwrap_or_default();
        Ok(TimeResult { costs, ..time })
    };
    let first_ms = time(&first.run)?.total_ms.median;
    let timed = |ready: Ready<'a>| -> anyhow::Result<Timed<'a>> {
        let run = &ready.run;
        let own: Vec<&FrameRecord> = records.iter().filter(|record| record.run == run.name).collect();
        let faults: f64 = own.iter().filter_map(|record| record.get("faults")).sum();
        if faults > 0.0 {
            (sweep.on_message)(&format!(
                "warning: {}: {faults} photons, addends or media were dropped or clamped",
                run.name
            ));
        }
        let of_frame = |record: &&FrameRecord| FrameResult {
            frame: record.frame,
            total_ms: record.get("total_ms"),
            ..FrameResult::default()
        };
        let frames = if part.moves(sweep.config) { own.iter().map(of_frame).collect() } else { Vec::new() };
        let index = runs.iter().position(|known| known.name == run.name);
        let outcome = index.and_then(|index| outcomes.get(index));
        let device = outcome.map(|outcome| outcome.device.clone()).unwrap_or_default();
        Ok(Timed { time: time(run)?, frames, device, ready })
    };
    let timed: Vec<Timed> = turns.into_iter().map(timed).collect::<anyhow::Result<_>>()?;

    let (shared, fixed): (Vec<Timed>, Vec<Timed>) = timed
        .into_iter()
        .partition(|timed| matches!(timed.ready.task.run.config.light_paths, Paths::Time(_)));
    for timed in fixed {
        write(sweep, timed, None)?;
    }
    let misses: Vec<Option<Miss>> = shared.iter().map(|timed| miss(plan, timed, first, first_ms)).collect();
    let can_correct = misses.iter().flatten().any(|miss| miss.next.is_some());
    if corrections == 0 || !can_correct {
        for (timed, miss) in shared.into_iter().zip(misses) {
            write(sweep, timed, miss.map(|miss| miss.note))?;
        }
        return Ok(true);
    }
    let mut again = Vec::new();
    for (Timed { ready, time, .. }, miss) in shared.into_iter().zip(misses) {
        let mut run = ready.run;
        if let Some(next) = miss.and_then(|miss| miss.next) {
            let ms = time.total_ms.median;
            (sweep.on_message)(&format!(
                "{} {}: {ms:.2} ms beside others; {next} light paths next",
                scene.name, run.name
            ));
            let pixels = f64::from(time.width) * f64::from(time.height);
            run.config.light_paths = Paths::PerPixel(f64::from(next) / pixels);
        }
        again.push(Ready { task: ready.task, run });
    }
    let is_first = |ready: &&Ready| ready.run.name == first.run.name;
    let run = again.iter().find(is_first).unwrap_or(first).run.clone();
    take_turns(sweep, plan, &Ready { task: first.task, run }, again, corrections - 1)
}

fn write(sweep: &SweepContext, timed: Timed, note: Option<String>) -> anyhow::Result<()> {
    let Timed { ready: Ready { task, run }, time, frames, device } = timed;
    (sweep.on_message)(&format!("{} {}: {:.2} ms", task.part.scene.name, run.name, time.total_ms.median));
    let mut result = sweep.result(task, &run);
    let wall_s = result.provenance.wall_s + time.total_ms.median * f64::from(time.frames) / 1e3;
    result.time = Some(time);
    result.frames = joined(&result.frames, &frames);
    result.note = note;
    result.provenance = provenance(device, sweep.config.seed, wall_s);
    sweep.results.write(&result)
}

/// Rate of the tracer alone on the runner of a run configuration (closest hits a second).
fn tracer_rate(plan: &MeasurementPlan, scene: &Scene, run: &RunConfig) -> anyhow::Result<f64> {
    let features = run.config.features.features(scene, plan.config.specular_roughness);
    Ok(closest_hits_per_second(&run.runner, scene, scene.camera(Some(&plan.camera))?, features)?)
}

/// A target time that was not met.
struct Miss {
    /// Light paths that may meet it.
    next: Option<u32>,
    /// Note for the result if the time stays unmet.
    note: String,
}

/// Returns the miss of a run configuration; none where it meets its target time.
fn miss(plan: &MeasurementPlan, timed: &Timed, first: &Ready, first_ms: f64) -> Option<Miss> {
    let Timed { ready: Ready { task, run }, time, .. } = timed;
    let Paths::Time(target) = task.run.config.light_paths else { return None };
    let shared =
        time.ratio_to_first.filter(|_| first.task.run.config.light_paths == task.run.config.light_paths);
    let (own, goal) = held(time.total_ms.median, shared.map(|ratio| (ratio, first_ms)), target);
    if is_met(own, goal) {
        return None;
    }
    // Convert the missing time to light paths by their rate.
    let rate = time.light_paths_per_s.unwrap_or(0.0);
    let paths = f64::from(time.light_paths) + (goal - own) * rate / 1e3;
    let paths = paths.round().clamp(1.0, f64::from(max_paths(plan, run)));
    let why = if paths <= 1.0 { "; all other work takes longer" } else { "" };
    let note = format!(
        "equal_time_ms = {target}: not met within {} %; {} light paths take {own:.3} ms{why}",
        100.0 * TOLERANCE,
        time.light_paths
    );
    let is_new = rate > 0.0 && paths != f64::from(time.light_paths);
    Some(Miss { next: is_new.then_some(paths as u32), note })
}

/// Maximum number of light paths of a frame to try: the kernels count rays in 32 bits.
fn max_paths(plan: &MeasurementPlan, run: &RunConfig) -> u32 {
    let pixels = u64::from(plan.config.width) * u64::from(plan.config.height);
    u64::from(u32::MAX / (run.config.max_bounces + 1)).min(pixels * MAX_PER_PIXEL) as u32
}

/// Returns the run configuration of a task with its light paths. Searches them once where a time is given. None where the
/// run was stopped.
fn find_paths<'a>(sweep: &SweepContext, task: &'a Task<'a>) -> anyhow::Result<Option<Ready<'a>>> {
    let Paths::Time(target) = task.run.config.light_paths else {
        return Ok(Some(Ready { task, run: task.run.clone() }));
    };
    let with = |paths| task.run.clone().with(|config| config.light_paths = paths);
    if let Some(known) = sweep.results.read(&task.identity).filter(|known| known.time.is_some()) {
        return Ok(Some(Ready { task, run: with(Paths::PerPixel(known.config.number(&PATHS_PER_PIXEL))) }));
    }
    if let Some(paths) = sweep.found.borrow().get(&task.identity) {
        return Ok(Some(Ready { task, run: with(*paths) }));
    }
    let plan = task.part.time_plan(sweep.config).context("there is no table [time]")?;
    let (start, count) = (plan.frames.start, plan.frames.len() as u32);
    let frames = start..start + count.min(TRIAL_FRAMES);
    let mut trial = |paths: u32| -> anyhow::Result<f64> {
        let run = with(Paths::Count(paths));
        let plan = MeasurementPlan { frames: frames.clone(), warm_up: 1, ..plan.clone() };
        let mut totals = Vec::new();
        let mut each = |records: Vec<FrameRecord>| {
            totals.extend(records.iter().filter_map(|record| record.get("total_ms")));
            Ok(())
        };
        let scene = &task.part.scene;
        measure(&plan, scene, &[run], None, sweep.stopped, &mut each)?.context("interrupted")?;
        let median = quartiles(&totals).context("no frame was timed")?.median;
        (sweep.on_message)(&format!(
            "{} {}: {paths} light paths take {median:.2} ms of {target}",
            scene.name, task.run.name
        ));
        Ok(median)
    };
    let pixels = u64::from(plan.config.width) * u64::from(plan.config.height);
    let found = search(target, pixels as u32, max_paths(&plan, &task.run), &mut trial);
    if (sweep.stopped)() {
        return Ok(None);
    }
    let found: EqualTimeResult = found?;
    let paths = Paths::PerPixel(f64::from(found.paths) / pixels as f64);
    sweep.found.borrow_mut().insert(task.identity.clone(), paths);
    Ok(Some(Ready { task, run: with(paths) }))
}
