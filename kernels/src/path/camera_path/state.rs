//! State of a camera path that outlives a vertex, and the steps that change it, in the order in which the loop calls them.

use super::{Arrival, CameraPathLight, CameraSuffix, Segment};
use crate::interface::counters::Counter;
use crate::interface::features::Features;
use crate::interface::point::SHARED_DEPTHS;
use crate::light::light_sampling::LightCandidates;
use crate::math::cone::RayCone;
use crate::math::rng::Rng;
use crate::math::sampler::next4;
use crate::math::{clamp, is_finite};
use crate::path::camera_ray::CameraPathStart;
use crate::path::direct_light::choose_light_samples;
use crate::path::emission::{environment_radiance, is_emitter, surface_emission};
use crate::path::light_numbers::LightNumbers;
use crate::path::observer::PathObserver;
use crate::path::prefix::{
    advance_prefix, collection_point, demodulation, inverse_if_all_channels, radius_without_rough_lobes,
};
use crate::path::radiance_cache::{Cube, albedo, cube_around, is_diffuse};
use crate::path::scratch::light_samples::{self, LightSamples};
use crate::path::scratch::{PathScratch, Sum};
use crate::path::{PathContext, count_rare};
use crate::platform::Atomics;
use crate::surface::class::Classes;
use crate::surface::dispersion::{Channel, is_mixed, needs_channel, part};
use crate::surface::may_have_non_delta_lobe;
use crate::surface::scatter::{BsdfSample, ScatteringVertex};
use crate::surface::textured::material_at;
use crate::surface::vertex::{Vertex, vertex};
use crate::trace::Tracer;
use crate::trace::through_media::TracedSegment;
use spirv_std::glam::Vec3;

/// Share of the throughput at the collection point above which Russian roulette ends no path.
const SURE: f32 = 0.5;

/// Numbers of the keys that round samples of light, and that decide which paths go on behind a known cell of the cache. No ray has
/// them.
const ROUNDING: u32 = 0x8000;
const FILLING: u32 = 0x8001;
/// Smallest share of paths that go on behind a known cell and give it another sample.
const MIN_FILLING: f32 = 1.0 / 32.0;
/// Number of samples of a cell over that share, while the cell has few of them.
const SAMPLES_FILLING: f32 = 4.0;
/// Smallest length of a segment that ends in a cell (edges of the cell). Close by, the blur of a cell would be seen.
const MIN_EDGES: f32 = 4.0;

/// State of a camera path that outlives a vertex.
#[derive(Clone, Copy)]
pub struct CameraPath {
    /// Its random numbers.
    pub rng: Rng,
    /// Lobes behind the collection point.
    suffix: CameraSuffix,
    /// Cone of a pixel at the eye.
    eye_cone: RayCone,
    /// Number of the segment, from 1, and of the vertex that it finds.
    pub depth: u32,
    /// Whether the path was scattered by specular lobes alone.
    pub in_prefix: bool,
    /// Whether it was scattered by delta lobes alone.
    pub in_delta_prefix: bool,
    /// Largest channel of the throughput that left the collection point.
    throughput_from_point: f32,
    /// Whether it met a surface of the radiance cache behind the collection point.
    met_cache: bool,
    /// Number of thin walls that the path passed; they count in no depth.
    pub passed_walls: u32,
    /// Number of shadow rays.
    pub shadow_rays: u32,
}

impl CameraPath {
    /// Path that has not left the eye.
    #[inline(always)]
    pub fn new(start: &CameraPathStart, suffix: CameraSuffix) -> CameraPath {
        CameraPath {
            rng: start.rng,
            suffix,
            eye_cone: start.cone,
            depth: 1,
            in_prefix: true,
            in_delta_prefix: true,
            throughput_from_point: 0.0,
            met_cache: false,
            passed_walls: 0,
            shadow_rays: 0,
        }
    }

