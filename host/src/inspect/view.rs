//! Inputs for tracing the paths of a frame again.

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use glam::Vec3;

use caustics_scene::Scene;

/// Frame that is inspected, with its scene.
#[derive(Clone, Copy)]
pub struct InspectedFrame<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Parameters of the frame.
    pub params: &'a FrameParams,
    /// Features that were compiled into the kernels.
    pub features: Features,
}

impl InspectedFrame<'_> {
    /// Converts a position to the file's coordinates (m).
    pub fn file_position(&self, position: Vec3) -> [f64; 3] {
        (position.as_dvec3() + self.scene.origin).to_array()
    }
}
