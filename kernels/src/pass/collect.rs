//! `collect`: traces a camera path through each pixel. Its prefix of specular events ends at the collection point;
//! beside it the path gathers all light that is no caustic.

mod aside;
mod connected;
pub mod errand;
pub mod observer;

use crate::declare::pass;
use crate::interface::NONE;
use crate::interface::choice::Caustics;
use crate::interface::counters::Counter;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::light::Light;
use crate::interface::material::{FLAG_EMIT_BOTH_SIDES, FLAGS_SCATTER_TEXTURE, Material};
use crate::interface::packed::to_signed_shares;
use crate::interface::point::{PointDirect, PointGeometry, PointShading};
use crate::interface::ray::{Hit, Ray};
use crate::interface::scene::SceneTables;
use crate::light::area::pdf_solid_angle;
use crate::light::environment;
use crate::light::light_sampling::{ByClass, LightCandidates, LightSample, Reservoir};
use crate::math::balance_heuristic;
use crate::math::cone::RayCone;
use crate::math::is_finite;
use crate::math::offset;
use crate::math::pencil::{Pencil, VirtualImage};
use crate::math::rng::{Rng, Stream};
use crate::math::sampler::next4;
use crate::platform::{Atomics, Slots, scratch};
use crate::surface::class::Classes;
use crate::surface::dispersion::{Channel, is_mixed, needs_channel, part};
use crate::surface::may_have_non_delta_lobe;
use crate::surface::media::MediaStack;
use crate::surface::scatter::{BsdfSample, ScatteringVertex};
use crate::surface::textured::{material_at, packed};
use crate::surface::turn::normal_changes;
use crate::surface::vertex::{Vertex, vertex};
use crate::trace::Tracer;
use crate::trace::initial_media::initial_media_stack;
use crate::trace::through_media::{shadow_transmittance, trace_through_media};
use aside::{Aside, Shadow, Sum};
use connected::Connected;
use errand::{Errand, Wanted, run};
use observer::{CollectionPoint, PathObserver, PointObserver};
use spirv_std::glam::Vec3;

/// Features that distort a pencil: without them a prefix meets plane mirrors alone.
const DISTORTING: Features = Features(Features::DIELECTRIC.0 | Features::SMOOTH_NORMALS.0);

/// Whether somebody asks where a point is imaged, and that is not where its path's length says.
#[inline(always)]
fn needs_virtual_image(features: Features) -> bool {
    features.has(Features::HISTORY) && features.has(DISTORTING)
}

#[cfg(not(target_arch = "spirv"))]
/// Pixels in Morton order: neighbouring invocations and boxes stay close in the image.
pub fn pixel_order(width: u32, height: u32) -> Vec<u32> {
    let spread = |x: u32| (0..16).fold(0u32, |code, bit| code | (x >> bit & 1) << (2 * bit));
    let mut order: Vec<u32> = (0..width * height).collect();
    order.sort_by_cached_key(|&pixel| spread(pixel % width) | spread(pixel / width) << 1);
    order
}

/// Camera suffix: lobes by which a camera path goes on and finds lights behind its collection point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraSuffix {
    /// Lobes that it follows.
    pub follows: Classes,
    /// Lobes by which it finds lights: those of the others are the light paths'.
    pub finds: Classes,
}

impl CameraSuffix {
    /// All light is the camera's: path tracing.
    pub const ALL: CameraSuffix = CameraSuffix { follows: Classes::ALL, finds: Classes::ALL };

    /// Nothing: the path ends there, and asks for no light on its way.
    pub const NOTHING: CameraSuffix = CameraSuffix { follows: Classes::NONE, finds: Classes::NONE };

    /// Whether the path asks for any light.
    #[inline(always)]
    fn is_lit(self) -> bool {
        self.finds != Classes::NONE
    }

    /// Whether a collection point at the end of the prefix takes light, divided by the probability of its class.
    #[inline(always)]
    fn divides(self) -> bool {
        self.finds != Classes::ALL
    }

    /// What the light paths of a frame leave to it.
    #[inline(always)]
    pub fn new(params: &FrameParams) -> CameraSuffix {
        let mut follows = Classes::ALL;
        if params.caustics == Caustics::Any as u32 {
            follows = Classes::NON_SPECULAR;
        }
        CameraSuffix { follows, finds: Classes::NON_SPECULAR }
    }
}