    /// Traces a segment through the media around it. Counts rare events at once, see `path::scratch`.
    #[inline(always)]
    pub fn trace_segment<T: Tracer, C: Atomics>(
        &self,
        segment: &mut Segment,
        context: PathContext<'_>,
        tracer: &mut T,
        counters: &mut C,
    ) -> TracedSegment {
        let traced = context.trace_segment(&mut segment.ray, segment.media, &self.rng, tracer);
        count_rare(Counter::MediaOverflow, traced.overflows, counters);
        count_rare(Counter::UnexpectedFaces, traced.unexpected, counters);
        traced
    }

    /// Adds the background, and by MIS the emission of the environment, where a ray leaves the scene.
    #[inline(always)]
    pub fn add_environment(
        &self,
        segment: &Segment,
        traced: &TracedSegment,
        context: PathContext<'_>,
        scratch: &mut PathScratch<'_>,
    ) {
        let features = context.features;
        if self.in_prefix {
            scratch.add(Sum::Radiance, segment.throughput * context.params.background);
        }
        if features.has(Features::ENVIRONMENT) && segment.finds_emission {
            let candidates = candidates(segment.from_prefix, context);
            let mut radiance =
                environment_radiance(&segment.ray, segment.pdf_solid_angle, candidates, context);
            if features.has(Features::ABSORPTION) {
                radiance *= traced.transmittance;
            }
            self.add_emitted(segment.throughput * radiance, segment, context, scratch);
        }
    }

    /// Finds the vertex at the end of a segment, its material, and the throughput behind the media.
    #[inline(always)]
    pub fn arrive(
        &self,
        segment: &Segment,
        traced: &TracedSegment,
        context: PathContext<'_>,
        scratch: &mut PathScratch<'_>,
    ) -> Arrival {
        let PathContext { features, scene, .. } = context;
        let mut texture_width = 0.0;
        if self.in_prefix {
            texture_width = advance_prefix(traced.hit.distance, context, scratch);
        } else if segment.from_prefix && scratch.keeps_indirect() {
            // This segment left the collection point
            scratch.set_proximity(1.0 / (segment.passed + traced.hit.distance));
        }
        let vertex = vertex(scene, features, &segment.ray, &traced.hit, texture_width);
        let material = material_at(scene, &vertex, features);
        let mut throughput = segment.throughput;
        if features.has(Features::ABSORPTION) {
            throughput *= traced.transmittance;
        }
        Arrival { vertex, material, media: traced.media, throughput }
    }

    /// Adds the emission of a surface, by MIS.
    #[inline(always)]
    pub fn add_emission(
        &self,
        segment: &Segment,
        arrival: &Arrival,
        distance: f32,
        context: PathContext<'_>,
        scratch: &mut PathScratch<'_>,
    ) {
        if is_emitter(arrival, context.features) && segment.finds_emission {
            let candidates = candidates(segment.from_prefix, context);
            let emission = surface_emission(
                arrival,
                segment.from,
                segment.passed + distance,
                segment.pdf_solid_angle,
                candidates,
                context,
            );
            self.add_emitted(emission, segment, context, scratch);
        }
    }

    /// Ends the path at the first diffuse surface behind the collection point, if the radiance cache knows it, and adds the light of its
    /// cell. Some paths go on all the same, and give the cell a sample.
    #[inline(always)]
    pub fn ends_in_cache<O: PathObserver, C: Atomics>(
        &mut self,
        segment: &Segment,
        arrival: &Arrival,
        distance: f32,
        context: PathContext<'_>,
        observer: &O,
        scratch: &mut PathScratch<'_>,
        counters: &mut C,
    ) -> bool {
        let PathContext { params, features, .. } = context;
        let mut ends = false;
        if features.has(Features::INDIRECT)
            && params.uses_cache()
            && !self.in_prefix
            && !self.met_cache
            && self.depth <= params.max_bounces
            && is_diffuse(&arrival.material)
        {
            self.met_cache = true;
            let color = arrival.throughput * albedo(&arrival.material);
            let Vertex { position, face_normal, material, .. } = arrival.vertex;
            let Cube { key, edge } = cube_around(position, face_normal, material, self.depth, params);
            let cell = observer.cached(&key);
            let is_far = segment.passed + distance > MIN_EDGES * edge;
            if is_far
                && cell.is_known()
                && self.rng.ray_key(FILLING) > filling_share(cell.count, params.cache_share)
            {
                ends = true;
                counters.add(Counter::CacheEnds as u32, 1);
                self.add_cached(color / cell.count, &cell.light, scratch);
            } else if is_far {
                scratch.start_cache_sample(&key, inverse_if_all_channels(color));
            }
        }
        ends
    }

