//! What the renderer says of itself to the pages, in JSON.

use caustics::experiment::axis::{AXES, PATHS_PER_PIXEL, RUNNER};
use caustics::experiment::cell::Paths;
use caustics::scene::{CameraChoice, Scene, SceneCamera};
use serde_json::{Value, json};

use super::lane::Lane;
use super::save;
use super::wish::Wish;

/// What there is to say.
pub struct Said<'a> {
    /// What of the command line `render` is told too.
    pub kept: &'a [String],
    /// The scene.
    pub scene: &'a Scene,
    /// What is wanted.
    pub wish: &'a Wish,
    /// Whether nodes are where a file of edits says.
    pub is_edited: bool,
    /// Keys that were recorded.
    pub recorded: usize,
    /// Whether no more are.
    pub is_full: bool,
    /// Whom it is seen by, once known.
    pub camera: Option<&'a SceneCamera>,
    /// The time of the animations (s).
    pub time: f64,
    /// Whether something moves.
    pub moves: bool,
    /// What renders the image.
    pub lane: Option<&'a Lane>,
    /// What renders what it is held against.
    pub against: Option<&'a Lane>,
    /// How far they are apart.
    pub distance: Option<&'a Value>,
    /// Exposure of the image that was shown last (stops).
    pub stops: f64,
    /// What failed.
    pub failure: Option<&'a str>,
}

/// All of it.
pub fn text(said: &Said<'_>) -> String {
    let Said { scene, wish, time, moves, lane, against, failure, .. } = *said;
    let mut value = json!({
        "is": "status", "moves": moves, "paused": wish.paused, "size": (wish.size), "time": time,
        "duration": scene.duration(), "playing": wish.playing.is_some(), "target_fps": wish.target_fps,
        "failure": failure, "warnings": scene.warnings, "distance": said.distance,
        "axes": ([values(wish, 0), values(wish, 1)]), "against": wish.against, "layer": wish.look.layer,
        "edited": (wish.nodes.keys().collect::<Vec<_>>()), "records": wish.records, "recorded": said.recorded,
        "is_full": said.is_full,
    });
    if let Some(camera) = said.camera {
        value["camera"] = camera_status(scene, wish, camera);
    }
    if let Some(lane) = lane {
        value["image"] = lane_status(lane);
        if let Some(camera) = said.camera.filter(|_| !moves) {
            let (cell, frames) = (&lane.configuration.cell, lane.sums.frames());
            let shot = save::Shot {
                camera: &camera.name,
                is_edited: said.is_edited,
                time,
                frames,
                stops: said.stops,
                is_staged: scene.additions.contains_key("light"),
            };
            value["command"] = save::command(said.kept, wish, cell, &shot).into();
        }
    }
    if let Some(lane) = against {
        value["other"] = lane_status(lane);
    }
    value.to_string()
}

/// The values of all axes of a side.
fn values(wish: &Wish, side: usize) -> Value {
    let cell = &wish.cells[side];
    AXES.into_iter()
        .map(|axis| {
            let value = match cell.paths {
                _ if *axis == RUNNER => cell.asked_runner.into(),
                Paths::PerPixel(paths) if *axis == PATHS_PER_PIXEL => paths.to_string(),
                _ => axis.get(cell),
            };
            (axis.key.to_string(), json!({ "value": value, "not_applicable": (axis.not_applicable)(cell) }))
        })
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// Where it is in the file's coordinates (m), which way it looks, its field of view (degrees).
fn camera_status(scene: &Scene, wish: &Wish, camera: &SceneCamera) -> Value {
    let position = scene.origin + camera.position.as_dvec3();
    let named = matches!(wish.camera, CameraChoice::Named(_)).then_some(&camera.name);
    json!({
        "from": position.to_array(), "forward": camera.forward.as_dvec3().to_array(),
        "fov": f64::from(camera.fov_y).to_degrees(), "name": named,
    })
}

fn lane_status(lane: &Lane) -> Value {
    let [width, height] = lane.configuration.size;
    json!({
        "device": lane.opened.session.device(), "why": lane.opened.reason, "gather": lane.opened.gather,
        "method": lane.configuration.cell.method.name, "size": lane.configuration.size, "frames": lane.report.frames(),
        "frame_ms": lane.report.frame_ms(), "pass_ms": lane.report.pass_ms(),
        "rates": lane.report.rates(u64::from(width) * u64::from(height)), "counters": lane.report.counters,
        "warnings": lane.report.counters.warnings(), "light_paths": lane.report.light_paths(),
        "samples": lane.sums.frames(), "error": lane.error.is_finite().then_some(lane.error),
        "seconds": lane.report.wall.as_secs_f64(),
    })
}
