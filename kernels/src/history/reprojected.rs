//! A collection point of today where it was in the frame before.

use crate::gather::contribution::is_same_surface;
use crate::interface::history::HistoryPoint;
use crate::interface::instance::Instance;
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::octahedral;
use spirv_std::glam::Vec3;

/// A point of today where it was in the frame before.
#[derive(Clone, Copy)]
pub struct ReprojectedPoint {
    /// Position (m).
    pub position: Vec3,
    /// Unit normal of the face.
    pub normal: Vec3,
    /// Radius of the disc (m).
    pub radius: f32,
    /// Index into the materials.
    pub material: u32,
}

impl ReprojectedPoint {
    /// Where the point is.
    #[inline(always)]
    pub fn unmoved(point: &PointGeometry, shading: &PointShading) -> Self {
        ReprojectedPoint {
            position: point.position,
            normal: point.normal,
            radius: point.radius,
            material: shading.material,
        }
    }

    /// Where the instance of a point was.
    #[inline(always)]
    pub fn new(point: &PointGeometry, shading: &PointShading, instances: &[Instance]) -> Self {
        let mut point_before = ReprojectedPoint::unmoved(point, shading);
        if shading.instance != 0 {
            let motion = instances[shading.instance as usize].to_previous;
            point_before.position = motion.point(point.position);
            point_before.normal = motion.vector(point.normal).normalize();
        }
        point_before
    }

    /// Whether a point is of the same surface, so that its light is reusable, `along` away from it.
    #[inline(always)]
    pub fn accepts(&self, history_point: &HistoryPoint, along: Vec3) -> bool {
        is_same_surface(along, self.normal, octahedral::decode(history_point.normal), self.radius)
    }
}
