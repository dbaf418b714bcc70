//! Reprojected points: collection points of this frame at their positions in the previous one.

use crate::gather::contribution::is_same_surface;
use crate::interface::history::HistoryPoint;
use crate::interface::instance::Instance;
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::octahedral;
use spirv_std::glam::Vec3;

/// A collection point of this frame at its position in the previous one.
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
    /// Point at its present position.
    #[inline(always)]
    pub fn unmoved(point: &PointGeometry, shading: &PointShading) -> Self {
        ReprojectedPoint {
            position: point.position,
            normal: point.normal,
            radius: point.radius,
            material: shading.material,
        }
    }

    /// Point at the previous position of its instance.
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

    /// Whether a history point, `along` away, is of the same surface, so that its light is reusable.
    #[inline(always)]
    pub fn accepts(&self, history_point: &HistoryPoint, along: Vec3) -> bool {
        is_same_surface(along, self.normal, octahedral::decode(history_point.normal), self.radius)
    }
}