/// The light that a camera path brings home.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraPathLight {
    /// Radiance that is no caustic (W m^-2 sr^-1).
    pub radiance: Vec3,
    /// With [`Features::PARTS`], as what follows is: the part of it that is no light which the non-specular class of the collection
    /// point reflects: what came before the point, its emission, and direct light on its specular class (W m^-2 sr^-1).
    pub prefix: Vec3,
    /// The direct light among what that class reflects.
    pub direct: PointDirect,
    /// The part of it that was found before the first non-delta bounce (W m^-2 sr^-1).
    pub delta_prefix: Vec3,
}

/// What a camera path brings home, and where its collection point is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Collected {
    /// All its light.
    pub light: CameraPathLight,
    /// Its point.
    pub point: CollectionPoint,
}

/// Share of what leaves the collection point from which on a path goes on for sure.
const SURE: f32 = 0.5;

/// A camera path before its first ray is traced.
#[derive(Clone, Copy, Debug)]
pub struct CameraPathStart {
    /// Its first ray.
    pub ray: Ray,
    /// The cone around that.
    pub cone: RayCone,
    /// The numbers that it samples from here on.
    pub rng: Rng,
}

impl CameraPathStart {
    /// At the eye, through a pixel, by the numbers of a stream.
    #[inline(always)]
    pub fn new(stream: Stream, pixel: u32, params: &FrameParams) -> CameraPathStart {
        let mut rng = Rng::new(stream, params.seed, params.film_pixel(pixel), params.frame);
        let ray = camera_ray(params, pixel, &mut rng);
        CameraPathStart { ray, cone: RayCone::at_eye(params.pixel_spread), rng }
    }
}

/// The camera ray through a pixel; samples from `rng` in any case, so that filters share all other numbers.
#[inline(always)]
pub fn camera_ray(params: &FrameParams, pixel: u32, rng: &mut Rng) -> Ray {
    let u = next4(rng, &params.sequence);
    let (mut x, mut y) = (0.5, 0.5);
    if params.has_box_filter() {
        (x, y) = (u.x, u.y);
    }
    let (column, row) = params.on_film(pixel);
    let camera = &params.camera;
    Ray::endless(camera.position, camera.direction_of(column as f32 + x, row as f32 + y, params))
}

/// Camera paths, a pixel an invocation.
#[pass(name = "collect", over = params.pixel_count(), work = Camera, joint)]
pub fn collect(
    index: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    counters: &mut impl Atomics,
    #[len = params.pixel_count()] pixel_order: &[u32],
    path_radiance: Slots<'_, Vec3>,
    prefix_radiance: Slots<'_, Vec3>,
    delta_prefix_radiance: Slots<'_, Vec3>,
    point_direct: Slots<'_, PointDirect>,
    point_geometry: Slots<'_, PointGeometry>,
    point_shading: Slots<'_, PointShading>,
) {
    let collect = Collect {
        pixel: pixel_order[index as usize],
        params,
        features,
        radiance: path_radiance,
        prefix: prefix_radiance,
        delta_prefix: delta_prefix_radiance,
        direct: point_direct,
        geometry: point_geometry,
        shading: point_shading,
    };
    run(collect, params, features, scene, tracer, counters);
}

/// The errand of `collect`: light that is no caustic, and a collection point. The point is written as soon as it is found: the path
/// behind it has no use for it.
pub struct Collect<'a> {
    /// The pixel.
    pub pixel: u32,
    /// Settings.
    pub params: &'a FrameParams,
    /// What the scene needs.
    pub features: Features,
    /// `path_radiance`, by pixel as what follows is.
    pub radiance: Slots<'a, Vec3>,
    /// `prefix_radiance`.
    pub prefix: Slots<'a, Vec3>,
    /// `delta_prefix_radiance`.
    pub delta_prefix: Slots<'a, Vec3>,
    /// `point_direct`.
    pub direct: Slots<'a, PointDirect>,
    /// `point_geometry`.
    pub geometry: Slots<'a, PointGeometry>,
    /// `point_shading`.
    pub shading: Slots<'a, PointShading>,
}

