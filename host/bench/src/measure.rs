//! Renders the frames of all cells, frame by frame, and measures each.
//!
//! Within a frame the cells take turns, and the order of the turns rotates from frame to frame, so that what disturbs the
//! machine for a while hits all alike. A cell has a session for each seed; the first one's time counts. Where there are
//! references, all seeds render every frame, and the frames that the plan compares are measured.

use std::time::Instant;

use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::point::PointGeometry;
use glam::Vec3;

use super::cell::Cell;
use super::error::{MEASURES, MeasuredImage, Seen};
use super::identity;
use super::plan::MeasurementPlan;
use super::record::FrameRecord;
use super::reference::References;
use caustics::metric::error_map::ErrorMap;
use caustics::render_config::RenderConfig;
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::Session;

/// A cell under way.
struct Run {
    cell: Cell,
    sessions: Vec<Session>,
    /// The frame before, of each seed.
    before: Vec<MeasuredImage>,
    shown: Option<ComparedFrame>,
}

/// The reference of a frame.
struct MeasuredReference {
    image: RenderedImage,
    measured: MeasuredImage,
}

/// The last frame of a cell that was compared with a reference: display colours, the first seed's.
#[derive(Clone, Debug)]
pub struct ComparedFrame {
    /// The image.
    pub image: Vec<Vec3>,
    /// Its reference.
    pub reference: Vec<Vec3>,
    /// FLIP of its pixels as colours, where the image is finite.
    pub error_map: Option<Vec<Vec3>>,
}

/// What is left of a cell beside its records.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Device and driver.
    pub device: String,
    /// Its last frame, if it was compared.
    pub shown: Option<ComparedFrame>,
}

/// Measures every frame of some cells and hands the records of each frame to `each`. What is left of the cells, in their
/// order; none where it was stopped.
///
/// # Errors
/// A session that cannot be opened, a frame that fails, a reference that is not there.
pub fn measure(
    plan: &MeasurementPlan,
    scene: &Scene,
    cells: &[Cell],
    references: Option<&References>,
    stopped: &dyn Fn() -> bool,
    each: &mut dyn FnMut(Vec<FrameRecord>) -> anyhow::Result<()>,
) -> anyhow::Result<Option<Vec<Outcome>>> {
    let mut scene = identity::posed(scene, plan.time_of(plan.frames.start))?;
    let mut runs: Vec<Run> = cells.iter().map(|cell| open(plan, &scene, cell)).collect::<Result<_, _>>()?;
    // With random numbers of their own: what learns would see the same frame twice.
    for warm_up in 0..plan.warm_up {
        scene.pose(plan.time_of(plan.frames.start))?;
        for session in runs.iter_mut().flat_map(|run| &mut run.sessions) {
            session.pose(&scene, scene.camera(Some(&plan.camera))?)?;
            session.frame(plan.frames.end.saturating_add(warm_up))?;
        }
    }
    let mut reference_before = None;
    for (count, frame) in plan.frames.clone().enumerate() {
        if stopped() {
            return Ok(None);
        }
        let start = Instant::now();
        scene.pose(plan.time_of(frame))?;
        let animate_ms = ms(start);
        let mut records = vec![FrameRecord::default(); runs.len()];
        for turn in 0..runs.len() {
            let index = (turn + count) % runs.len();
            let run = &mut runs[index];
            records[index] = FrameRecord {
                frame,
                cell: run.cell.name.clone(),
                values: [("turn".to_string(), turn as f64)].into(),
            };
            render(plan, &scene, run, &mut records[index], animate_ms)?;
        }
        if let Some(references) = references {
            for session in runs.iter_mut().flat_map(|run| run.sessions.iter_mut().skip(1)) {
                session.pose(&scene, scene.camera(Some(&plan.camera))?)?;
                session.frame(frame)?;
            }
            if plan.compares(frame) {
                let image = references.load(frame)?;
                let reference = MeasuredReference { measured: MeasuredImage::new(&image, &image), image };
                for (run, record) in runs.iter_mut().zip(&mut records) {
                    compare(plan, run, record, &reference, reference_before.as_ref())?;
                }
                reference_before = Some(reference.measured);
            } else {
                // Flicker is between a frame and the one before.
                reference_before = None;
            }
        }
        each(records)?;
    }
    let outcome = |run: Run| {
        let device = run.sessions.first().map(Session::device).unwrap_or_default();
        Outcome { device, shown: run.shown }
    };
    Ok(Some(runs.into_iter().map(outcome).collect()))
}

