//! `shoot.*`: traces light sub-paths and stores their photons. An emission declares the pass by `shoot_pass`.

use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::scene::SceneTables;
use crate::light::emit::Emit;
use crate::math::rng::{Rng, Stream};
use crate::path::PathContext;
use crate::path::light_path::trace_light_path;
use crate::path::photon_sink::{PhotonSink, PhotonStore};
use crate::platform::Atomics;
use crate::trace::Tracer;

/// Declares the pass that shoots by an emission. `shoot_pass!("shoot.mine", |power, table: &[f32]| Mine { power, table })` makes
/// `shoot` and `SHOOT`, which bind `table`, and `starts`, which reads it. The expression makes the emission (`Emit`) from a start
/// by power and the buffers. Passes of the shared entry point begin with `shared_entry`.
#[macro_export]
macro_rules! shoot_pass {
    ($($shared_entry:ident)? $name:literal, |$power:ident $(, $buffer:ident: $type:ty)*| $emit:expr) => {
        /// Traces the light paths of a batch, one an invocation, and stores their photons.
        #[$crate::declare::pass(name = $name, over = params.light_path_batch, work = Light $(, $shared_entry)?)]
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
            let store = $crate::path::photon_sink::PhotonStore {
                geometry: photon_geometry,
                light: photon_light,
                state: photon_state,
                starts: start_counts,
                params,
                features,
            };
            let path = dispatch.first + index;
            $crate::pass::shoot::stored(path, params, features, scene, &$emit, tracer, store, counters);
        }

        /// Passes the emission that starts the light paths of a frame to `then`, for callers that trace some of them again.
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

/// Traces a light path of the frame and stores its photons.
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

/// Traces a light path of the frame. Returns the state that its sink carried along the path.
#[inline(always)]
pub fn shoot<E: Emit, T: Tracer, S: PhotonSink, C: Atomics>(
    path: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    emit: &E,
    tracer: &mut T,
    sink: &mut S,
    counters: &mut C,
) -> S::PathState {
    let rng = Rng::new(Stream::Light, params.seed, path, params.frame);
    trace_light_path(path, rng, PathContext { params, features, scene }, emit, tracer, sink, counters)
}
