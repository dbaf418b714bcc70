//! Run configurations of a sweep file, without duplicates, with their identities.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use anyhow::ensure;
use toml::Spanned;

use super::config::{EnvironmentTable, SweepConfig};
use super::matrix_table::MatrixTable;
use crate::identity::{posed, view};
use crate::matrix::{RunConfigs, keep_one_of_each};
use crate::plan::{Compared, MeasurementPlan};
use crate::run_config::RunConfig;
use crate::run_parameters::name_all;
use caustics::hash::digest;
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::{self, EnvironmentMap, Scene, Staged, Staging};
use caustics::session::RunnerChoice;

/// Maximum number of scenes, each with a camera and a size, in a file: all are in memory at once.
const MAX_PARTS: usize = 1000;

/// A scene, a camera, a size, and their run configurations.
#[derive(Clone, Debug)]
pub struct SweepPart {
    /// Scene as loaded.
    pub scene: Scene,
    /// Name of the camera.
    pub camera: String,
    /// Additions to the scene that its file does not have, one line each.
    pub notes: Vec<String>,
    /// Width and height of the timed image, if times are measured (px).
    pub timed_size: Option<(u32, u32)>,
    /// Hash of everything that the part's run configurations share.
    view: String,
    /// Run configurations to measure.
    pub runs: Vec<RunConfig>,
}

/// Everything that a sweep measures.
#[derive(Clone, Debug, Default)]
pub struct Expanded {
    /// Parts, one for each scene, camera and size.
    pub parts: Vec<SweepPart>,
    /// Combinations that are not possible, one line each.
    pub skipped: Vec<String>,
}

impl Expanded {
    /// Loads the scenes and makes the run configurations; `runner` finds the runner of a name.
    ///
    /// # Errors
    /// If a scene cannot be loaded, or a camera or a runner is missing.
    pub fn new(
        config: &SweepConfig,
        runner: &mut dyn FnMut(&str) -> anyhow::Result<RunnerChoice>,
    ) -> anyhow::Result<Expanded> {
        let mut all = Expanded::default();
        let mut known = BTreeMap::new();
        // Count the parts before loading any scene.
        let mut parts = BTreeSet::new();
        for matrix in config.matrix.iter().map(Spanned::get_ref) {
            for size in timed_sizes(config, matrix) {
                parts.extend(matrix.scene.iter().map(|scene| (scene, format!("{:?}", matrix.camera), size)));
                ensure!(
                    parts.len() <= MAX_PARTS,
                    "its [[matrix]] have more than {MAX_PARTS} scenes, cameras and sizes in all; share them out among files"
                );
            }
        }
        drop(parts);
        let environment = config.environment.as_ref().map(EnvironmentTable::map).transpose()?;
        for matrix in &config.matrix {
            let matrix = matrix.get_ref();
            let RunConfigs { runs, skipped } = matrix.parameters.runs(runner)?;
            for line in skipped {
                if !all.skipped.contains(&line) {
                    all.skipped.push(line);
                }
            }
            for timed_size in timed_sizes(config, matrix) {
                let runs = per_pixel(config, timed_size, &runs);
                for argument in &matrix.scene {
                    match known.entry((argument.clone(), format!("{:?}", matrix.camera), timed_size)) {
                        Entry::Occupied(part) => {
                            let part: &mut SweepPart = &mut all.parts[*part.get()];
                            part.runs.extend(runs.iter().cloned());
                        }
                        Entry::Vacant(vacant) => {
                            vacant.insert(all.parts.len());
                            let runs = runs.clone();
                            let part = SweepPart::new(
                                config,
                                argument,
                                matrix,
                                timed_size,
                                runs,
                                environment.as_ref(),
                            )?;
                            all.parts.push(part);
                        }
                    }
                }
            }
        }
        for part in &mut all.parts {
            keep_one_of_each(&mut part.runs);
            name_all(&mut part.runs);
        }
        Ok(all)
    }
}

impl SweepPart {
    fn new(
        config: &SweepConfig,
        argument: &str,
        matrix: &MatrixTable,
        timed_size: Option<(u32, u32)>,
        runs: Vec<RunConfig>,
        environment: Option<&EnvironmentMap>,
    ) -> anyhow::Result<SweepPart> {
        let error_size = config.error.as_ref().map(|error| (error.width.0, error.height.0));
        let (width, height) = timed_size.or(error_size).unwrap_or((1, 1));
        let staging = Staging {
            camera: matrix.camera.clone(),
            load: config.load(),
            edits: None,
            environment: environment.cloned(),
            default_light: config.default_light,
            aspect: f64::from(width) / f64::from(height),
        };
        let Staged { scene, camera, notes } = staging.load(&scene::resolve(argument)?)?;
        let mut part = SweepPart { camera, notes, timed_size, view: String::new(), scene, runs };
        // Hash the common settings only; `identity` adds those of each run configuration.
        let plan = part.plan(config);
        let first = posed(&part.scene, plan.time_of(config.first_frame))?;
        part.view = digest(&view(&first, &part.camera, &plan.config));
        Ok(part)
    }

