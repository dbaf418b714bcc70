//! The camera path of a pixel [Moreau and Doggett 2022, section 3.1]. Its prefix of specular events leads from the eye to the
//! collection point. Behind it the camera suffix finds the light that is no caustic.
//!
//! The loop of [`trace_camera_path`] reads in the order in which it runs. Why light samples come before the lobes of a vertex, shadow
//! rays after them, and why there is one exit: see [`scratch`].

mod state;

pub use state::CameraPath;

use super::PathContext;
use super::camera_ray::CameraPathStart;
use super::direct_light::trace_shadow_rays;
use super::observer::PathObserver;
use super::prefix::scatter_prefix;
use super::scratch::light_samples;
use super::scratch::{self, PathScratch, Sum};
use crate::interface::choice::Caustics;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::point::{IndirectSample, PointDirect};
use crate::interface::radiance_cache::CacheSample;
use crate::interface::ray::Ray;
use crate::math::sampler::next4;
use crate::platform::{Atomics, scratch};
use crate::surface::class::Classes;
use crate::surface::media::MediaStack;
use crate::surface::vertex::Vertex;
use crate::trace::Tracer;
use spirv_std::glam::Vec3;

/// Camera suffix: lobes by which a camera path goes on and finds lights behind its collection point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraSuffix {
    /// Lobes that it follows.
    pub follows: Classes,
    /// Lobes by which it finds lights; light paths serve the others.
    pub finds: Classes,
}

impl CameraSuffix {
    /// All lobes: path tracing.
    pub const ALL: CameraSuffix = CameraSuffix { follows: Classes::ALL, finds: Classes::ALL };

    /// No lobes: the path ends at the collection point, and finds no light on its way.
    pub const NOTHING: CameraSuffix = CameraSuffix { follows: Classes::NONE, finds: Classes::NONE };

    /// Lobes that the light paths of a frame leave to the camera.
    #[inline(always)]
    pub fn new(params: &FrameParams) -> CameraSuffix {
        let mut follows = Classes::ALL;
        if params.caustics == Caustics::Any as u32 {
            follows = Classes::NON_SPECULAR;
        }
        CameraSuffix { follows, finds: Classes::NON_SPECULAR }
    }

    /// Whether the path finds any light.
    #[inline(always)]
    fn is_lit(self) -> bool {
        self.finds != Classes::NONE
    }

    /// Whether a collection point at the end of the prefix takes photons, divided by the probability of its class.
    #[inline(always)]
    fn divides(self) -> bool {
        self.finds != Classes::ALL
    }
}

/// Light that a camera path finds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraPathLight {
    /// Radiance that is no caustic (W m^-2 sr^-1).
    pub radiance: Vec3,
    /// Part of the radiance that the non-specular class of the collection point does not reflect (W m^-2 sr^-1). It is light
    /// found before the point, its emission, and direct light on its specular class. This part and those below need
    /// [`Features::PARTS`].
    pub prefix: Vec3,
    /// Direct light that the non-specular class of the point reflects.
    pub direct: PointDirect,
    /// The part of the radiance that was found before the first non-delta bounce (W m^-2 sr^-1).
    pub delta_prefix: Vec3,
    /// Indirect light at the collection point. Needs [`Features::INDIRECT`], and a frame in which points share it.
    pub indirect: IndirectSample,
    /// Sample for the radiance cache. Needs [`Features::INDIRECT`], and a frame that uses one.
    pub cached: CacheSample,
}