impl PathObserver for Collect<'_> {
    type Kept = ();

    #[inline(always)]
    fn collect(&mut self, _kept: &mut (), point: &CollectionPoint) {
        self.geometry.write(self.pixel, point.geometry);
        self.shading.write(self.pixel, point.shading);
    }
    #[inline(always)]
    fn end(&mut self, kept: &mut (), last: Vec3) {
        self.collect(kept, &CollectionPoint::none(last));
    }
}

impl Errand for Collect<'_> {
    #[inline(always)]
    fn wanted(&self) -> Wanted {
        Wanted { pixel: self.pixel, stream: Stream::Camera, suffix: CameraSuffix::new(self.params) }
    }
    #[inline(always)]
    fn leave(&mut self, light: &CameraPathLight, _kept: &()) {
        self.radiance.write(self.pixel, light.radiance);
        if self.features.has(Features::PARTS) {
            self.prefix.write(self.pixel, light.prefix);
            self.delta_prefix.write(self.pixel, light.delta_prefix);
            self.direct.write(self.pixel, light.direct);
        }
    }
}

/// Traces the path of one pixel.
#[inline(always)]
pub fn camera_path<T: Tracer, C: Atomics>(
    pixel: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
    counters: &mut C,
) -> Collected {
    let start = CameraPathStart::new(Stream::Camera, pixel, params);
    collected(start, CameraSuffix::new(params), params, features, scene, tracer, counters)
}

/// What a camera path brings home.
#[inline(always)]
pub fn collected<T: Tracer, C: Atomics>(
    start: CameraPathStart,
    suffix: CameraSuffix,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
    counters: &mut C,
) -> Collected {
    let (light, point) = follow(start, suffix, params, features, scene, tracer, &mut PointObserver, counters);
    Collected { light, point }
}

/// What a camera path takes along from one vertex to the next.
#[derive(Clone, Copy)]
struct Segment {
    ray: Ray,
    /// The vertex that it left, or the eye (m).
    from: Vec3,
    /// Whether the prefix leads to that.
    of_prefix: bool,
    media: MediaStack,
    throughput: Vec3,
    /// Density of its direction (1/sr), 0 from a lobe without a width.
    pdf_scattered: f32,
    /// Whether a light that it meets counts.
    finds_emission: bool,
}

impl Segment {
    const NONE: Segment = Segment {
        ray: Ray { origin: Vec3::ZERO, length: 0.0, direction: Vec3::ZERO, key: 0 },
        from: Vec3::ZERO,
        of_prefix: false,
        media: MediaStack::VACUUM,
        throughput: Vec3::ZERO,
        pdf_scattered: 0.0,
        finds_emission: false,
    };
}

