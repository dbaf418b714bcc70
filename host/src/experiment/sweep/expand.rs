//! The cells of a sweep's file, each once, with what they are known by.

use anyhow::Context;

use super::config::{Config, MatrixTable};
use crate::experiment::cell::{Cell, Paths, name_all};
use crate::experiment::identity::{posed, view};
use crate::experiment::matrix::{Cells, Matrix, keep_one_of_each};
use crate::experiment::plan::Plan;
use crate::hash::fnv1a;
use crate::method::settings::Settings;
use crate::scene::{self, Scene};
use crate::session::RunnerChoice;

/// A scene and its cells.
#[derive(Clone, Debug)]
pub struct Part {
    /// As loaded.
    pub scene: Scene,
    /// Name of the camera.
    pub camera: String,
    /// Scene as it was given.
    argument: String,
    /// Camera as it was given.
    asked: Option<String>,
    /// Hash of all that cells of the part share.
    view: String,
    /// What is measured.
    pub cells: Vec<Cell>,
}

/// Everything that a sweep measures.
#[derive(Clone, Debug, Default)]
pub struct Expanded {
    /// A part a scene and camera.
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
        for matrix in &config.matrix {
            let matrix = matrix.get_ref();
            let names = matrix.runner.0.iter().map(|name| name.0.0);
            let runners = names.map(&mut *runner).collect::<anyhow::Result<Vec<_>>>()?;
            let Cells { cells, skipped } = lists(config, matrix, runners).cells();
            for line in skipped {
                if !all.skipped.contains(&line) {
                    all.skipped.push(line);
                }
            }
            for argument in &matrix.scene.0 {
                let known = |part: &&mut Part| part.argument == *argument && part.asked == matrix.camera;
                match all.parts.iter_mut().find(known) {
                    Some(part) => part.cells.extend(cells.iter().cloned()),
                    None => all.parts.push(Part::new(config, argument, matrix, cells.clone())?),
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
    fn new(config: &Config, argument: &str, matrix: &MatrixTable, cells: Vec<Cell>) -> anyhow::Result<Part> {
        let scene = Scene::load(&scene::resolve(argument)?)?;
        let name = matrix.camera.as_deref();
        let camera = scene.cameras.iter().find(|camera| name.is_none_or(|name| camera.name == name));
        let camera =
            camera.with_context(|| format!("scene {argument} has no camera {}", name.unwrap_or("")))?;
        let camera = camera.name.clone();
        let mut part = Part {
            camera,
            argument: argument.into(),
            asked: matrix.camera.clone(),
            view: String::new(),
            scene,
            cells,
        };
        // What differs between cells is said by each of them.
        let first = posed(&part.scene, part.plan(config).time_of(config.first_frame))?;
        part.view = fnv1a(view(&first, &part.camera, &Settings::default()).bytes());
        Ok(part)
    }

    /// What all plans have in common: neither time nor error, and no cells.
    pub fn plan(&self, config: &Config) -> Plan {
        let settings = Settings { seed: config.seed, exposure: config.exposure, ..Settings::default() };
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
        let view = &self.view;
        let text = format!("{view} {moves:?} seed {seed} {exposure} {time:?} {error:?} {}", cell.key());
        fnv1a(text.bytes())
    }
}

fn lists(config: &Config, matrix: &MatrixTable, runners: Vec<RunnerChoice>) -> Matrix {
    // The same paths a pixel in both sizes.
    let size = config.time.as_ref().map(|time| (time.width, time.height));
    let size = size.or(config.error.as_ref().map(|error| (error.width, error.height)));
    let pixels = size.map_or(1.0, |(width, height)| f64::from(width.0) * f64::from(height.0));
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
        filters: matrix.filter.0.iter().map(|filter| filter.0).collect(),
        paths,
        radii: matrix.radius_px.0.iter().map(|radius| radius.0 as f32).collect(),
        bounces: matrix.max_bounces.0.iter().map(|bounces| bounces.0).collect(),
        runners,
        codes: matrix.needs.0.iter().map(|code| code.0).collect(),
    }
}