    /// Adds the light of a cell. Each of its values leaves out light of more scatterings than the one before.
    #[inline(always)]
    fn add_cached(&self, factor: Vec3, light: &[Vec3; SHARED_DEPTHS], scratch: &mut PathScratch<'_>) {
        scratch.add(Sum::Radiance, factor * light[0]);
        let mut left = 0;
        while left < SHARED_DEPTHS {
            let mut part = light[left];
            if left + 1 < SHARED_DEPTHS {
                part = (part - light[left + 1]).max(Vec3::ZERO);
            }
            scratch.add_indirect(left as u32, factor * part);
            left += 1;
        }
    }

    /// Adds emission that a segment met. It is direct light of the vertex that the segment left.
    #[inline(always)]
    fn add_emitted(
        &self,
        emission: Vec3,
        segment: &Segment,
        context: PathContext<'_>,
        scratch: &mut PathScratch<'_>,
    ) {
        scratch.add(Sum::Radiance, emission);
        if !segment.from_prefix {
            scratch.add_indirect(self.scatterings_left(self.depth - 1, context), emission);
        }
    }

    /// Number of scatterings that light of this number of scatterings leaves.
    #[inline(always)]
    pub fn scatterings_left(&self, scatterings: u32, context: PathContext<'_>) -> u32 {
        // Behind the last vertex a path may still pass thin walls.
        context.params.max_bounces - scatterings.min(context.params.max_bounces)
    }

    /// Lobes by which the path goes on and finds lights: all of them in the prefix, those of the suffix behind it.
    #[inline(always)]
    fn lobes(&self) -> CameraSuffix {
        let mut lobes = CameraSuffix::ALL;
        if !self.in_prefix {
            lobes = self.suffix;
        }
        lobes
    }

    /// Chooses the one channel that goes on where a medium disperses.
    #[inline(always)]
    fn choose_channel(&mut self, arrival: &mut Arrival, context: PathContext<'_>) -> Channel {
        let mut channel = Channel::GREEN;
        let materials = context.scene.materials;
        if needs_channel(&arrival.vertex, &arrival.material, materials, arrival.media, context.features) {
            let mixed = is_mixed(arrival.throughput);
            let u = if mixed { next4(&mut self.rng, &context.params.sequence).x } else { 0.0 };
            (channel, arrival.throughput) = part(arrival.throughput, u);
        }
        channel
    }

    /// Random numbers of the light samples of a vertex, with their count.
    #[inline(always)]
    fn sample_numbers(&mut self, arrival: &Arrival, context: PathContext<'_>) -> LightNumbers {
        let sequence = &context.params.sequence;
        let candidates = candidates(self.in_prefix, context);
        let u = next4(&mut self.rng, sequence);
        let mut choice = 0.0;
        if candidates.candidate_count > 1 {
            choice = next4(&mut self.rng, sequence).x;
        }
        let mut count = 0;
        let scatters =
            !context.features.has(Features::THIN_WALLS) || self.depth <= context.params.max_bounces;
        if scatters && self.suffix.is_lit() && may_have_non_delta_lobe(&arrival.material, context.features) {
            count = candidates.sample_count * candidates.candidate_count;
        }
        LightNumbers { candidates, count, u, choice }
    }

    /// BSDF of a vertex, and the media on both of its sides.
    #[inline(always)]
    fn scattering(
        &self,
        arrival: &Arrival,
        channel: Channel,
        lobes: CameraSuffix,
        context: PathContext<'_>,
    ) -> ScatteringVertex {
        ScatteringVertex::new(
            arrival.vertex,
            arrival.material,
            context.scene.materials,
            arrival.media,
            arrival.throughput,
            channel,
            lobes.follows,
            self.in_prefix && self.suffix.divides(),
            context.params.specular_roughness,
            context.features,
        )
    }

