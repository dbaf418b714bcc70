//! Passes that trace camera paths: which path an invocation traces, and what it stores of it. On a GPU they share an entry point
//! (`shared_entry`).

use super::PathContext;
use super::camera_path::{CameraPathLight, CameraSuffix, trace_camera_path};
use super::camera_ray::CameraPathStart;
use super::observer::PathObserver;
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::scene::SceneTables;
use crate::math::rng::Stream;
use crate::platform::Atomics;
use crate::trace::Tracer;

/// Pass over camera paths: requests a path for each invocation, and stores its light.
pub trait CameraPass: PathObserver {
    /// Features that paths are traced with: those of the scene, and those that the pass needs.
    #[inline(always)]
    fn features(&self, features: Features) -> Features {
        features
    }
    /// Requests the path of this invocation.
    fn request(&self) -> CameraPathRequest;
    /// Stores the light of the path.
    fn store(&mut self, light: &CameraPathLight, kept: &Self::Kept);
}

/// The camera path that an invocation traces.
#[derive(Clone, Copy, Debug)]
pub struct CameraPathRequest {
    /// Pixel that the path goes through; `NONE`: no path is traced.
    pub pixel: u32,
    /// Stream of its random numbers.
    pub stream: Stream,
    /// Its number among the paths of its stream and pixel in a frame.
    pub number: u32,
    /// Lobes behind its collection point.
    pub suffix: CameraSuffix,
}

/// Traces the path of an invocation and stores its light; without a path, no light.
#[inline(always)]
pub fn run_camera_pass<P: CameraPass, T: Tracer, C: Atomics>(
    mut pass: P,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
    counters: &mut C,
) {
    let context = PathContext { params, features: pass.features(features), scene };
    let CameraPathRequest { pixel, stream, number, suffix } = pass.request();
    let (mut light, mut kept) = (CameraPathLight::default(), P::Kept::default());
    if pixel != NONE {
        let start = CameraPathStart::new(stream, number, pixel, params);
        (light, kept) = trace_camera_path(start, suffix, context, tracer, &mut pass, counters);
    }
    pass.store(&light, &kept);
}
