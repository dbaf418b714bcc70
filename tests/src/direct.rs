//! Kernel functions called one by one on this thread, without a runner: light paths from any emitter, camera paths,
//! gathers of any neighbours. Also frames through a [`Session`] on the CPU.

use std::sync::atomic::AtomicBool;

use crate::collected::{Collected, camera_path};
use bytemuck::cast_slice;
use caustics::counters::Counters;
use caustics::render_config::RenderConfig;
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::declare::Step;
use caustics_kernels::declare::{Buffers, Call, buffers};
use caustics_kernels::gather::variant::Variant;
use caustics_kernels::interface::counters::COUNTER_COUNT;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::named::Named;
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::interface::scene::SceneTables;
use caustics_kernels::light::emit::{EmissionSample, Emit};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::math::rng::Rng;
use caustics_kernels::math::trig::sin_cos_turns;
use caustics_kernels::method::frame as gathers;
use caustics_kernels::pass::resolve::resolve;
use caustics_kernels::pass::shoot;
use caustics_kernels::path::photon_sink::PhotonSink;
use caustics_kernels::platform::{Atomics, Slots};
use caustics_kernels::trace::bvh::BvhTracer;
use glam::Vec3;

/// Returns the mean of independent values and its standard error.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Parallel light through a parallelogram (or the ellipse in it).
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Centre of the cross-section (m).
    pub centre: Vec3,
    /// Unit direction of travel.
    pub direction: Vec3,
    /// Half axes of the cross-section (m), orthogonal to each other and to the direction.
    pub axes: [Vec3; 2],
    /// Whether the cross-section is an ellipse instead of a parallelogram.
    pub round: bool,
    /// Irradiance on a plane across the beam (W m^-2).
    pub irradiance: f32,
}

impl Beam {
    /// Area of the cross-section (m^2).
    pub fn area(&self) -> f64 {
        let area = 4.0 * f64::from(self.axes[0].length()) * f64::from(self.axes[1].length());
        if self.round { area * std::f64::consts::PI / 4.0 } else { area }
    }
}

impl Emit for Beam {
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let u_position = rng.next4();
        let (x, y) = if self.round {
            let (sin, cos) = sin_cos_turns(u_position.w);
            (u_position.z.sqrt() * cos, u_position.z.sqrt() * sin)
        } else {
            (2.0 * u_position.z - 1.0, 2.0 * u_position.w - 1.0)
        };
        let origin = self.centre + self.axes[0] * x + self.axes[1] * y;
        EmissionSample {
            ray: Ray::endless(origin, self.direction),
            flux: Vec3::splat(self.irradiance * self.area() as f32),
            solid_angle: 0.0,
            area: self.area() as f32,
            start_code: 0,
            score: 0.0,
        }
    }
}

/// Counters in plain memory.
#[derive(Clone, Copy, Debug)]
pub struct Tally(pub [u32; COUNTER_COUNT]);

impl Default for Tally {
    fn default() -> Self {
        Tally([0; COUNTER_COUNT])
    }
}

impl Atomics for Tally {
    fn add(&mut self, index: u32, value: u32) -> u32 {
        let before = self.0[index as usize];
        self.0[index as usize] = before.wrapping_add(value);
        before
    }
}

/// Photons in memory.
#[derive(Clone, Debug, Default)]
pub struct Photons {
    /// Geometry of each photon.
    pub geometry: Vec<PhotonGeometry>,
    /// Light of each photon.
    pub light: Vec<PhotonLight>,
}

impl Photons {
    /// Adds a photon.
    pub fn push(&mut self, geometry: PhotonGeometry, light: PhotonLight) {
        self.geometry.push(geometry);
        self.light.push(light);
    }

    /// Number of photons.
    pub fn len(&self) -> u32 {
        self.geometry.len() as u32
    }

    /// Whether there are no photons.
    pub fn is_empty(&self) -> bool {
        self.geometry.is_empty()
    }

    /// Each photon and its flux (W) in the red channel.
    pub fn flux(&self) -> impl Iterator<Item = (&PhotonGeometry, f64)> {
        self.geometry.iter().zip(&self.light).map(|(geometry, light)| {
            (geometry, f64::from(light.flux.x) * f64::from(light.to_light.dot(geometry.normal)))
        })
    }
}

impl PhotonSink for Photons {
    type PathState = ();

    fn store_photon(&mut self, (): &mut (), geometry: PhotonGeometry, light: PhotonLight) {
        self.push(geometry, light);
    }
}

/// A scene with the parameters of a frame.
pub struct World<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Features that the scene needs.
    pub features: Features,
    /// Push constants.
    pub params: FrameParams,
}

impl<'a> World<'a> {
    /// Views the scene through its first camera. Light paths are traced even in a scene without lights.
    pub fn new(scene: &'a Scene, config: &RenderConfig) -> Self {
        let features = scene.features(config.specular_roughness) | Features::HISTORY | Features::PARTS;
        let mut params = config.params(scene, &scene.cameras[0], 0);
        params.light_path_count = config.max_light_paths();
        World { scene, features, params }
    }

