//! A session: one scene, one method, one runner; frames in, pictures out.

use anyhow::{Context, bail};
use bytemuck::cast_slice;
use caustics_kernels::gather::accumulator;
use caustics_kernels::gather::variant::{self, Variant};
use caustics_kernels::interface::counters::{COUNTER_NAMES, Counter};
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::math::ray::{Hit, Ray};
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::{max_abs, warp};
use glam::Vec3;
use std::collections::BTreeMap;

use crate::kernels;
use crate::method::settings::Settings;
use crate::method::{BufferSpec, Step, basic};
use crate::runner::cpu::CpuRunner;
use crate::runner::gpu::{GpuOptions, GpuRunner};
use crate::runner::{Runner, StepTime};
use crate::scene::{Scene, SceneCamera};

/// Which runner to open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunnerChoice {
    /// The CPU, on this many threads (0: all).
    Cpu {
        /// Worker threads.
        threads: usize,
    },
    /// A Vulkan device.
    Gpu {
        /// Index or part of the name; none: the best there is.
        device: Option<String>,
        /// Trace by ray queries.
        hardware: bool,
        /// Watch by the validation layer.
        validation: bool,
    },
}

/// Opens a runner with a scene's tables and the given buffers.
pub fn open(
    choice: &RunnerChoice,
    scene: &Scene,
    needs: Needs,
    buffers: &[BufferSpec],
) -> anyhow::Result<Box<dyn Runner>> {
    let tables = tables(scene);
    match choice {
        RunnerChoice::Cpu { threads } => Ok(Box::new(CpuRunner::new(*threads, needs, buffers, &tables)?)),
        RunnerChoice::Gpu { device, hardware, validation } => {
            let modules = kernels::modules()?;
            let options = GpuOptions {
                device: device.clone(),
                hardware: *hardware,
                validation: *validation,
                base: modules.base,
                rayquery: hardware.then_some(modules.rayquery),
            };
            let triangles = scene.triangles.len() as u32;
            Ok(Box::new(GpuRunner::new(options, needs, buffers, &tables, triangles)?))
        }
    }
}

/// The scene's tables as buffers.
pub fn tables(scene: &Scene) -> [(&'static str, &[u8]); 6] {
    [
        ("triangles", cast_slice(&scene.triangles)),
        ("surfaces", cast_slice(&scene.surfaces)),
        ("materials", cast_slice(&scene.materials)),
        ("lights", cast_slice(&scene.lights)),
        ("nodes", cast_slice(&scene.nodes)),
        ("blocks", cast_slice(&scene.blocks)),
    ]
}

/// Closest hits per second of a runner's tracer alone, on incoherent rays: from the camera paths' vertices of a small
/// picture into random directions. The best of several rounds.
pub fn closest_hits_per_second(
    choice: &RunnerChoice,
    scene: &Scene,
    camera: &SceneCamera,
    needs: Needs,
) -> anyhow::Result<f64> {
    const SIDE: u32 = 512;
    let settings = Settings { width: SIDE, height: SIDE, ..Settings::default() };
    let params = FrameParams { light_path_batch: SIDE * SIDE, ..settings.params(scene, camera, needs, 0) };
    let pixels = params.pixel_count() as usize;
    let mut buffers = basic::buffers(&variant::BRUTE, &FrameParams { light_path_count: 0, ..params });
    buffers.push(BufferSpec { name: "rays", bytes: size_of::<Ray>() * pixels });
    buffers.push(BufferSpec { name: "hits", bytes: size_of::<Hit>() * pixels });
    let mut runner = open(choice, scene, needs, &buffers)?;
    runner.write("pixel_order", cast_slice(&basic::pixel_order(SIDE, SIDE)))?;
    runner.run(&[Step::Dispatch { pass: "collect", count: params.pixel_count(), params }])?;
    let points: Vec<PointGeometry> = bytemuck::pod_collect_to_vec(&runner.read("point_geometry")?);
    let rays: Vec<Ray> = points
        .iter()
        .enumerate()
        .map(|(index, point)| {
            let u = Rng::new(Stream::Light, 0, index as u32, 0).next4();
            let direction = warp::uniform_sphere(u.x, u.y);
            let side = if direction.dot(point.normal) < 0.0 { -1.0 } else { 1.0 };
            let lift = point.normal * (1.0e-4 * side * max_abs(point.position));
            Ray::endless(point.position + lift, direction)
        })
        .collect();
    runner.write("rays", cast_slice(&rays))?;
    let hit = Step::Dispatch { pass: "step.hit", count: params.pixel_count(), params };
    let mut best = f64::MAX;
    for _ in 0..5 {
        let seconds: f64 = runner.run(&[hit])?.iter().map(|step| step.time.as_secs_f64()).sum();
        best = best.min(seconds);
    }
    Ok(pixels as f64 / best)
}

/// A picture and what it is made of, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width [px].
    pub width: usize,
    /// Height [px].
    pub height: usize,
    /// Radiance that is no caustic [W m^-2 sr^-1].
    pub path: Vec<Vec3>,
    /// Radiance of the caustics [W m^-2 sr^-1].
    pub caustics: Vec<Vec3>,
    /// Radius of the collection points [m]; 0 without a point.
    pub radius: Vec<f32>,
    /// Camera vertex of the collection points; 0 without a point.
    pub depth: Vec<f32>,
    /// Deposits taken.
    pub deposits: Vec<f32>,
}

/// Renders frames of one view.
pub struct Session {
    runner: Box<dyn Runner>,
    variant: &'static Variant,
    params: FrameParams,
}

