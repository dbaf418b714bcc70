//! Whole paths on the CPU with rays perturbed by a few ulps. Where a perturbed path diverges by itself, it is
//! ill-conditioned, which explains a divergence between two runners.

use std::convert::Infallible;

use crate::collected::{Collected, camera_path};
use caustics::scene::Scene;
use caustics_kernels::emission::{AIMED, Emission, POWER};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::history::VALIDATION_PERIOD;
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight};
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::interface::scene::SceneTables;
use caustics_kernels::light::aimed::Aimed;
use caustics_kernels::light::emit::{EmissionSample, Emit};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::path::PathContext;
use caustics_kernels::path::light_path::trace_light_path;
use caustics_kernels::path::photon_sink::PhotonSink;
use caustics_kernels::platform::Atomics;
use caustics_kernels::trace::Tracer;
use caustics_kernels::trace::bvh::BvhTracer;
use glam::Vec3;

use crate::matching::Photon;

/// Answer of a tracer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The closest triangle and its distance (m).
    Hit(u32, f32),
    /// Whether an occluder is between.
    Occluded(bool),
}

/// Relative size of the perturbation: the difference of two runners after one vertex.
const AMOUNT: f32 = 2.0e-6;
/// Number of perturbed paths that are tried for an explanation.
const TRIES: u32 = 512;

/// Tracer that perturbs rays and records the answers.
struct Trembling<'a> {
    tracer: BvhTracer<'a>,
    rng: Rng,
    amount: f32,
    answers: Vec<Answer>,
}

impl Trembling<'_> {
    fn tremble(&mut self, ray: &Ray) -> Ray {
        let mut noise = || (self.rng.next4().truncate() * 2.0 - Vec3::ONE) * self.amount;
        let origin = ray.origin + ray.origin.abs().max_element() * noise();
        Ray { origin, direction: ray.direction + noise(), ..*ray }
    }
}

impl Tracer for Trembling<'_> {
    fn closest(&mut self, ray: &Ray) -> Hit {
        let ray = self.tremble(ray);
        let hit = self.tracer.closest(&ray);
        self.answers.push(Answer::Hit(hit.triangle, hit.distance));
        hit
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        let ray = self.tremble(ray);
        let occluded = self.tracer.occluded(&ray);
        self.answers.push(Answer::Occluded(occluded));
        occluded
    }
}

/// Counters that ignore additions.
struct Ignore(Option<Infallible>);

impl Atomics for Ignore {
    fn add(&mut self, _index: u32, _value: u32) -> u32 {
        0
    }
}

/// Sink that keeps the photons of a path.
struct Keep(Vec<Photon>);

impl PhotonSink for Keep {
    type PathState = ();

    fn store_photon(&mut self, (): &mut (), geometry: PhotonGeometry, light: PhotonLight) {
        self.0.push((geometry, light));
    }
}

/// Emission of light paths, independent of a runner's buffers.
enum Starts<'a> {
    Power(ByPower<'a>),
    Aimed(Aimed<'a>),
}

impl<'a> Starts<'a> {
    /// Returns none for an emission that is not listed here, such as a new one.
    fn for_emission(emission: &Emission, power: ByPower<'a>) -> Option<Starts<'a>> {
        match emission.name {
            name if name == POWER.name => Some(Starts::Power(power)),
            name if name == AIMED.name => Some(Starts::Aimed(Aimed { power })),
            _ => None,
        }
    }
}

impl Emit for Starts<'_> {
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        match self {
            Starts::Power(power) => power.sample(rng),
            Starts::Aimed(aimed) => aimed.sample(rng),
        }
    }
}

/// The paths of one frame.
#[derive(Clone, Copy)]
pub struct LightPathContext<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Push constants.
    pub params: &'a FrameParams,
    /// Features of the scene.
    pub features: Features,
    /// Emission of light paths; validation paths start by power.
    pub emission: &'static Emission,
}