    /// Samples positions on lights, makes the BSDF of the vertex, and weighs the samples by it. Returns the BSDF, and the number
    /// of shadow rays in the scratch.
    #[inline(always)]
    pub fn sample_lights(
        &mut self,
        arrival: &mut Arrival,
        context: PathContext<'_>,
        sample_words: &mut [u32; light_samples::ROOM],
        scratch: &mut PathScratch<'_>,
    ) -> (ScatteringVertex, u32) {
        // Choose the lobes, and one channel where a medium disperses
        let lobes = self.lobes();
        let channel = self.choose_channel(arrival, context);
        let numbers = self.sample_numbers(arrival, context);

        // Sample positions on the lights
        let mut samples = LightSamples::new(&numbers, arrival.vertex.position, context, sample_words);

        // Make the BSDF
        let scattering = self.scattering(arrival, channel, lobes, context);
        if context.features.has(Features::PARTS) && self.in_prefix {
            // Restart the parts: a collection point here reflects nothing that was found before
            scratch.set(Sum::Prefix, scratch.sum(Sum::Radiance));
            scratch.set(Sum::Direct, Vec3::ZERO);
        }

        // Weigh the light samples by BSDF and MIS, and store their shadow rays
        let shadow_rays = choose_light_samples(
            &scattering,
            arrival.throughput,
            &numbers,
            &mut samples,
            lobes.finds,
            &self.rng,
            context.features,
            scratch,
        );
        (scattering, shadow_rays)
    }

    /// Ends the prefix where the first non-specular lobe was sampled, and makes the collection point there.
    #[inline(always)]
    pub fn end_prefix<O: PathObserver>(
        &mut self,
        scattered: &BsdfSample,
        scattering: &ScatteringVertex,
        arrival: &Arrival,
        context: PathContext<'_>,
        scratch: &mut PathScratch<'_>,
        observer: &mut O,
        kept: &mut O::Kept,
    ) {
        if self.in_prefix && scattered.sampled.class == Classes::NON_SPECULAR {
            self.in_prefix = false;
            let class_probability = scattering.bsdf.class_probability(Classes::NON_SPECULAR);
            if self.depth < context.params.max_bounces && class_probability > 0.0 {
                if context.features.has(Features::PARTS) {
                    scratch.set_class_probability(class_probability);
                }
                let (depth, eta) = (self.depth, scattering.bsdf.eta);
                let point =
                    collection_point(arrival, depth, class_probability, eta, self.eye_cone, context, scratch);
                if scratch.keeps_indirect() {
                    let diffuse = scattering.bsdf.diffuse_probability() / class_probability;
                    let carried = point.shading.throughput;
                    let factor = demodulation(carried, &scattered.sampled, &arrival.material, diffuse);
                    let radius = radius_without_rough_lobes(arrival, self.eye_cone, context, scratch);
                    scratch.set_demodulation(factor, radius);
                }
                observer.collect(kept, &point);
            } else {
                observer.end(kept, arrival.vertex.position);
            }
        }
    }

    /// Multiplies the throughput by f cos / pdf, and terminates the path by Russian roulette at non-specular events. The path
    /// survives with the probability min(1, throughput / (`SURE` times the throughput that left the collection point)).
    #[inline(always)]
    pub fn roulette(&mut self, scattered: &BsdfSample, throughput: &mut Vec3, was_prefix: bool, u: f32) {
        *throughput *= scattered.sampled.weight;
        if scattered.sampled.class == Classes::NON_SPECULAR {
            let carried = throughput.max_element();
            if was_prefix {
                self.throughput_from_point = carried;
            }
            let survival = (carried / (SURE * self.throughput_from_point)).min(1.0);
            *throughput = if u < survival { *throughput / survival } else { Vec3::ZERO };
        }
    }

    /// Whether the path goes on behind a vertex with this throughput.
    #[inline(always)]
    fn goes_on(&self, throughput: Vec3) -> bool {
        let carried = throughput.element_sum();
        (self.in_prefix || self.suffix.is_lit()) && is_finite(carried) && carried > 0.0
    }