    /// The scene's tables.
    pub fn tables(&self) -> SceneTables<'a> {
        self.scene.tables()
    }

    /// The software tracer.
    pub fn tracer(&self) -> BvhTracer<'a> {
        self.scene.tracer(self.features)
    }

    /// Emission by power.
    pub fn by_power(&self) -> ByPower<'_> {
        ByPower::new(self.tables(), &self.params, self.features)
    }

    /// Traces all light paths of the frame, on two threads.
    pub fn shoot<E: Emit + Sync>(&self, emit: &E) -> Photons {
        let count = self.params.light_path_count;
        let part = |indices: std::ops::Range<u32>| {
            let mut photons = Photons::default();
            let (mut tracer, mut tally) = (self.tracer(), Tally::default());
            for index in indices {
                shoot::shoot(
                    index,
                    &self.params,
                    self.features,
                    self.tables(),
                    emit,
                    &mut tracer,
                    &mut photons,
                    &mut tally,
                );
            }
            photons
        };
        std::thread::scope(|scope| {
            let second = scope.spawn(|| part(count / 2..count));
            let mut photons = part(0..count / 2);
            let rest = second.join().expect("no panic");
            photons.geometry.extend(rest.geometry);
            photons.light.extend(rest.light);
            photons
        })
    }

    /// Traces all camera paths of the frame.
    pub fn collect(&self) -> Vec<Collected> {
        let (mut tracer, mut tally) = (self.tracer(), Tally::default());
        (0..self.params.pixel_count())
            .map(|pixel| {
                camera_path(pixel, &self.params, self.features, self.tables(), &mut tracer, &mut tally)
            })
            .collect()
    }
}

/// Returns the accumulator words of all points by a variant, built and searched on this thread. `points` and `shadings`
/// have one entry per pixel.
pub fn gather(
    variant: &'static Variant,
    points: &[PointGeometry],
    shadings: &[PointShading],
    photons: &Photons,
    materials: &[Material],
    features: Features,
    params: &FrameParams,
) -> Vec<u32> {
    // One row of pixels, with room for these photons alone.
    let params = FrameParams {
        width: points.len() as u32,
        height: 1,
        photon_capacity: photons.len().max(1),
        ..*params
    };
    let mut steps = gathers::prepare(variant, &params);
    steps.extend(gathers::exchange(variant, &params));
    let mut memory = Buffers::default();
    for spec in buffers(&steps, &params) {
        memory.add(spec.name, spec.bytes).expect("memory");
    }
    let order: Vec<u32> = (0..params.width).collect();
    let state = [photons.len(), 0, 0, 0];
    let tables: [(&str, &[u8]); 7] = [
        ("materials", cast_slice(materials)),
        ("pixel_order", cast_slice(&order)),
        ("point_geometry", cast_slice(points)),
        ("point_shading", cast_slice(shadings)),
        ("photon_state", cast_slice(&state)),
        ("photon_geometry", cast_slice(&photons.geometry)),
        ("photon_light", cast_slice(&photons.light)),
    ];
    for (name, bytes) in tables {
        memory.add(name, bytes.len()).expect("memory");
        memory.write(name, 0, bytes).expect("it fits");
    }
    for step in steps {
        match step {
            Step::Clear { buffer } => memory.clear(buffer).expect("words of an index"),
            Step::Dispatch { pass, dispatch, .. } => {
                let on_cpu = pass.cpu.expect("a gather in software");
                on_cpu
                    .run(&Call {
                        buffers: &memory,
                        params: &params,
                        dispatch,
                        features,
                        stop: &AtomicBool::new(false),
                    })
                    .expect("its buffers are there");
            }
            other => panic!("{} is no step of the CPU", other.label()),
        }
    }
    memory.read::<u32>("accumulator").expect("sums").to_vec()
}

/// Resolves the radiance of every point from its accumulator words.
pub fn resolved(
    points: &[PointGeometry],
    shadings: &[PointShading],
    words: &[u32],
    params: &FrameParams,
) -> Vec<Vec3> {
    let mut radiance = vec![Vec3::ZERO; points.len()];
    let slots = Slots::new(&mut radiance);
    (0..points.len()).for_each(|pixel| resolve(pixel as u32, params, points, shadings, words, slots));
    radiance
}

/// Renders `frames` frames through the first camera on the CPU, as the command line does.
pub fn render(
    scene: &Scene,
    config: &RenderConfig,
    gather: &str,
    features: Option<Features>,
    threads: usize,
    frames: u32,
) -> Vec<(RenderedImage, Counters)> {
    let variant = <&Variant>::find(gather).expect("a known gather");
    let choice = RunnerChoice::Cpu { threads };
    let features = features.unwrap_or_else(|| scene.features(config.specular_roughness));
    let mut session = Session::new(
        &choice,
        scene,
        &scene.cameras[0],
        &RenderConfig { gather: Some(variant), ..config.clone() },
        features,
    )
    .expect("a session on the CPU opens");
    (0..frames)
        .map(|frame| {
            session.frame(frame).expect("a frame runs");
            (session.image().expect("an image"), session.counters().expect("counters"))
        })
        .collect()
}

/// Mean of the red channel over all pixels of a layer.
pub fn mean_of(layer: &[Vec3]) -> f64 {
    layer.iter().map(|value| f64::from(value.x)).sum::<f64>() / layer.len() as f64
}
