//! Camera paths and light paths: the two loops of the algorithm. Passes say which paths are traced and what becomes of them. Imports
//! `interface`, `platform`, `math`, `texture`, `trace`, `surface` and `light`.
//!
//! | step | function |
//! |---|---|
//! | start of a light path | [`Emit::sample`](crate::light::emit::Emit::sample) |
//! | camera path, its loop | [`camera_path::trace_camera_path`] |
//! | light path, its loop | [`light_path::trace_light_path`] |
//! | absorption, surfaces that a medium covers | [`trace_through_media`] |
//! | thin walls that light passes | [`thin_wall`](crate::surface::thin_wall) |
//! | emitted light that a camera path meets, by MIS | [`emission::surface_emission`], [`emission::environment_radiance`] |
//! | light sampling (NEE) by MIS, shadow rays | [`direct_light::choose_light_samples`], [`direct_light::trace_shadow_rays`] |
//! | end of the prefix, collection point | [`prefix::collection_point`] |
//! | Russian roulette | [`camera_path::CameraPath::roulette`], [`light_path::survival_probability`] |
//! | photon stored | [`photon_sink::PhotonSink::store_photon`] |
//! | contribution of a photon to a collection point | [`Receiver::contribution`](crate::gather::contribution::Receiver::contribution) |
//! | memory and registers of a GPU | [`scratch`] |

pub mod camera_pass;
pub mod camera_path;
pub mod camera_ray;
pub mod direct_light;
pub mod emission;
pub mod ledger;
pub mod light_numbers;
pub mod light_path;
pub mod observer;
pub mod photon_sink;
pub mod prefix;
pub mod radiance_cache;
pub mod scratch;

use crate::interface::counters::Counter;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::math::rng::Rng;
use crate::platform::Atomics;
use crate::surface::media::MediaStack;
use crate::surface::thin_wall::{MAX_PASSED, is_passed};
use crate::surface::vertex::Vertex;
use crate::trace::Tracer;
use crate::trace::initial_media::initial_media_stack;
use crate::trace::through_media::{TracedSegment, trace_through_media};
use spirv_std::glam::Vec3;

/// The scene and the settings in which paths are traced.
#[derive(Clone, Copy)]
pub struct PathContext<'a> {
    /// Settings of the frame.
    pub params: &'a FrameParams,
    /// Code that is compiled in.
    pub features: Features,
    /// Tables of the scene.
    pub scene: SceneTables<'a>,
}

impl PathContext<'_> {
    /// Media around the origin of a path.
    #[inline(always)]
    fn initial_media<T: Tracer>(self, origin: Vec3, tracer: &mut T) -> MediaStack {
        let mut media = MediaStack::VACUUM;
        if self.features.has(Features::STARTS_IN_MEDIUM) {
            media = initial_media_stack(origin, self.features, self.scene, tracer);
        }
        media
    }

    /// Traces a segment through the media around it, up to the first surface that no medium covers.
    #[inline(always)]
    fn trace_segment<T: Tracer>(
        self,
        ray: &mut Ray,
        media: MediaStack,
        rng: &Rng,
        tracer: &mut T,
    ) -> TracedSegment {
        if self.features.has(Features::BLENDS) {
            ray.key = rng.ray_key(0);
        }
        trace_through_media(ray, media, self.features, self.scene, tracer)
    }

    /// Whether a path that has passed this number of walls can pass another at a vertex, without a scattering event.
    #[inline(always)]
    fn can_pass(self, vertex: &Vertex, passed: u32) -> bool {
        let material = &self.scene.materials[vertex.material as usize];
        is_passed(material, self.params, self.features) && passed < MAX_PASSED
    }
}

/// Adds to a counter that is rarely above 0: an atomic addition costs more than the test.
#[inline(always)]
fn count_rare<C: Atomics>(counter: Counter, count: u32, counters: &mut C) {
    if count != 0 {
        counters.add(counter as u32, count);
    }
}
