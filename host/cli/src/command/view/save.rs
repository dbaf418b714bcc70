//! The image as a file, and the command that renders it.

use std::path::Path;

use caustics::output::exr;
use caustics::render_config::Paths;
use caustics::scene::{CameraChoice, Recorded, Scene};
use caustics::shell;
use caustics_bench::parameter::{HISTORY, PARAMETERS, PATH_HISTORY, PATHS_PER_PIXEL, Parameter, RUNNER};
use caustics_bench::run_config::RunConfig;
use clap::CommandFactory;
use clap::parser::ValueSource;

use super::edited::FILE;
use super::render_job::RenderJob;
use super::request::ViewRequest;
use crate::cli::Cli;
use crate::command::identity::{attributes, end, identity};

/// Encodes the sum of a render job as EXR: the file of `render`, byte for byte, except for the seconds that it took.
pub fn exr(job: &RenderJob, scene: &Scene, camera: &str, file: &Path) -> anyhow::Result<Vec<u8>> {
    let RenderJob { opened, config, sums, report, .. } = job;
    let session = &opened.session;
    let identity = identity(scene, camera, config, opened.gather, &opened.choice, session);
    let mut attributes = attributes(identity, file, session);
    end(&mut attributes, sums.frames(), report.wall.as_secs_f64());
    let variance = sums.variance().map(|variance| (variance, sums.frames()));
    Ok(exr::encode(&sums.mean(), variance, &attributes)?)
}

/// Options of `view` that the page decides or that `render` lacks, besides the parameters.
const OF_THE_PAGE: [&str; 12] = [
    "edits",
    "port",
    "bind",
    "target_fps",
    "time",
    "width",
    "height",
    "camera",
    "from",
    "look_at",
    "fov",
    "exposure",
];

/// Returns the arguments of `view` that `render` takes too, as words of a command.
pub fn kept() -> Vec<String> {
    let command = Cli::command();
    let (Some(view), Ok(matches)) = (command.find_subcommand("view"), command.clone().try_get_matches())
    else {
        return Vec::new();
    };
    let Some(matches) = matches.subcommand_matches("view") else { return Vec::new() };
    let mut words = Vec::new();
    for argument in view.get_arguments() {
        let id = argument.get_id().as_str();
        let is_given = matches.value_source(id) == Some(ValueSource::CommandLine);
        let is_parameter = caustics_bench::parameter::keys().any(|(key, ..)| key == id);
        if !is_given || is_parameter || OF_THE_PAGE.contains(&id) {
            continue;
        }
        // Quoting fails only for a NUL, which no argument has.
        match argument.get_long() {
            Some(name) if !argument.get_action().takes_values() => words.push(format!("--{name}")),
            Some(name) => words.extend(
                matches.get_raw(id).into_iter().flatten().filter_map(|value| shell::option(name, value)),
            ),
            None => words.extend(matches.get_raw(id).into_iter().flatten().filter_map(shell::path)),
        }
    }
    words
}

/// Properties of an image that the view request lacks.
pub struct Shot<'a> {
    /// Name of the camera.
    pub camera: &'a str,
    /// Whether a file of edits places nodes and the camera.
    pub is_edited: bool,
    /// Time of the animations (s).
    pub time: f64,
    /// Number of frames in the mean.
    pub frames: u32,
    /// Exposure of the PNG.
    pub stops: f64,
    /// Whether the scene got the default light.
    pub is_staged: bool,
}

/// Returns the command that renders the image again, to the same bits: `kept` from the command line, and the page's
/// choices. None if the camera's name has a NUL, which no command can hold.
pub fn command(
    kept: &[String],
    request: &ViewRequest,
    run_config: &RunConfig,
    shot: &Shot<'_>,
) -> Option<String> {
    let Shot { camera, is_edited, time, frames, stops, is_staged } = *shot;
    let mut words = vec!["caustics".to_string(), "render".into()];
    words.extend_from_slice(kept);
    let is_kept = |start: &str| kept.iter().any(|word| word.starts_with(start));
    // With a placed camera, a glowing object would get no light otherwise.
    if is_staged && !is_kept("--default-light") {
        words.push("--default-light".into());
    }
    if is_edited {
        words.push(shell::option("edits", FILE)?);
    }
    match request.camera {
        CameraChoice::Placed(_) if is_edited => {}
        // A placed camera has its options as name.
        CameraChoice::Placed(_) => {
            words.extend(camera.split(' ').map(shell::quoted).collect::<Option<Vec<_>>>()?);
        }
        CameraChoice::Named(_) | CameraChoice::First if camera == Recorded::NAME => {}
        CameraChoice::Named(_) | CameraChoice::First => words.push(shell::option("camera", camera)?),
    }
    let [width, height] = request.size;
    let mut options = vec![("width".to_string(), width.to_string()), ("height".into(), height.to_string())];
    if time != 0.0 {
        options.push(("time".into(), time.to_string()));
    }
    let parameters =
        PARAMETERS.into_iter().filter(|parameter| (parameter.not_applicable)(run_config).is_none());
    options.extend(parameters.filter_map(|parameter| spelled(parameter, run_config)));
    options.push(("frames".into(), frames.to_string()));
    // A single frame would go through the centres of its pixels, and read textures at the footprint's level.
    if !is_kept("--pixel-filter ") {
        options.push(("pixel-filter".into(), "box".into()));
    }
    if !is_kept("--texture-filter ") && !is_kept("--pixel-filter centre") {
        options.push(("texture-filter".into(), "finest".into()));
    }
    options.push(("exposure".into(), format!("{stops:.2}")));
    for (name, value) in options {
        words.push(shell::option(&name, value)?);
    }
    words.extend(["-o", "image.exr", "--png", "image.png"].map(String::from));
    Some(words.join(" "))
}

/// Returns the option of a parameter with its value; none where it is the default, or where `render` lacks the option.
fn spelled(parameter: &'static Parameter, run_config: &RunConfig) -> Option<(String, String)> {
    let value = match (parameter, run_config.config.light_paths) {
        (parameter, _) if [&HISTORY, &PATH_HISTORY].contains(&parameter) => return None,
        (parameter, _) if *parameter == RUNNER => run_config.asked_runner.into(),
        (parameter, Paths::Count(count)) if *parameter == PATHS_PER_PIXEL => {
            return Some(("light-paths".into(), count.to_string()));
        }
        (parameter, Paths::PerPixel(paths)) if *parameter == PATHS_PER_PIXEL => paths.to_string(),
        (parameter, _) if *parameter == PATHS_PER_PIXEL => return None,
        (parameter, _) => parameter.get(run_config),
    };
    (value != parameter.default && !value.is_empty()).then(|| (parameter.option(), value))
}
