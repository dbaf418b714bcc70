//! The light path: from a light by specular events to photons at every receiver behind them [Moreau and Doggett 2022, section
//! 3.2]. A photon is stored if the first event of the path was specular; with `Caustics::Any`, if any event before was.

use super::ledger::Ledger;
use super::photon_sink::PhotonSink;
use super::{PathContext, count_rare};
use crate::interface::choice::Caustics;
use crate::interface::counters::Counter;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::material::{FLAGS_SCATTER_TEXTURE, Material};
use crate::interface::point::{PhotonGeometry, PhotonLight};
use crate::interface::ray::{Hit, Ray};
use crate::light::emit::{EmissionSample, Emit};
use crate::math::is_finite;
use crate::math::rng::Rng;
use crate::platform::Atomics;
use crate::surface::class::Classes;
use crate::surface::dispersion::{Channel, is_mixed, needs_channel, part};
use crate::surface::media::MediaStack;
use crate::surface::scatter::{BsdfSample, ScatteringVertex};
use crate::surface::textured::material_at;
use crate::surface::vertex::{Vertex, vertex};
use crate::texture::cut_out::CutOuts;
use crate::trace::Tracer;
use crate::trace::through_media::TracedSegment;
use spirv_std::glam::Vec3;

/// Traces the light path with this index and these random numbers. Returns the state that its sink carried along the path.
#[inline(always)]
pub fn trace_light_path<E: Emit, T: Tracer, S: PhotonSink, C: Atomics>(
    index: u32,
    mut rng: Rng,
    context: PathContext<'_>,
    emit: &E,
    tracer: &mut T,
    sink: &mut S,
    counters: &mut C,
) -> S::PathState {
    let PathContext { params, features, scene } = context;
    // Sample the emission
    let emission = emit.sample(&mut rng);
    let mut path_state = S::PathState::default();
    sink.start(&mut path_state, &emission);
    let mut path = LightPath::new(index, rng, &emission, context, tracer);
    while path.vertices <= params.max_bounces {
        // Trace the segment through the media around it
        let traced = path.trace_segment(context, tracer);
        if traced.hit.is_miss() {
            path.ledger.escape(path.flux);
            break;
        }

        // Find the vertex, its lobes and its BSDF
        let here = vertex(scene, features, &path.ray, &traced.hit, 0.0);
        sink.arrive(&mut path_state, &path.ray, &traced.hit, &here);
        let material = material_at(scene, &here, features);
        path.absorb(&traced, features);
        let channel = path.choose_channel(&here, &material, context);
        let lobes = path.lobes(params);
        let scattering = path.scattering(here, material, channel, lobes, context);

        // Store a photon where a caustic meets a receiver
        if path.leaves_photon(&scattering, &material, features) {
            path.photons += 1;
            sink.store_photon(
                &mut path_state,
                path.photon_geometry(&here),
                path.photon_light(&here, &traced.hit, &emission, context),
            );
        }

        // End at a surface that absorbs all, or at the largest number of bounces
        if !scattering.bsdf.scatters() {
            path.ledger.arrive(&scattering, lobes, path.flux);
            break;
        }
        let can_pass = context.can_pass(&here, path.passed_walls);
        if path.vertices == params.max_bounces && !can_pass {
            path.cut();
            break;
        }

        // Sample the BSDF; passing a thin wall is no scattering event
        path.ledger.arrive(&scattering, lobes, path.flux);
        let u = path.rng.next4();
        let scattered = scattering.sample(u);
        let passes = can_pass && scattered.sampled.straight;
        path.scatter(&scattering, &scattered, passes);
        if path.vertices == params.max_bounces && !passes {
            path.cut();
            break;
        }

        // Cut a path that can store no caustic photon any more
        if path.is_too_late_for_a_caustic(&scattered, params) {
            path.cut();
            break;
        }

        // Terminate by Russian roulette where a diffuse surface absorbs flux
        let survival = survival_probability(&scattered);
        if u.w >= survival {
            break;
        }
        path.flux /= survival;
        let carried = path.flux.element_sum();
        if !is_finite(carried) || carried <= 0.0 {
            break;
        }

        // Leave the vertex
        path.leave(&scattered, passes);
        sink.scatter(&mut path_state, &scattered, path.flux);
    }
    path.count(index, params, counters);
    path_state
}