/// Traces a camera path from its first ray. Returns its light, and what the observer keeps of it.
#[inline(always)]
pub fn trace_camera_path<T: Tracer, O: PathObserver, C: Atomics>(
    start: CameraPathStart,
    suffix: CameraSuffix,
    context: PathContext<'_>,
    tracer: &mut T,
    observer: &mut O,
    counters: &mut C,
) -> (CameraPathLight, O::Kept) {
    scratch!(sample_words: light_samples::ROOM);
    scratch!(words: scratch::ROOM);
    // Start at the eye
    let mut scratch = PathScratch::new(words, &start, context);
    let mut kept = O::Kept::default();
    let mut path = CameraPath::new(&start, suffix);
    let mut next = Segment::from_eye(start.ray, context, tracer);
    loop {
        // Trace the segment through the media around it
        let mut segment = next;
        next = Segment::NONE;
        let traced = path.trace_segment(&mut segment, context, tracer, counters);
        if traced.hit.is_miss() {
            // Add the emission of the environment
            observer.escape(&segment.ray, segment.throughput);
            path.add_environment(&segment, &traced, context, &mut scratch);
            path.end_without_point(segment.from, observer, &mut kept);
        } else {
            // Add the emission of the surface, by MIS
            let mut arrival = path.arrive(&segment, &traced, context, &mut scratch);
            observer.arrive(&segment.ray, &traced.hit, &arrival.vertex, arrival.throughput);
            path.add_emission(&segment, &arrival, traced.hit.distance, context, &mut scratch);
            // End in the radiance cache, or start a sample for it
            let distance = traced.hit.distance;
            let ends =
                path.ends_in_cache(&segment, &arrival, distance, context, observer, &mut scratch, counters);
            // Process a thin wall behind the last vertex, too: the path may pass it to a light
            let can_pass = context.can_pass(&arrival.vertex, path.passed_walls);
            if !ends && (path.depth <= context.params.max_bounces || can_pass) {
                // Sample direct light by MIS; its shadow rays are traced below
                let (scattering, shadow_rays) =
                    path.sample_lights(&mut arrival, context, sample_words, &mut scratch);

                // Sample the BSDF; the first non-specular event ends the prefix at the collection point
                let (was_prefix, was_delta_prefix) = (path.in_prefix, path.in_delta_prefix);
                let left = path.scatterings_left(path.depth, context);
                let u = next4(&mut path.rng, &context.params.sequence);
                let scattered = scattering.sample(u);
                if scattering.bsdf.scatters() {
                    observer.scatter(&scattered);
                }
                path.end_prefix(
                    &scattered,
                    &scattering,
                    &arrival,
                    context,
                    &mut scratch,
                    observer,
                    &mut kept,
                );

                // Terminate the path by Russian roulette, or find its next segment
                path.roulette(&scattered, &mut arrival.throughput, was_prefix, u.w);
                if path.in_prefix {
                    scatter_prefix(&traced.hit, &arrival.vertex, &scattered, context, &mut scratch);
                }
                next = if can_pass && scattered.sampled.straight {
                    path.pass_wall(&segment, &arrival, &scattered, traced.hit.distance)
                } else {
                    path.leave(&arrival, &scattered, was_prefix, context, counters)
                };

                // Trace the shadow rays
                trace_shadow_rays(shadow_rays, was_prefix, left, context, tracer, &mut scratch);
                path.shadow_rays += shadow_rays;
                if was_delta_prefix && context.features.has(Features::PARTS) {
                    scratch.set(Sum::DeltaPrefix, scratch.sum(Sum::Radiance));
                }
            }
            if !next.exists {
                path.end_without_point(arrival.vertex.position, observer, &mut kept);
            }
        }
        if !next.exists {
            break;
        }
    }
    (path.finish(context.features, &scratch, counters), kept)
}

/// A segment of a camera path.
#[derive(Clone, Copy)]
pub struct Segment {
    /// Whether the segment exists; none follows the last one.
    exists: bool,
    ray: Ray,
    /// Vertex that it left, or the eye (m).
    from: Vec3,
    /// Whether that vertex ends a prefix or lies in it.
    from_prefix: bool,
    media: MediaStack,
    throughput: Vec3,
    /// Density of its direction (1/sr); 0 for a delta lobe.
    pdf_solid_angle: f32,
    /// Whether the path adds emission that the segment meets; light paths serve it otherwise.
    finds_emission: bool,
    /// Distance from the vertex that it left, through thin walls, to the start of its ray (m).
    passed: f32,
}

impl Segment {
    const NONE: Segment = Segment {
        exists: false,
        ray: Ray { origin: Vec3::ZERO, length: 0.0, direction: Vec3::ZERO, key: 0 },
        from: Vec3::ZERO,
        from_prefix: false,
        media: MediaStack::VACUUM,
        throughput: Vec3::ZERO,
        pdf_solid_angle: 0.0,
        finds_emission: false,
        passed: 0.0,
    };

    /// The first segment.
    #[inline(always)]
    fn from_eye<T: Tracer>(ray: Ray, context: PathContext<'_>, tracer: &mut T) -> Segment {
        let media = context.initial_media(ray.origin, tracer);
        Segment {
            exists: true,
            ray,
            from: ray.origin,
            media,
            throughput: Vec3::ONE,
            // Emission that the eye sees is not indirect light of the point.
            from_prefix: true,
            finds_emission: true,
            ..Segment::NONE
        }
    }
}

/// A vertex that a camera path arrives at.
#[derive(Clone, Copy)]
pub struct Arrival {
    /// The vertex.
    pub vertex: Vertex,
    /// Its material.
    pub material: Material,
    /// The media on the side of the path.
    pub media: MediaStack,
    /// Throughput from the eye to the vertex.
    pub throughput: Vec3,
}
