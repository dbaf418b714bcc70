//! Photon sinks, which receive the photons of light paths.

use crate::interface::counters::{Counter, PhotonState};
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::point::{PhotonGeometry, PhotonLight};
use crate::interface::ray::{Hit, Ray};
use crate::light::emit::EmissionSample;
use crate::light::light_pyramid::{GuidedStart, LightPyramid};
use crate::platform::{AtomicWords, Atomics, Slots};
use crate::surface::scatter::BsdfSample;
use crate::surface::vertex::Vertex;
use spirv_std::glam::Vec3;

/// Sink of the photons of a light path. It may observe the path; methods that it leaves empty cost nothing.
pub trait PhotonSink {
    /// State of a path, which changes along it. On a GPU a sink holds buffers and does not change: a compiler there may crash on
    /// buffers that a loop carries.
    type PathState: Copy + Default;

    /// A path starts.
    #[inline(always)]
    fn start(&mut self, _path_state: &mut Self::PathState, _emission: &EmissionSample) {}
    /// The path meets a surface, before it deposits there.
    #[inline(always)]
    fn arrive(&mut self, _path_state: &mut Self::PathState, _ray: &Ray, _hit: &Hit, _here: &Vertex) {}
    /// The path leaves a surface with this flux (W).
    #[inline(always)]
    fn scatter(&mut self, _path_state: &mut Self::PathState, _departure: &BsdfSample, _flux: Vec3) {}
    /// Stores one photon.
    fn store_photon(
        &mut self,
        path_state: &mut Self::PathState,
        geometry: PhotonGeometry,
        light: PhotonLight,
    );
}

/// Stores photons for a gather.
pub struct PhotonStore<'a> {
    /// Slots of `photon_geometry`.
    pub geometry: Slots<'a, PhotonGeometry>,
    /// Slots of `photon_light`.
    pub light: Slots<'a, PhotonLight>,
    /// `photon_state`.
    pub state: AtomicWords<'a>,
    /// `start_counts`: number of paths that started from each texel, and from each leaf of the light pyramids; empty unless the
    /// emission learns.
    pub starts: AtomicWords<'a>,
    /// The settings of the frame.
    pub params: &'a FrameParams,
    /// Code that is compiled in.
    pub features: Features,
}

impl PhotonStore<'_> {
    /// Counts the photons of a path that found no slot.
    #[inline(always)]
    pub fn close<C: Atomics>(&self, dropped: u32, counters: &mut C) {
        if dropped != 0 {
            counters.add(Counter::PhotonsDropped as u32, dropped);
        }
    }
}

impl PhotonSink for PhotonStore<'_> {
    /// Number of photons of the path that found no slot.
    type PathState = u32;

    #[inline(always)]
    fn start(&mut self, _dropped: &mut u32, emission: &EmissionSample) {
        if emission.score > 0.0 {
            let start = GuidedStart::decode(emission.start_code, self.params, self.features);
            self.starts.add(start.texel, 1);
            if LightPyramid::is_used(self.params, self.features) {
                self.starts.add(start.leaf_word(self.params), 1);
            }
        }
    }

    #[inline(always)]
    fn store_photon(&mut self, dropped: &mut u32, geometry: PhotonGeometry, light: PhotonLight) {
        let slot = self.state.add(PhotonState::Stored as u32, 1);
        if slot < self.params.photon_capacity {
            self.geometry.write(slot, geometry);
            self.light.write(slot, light);
        } else {
            *dropped += 1;
        }
    }
}
