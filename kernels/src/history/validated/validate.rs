//! `validate`: traces a few light paths that keep their random numbers from frame to frame, and marks where their photons
//! changed. If nothing moves in a scene, nothing changes, to the bit. If only the number of light paths changes, fluxes change by
//! rounding.
//!
//! A path keeps its numbers for eight frames, and paths take turns in sampling new ones; in that frame a path only stores its
//! photons. All marks are made at positions in the previous frame. The paths start by power, whatever emission the frame has. An
//! emission that learns would start them elsewhere in the next frame, and their light would seem to have moved.

use crate::declare::pass;
use crate::history::cells::{self, LightFrame, MAX_STEP, Mark, direct_radius, mark};
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::{VALIDATION_CELLS, VALIDATION_PERIOD, VALIDATION_PHOTONS, ValidationPhoton};
use crate::interface::instance::Instance;
use crate::interface::point::{PhotonGeometry, PhotonLight};
use crate::interface::scene::SceneTables;
use crate::light::power::ByPower;
use crate::math::rng::{Rng, Stream};
use crate::path::PathContext;
use crate::path::light_path::trace_light_path;
use crate::path::photon_sink::PhotonSink;
use crate::platform::{AtomicWords, Slots, Uncounted};
use crate::trace::Tracer;
use spirv_std::glam::Vec3;

/// Traces validation paths, one an invocation.
#[pass(name = "validate", over = params.validation_path_count, work = Reuse, shared_entry)]
pub fn validate(
    path: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    instances: &[Instance],
    #[len = params.validation_path_count * VALIDATION_PHOTONS] validation_photons: Slots<
        '_,
        ValidationPhoton,
    >,
    #[len = cells::WORDS * VALIDATION_CELLS] validation_cells: AtomicWords<'_>,
) {
    let mut compare = Compare::new(path, params, instances, validation_photons, validation_cells);
    let emit = ByPower::new(scene, params, features);
    let (rng, features) = (compare.rng(), uncounted(features));
    let context = PathContext { params, features, scene };
    let count = trace_light_path(path, rng, context, &emit, tracer, &mut compare, &mut Uncounted);
    compare.close(count);
}

/// Features that the scene needs, for paths without a ledger.
#[inline(always)]
pub fn uncounted(features: Features) -> Features {
    Features(features.0 & !Features::LEDGER.0)
}

/// Compares photons with those of the previous frame, and stores them in their slots.
pub struct Compare<'a> {
    path: u32,
    params: &'a FrameParams,
    instances: &'a [Instance],
    photons: Slots<'a, ValidationPhoton>,
    cells: AtomicWords<'a>,
}

impl<'a> Compare<'a> {
    /// Comparison for a validation path.
    #[inline(always)]
    pub fn new(
        path: u32,
        params: &'a FrameParams,
        instances: &'a [Instance],
        photons: Slots<'a, ValidationPhoton>,
        cells: AtomicWords<'a>,
    ) -> Self {
        Compare { path, params, instances, photons, cells }
    }

    /// Number of the frame, counted from the one in which the path samples new numbers.
    #[inline(always)]
    fn turn(&self) -> u32 {
        self.params.frame.wrapping_add(self.path)
    }

    /// Random numbers of the path.
    #[inline(always)]
    pub fn rng(&self) -> Rng {
        Rng::new(Stream::Validation, self.params.seed, self.path, self.turn() / VALIDATION_PERIOD)
    }

    #[inline(always)]
    fn compares(&self) -> bool {
        !self.turn().is_multiple_of(VALIDATION_PERIOD)
    }

    /// Slot of a photon.
    #[inline(always)]
    fn slot(&self, photon: u32) -> u32 {
        self.path * VALIDATION_PHOTONS + photon
    }
}

impl PhotonSink for Compare<'_> {
    /// Photons of the path so far.
    type PathState = u32;

    #[inline(always)]
    fn store_photon(&mut self, count: &mut u32, geometry: PhotonGeometry, light: PhotonLight) {
        if *count >= VALIDATION_PHOTONS {
            return;
        }
        let slot = self.slot(*count);
        let now = ValidationPhoton {
            position: geometry.position,
            // The number of light paths may differ between frames.
            flux: light.flux.element_sum() * self.params.light_path_count as f32,
            instance: geometry.instance,
        };
        let before = self.photons.read(slot);
        if self.compares() {
            let mut frame = 0;
            while frame < LightFrame::count(before.instance | now.instance) {
                let mut position = now.position;
                if frame == 0 {
                    // Previous position of this point of the surface.
                    position = self.instances[now.instance as usize].to_previous.point(now.position);
                }
                self.compare(&before, &now, frame, position);
                frame += 1;
            }
        }
        self.photons.write(slot, now);
        *count += 1;
    }
}

impl Compare<'_> {
    /// Marks a photon and its successor at `position`, in one of their frames of reference.
    #[inline(always)]
    fn compare(&mut self, before: &ValidationPhoton, now: &ValidationPhoton, frame: u32, position: Vec3) {
        let mut moved = MAX_STEP;
        if before.flux > 0.0 && before.instance == now.instance {
            moved = (position - before.position).length() / direct_radius(position, self.params);
        }
        let (before, now) = (self.mark(before, before.position, frame), self.mark(now, position, frame));
        mark(&mut self.cells, before, now, moved, self.params);
    }

    #[inline(always)]
    fn mark(&self, photon: &ValidationPhoton, position: Vec3, frame: u32) -> Mark {
        let flux = photon.flux / self.params.light_path_count as f32;
        Mark { position, carrier: LightFrame::new(photon.instance, frame), flux }
    }

    /// Marks and clears the photons that did not come again.
    #[inline(always)]
    pub fn close(&mut self, mut count: u32) {
        while count < VALIDATION_PHOTONS {
            let slot = self.slot(count);
            let before = self.photons.read(slot);
            if self.compares() && before.flux > 0.0 {
                let mut frame = 0;
                while frame < LightFrame::count(before.instance) {
                    let before = self.mark(&before, before.position, frame);
                    let gone = Mark { flux: 0.0, ..before };
                    mark(&mut self.cells, before, gone, MAX_STEP, self.params);
                    frame += 1;
                }
            }
            self.photons.write(slot, ValidationPhoton::default());
            count += 1;
        }
    }
}
