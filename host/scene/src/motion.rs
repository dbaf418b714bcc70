//! What moves in a scene with its nodes: cameras and lights.

use caustics_kernels::interface::features::Features;

use super::{PunctualLight, SceneCamera};

/// Something on a node.
#[derive(Clone, Debug, PartialEq)]
pub struct OnNode<T> {
    /// Its node.
    pub joint: usize,
    /// Whether the node moves.
    pub moves: bool,
    /// What it is, not yet placed.
    pub what: T,
}

/// What moves in a scene beside its meshes.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// The file, for messages.
    pub file: String,
    /// Cameras, in the scene's order.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
}

impl Motion {
    /// Types of the punctual lights that shine at some time.
    pub fn lights(&self) -> Features {
        let lights = self.lights.iter().filter(|light| light.what.intensity.max_element() > 0.0);
        lights.fold(Features(0), |all, light| all | light.what.shape.feature())
    }
}