/// Follows a camera path from its first ray. Returns its light, and what the observer keeps of it.
#[inline(always)]
pub fn follow<T: Tracer, O: PathObserver, C: Atomics>(
    start: CameraPathStart,
    suffix: CameraSuffix,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
    observer: &mut O,
    counters: &mut C,
) -> (CameraPathLight, O::Kept) {
    let CameraPathStart { ray, cone: direct, mut rng } = start;
    let mut kept = O::Kept::default();
    let parts = features.has(Features::PARTS);
    let mut next =
        Segment { ray, from: ray.origin, throughput: Vec3::ONE, finds_emission: true, ..Segment::NONE };
    if features.has(Features::STARTS_IN_MEDIUM) {
        next.media = initial_media_stack(ray.origin, features, scene, tracer);
    }
    let (mut prefix, mut delta_prefix) = (true, true);
    let mut from_point = 0.0;
    let all = LightCandidates::new(params);
    let candidates_of = |prefix: bool| if prefix { all } else { LightCandidates::ONE };
    scratch!(sample_words: connected::ROOM);
    scratch!(words: aside::ROOM);
    let mut aside = Aside::new(words, features, params);
    aside.set_cone(direct, 0.0);
    if needs_virtual_image(features) {
        aside.set_pencil(&Pencil::at_eye(ray.direction, params.camera.right));
    }
    let mut shadow_rays = 0;

    // The segment of this number, and the vertex that it finds; the last one may only emit. That the loop ends in one place
    // alone, with nothing left of a segment, spares a GPU what it would keep of paths that have ended while others go on.
    let mut depth = 1;
    loop {
        let Segment { mut ray, from, of_prefix, mut media, mut throughput, pdf_scattered, finds_emission } =
            next;
        next = Segment::NONE;
        if features.has(Features::BLENDS) {
            ray.key = rng.ray_key(0);
        }
        let traced = trace_through_media(&ray, media, features, scene, tracer);
        let hit = traced.hit;
        media = traced.media;
        count_rare(traced.overflows, Counter::MediaOverflow, counters);
        count_rare(traced.unexpected, Counter::UnexpectedFaces, counters);
        let mut goes_on = false;
        if hit.is_miss() {
            observer.escape(&ray, throughput);
            if prefix {
                aside.add(Sum::Radiance, throughput * params.background);
            }
            if features.has(Features::ENVIRONMENT) && finds_emission {
                let mut seen = environment(&ray, pdf_scattered, candidates_of(of_prefix), params, scene);
                if features.has(Features::ABSORPTION) {
                    seen *= traced.transmittance;
                }
                aside.add(Sum::Radiance, throughput * seen);
            }
            if prefix {
                observer.end(&mut kept, from);
            }
        } else {
            let mut width = 0.0;
            if prefix {
                let (cone, distance) = aside.cone();
                let cone = cone.advance(hit.distance);
                aside.set_cone(cone, distance + hit.distance);
                if needs_virtual_image(features) {
                    aside.set_pencil(&aside.pencil().advance(hit.distance));
                }
                if !params.sees_finest_textures() {
                    width = cone.total_width();
                }
            }
            let here = vertex(scene, features, &ray, &hit, width);
            let material = material_at(scene, &here, features);
            if features.has(Features::ABSORPTION) {
                throughput *= traced.transmittance;
            }
            observer.arrive(&ray, &hit, &here, throughput);

            // Emission, combined by MIS with light sampling at the vertex before.
            let is_emitter =
                features.has(Features::AREA_LIGHTS) && here.light != NONE && emits(&here, &material);
            if is_emitter && finds_emission {
                let light = scene.lights[here.light as usize];
                let mut mis_weight = 1.0;
                if pdf_scattered > 0.0 {
                    let cos = here.to_previous.dot(here.face_normal);
                    let square = hit.distance * hit.distance;
                    let pdf_light_sampling = pdf_solid_angle(&light, scene, features, from, square, cos)
                        * candidates_of(of_prefix).gain(&light);
                    mis_weight = balance_heuristic(pdf_scattered, pdf_light_sampling);
                }
                aside.add(Sum::Radiance, throughput * material.emission * mis_weight);
            }
            if depth <= params.max_bounces {
                // Direct light on every non-delta lobe, each class for itself.
                let (mut follows, mut finds) = (Classes::ALL, Classes::ALL);
                let candidates = candidates_of(prefix);
                if !prefix {
                    (follows, finds) = (suffix.follows, suffix.finds);
                }
                let mut channel = Channel::GREEN;
                if needs_channel(&here, &material, scene.materials, media, features) {
                    let mixed = is_mixed(throughput);
                    let u = if mixed { next4(&mut rng, &params.sequence).x } else { 0.0 };
                    (channel, throughput) = part(throughput, u);
                }
                let u = next4(&mut rng, &params.sequence);
                let mut choice = 0.0;
                if candidates.candidate_count > 1 {
                    choice = next4(&mut rng, &params.sequence).x;
                }
                let mut count = 0;
                if suffix.is_lit() && may_have_non_delta_lobe(&material, features) {
                    count = candidates.sample_count * candidates.candidate_count;
                }
                let sample_light = |number| {
                    candidates.sample_light(number, scene, params.light_count, features, here.position, u)
                };
                let mut connected = Connected::new(count, sample_light, sample_words);
                let scattering = ScatteringVertex::new(
                    here,
                    material,
                    scene.materials,
                    media,
                    throughput,
                    channel,
                    follows,
                    prefix && suffix.divides(),
                    params.specular_roughness,
                    features,
                );
                if parts && prefix {
                    aside.set(Sum::Prefix, aside.sum(Sum::Radiance));
                    aside.set(Sum::Direct, Vec3::ZERO);
                }
                let mut waits = 0;
                if scattering.bsdf.has_non_delta_lobe() {
                    let mut number = 0;
                    while number < count {
                        let mut reservoir = Reservoir::new(choice);
                        let end = number + candidates.candidate_count;
                        while number < end {
                            let candidate = connected.get(number);
                            let direct = direct_light(&scattering, &candidate, finds, features);
                            reservoir.add(connected.keep(number, candidate, direct), direct.sum());
                            number += 1;
                        }
                        if reservoir.has_sample() {
                            let (light_sample, direct) = connected.get_with_light(reservoir.kept);
                            let direct = direct.times(reservoir.inverse_probability());
                            let mut ray = shadow_ray(&here, &light_sample);
                            if features.has(Features::BLENDS) {
                                ray.key = rng.ray_key(number);
                            }
                            let shadow = Shadow {
                                ray,
                                media: scattering.media_towards(light_sample.to_light),
                                radiance: throughput * direct.sum(),
                                specular: throughput * direct.specular,
                                non_specular: throughput * direct.non_specular,
                            };
                            aside.set_shadow(waits, &shadow);
                            waits += 1;
                        }
                    }
                }
                let (was_prefix, was_delta_prefix) = (prefix, delta_prefix);

                // Scatter; the first non-specular choice makes the collection point.
                let u = next4(&mut rng, &params.sequence);
                let scattered = scattering.sample(u);
                if scattering.bsdf.scatters() {
                    observer.scatter(&scattered);
                }
                if prefix && scattered.sampled.class == Classes::NON_SPECULAR {
                    prefix = false;
                    let class_probability = scattering.bsdf.class_probability(Classes::NON_SPECULAR);
                    if depth < params.max_bounces && class_probability > 0.0 {
                        let cos = here.to_previous.dot(here.face_normal);
                        let (cone, distance) = aside.cone();
                        let mut virtual_image = VirtualImage::straight(distance);
                        if needs_virtual_image(features) {
                            virtual_image = aside.pencil().virtual_image(distance);
                        }
                        if parts {
                            aside.set_class_probability(class_probability);
                        }
                        let geometry = PointGeometry {
                            position: here.position,
                            radius: cone.radius(
                                cos,
                                params.radius_px,
                                here.position,
                                direct.advance(distance).width,
                            ),
                            normal: here.face_normal,
                            depth,
                        };
                        let mut shading = PointShading {
                            to_viewer: here.to_previous,
                            material: here.material,
                            shading_normal: here.shading_normal,
                            red_green: 0,
                            throughput: throughput / class_probability,
                            blue_roughness_metallic: 0,
                            eta: scattering.bsdf.eta,
                            instance: here.instance,
                            distance: virtual_image.distance,
                            astigmatism: to_signed_shares(virtual_image.astigmatism),
                        };
                        if features.has(Features::TEXTURES) && material.flags & FLAGS_SCATTER_TEXTURE != 0 {
                            let (first, second) = packed(&material);
                            shading.red_green = first;
                            shading.blue_roughness_metallic = second;
                        }
                        observer.collect(&mut kept, &CollectionPoint { geometry, shading, length: distance });
                    } else {
                        observer.end(&mut kept, here.position);
                    }
                }
                throughput *= scattered.sampled.weight;
                if scattered.sampled.class == Classes::NON_SPECULAR {
                    // Russian roulette, by what is left of what left the collection point.
                    let carried = throughput.max_element();
                    if was_prefix {
                        from_point = carried;
                    }
                    let survival = (carried / (SURE * from_point)).min(1.0);
                    throughput = if u.w < survival { throughput / survival } else { Vec3::ZERO };
                }
                let carried = throughput.element_sum();
                goes_on = (prefix || suffix.is_lit()) && is_finite(carried) && carried > 0.0;
                if prefix {
                    if needs_virtual_image(features) {
                        scatter_pencil(&mut aside, scene, features, &hit, &here, &scattered);
                    }
                    let (cone, distance) = aside.cone();
                    aside.set_cone(scatter_cone(cone, &here, &scattered), distance);
                }
                if goes_on && scattered.sampled.transmitted {
                    // Radiance is compressed into the denser side's smaller solid angle.
                    throughput *= scattered.sampled.eta * scattered.sampled.eta;
                    count_rare(scattered.media_overflow.into(), Counter::MediaOverflow, counters);
                }
                delta_prefix = delta_prefix && scattered.sampled.pdf_solid_angle == 0.0;
                next = Segment {
                    ray: scattered.ray,
                    from: here.position,
                    of_prefix: was_prefix,
                    media: scattered.media,
                    throughput,
                    pdf_scattered: scattered.sampled.pdf_solid_angle,
                    finds_emission: prefix || suffix.finds.has(scattered.sampled.class),
                };

                // Of the vertex nothing is needed any more.
                let mut index = 0;
                while index < waits {
                    let shadow = aside.shadow(index);
                    let transmittance =
                        shadow_transmittance(&shadow.ray, shadow.media, features, scene, tracer);
                    if transmittance.max_element() > 0.0 {
                        aside.add(Sum::Radiance, shadow.radiance * transmittance);
                        if parts && was_prefix {
                            aside.add(Sum::Prefix, shadow.specular * transmittance);
                            aside.add(Sum::Direct, shadow.non_specular * transmittance);
                        }
                    }
                    index += 1;
                }
                shadow_rays += waits;
                if parts && was_delta_prefix {
                    aside.set(Sum::DeltaPrefix, aside.sum(Sum::Radiance));
                }
            }
            if prefix && !goes_on {
                observer.end(&mut kept, here.position);
            }
        }
        if !goes_on {
            break;
        }
        depth += 1;
    }

    let mut light = aside.light();
    if parts && delta_prefix {
        light.delta_prefix = light.radiance;
    }
    if !is_finite(light.radiance.element_sum()) {
        light = CameraPathLight::default();
        counters.add(Counter::NonFinite as u32, 1);
    }
    counters.add(Counter::CameraRays as u32, depth);
    counters.add(Counter::ShadowRays as u32, shadow_rays);
    (light, kept)
}

