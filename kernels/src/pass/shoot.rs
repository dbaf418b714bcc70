//! `shoot.*`: traces light sub-paths. Every hit after at least one specular event deposits its flux; that event is the first,
//! or with `Caustics::Any` any. An emission declares the pass by `shoot_pass`.

pub mod ledger;
pub mod photon_sink;

use crate::interface::choice::Caustics;
use crate::interface::counters::Counter;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::material::FLAGS_SCATTER_TEXTURE;
use crate::interface::point::{PhotonGeometry, PhotonLight};
use crate::interface::scene::SceneTables;
use crate::light::emit::Emit;
use crate::math::is_finite;
use crate::math::rng::{Rng, Stream};
use crate::platform::Atomics;
use crate::surface::class::Classes;
use crate::surface::dispersion::{Channel, is_mixed, needs_channel, part};
use crate::surface::media::MediaStack;
use crate::surface::scatter::{BsdfSample, ScatteringVertex};
use crate::surface::textured::material_at;
use crate::surface::vertex::vertex;
use crate::trace::Tracer;
use crate::trace::initial_media::initial_media_stack;
use crate::trace::through_media::trace_through_media;
use ledger::Ledger;
use photon_sink::{PhotonSink, PhotonStore};
use spirv_std::glam::Vec3;

/// The pass that shoots by an emission: `shoot_pass!("shoot.mine", |power, table: &[f32]| Mine { power, table })` declares
/// `shoot` and `SHOOT`, which bind `table`, and `starts`, which reads it. The expression makes the emission (`Emit`) of a start by
/// power and of its buffers. Those that shoot by an entry point of `joint` say `joint` first.
#[macro_export]
macro_rules! shoot_pass {
    ($($joint:ident)? $name:literal, |$power:ident $(, $buffer:ident: $type:ty)*| $emit:expr) => {
        /// Light paths of a batch, one an invocation; photons are stored.
        #[$crate::declare::pass(name = $name, over = params.light_path_batch, work = Light $(, $joint)?)]
        pub fn shoot(
            index: u32,
            params: &$crate::interface::frame::FrameParams,
            dispatch: $crate::interface::frame::Dispatch,
            features: $crate::interface::features::Features,
            scene: $crate::interface::scene::SceneTables<'_>,
            tracer: &mut impl $crate::trace::Tracer,
            counters: &mut impl $crate::platform::Atomics,
            #[len = params.photon_capacity]
            photon_geometry: $crate::platform::Slots<'_, $crate::interface::point::PhotonGeometry>,
            #[len = params.photon_capacity]
            photon_light: $crate::platform::Slots<'_, $crate::interface::point::PhotonLight>,
            #[len = $crate::interface::counters::PHOTON_STATE_COUNT as u32]
            photon_state: $crate::platform::AtomicWords<'_>,
            #[len = 0]
            start_counts: $crate::platform::AtomicWords<'_>,
            $($buffer: $type,)*
        ) {
            let $power = $crate::light::power::ByPower::new(scene, params, features);
            let store = $crate::pass::shoot::photon_sink::PhotonStore {
                geometry: photon_geometry,
                light: photon_light,
                state: photon_state,
                starts: start_counts,
                capacity: params.photon_capacity,
            };
            let path = dispatch.first + index;
            $crate::pass::shoot::stored(path, params, features, scene, &$emit, tracer, store, counters);
        }

        /// Hands on what starts the light paths of a frame, for who traces some of them again.
        #[cfg(not(target_arch = "spirv"))]
        pub fn starts(
            scene: $crate::interface::scene::SceneTables<'_>,
            params: &$crate::interface::frame::FrameParams,
            features: $crate::interface::features::Features,
            _buffers: &$crate::declare::Buffers,
            then: &mut dyn FnMut(&(dyn $crate::light::emit::Emit + Sync)),
        ) -> Result<(), $crate::declare::BufferError> {
            let $power = $crate::light::power::ByPower::new(scene, params, features);
            $(
                let $buffer = _buffers.read(stringify!($buffer))?;
                let $buffer: $type = &$buffer;
            )*
            then(&$emit);
            Ok(())
        }
    };
}

/// Traces a light path and stores its photons.
#[inline(always)]
pub fn stored<E: Emit, T: Tracer, C: Atomics>(
    path: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    emit: &E,
    tracer: &mut T,
    mut store: PhotonStore<'_>,
    counters: &mut C,
) {
    let dropped = shoot(path, params, features, scene, emit, tracer, &mut store, counters);
    store.close(dropped, counters);
}

/// Traces a light path; what its receiver carried along the way.
#[inline(always)]
pub fn shoot<E: Emit, T: Tracer, R: PhotonSink, C: Atomics>(
    path: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    emit: &E,
    tracer: &mut T,
    sink: &mut R,
    counters: &mut C,
) -> R::PathState {
    let rng = Rng::new(Stream::Light, params.seed, path, params.frame);
    follow(path, rng, params, features, scene, emit, tracer, sink, counters)
}