    /// Whether the frames differ.
    pub fn moves(&self, config: &SweepConfig) -> bool {
        self.scene.is_animated() && config.moment_s.is_none()
    }

    /// Returns the settings that all plans share, without time, error and run configurations.
    pub fn plan(&self, config: &SweepConfig) -> MeasurementPlan {
        let image = RenderConfig {
            seed: config.seed,
            exposure: config.exposure,
            texture_filter: Some(config.texture_filter),
            specular_roughness: config.specular_roughness,
            pixel_filter: config.pixel_filter,
            background: config.background,
            ..RenderConfig::default()
        };
        MeasurementPlan {
            config: image,
            camera: self.camera.clone(),
            frames: 0..1,
            fps: config.fps.0,
            moment: (!self.moves(config)).then_some(config.moment_s.unwrap_or(0.0)),
            warm_up: 0,
            time: false,
            compared: Compared::Last,
            reference_pixel_filter: config.reference_pixel_filter,
            seeds: 1,
        }
    }

    /// Plan of the timed frames, if times are measured.
    pub fn time_plan(&self, config: &SweepConfig) -> Option<MeasurementPlan> {
        let (time, (width, height)) = (config.time.as_ref()?, self.timed_size?);
        let plan = self.plan(config);
        let first = if self.moves(config) { config.first_frame } else { 0 };
        let image = RenderConfig { width, height, ..plan.config };
        let frames = first..first + time.frames.0;
        Some(MeasurementPlan { config: image, frames, warm_up: time.warm_up, time: true, ..plan })
    }

    /// Plan of the frames by which errors of a run configuration are measured, if they are. A still scene has one frame, or
    /// the last of several where state outlives a frame.
    pub fn error_plan(&self, config: &SweepConfig, run: &RunConfig) -> Option<MeasurementPlan> {
        let error = config.error.as_ref()?;
        let plan = self.plan(config);
        let first = if self.moves(config) { config.first_frame } else { 0 };
        let end = first + error.frames.0;
        let compared = match &error.compared_frames {
            Some(frames) => Compared::These(frames.0.clone()),
            None if self.moves(config) || error.every_frame => Compared::Every,
            None => Compared::Last,
        };
        let is_alone =
            compared == Compared::Last && run.config.method.kept(run.config.parts()).next().is_none();
        let frames = if is_alone { end - 1..end } else { first..end };
        let image = RenderConfig { width: error.width.0, height: error.height.0, ..plan.config };
        Some(MeasurementPlan { config: image, frames, compared, seeds: error.seeds.0, ..plan })
    }

    /// Hash of everything that decides the measures of a run configuration.
    pub fn identity(&self, config: &SweepConfig, run: &RunConfig) -> String {
        // List every field, so that a new key has to be decided on. The view covers the common settings and the additions
        // to the scene; the run configurations cover the lists.
        let SweepConfig {
            fps,
            first_frame,
            seed,
            exposure,
            time,
            error,
            moment_s,
            texture_filter: _,
            specular_roughness: _,
            pixel_filter: _,
            reference_pixel_filter,
            background: _,
            environment: _,
            default_light: _,
            floor: _,
            strict: _,
            animation: _,
            copies: _,
            bvh_quality: _,
            variant: _,
            matrix: _,
        } = config;
        let moves = self.moves(config).then_some((fps.0, first_frame));
        let (view, size) = (&self.view, self.timed_size);
        // Sweeps without this key keep the identities that they had before it.
        let reference =
            reference_pixel_filter.map_or(String::new(), |filter| format!("references {} ", filter.name()));
        let text = format!(
            "{reference}{view} {moves:?} {moment_s:?} seed {seed} {exposure} {time:?} {size:?} {error:?} {}",
            run.key()
        );
        digest(&text)
    }
}

/// Sizes of the timed images; a single none where no times are measured.
fn timed_sizes(config: &SweepConfig, matrix: &MatrixTable) -> Vec<Option<(u32, u32)>> {
    if matrix.size.is_empty() {
        return vec![config.time.as_ref().map(|time| (time.width.0, time.height.0))];
    }
    matrix.size.iter().map(|(width, height)| Some((width.0, height.0))).collect()
}

/// Returns the run configurations with light paths a pixel instead of a number of light paths, which makes images of all
/// sizes comparable.
fn per_pixel(config: &SweepConfig, timed_size: Option<(u32, u32)>, runs: &[RunConfig]) -> Vec<RunConfig> {
    let size = timed_size.or(config.error.as_ref().map(|error| (error.width.0, error.height.0)));
    let pixels = size.map_or(1.0, |(width, height)| f64::from(width) * f64::from(height));
    let to_per_pixel = |run: &RunConfig| match run.config.light_paths {
        Paths::Count(count) => {
            run.clone().with(|config| config.light_paths = Paths::PerPixel(f64::from(count) / pixels))
        }
        _ => run.clone(),
    };
    runs.iter().map(to_per_pixel).collect()
}