/// Counts what hardly ever occurs, at once: a sum would be one value more that a path keeps.
#[inline(always)]
fn count_rare<C: Atomics>(times: u32, counter: Counter, counters: &mut C) {
    if times != 0 {
        counters.add(counter as u32, times);
    }
}

/// What a ray that meets nothing sees of the environment, combined by MIS with light sampling at the vertex that it left.
#[inline(always)]
fn environment(
    ray: &Ray,
    pdf_scattered: f32,
    candidates: LightCandidates,
    params: &FrameParams,
    scene: SceneTables<'_>,
) -> Vec3 {
    // The last row, if there is one.
    let mut light = Light::default();
    if params.light_count > 0 {
        light = scene.lights[(params.light_count - 1) as usize];
    }
    if light.kind != Features::ENVIRONMENT.0 {
        return Vec3::ZERO;
    }
    let mut mis_weight = 1.0;
    if pdf_scattered > 0.0 {
        let pdf_light_sampling =
            environment::pdf_solid_angle(&light, scene, ray.direction) * candidates.gain(&light);
        mis_weight = balance_heuristic(pdf_scattered, pdf_light_sampling);
    }
    environment::radiance_from(scene, ray.direction) * mis_weight
}

/// Whether the vertex's side of the triangle emits.
#[inline(always)]
fn emits(vertex: &Vertex, material: &Material) -> bool {
    vertex.front || material.flags & FLAG_EMIT_BOTH_SIDES != 0
}