/// Traces the light path that these random numbers make; what its receiver carried along the way.
#[inline(always)]
pub fn follow<E: Emit, T: Tracer, R: PhotonSink, C: Atomics>(
    path: u32,
    mut rng: Rng,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    emit: &E,
    tracer: &mut T,
    sink: &mut R,
    counters: &mut C,
) -> R::PathState {
    let emission = emit.sample(&mut rng);
    let mut path_state = R::PathState::default();
    sink.start(&mut path_state, &emission);
    let mut flux = emission.flux / params.light_path_count as f32;
    let mut ray = emission.ray;
    let mut media = MediaStack::VACUUM;
    if features.has(Features::STARTS_IN_MEDIUM) {
        media = initial_media_stack(ray.origin, features, scene, tracer);
    }
    let mut ledger = Ledger::new(params, path, features);
    ledger.emit(flux);
    let mut caustic = false;
    let (mut rays, mut photons, mut cut, mut overflows, mut unexpected) = (0, 0, 0, 0, 0);

    // Hit `hit_count` lies behind `hit_count - 1` scatterings; one more is left for the collection point. What carries nothing
    // meets nothing.
    let mut hit_count = if flux.element_sum() > 0.0 { 1 } else { params.max_bounces + 1 };
    while hit_count <= params.max_bounces {
        rays += 1;
        if features.has(Features::BLENDS) {
            ray.key = rng.ray_key(0);
        }
        let traced = trace_through_media(&ray, media, features, scene, tracer);
        let hit = traced.hit;
        media = traced.media;
        overflows += traced.overflows;
        unexpected += traced.unexpected;
        if hit.is_miss() {
            ledger.escape(flux);
            break;
        }
        let here = vertex(scene, features, &ray, &hit, 0.0);
        sink.arrive(&mut path_state, &ray, &hit, &here);
        let material = material_at(scene, &here, features);
        if features.has(Features::ABSORPTION) {
            let before = flux;
            flux *= traced.transmittance;
            ledger.pass(before, flux);
        }
        let mut followed = Classes::ALL;
        if hit_count == 1 && params.caustics != Caustics::Any as u32 {
            followed = Classes::SPECULAR;
        }
        let mut channel = Channel::GREEN;
        if needs_channel(&here, &material, scene.materials, media, features) {
            let u = if is_mixed(flux) { rng.next4().x } else { 0.0 };
            (channel, flux) = part(flux, u);
        }
        let scattering = ScatteringVertex::new(
            here,
            material,
            scene.materials,
            media,
            flux,
            channel,
            followed,
            false,
            params.specular_roughness,
            features,
        );
        let cos_arriving = here.to_previous.dot(here.face_normal);
        // Points see textures at a coarser level, where the surface may scatter although it does not here.
        let textured = features.has(Features::TEXTURES | Features::NORMAL_MAPS)
            && material.flags & FLAGS_SCATTER_TEXTURE != 0;
        let receives = textured || scattering.bsdf.receives();
        if caustic && receives && cos_arriving > 0.0 {
            photons += 1;
            sink.store_photon(
                &mut path_state,
                PhotonGeometry {
                    position: here.position,
                    scatterings: hit_count - 1,
                    normal: here.face_normal,
                    instance: here.instance,
                },
                PhotonLight {
                    to_light: here.to_previous,
                    texel: emission.texel,
                    flux: flux / cos_arriving,
                    score: emission.score,
                },
            );
        }
        if !scattering.bsdf.scatters() {
            ledger.arrive(&scattering, followed, flux);
            break;
        }
        if hit_count == params.max_bounces {
            ledger.cut(flux);
            cut = 1;
            break;
        }

        ledger.arrive(&scattering, followed, flux);
        let u = rng.next4();
        let scattered = scattering.sample(u);
        let arriving = flux;
        flux *= scattered.sampled.weight * adjoint(&scattering, &scattered);
        ledger.leave(&scattered, arriving, flux);
        if scattered.sampled.class == Classes::SPECULAR {
            caustic = true;
        } else if !caustic && hit_count + 1 == params.max_bounces {
            // Too late for a caustic: the last hit could only receive direct light's continuation.
            ledger.cut(flux);
            cut = 1;
            break;
        }

        // Russian roulette where flux is lost to diffuse absorption.
        if scattered.sampled.class == Classes::NON_SPECULAR {
            let survival = scattered.sampled.weight.max_element().min(1.0);
            if u.w >= survival {
                break;
            }
            flux /= survival;
        }
        let carried = flux.element_sum();
        if !is_finite(carried) || carried <= 0.0 {
            break;
        }
        overflows += u32::from(scattered.media_overflow);
        sink.scatter(&mut path_state, &scattered, flux);
        media = scattered.media;
        ray = scattered.ray;
        hit_count += 1;
    }

    ledger.close(path, params.inverse_quantum(), counters);
    counters.add(Counter::LightPaths as u32, 1);
    counters.add(Counter::LightRays as u32, rays);
    if photons != 0 {
        counters.add(Counter::Photons as u32, photons);
    }
    if cut != 0 {
        counters.add(Counter::Cut as u32, cut);
    }
    if overflows != 0 {
        counters.add(Counter::MediaOverflow as u32, overflows);
    }
    if unexpected != 0 {
        counters.add(Counter::UnexpectedFaces as u32, unexpected);
    }
    path_state
}

/// Correction of flux where the shading normal is not the face's [Veach 1997, 5.3]:
/// |arriving . n_s| |leaving . n_g| / (|arriving . n_g| |leaving . n_s|).
#[inline(always)]
fn adjoint(scattering: &ScatteringVertex, scattered: &BsdfSample) -> f32 {
    let vertex = &scattering.vertex;
    let direction: Vec3 = scattered.ray.direction;
    let shading = vertex.to_previous.dot(vertex.shading_normal) * direction.dot(vertex.face_normal);
    let geometric = vertex.to_previous.dot(vertex.face_normal) * direction.dot(vertex.shading_normal);
    if geometric == 0.0 { 0.0 } else { (shading / geometric).abs() }
}
