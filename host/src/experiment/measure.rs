//! Renders the frames of all cells, frame by frame, and measures each.
//!
//! Within a frame the cells take turns, and the order of the turns rotates from frame to frame, so that what disturbs the
//! machine for a while hits all alike. A cell has a session for each seed; the first one's time counts.

use std::time::Instant;

use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::point::PointGeometry;
use glam::Vec3;

use super::cell::Cell;
use super::error::{Errors, Look};
use super::gain::mean_variance;
use super::identity;
use super::plan::Plan;
use super::reference::{References, camera};
use super::row::Row;
use crate::picture::Picture;
use crate::scene::Scene;
use crate::session::Session;
use crate::settings::Settings;

/// A cell under way.
struct Run {
    cell: Cell,
    identity: String,
    sessions: Vec<Session>,
    /// The frame before, of each seed.
    before: Vec<Look>,
}

/// The reference of a frame.
struct Truth {
    picture: Picture,
    look: Look,
    /// What changed since the reference before: whole and caustics.
    change: Option<(Option<f64>, Option<f64>)>,
}

impl Truth {
    fn new(picture: Picture, before: Option<&Look>, exposure: f32) -> Truth {
        let look = Look::new(&picture, &picture);
        let change = before.map(|before| look.change(before, f64::from(exposure)));
        Truth { picture, look, change }
    }
}

/// Measures every frame of some cells and hands the rows of each frame to `each`. The devices of the cells; none where it
/// was stopped.
pub fn measure(
    plan: &Plan,
    scene: &Scene,
    cells: &[Cell],
    references: Option<&References>,
    stopped: &dyn Fn() -> bool,
    each: &mut dyn FnMut(Vec<Row>) -> anyhow::Result<()>,
) -> anyhow::Result<Option<Vec<String>>> {
    let mut scene = identity::posed(scene, plan.time_of(plan.frames.start))?;
    let mut runs: Vec<Run> = cells.iter().map(|cell| open(plan, &scene, cell)).collect::<Result<_, _>>()?;
    for _ in 0..plan.warm_up {
        scene.pose(plan.time_of(plan.frames.start))?;
        for session in runs.iter_mut().flat_map(|run| &mut run.sessions) {
            session.pose(&scene, camera(&scene, &plan.camera)?)?;
            session.frame(plan.frames.start)?;
        }
    }
    let mut truth_before = None;
    for (count, frame) in plan.frames.clone().enumerate() {
        if stopped() {
            return Ok(None);
        }
        let start = Instant::now();
        scene.pose(plan.time_of(frame))?;
        let animate_ms = ms(start);
        let mut rows = vec![Row::default(); runs.len()];
        for turn in 0..runs.len() {
            let index = (turn + count) % runs.len();
            let run = &mut runs[index];
            rows[index] = Row {
                frame,
                time: plan.time_of(frame),
                cell: run.cell.name.clone(),
                identity: run.identity.clone(),
                values: [("turn".to_string(), turn as f64)].into(),
            };
            render(plan, &scene, run, &mut rows[index], animate_ms)?;
        }
        if let Some(references) = references {
            let truth = Truth::new(references.load(frame)?, truth_before.as_ref(), plan.settings.exposure);
            for (run, row) in runs.iter_mut().zip(&mut rows) {
                errors(plan, &scene, run, row, &truth)?;
            }
            truth_before = Some(truth.look);
        }
        each(rows)?;
    }
    let device = |run: &Run| run.sessions.first().map(Session::device).unwrap_or_default();
    Ok(Some(runs.iter().map(device).collect()))
}

fn open(plan: &Plan, scene: &Scene, cell: &Cell) -> anyhow::Result<Run> {
    let camera = camera(scene, &plan.camera)?;
    let features = cell.features(scene, plan.settings.specular_roughness);
    let session = |seed| {
        let settings = Settings { seed: plan.settings.seed + seed, ..cell.settings(&plan.settings) };
        Session::new(&cell.runner, scene, camera, &settings, cell.method, cell.variant(), features)
    };
    let sessions: Vec<Session> = (0..plan.seeds()).map(session).collect::<Result<_, _>>()?;
    let identity = identity::of_cell(plan, cell, scene);
    Ok(Run { cell: cell.clone(), identity, sessions, before: Vec::new() })
}

