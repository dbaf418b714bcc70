//! Cameras and lights that move with nodes.

use caustics_kernels::interface::features::Features;

use super::{PunctualLight, SceneCamera};

/// A camera or a light on a node.
#[derive(Clone, Debug, PartialEq)]
pub struct OnNode<T> {
    /// Index of the node.
    pub joint: usize,
    /// Whether the node moves.
    pub moves: bool,
    /// The object in the node's space.
    pub what: T,
}

/// Moving objects of a scene besides its meshes.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Name of the file in messages.
    pub file: String,
    /// Cameras, in the scene's order.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
}

impl Motion {
    /// Types of the punctual lights that emit at some time.
    pub fn lights(&self) -> Features {
        let lights = self.lights.iter().filter(|light| light.what.intensity.max_element() > 0.0);
        lights.fold(Features(0), |all, light| all | light.what.shape.feature())
    }
}
