//! How far a cell is from the reference: means over seeds, and pictures of the last frame.
//!
//! Of a scene that moves every frame is measured. Of a still one, one frame; with a history the last of several.

use glam::Vec3;

use crate::experiment::cell::Cell;
use crate::experiment::error::{Errors, Look};
use crate::experiment::identity::posed;
use crate::experiment::plan::Plan;
use crate::experiment::reference::{References, camera};
use crate::experiment::result::{CellError, FrameResult};
use crate::picture::Picture;
use crate::scene::Scene;
use crate::session::Session;
use crate::settings::Settings;

/// Errors of a cell.
#[derive(Clone, Debug)]
pub struct Accuracy {
    /// Means over seeds and frames; the pictures have no names yet.
    pub error: CellError,
    /// Means over seeds, of scenes that move.
    pub frames: Vec<FrameResult>,
    /// Display colours of the last frame, the first seed's.
    pub picture: Vec<Vec3>,
    /// FLIP of its pixels as colours, where the picture is finite.
    pub error_map: Option<Vec<Vec3>>,
    /// Display colours of its reference.
    pub reference: Vec<Vec3>,
    /// Device and driver.
    pub device: String,
}

/// The truth of a frame.
struct Truth {
    picture: Picture,
    look: Look,
}

/// Renders a cell with every seed of the plan. None where it was stopped.
pub fn accuracy(
    plan: &Plan,
    scene: &Scene,
    cell: &Cell,
    references: &References,
    reference_frames: u32,
    stopped: &dyn Fn() -> bool,
) -> anyhow::Result<Option<Accuracy>> {
    let frames = plan.frames.clone();
    let is_still = !scene.is_animated();
    let last = frames.end.saturating_sub(1);
    let is_measured = |frame: u32| !is_still || frame == last;
    let first = if is_still && cell.history.name == "none" { last } else { frames.start };
    let exposure = f64::from(plan.settings.exposure);

    let truths = (first..frames.end).filter(|frame| is_measured(*frame)).map(|frame| {
        let picture = references.load(frame)?;
        Ok((frame, Truth { look: Look::new(&picture, &picture), picture }))
    });
    let truths = truths.collect::<anyhow::Result<Vec<_>>>()?;
    let mut errors: Vec<Vec<Errors>> = vec![Vec::new(); truths.len()];
    let mut shown = None;
    for seed in 0..plan.seeds() {
        let mut scene = posed(scene, plan.time_of(first))?;
        let settings = Settings { seed: plan.settings.seed + seed, ..cell.settings(&plan.settings) };
        let features = cell.features(&scene, settings.specular_roughness);
        let view = camera(&scene, &plan.camera)?;
        let mut session =
            Session::new(&cell.runner, &scene, view, &settings, cell.method, cell.variant(), features)?;
        for frame in first..frames.end {
            if stopped() {
                return Ok(None);
            }
            scene.pose(plan.time_of(frame))?;
            session.pose(&scene, camera(&scene, &plan.camera)?)?;
            session.frame(frame)?;
            let Some(index) = truths.iter().position(|(known, _)| *known == frame) else { continue };
            let truth = &truths[index].1;
            let picture = session.picture()?;
            let look = Look::new(&picture, &truth.picture);
            errors[index].push(look.errors(&truth.look, exposure));
            if seed == 0 && frame == last {
                let map = look.flip_map(&truth.look, exposure);
                // What the session shows overwrites its frame.
                let colors = (session.display(&picture)?, session.display(&truth.picture)?);
                shown = Some((colors, map.map(|map| map.to_colors()), session.device()));
            }
        }
    }
    let ((picture, reference), error_map, device) =
        shown.ok_or_else(|| anyhow::anyhow!("no frame was measured"))?;
    let means: Vec<Errors> = errors.iter().map(|of| mean(of)).collect();
    let Errors { flip, flip_caustics, relmse, relmse_caustics } = mean(&means);
    let error = CellError {
        width: plan.settings.width,
        height: plan.settings.height,
        light_paths: cell.settings(&plan.settings).light_paths,
        seeds: plan.seeds(),
        reference_frames,
        flip,
        flip_caustics,
        relmse,
        relmse_caustics,
        ..CellError::default()
    };
    let frames = truths.iter().zip(&means).filter(|_| !is_still).map(|((frame, _), of)| FrameResult {
        frame: *frame,
        total_ms: None,
        flip: of.flip,
        flip_caustics: of.flip_caustics,
    });
    let frames = frames.collect();
    Ok(Some(Accuracy { error, frames, picture, error_map, reference, device }))
}

/// Means of measures that are all there.
fn mean(of: &[Errors]) -> Errors {
    let mean = |get: fn(&Errors) -> Option<f64>| {
        let sum = of.iter().map(get).sum::<Option<f64>>()?;
        (!of.is_empty()).then(|| sum / of.len() as f64)
    };
    Errors {
        flip: mean(|of| of.flip),
        flip_caustics: mean(|of| of.flip_caustics),
        relmse: mean(|of| of.relmse),
        relmse_caustics: mean(|of| of.relmse_caustics),
    }
}
