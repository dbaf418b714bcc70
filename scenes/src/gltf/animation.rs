//! Moving nodes: groups, and channels of the document's single animation.

use glam::{DQuat, DVec3};
use serde_json::json;

use super::{Document, Node};

/// Animated property of a node.
#[derive(Clone, Copy, Debug)]
pub enum Property {
    /// Translation (m).
    Translation,
    /// Orientation, a unit quaternion x, y, z, w.
    Rotation,
    /// Scale along the node's axes.
    Scale,
}

/// Interpolation between keys.
#[derive(Clone, Copy, Debug)]
pub enum Interpolation {
    /// Holds the earlier key.
    Step,
    /// Linear; rotations take the shortest arc.
    Linear,
    /// Cubic; a key has three rows: arriving tangent [1/s], value, leaving tangent [1/s].
    Cubic,
}

impl Document {
    /// Sets the translation of a node (m).
    pub fn place(&mut self, node: Node, translation: DVec3) {
        self.nodes[node.0]["translation"] = json!(translation.to_array());
    }

    /// Sets the rotation of a node.
    pub fn turn(&mut self, node: Node, rotation: DQuat) {
        self.nodes[node.0]["rotation"] = json!(rotation.as_quat().to_array());
    }

    /// Adds a parent node of other nodes.
    pub fn group(&mut self, name: &str, children: &[Node]) -> Node {
        let children: Vec<usize> = children.iter().map(|child| child.0).collect();
        self.nodes.push(json!({ "children": children, "name": name }));
        self.children.extend(children);
        Node(self.nodes.len() - 1)
    }

    /// Animates a node: values at times (s).
    pub fn animate<const N: usize>(
        &mut self,
        node: Node,
        property: Property,
        interpolation: Interpolation,
        times: &[f64],
        values: &[[f64; N]],
    ) {
        let (path, components) = match property {
            Property::Translation => ("translation", 3),
            Property::Rotation => ("rotation", 4),
            Property::Scale => ("scale", 3),
        };
        let (name, rows) = match interpolation {
            Interpolation::Step => ("STEP", 1),
            Interpolation::Linear => ("LINEAR", 1),
            Interpolation::Cubic => ("CUBICSPLINE", 3),
        };
        assert_eq!((N, values.len()), (components, rows * times.len()), "values of {path}, {name}");
        let input = self.floats(times.iter().copied(), "SCALAR", times.len());
        // Readers need the first and the last time.
        self.accessors[input]["min"] = json!([times[0] as f32]);
        self.accessors[input]["max"] = json!([times[times.len() - 1] as f32]);
        let output =
            self.floats(values.iter().flatten().copied(), if N == 3 { "VEC3" } else { "VEC4" }, values.len());
        self.channels.push(json!({
            "sampler": self.samplers.len(), "target": { "node": node.0, "path": path },
        }));
        self.samplers.push(json!({ "input": input, "interpolation": name, "output": output }));
    }

    fn floats(&mut self, values: impl Iterator<Item = f64>, kind: &str, count: usize) -> usize {
        let bytes: Vec<u8> = values.flat_map(|value| (value as f32).to_le_bytes()).collect();
        let view = self.plain_view(&bytes);
        self.accessors.push(json!({
            "bufferView": view, "componentType": 5126, "count": count, "type": kind,
        }));
        self.accessors.len() - 1
    }
}
