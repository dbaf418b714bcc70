//! Errors of a run configuration against references, which are rendered where they are missing.

use std::time::Instant;

use anyhow::Context;

use super::task::{SweepContext, Task, joined};
use crate::error::{FLIP, MEASURES, Measure, RELMSE, mean};
use crate::measure::measure;
use crate::plan::Compared;
use crate::record::FrameRecord;
use crate::reference::{Kept, References};
use crate::result::{ErrorResult, FrameResult};
use crate::run_config::RunConfig;
use crate::store::provenance;
use caustics::hash::digest;

/// Measures the errors of a run configuration, if the sweep asks for any, and writes them. Returns `false` where the run
/// was stopped.
///
/// # Errors
///
/// If a frame fails, or a file cannot be written.
pub fn measure_error(sweep: &SweepContext, task: &Task, run: &RunConfig) -> anyhow::Result<bool> {
    let plan = task.part.error_plan(sweep.config, run);
    let (Some(error), Some(plan)) = (&sweep.config.error, &plan) else { return Ok(true) };
    let scene = &task.part.scene;
    let start = Instant::now();
    let references = References::new(plan, run, scene, error.reference_frames.0, &sweep.cache);
    let compared: Vec<u32> = plan.frames.clone().filter(|frame| plan.compares(*frame)).collect();
    for (index, frame) in compared.iter().enumerate() {
        match references.keep(*frame, sweep.stopped)? {
            Kept::Stopped => return Ok(false),
            Kept::Reused => {}
            Kept::Rendered | Kept::Replaced => {
                let (count, total) = (index + 1, compared.len());
                (sweep.on_message)(&format!("{}: reference {count} of {total} rendered", scene.name));
            }
        }
    }
    // Leave the time of the references out of the configuration's.
    let referenced = start.elapsed();
    let mut records: Vec<FrameRecord> = Vec::new();
    let mut each = |new: Vec<FrameRecord>| {
        records.extend(new.into_iter().filter(|record| plan.compares(record.frame)));
        Ok(())
    };
    let runs = std::slice::from_ref(run);
    let outcomes = measure(plan, scene, runs, Some(&references), sweep.stopped, &mut each)?;
    let Some(outcome) = outcomes.and_then(|mut outcomes| outcomes.pop()) else { return Ok(false) };
    let shown = outcome.shown.context("no frame was measured")?;

    let (width, height) = (plan.config.width, plan.config.height);
    let write = |name: String, colors| sweep.results.write_png(name, width, height, colors);
    let reference_key = format!(
        "{} {} {}",
        references.folder().display(),
        compared.last().unwrap_or(&0),
        sweep.config.exposure
    );
    let identity = &task.identity;
    let off = ErrorResult {
        width,
        height,
        light_paths: mean(records.iter().map(|record: &FrameRecord| record.get("light_paths")))
            .unwrap_or_default() as u32,
        seeds: plan.seeds,
        reference_frames: error.reference_frames.0,
        image: write(format!("{identity}.png"), &shown.image)?,
        error_map: match &shown.error_map {
            Some(colors) => write(format!("{identity}-flip.png"), colors)?,
            None => None,
        },
        reference: write(format!("reference-{}.png", digest(&reference_key)), &shown.reference)?,
        ..ErrorResult::default()
    };
    let mean_of_records = |key: &str| {
        mean(records.iter().map(|record: &FrameRecord| record.get(key)).skip(skipped(key, &records)))
    };
    let mut off = MEASURES.iter().fold(off, |off, measure| off.with(measure, mean_of_records(measure.key)));
    // Take the standard error of one frame for the mean of all: frames of one seed share their history.
    let sure =
        |measure: &&Measure| Some((measure.key.to_string(), mean_of_records(&measure.standard_error_key())?));
    off.standard_errors = MEASURES.iter().filter_map(sure).collect();
    let mut result = sweep.result(task, run);
    if plan.compared != Compared::Last {
        let frame = |record: &FrameRecord| FrameResult {
            frame: record.frame,
            total_ms: None,
            values: MEASURES
                .iter()
                .map(|measure| (measure.key.to_string(), record.get(measure.key)))
                .collect(),
        };
        result.frames = joined(&result.frames, &records.iter().map(frame).collect::<Vec<_>>());
    }
    let wall_s = result.provenance.wall_s + (start.elapsed() - referenced).as_secs_f64();
    result.provenance = provenance(outcome.device, sweep.config.seed, wall_s);
    let text = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.4}"));
    let (flip, relmse) = (text(off.get(&FLIP)), text(off.get(&RELMSE)));
    (sweep.on_message)(&format!("{} {}: FLIP {flip}, relMSE {relmse}", scene.name, run.name));
    result.error = Some(off);
    sweep.results.write(&result)?;
    Ok(true)
}

/// Number of records at the start that lack the measure: the first frame has no frame before it.
fn skipped(key: &str, records: &[FrameRecord]) -> usize {
    usize::from(records.len() > 1 && records[0].get(key).is_none() && records[1].get(key).is_some())
}
