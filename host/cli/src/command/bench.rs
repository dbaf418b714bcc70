//! `caustics bench`: a sweep of one scene, given by options, that also prints its results.

use std::process::ExitCode;

use caustics::exposure::Exposure;
use caustics_bench::parameter::PATHS_PER_PIXEL;
use caustics_bench::result::RunResult;
use caustics_bench::store::{Results, create};
use caustics_bench::sweep::config::{EnvironmentTable, ErrorTable, SweepConfig, TimeTable};
use caustics_bench::sweep::value::{Count, Positive, Side};
use caustics_bench::table::table;
use caustics_kernels::interface::choice::{PixelFilter, TextureFilter};
use toml::Spanned;

use super::console::print;
use super::options::{camera, check_environment, check_fps, check_size, color, default_light};
use super::sweep::{check_tables, expand, forget, measure, tasks, write_tables};
use crate::cli::{Bench, Quantity, Usage};

/// Measures, writes and prints. Returns exit code 130 after Ctrl-C; finished run configurations are kept.
pub fn run(options: &Bench) -> anyhow::Result<ExitCode> {
    let config = config(options)?;
    let folder = options.output.as_deref();
    folder.map_or(Ok(()), |folder| check_tables(folder, &config, &[]))?;
    let expanded = expand(&config, &options.machine)?;
    let tasks = tasks(&config, &expanded)?;
    if let Some(folder) = folder {
        create(folder)?;
        if options.force {
            forget(folder, &tasks)?;
        }
    }
    let results = Results::new(folder)?;
    let is_done = measure(&config, &tasks, &results, "")?;
    folder.map_or(Ok(()), write_tables)?;
    let measured: Vec<(String, RunResult)> = tasks
        .iter()
        .filter_map(|task| Some((task.run.name.clone(), results.read(&task.identity)?)))
        .collect();
    if options.json {
        let results: Vec<&RunResult> = measured.iter().map(|(_, result)| result).collect();
        print(serde_json::to_string_pretty(&results)?)?;
    } else if !measured.is_empty() {
        print(table(&measured).trim_end())?;
    }
    Ok(if is_done { ExitCode::SUCCESS } else { ExitCode::from(130) })
}

/// Returns the options as a sweep file.
fn config(options: &Bench) -> anyhow::Result<SweepConfig> {
    let Bench { view, frames, .. } = options;
    let measures = |quantity| options.measure.contains(&quantity);
    check_fps(options.fps)?;
    check_environment(view)?;
    if measures(Quantity::Error) && !(2..=1024).contains(&options.seeds) {
        return Err(Usage(format!("--seeds {}: give 2 to 1024, a variance takes two", options.seeds)).into());
    }
    if options.reference_frames == 0 {
        return Err(Usage("--reference-frames 0: give at least 1".into()).into());
    }
    check_size(view.width, view.height)?;
    let mut matrix = options.parameters.table()?;
    matrix.scene = vec![options.scene.clone()];
    matrix.camera = camera(view)?;
    if !options.parameters.has(&PATHS_PER_PIXEL) {
        matrix.add("light_paths", PATHS_PER_PIXEL.default).map_err(Usage)?;
    }
    let Exposure::Stops(exposure) = view.exposure else {
        return Err(
            Usage("--exposure auto: bench measures many images; give one number of stops".into()).into()
        );
    };
    let (width, height, count) = (Side(view.width), Side(view.height), Count(frames.len() as u32));
    let config = SweepConfig {
        fps: Positive(options.fps),
        first_frame: frames.start,
        seed: view.seed,
        exposure: exposure as f32,
        texture_filter: view.texture_filter.unwrap_or(TextureFilter::Cone),
        specular_roughness: view.specular_roughness,
        pixel_filter: view.pixel_filter.unwrap_or(PixelFilter::Centre),
        reference_pixel_filter: options.reference_pixel_filter,
        background: view.background.as_deref().map(color).transpose()?.map(|color| color.to_array()),
        environment: view.environment.clone().map(|source| EnvironmentTable {
            source,
            rotation: view.environment_rotation,
            scale: view.environment_scale,
        }),
        default_light: default_light(view),
        floor: view.floor,
        strict: options.loading.strict,
        variant: options.loading.variant.clone(),
        animation: options.loading.animation.clone(),
        copies: options.loading.copies,
        bvh_quality: options.loading.bvh_quality,
        moment_s: options.moment,
        time: measures(Quantity::Time).then_some(TimeTable {
            width,
            height,
            frames: count,
            warm_up: options.warm_up,
            tracer_rate: true,
        }),
        error: measures(Quantity::Error).then_some(ErrorTable {
            width,
            height,
            seeds: Count(options.seeds),
            reference_frames: Count(options.reference_frames),
            frames: count,
            every_frame: options.every_frame,
            compared_frames: None,
        }),
        matrix: vec![Spanned::new(0..0, matrix)],
    };
    config.check("").map_err(Usage)?;
    Ok(config)
}
