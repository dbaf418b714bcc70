//! Status of the renderer for the pages, in JSON.

use caustics::render_config::Paths;
use caustics::scene::{CameraChoice, Scene, SceneCamera};
use caustics_bench::parameter::{PARAMETERS, PATHS_PER_PIXEL, RUNNER};
use serde_json::{Value, json};

use super::render_job::RenderJob;
use super::request::ViewRequest;
use super::save;

/// Status of the renderer.
pub struct Status<'a> {
    /// Arguments of the command line that `render` takes too.
    pub kept: &'a [String],
    /// The scene.
    pub scene: &'a Scene,
    /// View request.
    pub request: &'a ViewRequest,
    /// Whether there are edits or keys.
    pub is_edited: bool,
    /// Number of recorded keys.
    pub recorded: usize,
    /// Whether the recording is full.
    pub is_full: bool,
    /// Camera, once known.
    pub camera: Option<&'a SceneCamera>,
    /// Time of the animations (s).
    pub time: f64,
    /// Whether something moves.
    pub moves: bool,
    /// Render job of the image.
    pub job: Option<&'a RenderJob>,
    /// Render job of the image to compare with.
    pub against: Option<&'a RenderJob>,
    /// Distance between both.
    pub distance: Option<&'a Value>,
    /// Exposure of the last image (stops).
    pub stops: f64,
    /// Failure of the last frame.
    pub failure: Option<&'a str>,
}

/// Returns the status as JSON.
pub fn text(status: &Status<'_>) -> String {
    let Status { scene, request, time, moves, job, against, failure, .. } = *status;
    let mut value = json!({
        "is": "status", "moves": moves, "paused": request.paused, "size": (request.size), "time": time,
        "duration": scene.duration(), "playing": request.playing.is_some(), "target_fps": request.target_fps,
        "failure": failure, "warnings": scene.warnings, "distance": status.distance,
        "axes": ([values(request, 0), values(request, 1)]), "against": request.against, "layer": request.look.layer,
        "edited": (request.nodes.keys().collect::<Vec<_>>()), "records": request.records, "recorded": status.recorded,
        "is_full": status.is_full,
    });
    if let Some(camera) = status.camera {
        value["camera"] = camera_status(scene, request, camera);
    }
    if let Some(job) = job {
        value["image"] = job_status(job);
        if let Some(camera) = status.camera.filter(|_| !moves) {
            let (run_config, frames) = (&job.configuration.run_config, job.sums.frames());
            let shot = save::Shot {
                camera: &camera.name,
                is_edited: status.is_edited,
                time,
                frames,
                stops: status.stops,
                is_staged: scene.additions.contains_key("light"),
            };
            value["command"] = save::command(status.kept, request, run_config, &shot).into();
        }
    }
    if let Some(job) = against {
        value["other"] = job_status(job);
    }
    value.to_string()
}

/// Returns the values of all parameters of a side.
fn values(request: &ViewRequest, side: usize) -> Value {
    let run_config = &request.run_configs[side];
    PARAMETERS
        .into_iter()
        .map(|parameter| {
            let value = match run_config.config.light_paths {
                _ if *parameter == RUNNER => run_config.asked_runner.into(),
                Paths::PerPixel(paths) if *parameter == PATHS_PER_PIXEL => paths.to_string(),
                _ => parameter.get(run_config),
            };
            (
                parameter.key.to_string(),
                json!({ "value": value, "not_applicable": (parameter.not_applicable)(run_config).map(|why| why.to_string()) }),
            )
        })
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// Returns the position in the file's coordinates (m), the direction, and the field of view (degrees).
fn camera_status(scene: &Scene, request: &ViewRequest, camera: &SceneCamera) -> Value {
    let position = scene.origin + camera.position.as_dvec3();
    let named = matches!(request.camera, CameraChoice::Named(_)).then_some(&camera.name);
    json!({
        "from": position.to_array(), "forward": camera.forward.as_dvec3().to_array(),
        "fov": f64::from(camera.fov_y).to_degrees(), "name": named,
    })
}

fn job_status(job: &RenderJob) -> Value {
    let [width, height] = job.configuration.size;
    json!({
        "device": job.opened.session.device(), "why": job.opened.reason, "gather": job.opened.gather,
        "method": job.configuration.run_config.config.method.name, "size": job.configuration.size, "frames": job.report.frames(),
        "frame_ms": job.report.frame_ms(), "pass_ms": job.report.pass_ms(),
        "rates": job.report.rates(u64::from(width) * u64::from(height)), "counters": job.report.counters,
        "warnings": job.report.counters.warnings(), "light_paths": job.report.light_paths(),
        "samples": job.sums.frames(), "error": job.error.is_finite().then_some(job.error),
        "seconds": job.report.wall.as_secs_f64(),
    })
}