impl Session {
    /// Opens the runner and allocates for the view.
    pub fn new(
        choice: &RunnerChoice,
        scene: &Scene,
        camera: &SceneCamera,
        settings: &Settings,
        variant: &'static Variant,
        needs: Needs,
    ) -> anyhow::Result<Session> {
        if variant.hardware && !matches!(choice, RunnerChoice::Gpu { hardware: true, .. }) {
            bail!("--gather {} needs ray queries (--runner gpu --tracer hardware)", variant.name);
        }
        let params = settings.params(scene, camera, needs, 0);
        let mut runner = open(choice, scene, needs, &basic::buffers(variant, &params))?;
        runner.write("pixel_order", cast_slice(&basic::pixel_order(params.width, params.height)))?;
        Ok(Session { runner, variant, params })
    }

    /// Device and driver.
    pub fn device(&self) -> String {
        self.runner.device()
    }

    /// Push constants of the first frame.
    pub fn params(&self) -> &FrameParams {
        &self.params
    }

    /// Renders frame `index`; its time by step.
    pub fn frame(&mut self, index: u32) -> anyhow::Result<Vec<StepTime>> {
        let params = FrameParams { frame: index, ..self.params };
        self.runner.run(&basic::steps(self.variant, params))
    }

    /// The picture of the last frame.
    pub fn picture(&mut self) -> anyhow::Result<Picture> {
        let geometry: Vec<PointGeometry> = self.read("point_geometry")?;
        let words: Vec<u32> = self.read("accumulator")?;
        let count = |point: &[u32]| point[accumulator::WORDS as usize - 1] as f32;
        Ok(Picture {
            width: self.params.width as usize,
            height: self.params.height as usize,
            path: self.read("path_radiance")?,
            caustics: self.read("caustic_radiance")?,
            radius: geometry.iter().map(|point| point.radius).collect(),
            depth: geometry.iter().map(|point| point.depth as f32).collect(),
            deposits: words.chunks(accumulator::WORDS as usize).map(count).collect(),
        })
    }

    /// A buffer of the runner.
    pub fn read<T: bytemuck::Pod>(&mut self, buffer: &str) -> anyhow::Result<Vec<T>> {
        let bytes = self.runner.read(buffer).with_context(|| format!("reading buffer {buffer}"))?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Counters of the last frame.
    pub fn counters(&mut self) -> anyhow::Result<Counters> {
        let words: Vec<u32> = self.read("counters")?;
        Ok(Counters(
            COUNTER_NAMES.iter().map(|&(slot, name)| (name, u64::from(words[slot as usize]))).collect(),
        ))
    }

    /// Display colours in [0, 1] of a picture (of an average, say).
    pub fn display(&mut self, picture: &Picture) -> anyhow::Result<Vec<Vec3>> {
        self.runner.write("path_radiance", cast_slice(&picture.path))?;
        self.runner.write("caustic_radiance", cast_slice(&picture.caustics))?;
        let steps = basic::steps(self.variant, FrameParams { light_path_count: 0, ..self.params });
        let display = steps.last().copied().context("a frame ends with display")?;
        self.runner.run(&[display])?;
        self.read("display_color")
    }
}

/// What the kernels counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(transparent)]
pub struct Counters(BTreeMap<&'static str, u64>);

impl Counters {
    /// One counter.
    pub fn get(&self, counter: Counter) -> u64 {
        let name = COUNTER_NAMES.iter().find(|(slot, _)| *slot == counter).map(|(_, name)| *name);
        name.and_then(|name| self.0.get(name).copied()).unwrap_or(0)
    }

    /// Adds another frame's.
    pub fn add(&mut self, other: &Counters) {
        for (name, value) in &other.0 {
            *self.0.entry(name).or_default() += value;
        }
    }

    /// What a person should be warned of.
    pub fn warnings(&self) -> Vec<String> {
        [
            (Counter::DepositsDropped, "deposits found no room and are missing"),
            (Counter::Clamped, "addends were clamped by the accumulator"),
            (Counter::NonFinite, "non-finite addends were left out"),
            (Counter::MediaOverflow, "paths were inside more than four nested media"),
        ]
        .iter()
        .filter(|(counter, _)| self.get(*counter) > 0)
        .map(|(counter, what)| format!("{} {what}", self.get(*counter)))
        .collect()
    }
}

/// The mean of several pictures.
#[derive(Clone, Debug, Default)]
pub struct Average {
    sum: Picture,
    frames: u32,
}

impl Average {
    /// Adds a picture; all must have one size.
    pub fn add(&mut self, picture: Picture) {
        if self.frames == 0 {
            self.sum = picture;
        } else {
            let vectors =
                |sum: &mut [Vec3], new: &[Vec3]| sum.iter_mut().zip(new).for_each(|(s, n)| *s += *n);
            let numbers = |sum: &mut [f32], new: &[f32]| sum.iter_mut().zip(new).for_each(|(s, n)| *s += *n);
            vectors(&mut self.sum.path, &picture.path);
            vectors(&mut self.sum.caustics, &picture.caustics);
            numbers(&mut self.sum.radius, &picture.radius);
            numbers(&mut self.sum.depth, &picture.depth);
            numbers(&mut self.sum.deposits, &picture.deposits);
        }
        self.frames += 1;
    }

    /// Pictures added.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The mean.
    pub fn mean(&self) -> Picture {
        let scale = 1.0 / self.frames.max(1) as f32;
        let mut mean = self.sum.clone();
        if self.frames > 1 {
            mean.path.iter_mut().chain(&mut mean.caustics).for_each(|value| *value *= scale);
            let numbers = mean.radius.iter_mut().chain(&mut mean.depth).chain(&mut mean.deposits);
            numbers.for_each(|value| *value *= scale);
        }
        mean
    }
}
