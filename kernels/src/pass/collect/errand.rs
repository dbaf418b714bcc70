//! What camera paths are traced for. A pass says which path an invocation traces and what it leaves of it; all else is
//! [`follow`], which such passes share, on a GPU in one entry point (`joint`).

use super::observer::PathObserver;
use super::{CameraPathLight, CameraPathStart, CameraSuffix, follow};
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::scene::SceneTables;
use crate::math::rng::Stream;
use crate::platform::Atomics;
use crate::trace::Tracer;

/// What an invocation of a pass traces a camera path for.
pub trait Errand: PathObserver {
    /// What the path is traced with: what the scene needs, and what the pass asks for beside.
    #[inline(always)]
    fn features(&self, features: Features) -> Features {
        features
    }
    /// The path.
    fn wanted(&self) -> Wanted;
    /// Leaves what the path brought home.
    fn leave(&mut self, light: &CameraPathLight, kept: &Self::Kept);
}

/// A camera path that somebody wants.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// The pixel that it goes through; `NONE`: no path is traced, and it brings nothing.
    pub pixel: u32,
    /// Its random numbers.
    pub stream: Stream,
    /// What it does behind its collection point.
    pub suffix: CameraSuffix,
}

/// Runs an errand.
#[inline(always)]
pub fn run<E: Errand, T: Tracer, C: Atomics>(
    mut errand: E,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
    counters: &mut C,
) {
    let features = errand.features(features);
    let Wanted { pixel, stream, suffix } = errand.wanted();
    let (mut light, mut kept) = (CameraPathLight::default(), E::Kept::default());
    if pixel != NONE {
        let start = CameraPathStart::new(stream, pixel, params);
        (light, kept) = follow(start, suffix, params, features, scene, tracer, &mut errand, counters);
    }
    errand.leave(&light, &kept);
}