fn open(plan: &MeasurementPlan, scene: &Scene, cell: &Cell) -> anyhow::Result<Run> {
    let camera = scene.camera(Some(&plan.camera))?;
    let session = |seed| {
        let config =
            RenderConfig { seed: plan.config.seed + seed, ..cell.config.with_image_of(&plan.config) };
        Session::new(&cell.runner, scene, camera, &config, config.features(scene))
    };
    let sessions: Vec<Session> = (0..plan.seeds).map(session).collect::<Result<_, _>>()?;
    Ok(Run { cell: cell.clone(), sessions, before: Vec::new(), shown: None })
}

/// Renders the frame with the first seed: times and counters.
fn render(
    plan: &MeasurementPlan,
    scene: &Scene,
    run: &mut Run,
    record: &mut FrameRecord,
    animate_ms: f64,
) -> anyhow::Result<()> {
    let Some(session) = run.sessions.first_mut() else { return Ok(()) };
    let start = Instant::now();
    session.pose(scene, scene.camera(Some(&plan.camera))?)?;
    let pose_ms = ms(start);
    let start = Instant::now();
    let times = session.frame(record.frame)?;
    let frame_ms = ms(start);
    if plan.time {
        record.set("total_ms", Some(animate_ms + pose_ms + frame_ms));
        for step in times {
            *record.values.entry(format!("pass.{}_ms", step.pass)).or_default() +=
                1e3 * step.time.as_secs_f64();
        }
    }
    let counters = session.counters()?;
    let faults = [Counter::PhotonsDropped, Counter::Clamped, Counter::NonFinite, Counter::MediaOverflow];
    record.set("faults", Some(faults.map(|fault| counters.get(fault) as f64).iter().sum()));
    for (name, counter) in [
        ("camera_rays", Counter::CameraRays),
        ("shadow_rays", Counter::ShadowRays),
        ("light_rays", Counter::LightRays),
        ("light_paths", Counter::LightPaths),
    ] {
        record.set(name, Some(counters.get(counter) as f64));
    }
    // Read once: it takes time between the turns.
    if plan.time && record.frame + 1 == plan.frames.end && run.cell.config.method.gathers {
        let points: Vec<PointGeometry> = session.read("point_geometry")?;
        record.set("points", Some(points.iter().filter(|point| point.exists()).count() as f64));
    }
    Ok(())
}

/// Measures the errors of the frame that the sessions have rendered.
fn compare(
    plan: &MeasurementPlan,
    run: &mut Run,
    record: &mut FrameRecord,
    reference: &MeasuredReference,
    reference_before: Option<&MeasuredImage>,
) -> anyhow::Result<()> {
    let images: Vec<RenderedImage> = run.sessions.iter_mut().map(Session::image).collect::<Result<_, _>>()?;
    let now: Vec<MeasuredImage> =
        images.iter().map(|image| MeasuredImage::new(image, &reference.image)).collect();
    let exposure = f64::from(plan.config.exposure);
    let seen =
        Seen { now: &now, before: &run.before, reference: &reference.measured, reference_before, exposure };
    for measure in MEASURES {
        let found = (measure.compute)(&seen);
        record.set(measure.key, found.map(|found| found.value));
        record.set(&measure.standard_error_key(), found.and_then(|found| found.standard_error));
    }
    if record.frame + 1 == plan.frames.end
        && let (Some(session), [image, ..], [first, ..]) = (run.sessions.first_mut(), &images[..], &now[..])
    {
        // What the session shows overwrites its frame, of which nothing more is read.
        run.shown = Some(ComparedFrame {
            image: session.display(image)?,
            reference: session.display(&reference.image)?,
            error_map: first.flip_map(&reference.measured, exposure).map(ErrorMap::to_colors),
        });
    }
    run.before = now;
    Ok(())
}

fn ms(start: Instant) -> f64 {
    1e3 * start.elapsed().as_secs_f64()
}
