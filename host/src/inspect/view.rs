//! What paths of a frame are traced again in.

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use glam::Vec3;

use caustics_scene::Scene;

/// A frame and its scene.
#[derive(Clone, Copy)]
pub struct InspectedFrame<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The settings of the frame.
    pub params: &'a FrameParams,
    /// Kernel code that was compiled in.
    pub features: Features,
}

impl InspectedFrame<'_> {
    /// A position in the file's coordinates (m).
    pub fn file_position(&self, position: Vec3) -> [f64; 3] {
        (position.as_dvec3() + self.scene.origin).to_array()
    }
}
