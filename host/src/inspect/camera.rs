//! Camera path of an inspected pixel.

use caustics_kernels::math::rng::Stream;
use caustics_kernels::path::PathContext;
use caustics_kernels::path::camera_path::{CameraSuffix, trace_camera_path};
use caustics_kernels::path::camera_ray::CameraPathStart;
use caustics_kernels::platform::Uncounted;

use super::record::PathRecorder;
use super::view::InspectedFrame;
use super::{CameraPath, Event};

/// Traces the camera path of a pixel, up to its collection point if `has_point`.
pub fn path(view: InspectedFrame<'_>, pixel: u32, has_point: bool) -> CameraPath {
    let InspectedFrame { scene, params, features } = view;
    let (stream, suffix) = if has_point {
        (Stream::Camera, CameraSuffix::NOTHING)
    } else {
        (Stream::Reference, CameraSuffix::ALL)
    };
    let start = CameraPathStart::new(stream, 0, pixel, params);
    let (mut tracer, mut record) = (scene.tracer(features), PathRecorder::new(view));
    let context = PathContext { params, features, scene: scene.tables() };
    trace_camera_path(start, suffix, context, &mut tracer, &mut record, &mut Uncounted);
    if has_point && record.has_point {
        record.end(Event::CollectionPoint);
    } else if has_point && record.is_scattered() {
        // The path reached its maximum length at a non-specular event.
        record.end(Event::Ended);
    }
    CameraPath {
        eye: view.file_position(start.ray.origin),
        direction: start.ray.direction.to_array(),
        vertices: record.vertices,
        leaves: record.left.map(|ray| ray.direction.to_array()),
    }
}