/// Reflected or transmitted light of a light sample, each class for itself, weighted by MIS against finding the light by scattering (balance
/// heuristic).
#[inline(always)]
fn direct_light(
    scattering: &ScatteringVertex,
    light_sample: &LightSample,
    classes: Classes,
    features: Features,
) -> ByClass {
    let mut sum = ByClass::default();
    if light_sample.radiance_over_pdf.max_element() > 0.0 {
        let cos = light_sample.to_light.dot(scattering.vertex.shading_normal).abs();
        let above = light_sample.to_light.dot(scattering.vertex.face_normal) > 0.0;
        if features.has(Features::ROUGH_DIELECTRIC) && !above && classes.has(Classes::SPECULAR) {
            // Through the surface; radiance is compressed as where a path scatters.
            let eta = scattering.bsdf.eta;
            sum.specular = light_sample.radiance_over_pdf
                * mis_weighted(scattering, light_sample, Classes::SPECULAR)
                * (cos * eta * eta);
            return sum;
        }
        let light = light_sample.radiance_over_pdf * if above { cos } else { 0.0 };
        sum.non_specular = light * mis_weighted(scattering, light_sample, Classes::NON_SPECULAR);
        if classes.has(Classes::SPECULAR) && scattering.bsdf.has_non_delta_lobe_in(Classes::SPECULAR) {
            sum.specular = light * mis_weighted(scattering, light_sample, Classes::SPECULAR);
        }
    }
    sum
}