/// State of a light path that outlives a vertex.
pub struct LightPath {
    rng: Rng,
    ray: Ray,
    media: MediaStack,
    /// Flux that the ray carries (W).
    flux: Vec3,
    /// Number of the vertex that the ray finds, from 1. `vertices - 1` scatterings lie before it, and the camera path has at
    /// least one.
    vertices: u32,
    /// Number of thin walls that the path passed; they are no vertices.
    passed_walls: u32,
    /// Whether the light that the ray carries is a caustic, made by a specular event before.
    is_caustic: bool,
    ledger: Ledger,
    rays: u32,
    photons: u32,
    /// 1 where the path was cut by its length.
    cut: u32,
    media_overflows: u32,
    unexpected_faces: u32,
}

impl LightPath {
    /// Path that leaves its light. A path without flux finds no vertex.
    #[inline(always)]
    fn new<T: Tracer>(
        index: u32,
        rng: Rng,
        emission: &EmissionSample,
        context: PathContext<'_>,
        tracer: &mut T,
    ) -> LightPath {
        let PathContext { params, features, .. } = context;
        let flux = emission.flux / params.light_path_count as f32;
        let media = context.initial_media(emission.ray.origin, tracer);
        let mut ledger = Ledger::new(params, index, features);
        ledger.emit(flux);
        LightPath {
            rng,
            ray: emission.ray,
            media,
            flux,
            vertices: if flux.element_sum() > 0.0 { 1 } else { params.max_bounces + 1 },
            passed_walls: 0,
            is_caustic: false,
            ledger,
            rays: 0,
            photons: 0,
            cut: 0,
            media_overflows: 0,
            unexpected_faces: 0,
        }
    }

    /// Traces a segment through the media around it, up to the first surface that no medium covers.
    #[inline(always)]
    fn trace_segment<T: Tracer>(&mut self, context: PathContext<'_>, tracer: &mut T) -> TracedSegment {
        self.rays += 1;
        let traced = context.trace_segment(&mut self.ray, self.media, &self.rng, tracer);
        self.media = traced.media;
        self.media_overflows += traced.overflows;
        self.unexpected_faces += traced.unexpected;
        traced
    }

    /// Absorbs flux in the media of a segment.
    #[inline(always)]
    fn absorb(&mut self, traced: &TracedSegment, features: Features) {
        if features.has(Features::ABSORPTION) {
            let before = self.flux;
            self.flux *= traced.transmittance;
            self.ledger.pass(before, self.flux);
        }
    }

    /// Chooses the one channel that goes on where a medium disperses.
    #[inline(always)]
    fn choose_channel(&mut self, here: &Vertex, material: &Material, context: PathContext<'_>) -> Channel {
        let mut channel = Channel::GREEN;
        if needs_channel(here, material, context.scene.materials, self.media, context.features) {
            let u = if is_mixed(self.flux) { self.rng.next4().x } else { 0.0 };
            (channel, self.flux) = part(self.flux, u);
        }
        channel
    }

    /// Lobes that the path follows: at its first vertex the specular ones alone, unless `Caustics::Any` counts later specular
    /// events.
    #[inline(always)]
    fn lobes(&self, params: &FrameParams) -> Classes {
        let mut lobes = Classes::ALL;
        if self.vertices == 1 && params.caustics != Caustics::Any as u32 {
            lobes = Classes::SPECULAR;
        }
        lobes
    }

    /// BSDF of a vertex, and the media on both of its sides.
    #[inline(always)]
    fn scattering(
        &self,
        here: Vertex,
        material: Material,
        channel: Channel,
        lobes: Classes,
        context: PathContext<'_>,
    ) -> ScatteringVertex {
        ScatteringVertex::new(
            here,
            material,
            context.scene.materials,
            self.media,
            self.flux,
            channel,
            lobes,
            false,
            context.params.specular_roughness,
            context.features,
        )
    }

    /// Whether a photon is stored. A textured surface counts as a receiver: collection points see coarser texture levels, at
    /// which it may receive.
    #[inline(always)]
    fn leaves_photon(&self, scattering: &ScatteringVertex, material: &Material, features: Features) -> bool {
        let textured = features.has(Features::TEXTURES | Features::NORMAL_MAPS)
            && material.flags & FLAGS_SCATTER_TEXTURE != 0;
        let receives = textured || scattering.bsdf.receives();
        self.is_caustic && receives && cos_arriving(&scattering.vertex) > 0.0
    }

    /// Geometry of the photon.
    #[inline(always)]
    fn photon_geometry(&self, here: &Vertex) -> PhotonGeometry {
        PhotonGeometry {
            position: here.position,
            scatterings: self.vertices - 1,
            normal: here.face_normal,
            instance: here.instance,
        }
    }