impl<'a> LightPathContext<'a> {
    fn tables(&self) -> SceneTables<'a> {
        self.scene.tables()
    }

    fn tracer(&self, attempt: u32) -> Trembling<'a> {
        let amount = if attempt == 0 { 0.0 } else { AMOUNT };
        let rng = Rng::new(Stream::Camera, 99, attempt, 0);
        Trembling { tracer: self.scene.tracer(self.features), rng, amount, answers: vec![] }
    }

    /// Traces the camera path of a pixel; attempt 0 is unperturbed.
    fn camera(&self, pixel: u32, attempt: u32) -> (Collected, Vec<Answer>) {
        let mut tracer = self.tracer(attempt);
        let tables = self.tables();
        let collected =
            camera_path(pixel, self.params, self.features, tables, &mut tracer, &mut Ignore(None));
        (collected, tracer.answers)
    }

    /// Traces a light path and returns its photons; attempt 0 is unperturbed.
    fn light(&self, path: u32, attempt: u32) -> (Vec<Photon>, Vec<Answer>) {
        let rng = Rng::new(Stream::Light, self.params.seed, path, self.params.frame);
        self.follow(path, rng, self.emission, attempt)
    }

    /// Traces a validation path and returns its photons.
    fn validation(&self, path: u32, attempt: u32) -> (Vec<Photon>, Vec<Answer>) {
        let round = (self.params.frame + path) / VALIDATION_PERIOD;
        self.follow(path, Rng::new(Stream::Validation, self.params.seed, path, round), &POWER, attempt)
    }

    fn follow(&self, path: u32, rng: Rng, emission: &Emission, attempt: u32) -> (Vec<Photon>, Vec<Answer>) {
        let (mut tracer, mut keep) = (self.tracer(attempt), Keep(vec![]));
        let (params, features, scene) = (self.params, self.features, self.tables());
        let emit =
            Starts::for_emission(emission, ByPower::new(scene, params, features)).expect("a known emission");
        let ignore = &mut Ignore(None);
        let context = PathContext { params, features, scene };
        trace_light_path(path, rng, context, &emit, &mut tracer, &mut keep, ignore);
        (keep.0, tracer.answers)
    }

    /// Whether its light paths can be traced here; otherwise they are only compared.
    pub fn starts_are_known(&self) -> bool {
        Starts::for_emission(self.emission, ByPower::new(self.tables(), self.params, self.features)).is_some()
    }

    /// Photons of every light path, each with the index of its path.
    pub fn photons(&self) -> Vec<(u32, Photon)> {
        let paths = 0..self.params.light_path_batch;
        paths.flat_map(|path| self.light(path, 0).0.into_iter().map(move |photon| (path, photon))).collect()
    }

    /// Explains why the camera path of a pixel may diverge: the first answer that differs in a perturbed path.
    pub fn explain_camera(
        &self,
        pixel: u32,
        differs: impl Fn(&Collected, &Collected) -> bool,
    ) -> Option<String> {
        let (still, answers) = self.camera(pixel, 0);
        (1..TRIES).find_map(|attempt| {
            let (other, trembling) = self.camera(pixel, attempt);
            differs(&still, &other).then(|| first_difference(&answers, &trembling))
        })
    }

    /// Explains why a light path may diverge.
    pub fn explain_light(&self, path: u32, differs: impl Fn(&[Photon], &[Photon]) -> bool) -> Option<String> {
        explain(|attempt| self.light(path, attempt), differs)
    }

    /// Explains why a validation path may diverge.
    pub fn explain_validation(
        &self,
        path: u32,
        differs: impl Fn(&[Photon], &[Photon]) -> bool,
    ) -> Option<String> {
        explain(|attempt| self.validation(path, attempt), differs)
    }
}

/// Perturbs a light path until it diverges, and describes the first difference.
fn explain(
    trace: impl Fn(u32) -> (Vec<Photon>, Vec<Answer>),
    differs: impl Fn(&[Photon], &[Photon]) -> bool,
) -> Option<String> {
    let (still, answers) = trace(0);
    (1..TRIES).find_map(|attempt| {
        let (other, trembling) = trace(attempt);
        differs(&still, &other).then(|| first_difference(&answers, &trembling))
    })
}

/// Describes the first ray with another answer, else the first whose distance moved by more than the perturbation moves
/// it.
fn first_difference(still: &[Answer], trembling: &[Answer]) -> String {
    let find =
        |differ: fn(Answer, Answer) -> bool| still.iter().zip(trembling).position(|(&a, &b)| differ(a, b));
    let is_other = |a, b| match (a, b) {
        (Answer::Hit(a, _), Answer::Hit(b, _)) => a != b,
        (a, b) => a != b,
    };
    let has_moved = |a, b| match (a, b) {
        (Answer::Hit(_, a), Answer::Hit(_, b)) => (a - b).abs() > 4.0 * AMOUNT * a.max(b),
        _ => false,
    };
    let ends = still.len().min(trembling.len());
    let cut = (still.len() != trembling.len()).then_some(ends);
    match find(is_other).or(cut).or_else(|| find(has_moved)) {
        Some(ray) => format!("ray {ray}: {:?} or {:?}", still.get(ray), trembling.get(ray)),
        None => "the same hits, weights amplified".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobes;
    use caustics::render_config::{Paths, RenderConfig};

    #[test]
    fn camera_path_repeats_unperturbed_and_diverges_in_some_perturbed_attempts() {
        let scene = lobes::scene();
        let config = RenderConfig {
            width: 64,
            height: 36,
            light_paths: Paths::Count(1024),
            ..RenderConfig::default()
        };
        let params = config.params(&scene, &scene.cameras[0], 0);
        let paths =
            LightPathContext { scene: &scene, params: &params, features: Features::ALL, emission: &POWER };
        assert_eq!(paths.camera(1000, 0), paths.camera(1000, 0));
        assert!(!paths.photons().is_empty());
        // A comparer that never differs finds no explanation; one that demands equal bits soon does.
        assert_eq!(paths.explain_camera(1000, |_, _| false), None);
        let pixels = (0..64 * 36).step_by(50);
        let found = pixels.filter(|&pixel| {
            paths.explain_camera(pixel, |a, b| a.light.radiance != b.light.radiance).is_some()
        });
        assert!(found.count() > 10);
    }
}
