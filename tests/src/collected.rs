//! Camera paths with their collection points, for tests.

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::scene::SceneTables;
use caustics_kernels::math::rng::Stream;
use caustics_kernels::path::PathContext;
use caustics_kernels::path::camera_path::{CameraPathLight, CameraSuffix, trace_camera_path};
use caustics_kernels::path::camera_ray::CameraPathStart;
use caustics_kernels::path::observer::{CollectionPoint, PathObserver};
use caustics_kernels::platform::Atomics;
use caustics_kernels::trace::Tracer;
use glam::Vec3;

/// Light and collection point of a camera path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Collected {
    /// All light of the path.
    pub light: CameraPathLight,
    /// Its collection point.
    pub point: CollectionPoint,
}

/// Traces the path of a pixel, as `collect` does.
pub fn camera_path<T: Tracer, C: Atomics>(
    pixel: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
    counters: &mut C,
) -> Collected {
    let start = CameraPathStart::new(Stream::Camera, 0, pixel, params);
    collected(start, CameraSuffix::new(params), params, features, scene, tracer, counters)
}

/// Traces a camera path.
pub fn collected<T: Tracer, C: Atomics>(
    start: CameraPathStart,
    suffix: CameraSuffix,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
    counters: &mut C,
) -> Collected {
    let context = PathContext { params, features, scene };
    let (light, point) = trace_camera_path(start, suffix, context, tracer, &mut PointObserver, counters);
    Collected { light, point }
}

/// Path observer that keeps the collection point alone.
struct PointObserver;

impl PathObserver for PointObserver {
    type Kept = CollectionPoint;

    fn collect(&mut self, kept: &mut CollectionPoint, point: &CollectionPoint) {
        *kept = *point;
    }

    fn end(&mut self, kept: &mut CollectionPoint, last: Vec3) {
        *kept = CollectionPoint::none(last);
    }
}