    /// Light of the photon: its flux over the cosine to the face normal, see
    /// [`Receiver::contribution`](crate::gather::contribution::Receiver::contribution).
    #[inline(always)]
    fn photon_light(
        &self,
        here: &Vertex,
        hit: &Hit,
        emission: &EmissionSample,
        context: PathContext<'_>,
    ) -> PhotonLight {
        let mut flux = self.flux / cos_arriving(here);
        if context.features.has(Features::BLENDS) {
            // Camera paths meet a blended surface with the same probability: the product counts its alpha once.
            flux /= CutOuts::new(context.scene, context.features).share(hit.triangle, hit.u, hit.v);
        }
        PhotonLight {
            to_light: here.to_previous,
            start_code: emission.start_code,
            flux,
            score: emission.score,
        }
    }

    /// Multiplies the flux by f cos / pdf, corrected for shading normals. A specular event makes the flux a caustic, unless it
    /// passes a thin wall.
    #[inline(always)]
    pub fn scatter(&mut self, scattering: &ScatteringVertex, scattered: &BsdfSample, passes: bool) {
        let arriving = self.flux;
        self.flux *= scattered.sampled.weight * shading_normal_correction(scattering, scattered);
        self.ledger.leave(scattered, arriving, self.flux);
        if scattered.sampled.class == Classes::SPECULAR && !passes {
            self.is_caustic = true;
        }
    }

    /// Whether the path can store no caustic photon any more: a specular event at the last vertex comes too late for one.
    #[inline(always)]
    fn is_too_late_for_a_caustic(&self, scattered: &BsdfSample, params: &FrameParams) -> bool {
        scattered.sampled.class != Classes::SPECULAR
            && !self.is_caustic
            && self.vertices + 1 == params.max_bounces
    }

    /// Cuts the path by its length.
    #[inline(always)]
    fn cut(&mut self) {
        self.ledger.cut(self.flux);
        self.cut = 1;
    }

    /// Leaves the vertex.
    #[inline(always)]
    fn leave(&mut self, scattered: &BsdfSample, passes: bool) {
        self.media_overflows += u32::from(scattered.media_overflow);
        self.media = scattered.media;
        self.ray = scattered.ray;
        if passes {
            self.passed_walls += 1;
        } else {
            self.vertices += 1;
        }
    }

    /// Counts what happened on the path.
    #[inline(always)]
    fn count<C: Atomics>(self, index: u32, params: &FrameParams, counters: &mut C) {
        // Training paths follow those of the frame; their work counts, they and their energy do not.
        if index < params.light_path_count {
            self.ledger.close(index, params.inverse_quantum(), counters);
            counters.add(Counter::LightPaths as u32, 1);
        }
        counters.add(Counter::LightRays as u32, self.rays);
        count_rare(Counter::Photons, self.photons, counters);
        count_rare(Counter::Cut, self.cut, counters);
        count_rare(Counter::MediaOverflow, self.media_overflows, counters);
        count_rare(Counter::UnexpectedFaces, self.unexpected_faces, counters);
    }
}

/// Probability that a path survives a scattering: the share of the flux that a non-specular lobe leaves; 1 at specular lobes.
#[inline(always)]
pub fn survival_probability(scattered: &BsdfSample) -> f32 {
    let mut survival = 1.0;
    if scattered.sampled.class == Classes::NON_SPECULAR {
        survival = scattered.sampled.weight.max_element().min(1.0);
    }
    survival
}

/// Cosine between the face normal and the direction that light arrives from.
#[inline(always)]
fn cos_arriving(here: &Vertex) -> f32 {
    here.to_previous.dot(here.face_normal)
}

/// Correction of flux where the shading normal is not the face's [Veach 1997, 5.3]:
/// |arriving . n_s| |leaving . n_g| / (|arriving . n_g| |leaving . n_s|).
#[inline(always)]
fn shading_normal_correction(scattering: &ScatteringVertex, scattered: &BsdfSample) -> f32 {
    let vertex = &scattering.vertex;
    let direction: Vec3 = scattered.ray.direction;
    let shading = vertex.to_previous.dot(vertex.shading_normal) * direction.dot(vertex.face_normal);
    let geometric = vertex.to_previous.dot(vertex.face_normal) * direction.dot(vertex.shading_normal);
    if geometric == 0.0 { 0.0 } else { (shading / geometric).abs() }
}
