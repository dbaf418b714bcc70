//! A cell of a sweep: its errors and its file.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use caustics::experiment::cell::{Cell, Paths};
use caustics::experiment::reference::{Kept, References};
use caustics::experiment::result::{CellResult, CellTime, FrameResult};
use caustics::experiment::store::{self, provenance};
use caustics::experiment::sweep::accuracy::accuracy;
use caustics::experiment::sweep::config::Config;
use caustics::experiment::sweep::expand::Part;
use caustics::hash::fnv1a;
use caustics::output::png;
use caustics::output::target::Target;
use caustics::settings::Settings;
use glam::Vec3;

use super::sweep::error_plan;

/// A cell and what it is known by.
pub struct Task<'a> {
    /// Its scene.
    pub part: &'a Part,
    /// The cell.
    pub cell: Cell,
    /// Hash of all that decides its measures.
    pub identity: String,
}

/// What all cells are measured with.
pub struct Desk<'a> {
    /// The file.
    pub config: &'a Config,
    /// Where results go.
    pub folder: &'a Path,
    /// Where references are kept.
    pub cache: PathBuf,
    /// Whether Ctrl-C came.
    pub stopped: &'a dyn Fn() -> bool,
    /// Light paths that were searched for, by the cell's identity.
    pub found: RefCell<BTreeMap<String, Paths>>,
}

impl Task<'_> {
    /// Those of a part.
    pub fn all<'a>(config: &Config, part: &'a Part) -> Vec<Task<'a>> {
        let of = |cell: &Cell| Task { part, cell: cell.clone(), identity: part.identity(config, cell) };
        part.cells.iter().map(of).collect()
    }
}

impl Desk<'_> {
    /// The result that a task has; an empty one where it has none. `cell` is the task's with the light paths that were found.
    pub fn result(&self, task: &Task, cell: &Cell) -> CellResult {
        store::read(self.folder, &task.identity).unwrap_or_else(|| {
            let of_error = self.config.error.as_ref().map(|error| (error.width.0, error.height.0));
            let (width, height) = task.part.timed_size.or(of_error).unwrap_or((1, 1));
            let settings = Settings { width, height, ..task.part.plan(self.config).settings };
            CellResult {
                identity: task.identity.clone(),
                cell: cell.config(&task.part.scene, &task.part.camera, &settings),
                ..CellResult::default()
            }
        })
    }

    /// Writes times into the file of a cell.
    pub fn write_time(
        &self,
        task: &Task,
        cell: &Cell,
        time: CellTime,
        frames: Vec<FrameResult>,
        device: String,
        note: Option<String>,
    ) -> anyhow::Result<()> {
        let mut result = self.result(task, cell);
        let wall_s = result.provenance.wall_s + time.total_ms.median * f64::from(time.frames) / 1e3;
        result.time = Some(time);
        result.frames = joined(&result.frames, &frames);
        result.note = note;
        result.provenance = provenance(device, self.config.seed, wall_s);
        store::write(self.folder, &result)
    }

    /// Measures the errors of a cell and writes them into its file. False where it was stopped.
    pub fn measure_error(&self, task: &Task, cell: &Cell) -> anyhow::Result<bool> {
        let Some(error) = &self.config.error else { return Ok(true) };
        let plan = error_plan(self.config, task.part).context("there is no table [error]")?;
        let scene = &task.part.scene;
        let start = Instant::now();
        let references = References::new(&plan, cell, scene, error.reference_frames.0, &self.cache);
        let frames = if scene.is_animated() { plan.frames.clone() } else { 0..1 };
        for frame in frames.clone() {
            let kept = references.keep(frame, self.stopped)?;
            match kept {
                Kept::Stopped => return Ok(false),
                Kept::Reused => {}
                Kept::Rendered | Kept::Replaced => {
                    let count = frame - frames.start + 1;
                    tell!("{}: reference {count} of {} rendered", scene.name, frames.len());
                }
            }
        }
        // The time of references is not the cell's.
        let referenced = start.elapsed();
        let measured = accuracy(&plan, scene, cell, &references, error.reference_frames.0, self.stopped)?;
        let Some(measured) = measured else { return Ok(false) };
        let mut result = self.result(task, cell);
        let (width, height) = (error.width.0, error.height.0);
        let write = |name: String, colors: &[Vec3]| -> anyhow::Result<String> {
            let bytes = png::encode(width, height, colors)?;
            Target::claim(&store::cells(self.folder).join(&name), true)?.finish(&bytes)?;
            Ok(name)
        };
        let last = if scene.is_animated() { plan.frames.end - 1 } else { 0 };
        let truth = format!("{} {last} {}", references.folder().display(), self.config.exposure);
        let mut off = measured.error;
        off.picture = Some(write(format!("{}.png", task.identity), &measured.picture)?);
        off.error_map = measured
            .error_map
            .map(|colors| write(format!("{}-flip.png", task.identity), &colors))
            .transpose()?;
        off.reference = Some(write(format!("reference-{}.png", fnv1a(truth.bytes())), &measured.reference)?);
        result.frames = joined(&result.frames, &measured.frames);
        let wall_s = result.provenance.wall_s + (start.elapsed() - referenced).as_secs_f64();
        result.provenance = provenance(measured.device, self.config.seed, wall_s);
        let text = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.4}"));
        tell!("{} {}: FLIP {}, relMSE {}", scene.name, cell.name, text(off.flip), text(off.relmse));
        result.error = Some(off);
        store::write(self.folder, &result)?;
        Ok(true)
    }
}

/// Frames of both, each with what either knows.
fn joined(a: &[FrameResult], b: &[FrameResult]) -> Vec<FrameResult> {
    let mut all: BTreeMap<u32, FrameResult> = BTreeMap::new();
    for of in a.iter().chain(b) {
        let frame =
            all.entry(of.frame).or_insert_with(|| FrameResult { frame: of.frame, ..Default::default() });
        frame.total_ms = of.total_ms.or(frame.total_ms);
        frame.flip = of.flip.or(frame.flip);
        frame.flip_caustics = of.flip_caustics.or(frame.flip_caustics);
    }
    all.into_values().collect()
}
