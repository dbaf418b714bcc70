//! The energy ledger of one light path. In expectation over paths, emitted = absorbed + escaped + cut + lost at shading normals +
//! left to the camera. Absorption is estimated by an albedo of its own, not by the weight of the sampled continuation.

use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::ledger::{Entry, slot};
use crate::math::quanta::Quanta;
use crate::math::rng::{Rng, Stream};
use crate::platform::Atomics;
use crate::surface::class::Classes;
use crate::surface::scatter::{BsdfSample, ScatteringVertex};
use spirv_std::glam::Vec3;

/// Where the flux of one path went, summed over channels (W).
#[derive(Clone, Copy, Debug)]
pub struct Ledger {
    asked: bool,
    rng: Rng,
    emitted: f32,
    absorbed: f32,
    escaped: f32,
    cut: f32,
    shading_normals: f32,
    left_to_camera: f32,
}

impl Ledger {
    /// Ledger of light path `path`; without `Features::LEDGER` it does nothing.
    #[inline(always)]
    pub fn new(params: &FrameParams, path: u32, features: Features) -> Self {
        Ledger {
            asked: features.has(Features::LEDGER),
            rng: Rng::new(Stream::Ledger, params.seed, path, params.frame),
            emitted: 0.0,
            absorbed: 0.0,
            escaped: 0.0,
            cut: 0.0,
            shading_normals: 0.0,
            left_to_camera: 0.0,
        }
    }

    /// Adds flux that leaves the light.
    #[inline(always)]
    pub fn emit(&mut self, flux: Vec3) {
        self.emitted += flux.element_sum();
    }

    /// Adds flux that meets nothing.
    #[inline(always)]
    pub fn escape(&mut self, flux: Vec3) {
        self.escaped += flux.element_sum();
    }

    /// Adds flux of a path that is cut by its length.
    #[inline(always)]
    pub fn cut(&mut self, flux: Vec3) {
        self.cut += flux.element_sum();
    }

    /// Adds flux that a medium absorbs.
    #[inline(always)]
    pub fn pass(&mut self, before: Vec3, after: Vec3) {
        self.absorbed += (before - after).element_sum();
    }

    /// Splits flux that arrives at a surface: adds the absorbed flux, and the flux of lobes outside of `followed`, which is left
    /// to the camera.
    #[inline(always)]
    pub fn arrive(&mut self, scattering: &ScatteringVertex, followed: Classes, flux: Vec3) {
        if self.asked {
            let u = self.rng.next4();
            let albedo = scattering.bsdf.albedo(Classes::ALL, u);
            self.absorbed += (flux * (Vec3::ONE - albedo)).element_sum();
            self.left_to_camera += (flux * (albedo - scattering.bsdf.albedo(followed, u))).element_sum();
        }
    }

    /// Adds the flux that the correction for shading normals takes at a surface.
    #[inline(always)]
    pub fn leave(&mut self, scattered: &BsdfSample, arriving: Vec3, leaving: Vec3) {
        if self.asked {
            let scattered = arriving * scattered.sampled.weight;
            self.shading_normals += (scattered - leaving).element_sum();
        }
    }

    /// Adds the path to the ledger of the frame.
    #[inline(always)]
    pub fn close<C: Atomics>(self, path: u32, inverse_quantum: f32, counters: &mut C) {
        if self.asked {
            let mut add = |entry, flux| {
                Quanta::from_signed(flux, inverse_quantum).add_to(counters, slot(entry, path));
            };
            add(Entry::Emitted, self.emitted);
            add(Entry::Absorbed, self.absorbed);
            add(Entry::Escaped, self.escaped);
            add(Entry::Cut, self.cut);
            add(Entry::ShadingNormals, self.shading_normals);
            add(Entry::LeftToCamera, self.left_to_camera);
        }
    }
}