/// Renders the frame with the first seed: times and counters.
fn render(plan: &Plan, scene: &Scene, run: &mut Run, row: &mut Row, animate_ms: f64) -> anyhow::Result<()> {
    let Some(session) = run.sessions.first_mut() else { return Ok(()) };
    let start = Instant::now();
    session.pose(scene, camera(scene, &plan.camera)?)?;
    let pose_ms = ms(start);
    let start = Instant::now();
    let times = session.frame(row.frame)?;
    let frame_ms = ms(start);
    if plan.time {
        row.set("animate_ms", Some(animate_ms));
        row.set("pose_ms", Some(pose_ms));
        row.set("total_ms", Some(animate_ms + pose_ms + frame_ms));
        for step in times {
            *row.values.entry(format!("pass.{}_ms", step.pass)).or_default() += 1e3 * step.time.as_secs_f64();
        }
    }
    let counters = session.counters()?;
    let faults = [Counter::DepositsDropped, Counter::Clamped, Counter::NonFinite, Counter::MediaOverflow];
    row.set("faults", Some(faults.map(|fault| counters.get(fault) as f64).iter().sum()));
    for (name, counter) in [
        ("camera_rays", Counter::CameraRays),
        ("shadow_rays", Counter::ShadowRays),
        ("light_rays", Counter::LightRays),
        ("light_paths", Counter::LightPaths),
        ("deposits", Counter::Deposits),
        ("gathered", Counter::Gathered),
    ] {
        row.set(name, Some(counters.get(counter) as f64));
    }
    // Read once: it takes time between the turns.
    if plan.time && row.frame + 1 == plan.frames.end && run.cell.method.gathers {
        let points: Vec<PointGeometry> = session.read("point_geometry")?;
        row.set("points", Some(points.iter().filter(|point| point.radius > 0.0).count() as f64));
    }
    Ok(())
}

/// Renders the frame with the other seeds, and measures errors: means over the seeds.
fn errors(plan: &Plan, scene: &Scene, run: &mut Run, row: &mut Row, truth: &Truth) -> anyhow::Result<()> {
    for session in &mut run.sessions[1..] {
        session.pose(scene, camera(scene, &plan.camera)?)?;
        session.frame(row.frame)?;
    }
    let pictures: Vec<Picture> = run.sessions.iter_mut().map(Session::picture).collect::<Result<_, _>>()?;
    let looks: Vec<Look> = pictures.iter().map(|picture| Look::new(picture, &truth.picture)).collect();
    let exposure = f64::from(plan.settings.exposure);
    let errors: Vec<Errors> = looks.iter().map(|look| look.errors(&truth.look, exposure)).collect();
    row.set("flip", mean(errors.iter().map(|of| of.flip)));
    row.set("flip_caustics", mean(errors.iter().map(|of| of.flip_caustics)));
    row.set("relmse", mean(errors.iter().map(|of| of.relmse)));
    row.set("relmse_caustics", mean(errors.iter().map(|of| of.relmse_caustics)));
    if let Some((whole, caustics)) = truth.change {
        let changes: Vec<_> =
            looks.iter().zip(&run.before).map(|(now, before)| now.change(before, exposure)).collect();
        let beyond = |change: Option<f64>, truth: Option<f64>| Some(change? - truth?);
        row.set("flicker", beyond(mean(changes.iter().map(|of| of.0)), whole));
        row.set("flicker_caustics", beyond(mean(changes.iter().map(|of| of.1)), caustics));
    }
    let layers: Vec<&[Vec3]> = pictures.iter().map(|picture| picture.caustics.as_slice()).collect();
    row.set("caustics_variance_radiance2", mean_variance(&layers));
    run.before = looks;
    Ok(())
}

/// The mean of values that are all there.
fn mean(values: impl ExactSizeIterator<Item = Option<f64>>) -> Option<f64> {
    let count = values.len() as f64;
    values.sum::<Option<f64>>().map(|sum| sum / count).filter(|mean| mean.is_finite())
}

fn ms(start: Instant) -> f64 {
    1e3 * start.elapsed().as_secs_f64()
}
