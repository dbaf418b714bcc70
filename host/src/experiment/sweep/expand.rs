//! The cells of a sweep's file, each once, with what they are known by.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use anyhow::Context;

use super::config::{Config, MatrixTable};
use crate::experiment::cell::{Cell, Paths, name_all};
use crate::experiment::identity::{posed, view};
use crate::experiment::matrix::{Cells, Matrix, keep_one_of_each};
use crate::experiment::plan::Plan;
use crate::hash::fnv1a;
use crate::scene::{self, Scene};
use crate::session::RunnerChoice;
use crate::settings::Settings;

/// A scene, a size, and their cells.
#[derive(Clone, Debug)]
pub struct Part {
    /// As loaded.
    pub scene: Scene,
    /// Name of the camera.
    pub camera: String,
    /// Width and height of the picture that is timed, if it is (px).
    pub timed_size: Option<(u32, u32)>,
    /// Hash of all that cells of the part share.
    view: String,
    /// What is measured.
    pub cells: Vec<Cell>,
}

/// Everything that a sweep measures.
#[derive(Clone, Debug, Default)]
pub struct Expanded {
    /// A part a scene, camera and size.
    pub parts: Vec<Part>,
    /// What cannot be, a line each.
    pub skipped: Vec<String>,
}

impl Expanded {
    /// Loads the scenes and makes the cells; `runner` finds the runner of a name.
    pub fn new(
        config: &Config,
        runner: &mut dyn FnMut(&str) -> anyhow::Result<RunnerChoice>,
    ) -> anyhow::Result<Expanded> {
        let mut all = Expanded::default();
        let mut known = BTreeMap::new();
        for matrix in &config.matrix {
            let matrix = matrix.get_ref();
            let names = matrix.runner.0.iter().map(|name| name.0.0);
            let runners = names.map(&mut *runner).collect::<anyhow::Result<Vec<_>>>()?;
            for timed_size in timed_sizes(config, matrix) {
                let Cells { cells, skipped } = lists(config, matrix, timed_size, runners.clone()).cells();
                for line in skipped {
                    if !all.skipped.contains(&line) {
                        all.skipped.push(line);
                    }
                }
                for argument in &matrix.scene.0 {
                    match known.entry((argument.clone(), matrix.camera.clone(), timed_size)) {
                        Entry::Occupied(part) => {
                            let part: &mut Part = &mut all.parts[*part.get()];
                            part.cells.extend(cells.iter().cloned());
                        }
                        Entry::Vacant(place) => {
                            place.insert(all.parts.len());
                            all.parts.push(Part::new(config, argument, matrix, timed_size, cells.clone())?);
                        }
                    }
                }
            }
        }
        for part in &mut all.parts {
            keep_one_of_each(&mut part.cells);
            name_all(&mut part.cells);
        }
        Ok(all)
    }
}

impl Part {
    fn new(
        config: &Config,
        argument: &str,
        matrix: &MatrixTable,
        timed_size: Option<(u32, u32)>,
        cells: Vec<Cell>,
    ) -> anyhow::Result<Part> {
        let scene = Scene::load(&scene::resolve(argument)?)?;
        let name = matrix.camera.as_deref();
        let camera = scene.cameras.iter().find(|camera| name.is_none_or(|name| camera.name == name));
        let camera =
            camera.with_context(|| format!("scene {argument} has no camera {}", name.unwrap_or("")))?;
        let camera = camera.name.clone();
        let mut part = Part { camera, timed_size, view: String::new(), scene, cells };
        // What differs between cells is said by each of them.
        let first = posed(&part.scene, part.plan(config).time_of(config.first_frame))?;
        let common = Settings { texture_filter: Some(config.texture_filter.0), ..Settings::default() };
        part.view = fnv1a(view(&first, &part.camera, &common).bytes());
        Ok(part)
    }

    /// What all plans have in common: neither time nor error, and no cells.
    pub fn plan(&self, config: &Config) -> Plan {
        let settings = Settings {
            seed: config.seed,
            exposure: config.exposure,
            texture_filter: Some(config.texture_filter.0),
            ..Settings::default()
        };
        Plan {
            cells: Vec::new(),
            settings,
            camera: self.camera.clone(),
            frames: 0..1,
            fps: config.fps.0,
            moment: (!self.scene.is_animated()).then_some(0.0),
            warm_up: 0,
            time: false,
            error: None,
        }
    }

    /// Hash of all that decides what is measured of a cell.
    pub fn identity(&self, config: &Config, cell: &Cell) -> String {
        let Config { fps, first_frame, seed, exposure, time, error, .. } = config;
        let moves = self.scene.is_animated().then_some((fps.0, first_frame));
        let (view, size) = (&self.view, self.timed_size);
        let text =
            format!("{view} {moves:?} seed {seed} {exposure} {time:?} {size:?} {error:?} {}", cell.key());
        fnv1a(text.bytes())
    }
}

/// Sizes of the pictures that are timed; one that is none where no times are measured.
fn timed_sizes(config: &Config, matrix: &MatrixTable) -> Vec<Option<(u32, u32)>> {
    if matrix.size.is_empty() {
        return vec![config.time.as_ref().map(|time| (time.width.0, time.height.0))];
    }
    matrix.size.iter().map(|(width, height)| Some((width.0, height.0))).collect()
}

fn lists(
    config: &Config,
    matrix: &MatrixTable,
    timed_size: Option<(u32, u32)>,
    runners: Vec<RunnerChoice>,
) -> Matrix {
    // The same paths a pixel in both sizes.
    let size = timed_size.or(config.error.as_ref().map(|error| (error.width.0, error.height.0)));
    let pixels = size.map_or(1.0, |(width, height)| f64::from(width) * f64::from(height));
    let mut paths = Vec::new();
    if let Some(counts) = &matrix.light_paths {
        paths.extend(counts.0.iter().map(|count| Paths::PerPixel(f64::from(count.0) / pixels)));
    }
    if let Some(densities) = &matrix.paths_per_pixel {
        paths.extend(densities.0.iter().map(|paths| Paths::PerPixel(paths.0)));
    }
    paths.extend(matrix.equal_time_ms.map(|ms| Paths::Time(ms.0)));
    Matrix {
        methods: matrix.method.0.iter().map(|method| method.0).collect(),
        gathers: matrix.gather.iter().map(|gather| gather.0).collect(),
        histories: matrix.history.0.iter().map(|history| history.0).collect(),
        denoisers: matrix.denoiser.0.iter().map(|denoiser| denoiser.0).collect(),
        paths,
        radii: matrix.radius_px.0.iter().map(|radius| radius.0 as f32).collect(),
        bounces: matrix.max_bounces.0.iter().map(|bounces| bounces.0).collect(),
        runners,
        codes: matrix.features.0.iter().map(|code| code.0).collect(),
    }
}