/// f of one class times its MIS weight.
#[inline(always)]
fn mis_weighted(scattering: &ScatteringVertex, light_sample: &LightSample, class: Classes) -> Vec3 {
    let lobes = scattering.eval(light_sample.to_light, class);
    if light_sample.pdf_solid_angle > 0.0 {
        lobes.f * balance_heuristic(light_sample.pdf_solid_angle, lobes.pdf_solid_angle)
    } else {
        lobes.f
    }
}

/// The ray from a vertex to just before a light.
#[inline(always)]
fn shadow_ray(vertex: &Vertex, light_sample: &LightSample) -> Ray {
    let origin = offset::leave(vertex.position, vertex.face_normal, light_sample.to_light, vertex.clearance);
    if light_sample.endless {
        return Ray::endless(origin, light_sample.to_light);
    }
    let along = light_sample.target - origin;
    let length = along.length();
    Ray { origin, length, direction: along / length, key: 0 }
}

/// The ray cone behind a specular event.
#[inline(always)]
fn scatter_cone(cone: RayCone, vertex: &Vertex, scattered: &BsdfSample) -> RayCone {
    let sampled = &scattered.sampled;
    let cos = vertex.to_previous.dot(vertex.shading_normal).abs();
    // A rough thin wall passes its mirrored reflection and refracts nothing on the whole.
    let unrefracted = sampled.straight || (sampled.roughness > 0.0 && sampled.eta == 1.0);
    if !sampled.transmitted {
        let cone = cone.reflect(vertex.curvature, cos);
        if sampled.roughness > 0.0 { cone.roughen(sampled.roughness) } else { cone }
    } else if unrefracted {
        if sampled.roughness > 0.0 { cone.roughen(sampled.roughness) } else { cone }
    } else if sampled.roughness > 0.0 {
        // Refracted at a facet: both cosines are the facet's. Directions as the lobes see them.
        let facing = |direction: Vec3, above: bool| {
            if (direction.dot(vertex.shading_normal) > 0.0) == above { direction } else { -direction }
        };
        let (to_previous, direction) =
            (facing(vertex.to_previous, true), facing(scattered.ray.direction, false));
        let half = (to_previous * sampled.eta + direction).normalize();
        let (cos, cos_behind) = (to_previous.dot(half).abs(), direction.dot(half).abs());
        let cone = cone.refract(vertex.curvature, cos, cos_behind, sampled.eta);
        cone.roughen_refracted(sampled.roughness, sampled.eta)
    } else {
        cone.refract(vertex.curvature, cos, -sampled.direction.z, sampled.eta)
    }
}

/// Turns the pencil at a specular event. It is read again where it is used.
#[inline(always)]
fn scatter_pencil(
    aside: &mut Aside<'_>,
    scene: SceneTables<'_>,
    features: Features,
    hit: &Hit,
    vertex: &Vertex,
    scattered: &BsdfSample,
) {
    let sampled = &scattered.sampled;
    let (from, to) = (-vertex.to_previous, scattered.ray.direction);
    if sampled.straight {
        return;
    }
    let pencil = if sampled.transmitted && sampled.eta == 1.0 {
        // A rough thin wall refracts nothing on the whole.
        aside.pencil().turn(from, to)
    } else {
        let eta = if sampled.transmitted { sampled.eta } else { 1.0 };
        let steps = aside.pencil().steps(from, vertex.face_normal);
        let (change_x, change_y) = normal_changes(scene, features, hit, vertex.front, steps);
        aside.pencil().reflect_or_refract(from, to, eta, !sampled.transmitted, change_x, change_y)
    };
    aside.set_pencil(&pencil);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_pixels_is_a_permutation_of_tiles() {
        let order = pixel_order(17, 9);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..17 * 9).collect::<Vec<_>>());
        // The first 64 are the first tile of 8 by 8.
        assert!(order[..64].iter().all(|pixel| pixel % 17 < 8 && pixel / 17 < 8));
    }
}
