//! The camera path of a pixel.

use caustics_kernels::math::cone::RayCone;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::pass::collect::{Beyond, camera_ray, watched};
use caustics_kernels::seam::Uncounted;

use super::record::Record;
use super::view::View;
use super::{CameraPath, Event};

/// Traces the path of a pixel: to its collection point, or all of it where methods have none.
pub fn path(view: View<'_>, pixel: u32, has_point: bool) -> CameraPath {
    let View { scene, params, features } = view;
    let (stream, beyond) =
        if has_point { (Stream::Camera, Beyond::NOTHING) } else { (Stream::Reference, Beyond::ALL) };
    let mut rng = Rng::new(stream, params.seed, pixel, params.frame);
    let ray = camera_ray(params, pixel, &mut rng);
    let cone = RayCone::at_eye(params.pixel_spread);
    let (mut tracer, mut record) = (scene.tracer(features), Record::new(view));
    let tables = scene.tables();
    watched(ray, cone, rng, beyond, params, features, tables, &mut tracer, &mut record, &mut Uncounted);
    if has_point && record.has_point {
        record.end(Event::CollectionPoint);
    } else if has_point && record.is_scattered() {
        // The first event that is not specular, behind as many vertices as paths have.
        record.end(Event::Ended);
    }
    CameraPath {
        eye: view.placed(ray.origin),
        direction: ray.direction.to_array(),
        vertices: record.vertices,
        leaves: record.left.map(|ray| ray.direction.to_array()),
    }
}
