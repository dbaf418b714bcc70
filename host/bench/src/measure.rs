//! Renders the frames of all run configurations, frame by frame, and measures each.
//!
//! Within a frame the run configurations take turns. The order of the turns rotates from frame to frame, so that a
//! disturbance of the machine affects all alike. A configuration has a session for each seed; only the first one's time
//! counts. With references, all seeds render every frame, and the plan says which frames are compared.

use std::cell::OnceCell;
use std::time::Instant;

use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::point::PointGeometry;
use glam::Vec3;

use super::error::{MEASURES, MeasuredImage, Seen};
use super::identity;
use super::plan::MeasurementPlan;
use super::record::FrameRecord;
use super::reference::References;
use super::run_config::RunConfig;
use caustics::metric::error_map::ErrorMap;
use caustics::render_config::RenderConfig;
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::Session;

/// A run configuration under way.
struct ActiveRun {
    run: RunConfig,
    sessions: Vec<Session>,
    /// Images of the frame before, one per seed.
    before: Vec<MeasuredImage>,
    shown: Option<ComparedFrame>,
}

/// The reference of a frame.
struct MeasuredReference {
    image: RenderedImage,
    measured: MeasuredImage,
}

/// Last frame of a run configuration that was compared with a reference, in display colours of the first seed.
#[derive(Clone, Debug)]
pub struct ComparedFrame {
    /// The image.
    pub image: Vec<Vec3>,
    /// Its reference.
    pub reference: Vec<Vec3>,
    /// FLIP of its pixels as colours, where the image is finite.
    pub error_map: Option<Vec<Vec3>>,
}

/// Result of a run configuration, beside its records.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Device and driver.
    pub device: String,
    /// Last frame, if it was compared.
    pub shown: Option<ComparedFrame>,
}

/// Renders every frame of the run configurations and passes the records of each frame to `each`. Returns an outcome for
/// each configuration, in their order, or none where the run was stopped.
///
/// # Errors
/// If a session cannot be opened, a frame fails, or a reference is missing.
pub fn measure(
    plan: &MeasurementPlan,
    scene: &Scene,
    runs: &[RunConfig],
    references: Option<&References>,
    stopped: &dyn Fn() -> bool,
    each: &mut dyn FnMut(Vec<FrameRecord>) -> anyhow::Result<()>,
) -> anyhow::Result<Option<Vec<Outcome>>> {
    let mut scene = identity::posed(scene, plan.time_of(plan.frames.start))?;
    let mut all: Vec<ActiveRun> = runs.iter().map(|run| open(plan, &scene, run)).collect::<Result<_, _>>()?;
    // Warm up with other random numbers: a method that learns would otherwise see the same frame twice.
    for warm_up in 0..plan.warm_up {
        scene.pose(plan.time_of(plan.frames.start))?;
        for session in all.iter_mut().flat_map(|active| &mut active.sessions) {
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
        let mut records = vec![FrameRecord::default(); all.len()];
        for turn in 0..all.len() {
            let index = (turn + count) % all.len();
            let active = &mut all[index];
            records[index] = FrameRecord {
                frame,
                run: active.run.name.clone(),
                values: [("turn".to_string(), turn as f64)].into(),
            };
            render(plan, &scene, active, &mut records[index], animate_ms)?;
        }
        if let Some(references) = references {
            for session in all.iter_mut().flat_map(|active| active.sessions.iter_mut().skip(1)) {
                session.pose(&scene, scene.camera(Some(&plan.camera))?)?;
                session.frame(frame)?;
            }
            if plan.compares(frame) {
                let image = references.load(frame)?;
                let reference = MeasuredReference { measured: MeasuredImage::new(&image, &image), image };
                for (active, record) in all.iter_mut().zip(&mut records) {
                    compare(plan, active, record, &reference, reference_before.as_ref())?;
                }
                reference_before = Some(reference.measured);
            } else {
                // Flicker compares a frame with the one directly before.
                reference_before = None;
            }
        }
        each(records)?;
    }
    let outcome = |active: ActiveRun| {
        let device = active.sessions.first().map(Session::device).unwrap_or_default();
        Outcome { device, shown: active.shown }
    };
    Ok(Some(all.into_iter().map(outcome).collect()))
}

fn open(plan: &MeasurementPlan, scene: &Scene, run: &RunConfig) -> anyhow::Result<ActiveRun> {
    let camera = scene.camera(Some(&plan.camera))?;
    let session = |seed| {
        let config = RenderConfig { seed: plan.config.seed + seed, ..run.config.with_image_of(&plan.config) };
        Session::new(&run.runner, scene, camera, &config, config.features(scene))
    };
    let sessions: Vec<Session> = (0..plan.seeds).map(session).collect::<Result<_, _>>()?;
    Ok(ActiveRun { run: run.clone(), sessions, before: Vec::new(), shown: None })
}

/// Renders the frame with the first seed, and records times and counters.
fn render(
    plan: &MeasurementPlan,
    scene: &Scene,
    active: &mut ActiveRun,
    record: &mut FrameRecord,
    animate_ms: f64,
) -> anyhow::Result<()> {
    let Some(session) = active.sessions.first_mut() else { return Ok(()) };
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
    // Read the points in the last frame only: reading takes time between the turns.
    if plan.time && record.frame + 1 == plan.frames.end && active.run.config.method.gathers {
        let points: Vec<PointGeometry> = session.read("point_geometry")?;
        record.set("points", Some(points.iter().filter(|point| point.exists()).count() as f64));
    }
    Ok(())
}

/// Measures the errors of the frame that the sessions have rendered.
fn compare(
    plan: &MeasurementPlan,
    active: &mut ActiveRun,
    record: &mut FrameRecord,
    reference: &MeasuredReference,
    reference_before: Option<&MeasuredImage>,
) -> anyhow::Result<()> {
    let images: Vec<RenderedImage> =
        active.sessions.iter_mut().map(Session::image).collect::<Result<_, _>>()?;
    let now: Vec<MeasuredImage> =
        images.iter().map(|image| MeasuredImage::new(image, &reference.image)).collect();
    let exposure = f64::from(plan.config.exposure);
    let seen = Seen {
        now: &now,
        before: &active.before,
        reference: &reference.measured,
        reference_before,
        exposure,
        parts: OnceCell::new(),
    };
    for measure in MEASURES {
        let found = (measure.compute)(&seen);
        record.set(measure.key, found.map(|found| found.value));
        record.set(&measure.standard_error_key(), found.and_then(|found| found.standard_error));
    }
    if record.frame + 1 == plan.frames.end
        && let (Some(session), [image, ..], [first, ..]) =
            (active.sessions.first_mut(), &images[..], &now[..])
    {
        // Displaying overwrites the session's frame, which is not read again.
        active.shown = Some(ComparedFrame {
            image: session.display(image)?,
            reference: session.display(&reference.image)?,
            error_map: first.flip_map(&reference.measured, exposure).map(ErrorMap::to_colors),
        });
    }
    active.before = now;
    Ok(())
}

fn ms(start: Instant) -> f64 {
    1e3 * start.elapsed().as_secs_f64()
}