    /// Returns the next segment behind a thin wall: that before the wall goes on, without a scattering event.
    #[inline(always)]
    pub fn pass_wall(
        &mut self,
        segment: &Segment,
        arrival: &Arrival,
        scattered: &BsdfSample,
        distance: f32,
    ) -> Segment {
        let exists = self.goes_on(arrival.throughput);
        self.passed_walls += u32::from(exists);
        Segment {
            exists,
            ray: scattered.ray,
            media: scattered.media,
            throughput: arrival.throughput,
            passed: segment.passed + distance,
            ..*segment
        }
    }

    /// Returns the next segment behind a scattering event, if the path goes on.
    #[inline(always)]
    pub fn leave<C: Atomics>(
        &mut self,
        arrival: &Arrival,
        scattered: &BsdfSample,
        was_prefix: bool,
        context: PathContext<'_>,
        counters: &mut C,
    ) -> Segment {
        let sampled = &scattered.sampled;
        let mut throughput = arrival.throughput;
        let mut exists = self.goes_on(throughput);
        if context.features.has(Features::THIN_WALLS) {
            exists = exists && self.depth <= context.params.max_bounces;
        }
        if exists && sampled.transmitted {
            // Scale radiance by eta^2, as solid angles shrink in the denser medium [Veach 1997, 5.2].
            throughput *= sampled.eta * sampled.eta;
            count_rare(Counter::MediaOverflow, scattered.media_overflow.into(), counters);
        }
        self.in_delta_prefix = self.in_delta_prefix && sampled.pdf_solid_angle == 0.0;
        self.depth += u32::from(exists);
        Segment {
            exists,
            ray: scattered.ray,
            from: arrival.vertex.position,
            from_prefix: was_prefix,
            media: scattered.media,
            throughput,
            pdf_solid_angle: sampled.pdf_solid_angle,
            finds_emission: self.in_prefix || self.suffix.finds.has(sampled.class),
            passed: 0.0,
        }
    }

    /// Reports a path that ends in its prefix to the observer.
    #[inline(always)]
    pub fn end_without_point<O: PathObserver>(&self, last: Vec3, observer: &mut O, kept: &mut O::Kept) {
        if self.in_prefix {
            observer.end(kept, last);
        }
    }

    /// Returns the light of the ended path. Where it is not finite, counts the path and returns no light.
    #[inline(always)]
    pub fn finish<C: Atomics>(
        &self,
        features: Features,
        scratch: &PathScratch<'_>,
        counters: &mut C,
    ) -> CameraPathLight {
        let mut light = scratch.light();
        if features.has(Features::PARTS) && self.in_delta_prefix {
            light.delta_prefix = light.radiance;
        }
        if scratch.keeps_indirect() {
            light.indirect = scratch.indirect_sample(self.rng.ray_key(ROUNDING));
        }
        if scratch.keeps_cached() {
            light.cached = scratch.cache_sample(self.rng.ray_key(ROUNDING));
        }
        if !is_finite(light.radiance.element_sum()) {
            light = CameraPathLight::default();
            counters.add(Counter::NonFinite as u32, 1);
        }
        counters.add(Counter::CameraRays as u32, self.depth + self.passed_walls);
        counters.add(Counter::ShadowRays as u32, self.shadow_rays);
        light
    }
}

/// Share of the paths that go on behind a cell with so many samples, of the range of a random word. At most a share `ends` may end.
#[inline(always)]
fn filling_share(samples: f32, ends: f32) -> u32 {
    let share = clamp(SAMPLES_FILLING / samples, MIN_FILLING, 0.5).max(1.0 - ends);
    (share * 4_294_967_040.0) as u32
}

/// Light samples of a vertex: several in the prefix, one behind the collection point.
#[inline(always)]
fn candidates(in_prefix: bool, context: PathContext<'_>) -> LightCandidates {
    if in_prefix { LightCandidates::new(context.params) } else { LightCandidates::one(context.params) }
}
