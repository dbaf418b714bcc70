//! Animations: values of keys at a time, and the node transforms that follow from them. All in f64.

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};

/// Number of equal parts of the animations' duration, at whose ends [`NodeTree::looks`] samples the poses.
const LOOKS: u32 = 8;

/// Property of a node that a channel sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Path {
    /// Translation (m).
    Translation,
    /// Rotation, a quaternion.
    Rotation,
    /// Scale.
    Scale,
    /// Weights of its mesh's morph targets, four in each channel.
    Weights,
}

/// Interpolation between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Holds the earlier key's value.
    Step,
    /// Linear; rotations take the shorter arc.
    Linear,
    /// Cubic Hermite spline; rotations are normalised afterwards.
    Cubic,
}

/// The keys of one property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The property that the channel sets.
    pub path: Path,
    /// Interpolation between its keys.
    pub interpolation: Interpolation,
    /// Times of the keys (s), ascending, at least one.
    pub times: Vec<f64>,
    /// One value a key. A spline has three: the tangent before [1/s], the value, and the tangent after [1/s].
    pub values: Vec<DVec4>,
}

impl Channel {
    /// Returns the value at a time (s). Before the first key and after the last, that key's value holds. Rotations have unit
    /// length.
    pub fn at(&self, time: f64) -> DVec4 {
        let last = self.times.len() - 1;
        let key = self.times.partition_point(|&key| key <= time).saturating_sub(1);
        let is_before = time <= self.times[0];
        if is_before || key == last || self.interpolation == Interpolation::Step {
            return self.unit(self.value(key), key);
        }
        let interval = self.times[key + 1] - self.times[key];
        let share = (time - self.times[key]) / interval;
        let (from, to) = (self.value(key), self.value(key + 1));
        match (self.interpolation, self.path) {
            (Interpolation::Cubic, _) => {
                let (leave, arrive) = (self.values[3 * key + 2], self.values[3 * (key + 1)]);
                self.unit(hermite(from, leave * interval, to, arrive * interval, share), key)
            }
            (_, Path::Rotation) => {
                let [from, to] = [from, to].map(|value| DQuat::from_vec4(value.normalize()));
                DVec4::from(from.slerp(to, share).normalize())
            }
            _ => from + (to - from) * share,
        }
    }

    fn value(&self, key: usize) -> DVec4 {
        if self.interpolation == Interpolation::Cubic { self.values[3 * key + 1] } else { self.values[key] }
    }

    /// Normalises a rotation. A spline that passes through zero keeps the value of its key.
    fn unit(&self, value: DVec4, key: usize) -> DVec4 {
        if self.path != Path::Rotation {
            return value;
        }
        value.try_normalize().unwrap_or_else(|| self.value(key).normalize())
    }
}

/// A cubic from `from` to `to` with the given slopes, at `t` in [0, 1].
fn hermite(from: DVec4, leave: DVec4, to: DVec4, arrive: DVec4, t: f64) -> DVec4 {
    let (t2, t3) = (t * t, t * t * t);
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + leave * (t3 - 2.0 * t2 + t)
        + to * (3.0 * t2 - 2.0 * t3)
        + arrive * (t3 - t2)
}

/// A node's own transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Local {
    /// Translation (m).
    pub translation: DVec3,
    /// Rotation of any length above zero.
    pub rotation: DQuat,
    /// Scale.
    pub scale: DVec3,
    /// Matrix in place of rotation and scale, for a node that no animation moves. Rotation and scale then approximate it.
    pub matrix: Option<DMat3>,
    /// Channels of the file's animations.
    pub channels: Vec<Channel>,
    /// Channels of the user's edits; they override the animations.
    pub edits: Vec<Channel>,
}

impl Default for Local {
    fn default() -> Local {
        Local {
            translation: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            scale: DVec3::ONE,
            matrix: None,
            channels: Vec::new(),
            edits: Vec::new(),
        }
    }
}

impl Local {
    /// Returns the transform at a time (s); `None` if it is not finite or its rotation has no length.
    pub fn at(&self, time: f64) -> Option<DAffine3> {
        let (mut translation, mut rotation, mut scale) = (self.translation, self.rotation, self.scale);
        for channel in self.channels.iter().chain(&self.edits) {
            let value = channel.at(time);
            match channel.path {
                Path::Translation => translation = value.truncate(),
                Path::Rotation => rotation = DQuat::from_vec4(value),
                Path::Scale => scale = value.truncate(),
                Path::Weights => {}
            }
        }
        let is_turned = self.edits.iter().any(|edit| edit.path != Path::Translation);
        let transform = match self.matrix.filter(|_| !is_turned) {
            Some(matrix3) => DAffine3 { matrix3, translation },
            None => {
                let rotation = (rotation.length() > 1e-6).then(|| rotation.normalize())?;
                DAffine3::from_scale_rotation_translation(scale, rotation, translation)
            }
        };
        transform.is_finite().then_some(transform)
    }
}

/// A node of the rig.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Node {
    /// Name of the node in messages.
    pub label: String,
    /// The file's node; `None` for a node that the file does not have.
    pub of_file: Option<OfFile>,
    /// Index of its parent, which comes before it.
    pub parent: Option<usize>,
    /// Transform relative to the parent.
    pub local: Local,
    /// Whether the node or an ancestor has channels or may be edited.
    pub moves: bool,
    /// Weights of its mesh's morph targets.
    pub morph: Morph,
}

/// A node as the file describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OfFile {
    /// Index among the file's nodes.
    pub index: usize,
    /// Name in the file.
    pub name: Option<String>,
    /// Whether it has a mesh.
    pub has_mesh: bool,
    /// Whether it has a punctual light.
    pub has_light: bool,
    /// Whether it has a camera.
    pub has_camera: bool,
}

/// Weights of a node's morph targets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Morph {
    /// Weights without channels, one a target.
    pub weights: Vec<f64>,
    /// Channels that set the weights, four each; empty, or covering all targets.
    pub channels: Vec<Channel>,
}

impl Morph {
    /// Returns the weights at a time (s), one a target.
    pub fn at(&self, time: f64) -> Vec<f64> {
        if self.channels.is_empty() {
            return self.weights.clone();
        }
        let all = self.channels.iter().flat_map(|channel| channel.at(time).to_array());
        all.take(self.weights.len()).collect()
    }
}

/// Transforms and weights of all nodes at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Nodes {
    /// Transform from each node to the world.
    pub to_world: Vec<DAffine3>,
    /// Weights of each node's morph targets.
    pub weights: Vec<Vec<f64>>,
}

/// The glTF node tree, parents first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeTree {
    /// Nodes.
    pub joints: Vec<Node>,
}

impl Node {
    /// All channels of its animations and of the user's edits.
    fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.local.channels.iter().chain(&self.morph.channels).chain(&self.local.edits)
    }
}

impl NodeTree {
    /// Returns the transforms of all nodes at a time (s), or the index of the first node whose transform is not finite.
    pub fn at(&self, time: f64) -> Result<Nodes, usize> {
        let mut to_world: Vec<DAffine3> = Vec::with_capacity(self.joints.len());
        for (id, joint) in self.joints.iter().enumerate() {
            let parent = joint.parent.map_or(DAffine3::IDENTITY, |parent| to_world[parent]);
            let node_to_world = joint.local.at(time).map(|local| parent * local);
            to_world.push(node_to_world.filter(DAffine3::is_finite).ok_or(id)?);
        }
        let weights = self.joints.iter().map(|joint| joint.morph.at(time)).collect();
        Ok(Nodes { to_world, weights })
    }

    /// A node and its ancestors.
    pub fn upwards(&self, joint: usize) -> impl Iterator<Item = &Node> {
        let node = |id: usize| self.joints.get(id);
        std::iter::successors(node(joint), move |child| node(child.parent?))
    }

    /// Nodes at `LOOKS + 1` times, evenly over the animations. Times at which a transform is not finite are left out.
    pub fn looks(&self) -> impl Iterator<Item = Nodes> + '_ {
        let last = self.duration();
        let times = (0..=LOOKS).map(move |look| last * f64::from(look) / f64::from(LOOKS));
        times.filter_map(|time| self.at(time).ok())
    }

    /// Time of the last key (s); 0 where nothing moves.
    pub fn duration(&self) -> f64 {
        let channels = self.joints.iter().flat_map(Node::channels);
        channels.filter_map(|channel| channel.times.last()).fold(0.0, |last: f64, &time| last.max(time))
    }
}

/// Whether a transform flattens space: a scale of zero, or axes in one plane.
pub fn is_singular(transform: &DAffine3) -> bool {
    let axes = transform.matrix3;
    let size = axes.x_axis.length() * axes.y_axis.length() * axes.z_axis.length();
    // The negation makes a transform that is not finite count as singular.
    !(axes.determinant().abs() > 1e-12 * size && transform.inverse().is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(path: Path, interpolation: Interpolation, times: &[f64], values: &[[f64; 4]]) -> Channel {
        let values = values.iter().map(|&value| DVec4::from(value)).collect();
        Channel { path, interpolation, times: times.into(), values }
    }

    #[test]
    fn steps_hold_lines_interpolate_and_end_values_hold_outside() {
        let values = [[1.0, 2.0, 3.0, 0.0], [3.0, 2.0, -1.0, 0.0], [7.0, 0.0, 0.0, 0.0]];
        let translation =
            |interpolation| channel(Path::Translation, interpolation, &[1.0, 2.0, 4.0], &values);
        let (step, line) = (translation(Interpolation::Step), translation(Interpolation::Linear));
        for (time, stepped, joined) in [
            (-1.0, 1.0, 1.0),
            (1.0, 1.0, 1.0),
            (1.5, 1.0, 2.0),
            (2.0, 3.0, 3.0),
            (3.5, 3.0, 6.0),
            (9.0, 7.0, 7.0),
        ] {
            assert_eq!((step.at(time).x, line.at(time).x), (stepped, joined), "at {time}");
        }
    }

    #[test]
    fn rotations_take_the_shorter_arc() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // A quarter turn about z. Its end is written as q, as -q, and at half length.
        for sign in [1.0, -1.0, 0.5] {
            let end = [0.0, 0.0, sign * half, sign * half];
            let turn =
                channel(Path::Rotation, Interpolation::Linear, &[0.0, 2.0], &[[0.0, 0.0, 0.0, 1.0], end]);
            for (time, angle) in [(0.5, 22.5_f64), (1.0, 45.0), (1.5, 67.5)] {
                let rotation = DQuat::from_vec4(turn.at(time));
                let (sine, cosine) = angle.to_radians().sin_cos();
                assert!((rotation * DVec3::X - DVec3::new(cosine, sine, 0.0)).length() < 1e-12, "{angle}");
                assert!((rotation.length() - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn splines_are_hermite_with_tangents_per_second() {
        // From 0 to 1 in two seconds, with a start slope of 3 per second and an end slope of -1 per second. In the middle:
        // (p0 + p1) / 2 + (m0 - m1) / 8 with m = 2 s times the tangents.
        let x = |value: f64| [value, 0.0, 0.0, 0.0];
        let values = [x(9.0), x(0.0), x(3.0), x(-1.0), x(1.0), x(9.0)];
        let spline = channel(Path::Translation, Interpolation::Cubic, &[1.0, 3.0], &values);
        assert_eq!(spline.at(2.0).x, 0.5 + (6.0 + 2.0) / 8.0);
        assert_eq!(
            (spline.at(0.0).x, spline.at(1.0).x, spline.at(3.0).x, spline.at(4.0).x),
            (0.0, 0.0, 1.0, 1.0)
        );
        // Measure the slope at the start by a small step.
        assert!((spline.at(1.0 + 1e-6).x / 1e-6 - 3.0).abs() < 1e-4);

        let zero = [0.0; 4];
        let (from, to) = ([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0]);
        let turn =
            channel(Path::Rotation, Interpolation::Cubic, &[0.0, 1.0], &[zero, from, zero, zero, to, zero]);
        let middle = turn.at(0.5);
        assert!((middle - DVec4::new(0.0, 0.0, 0.5, 0.5).normalize()).length() < 1e-15);
        // A spline from q to -q passes through zero, which is no rotation: the key's rotation holds.
        let back = [0.0, 0.0, 0.0, -1.0];
        let turn =
            channel(Path::Rotation, Interpolation::Cubic, &[0.0, 1.0], &[zero, from, zero, zero, back, zero]);
        assert_eq!(turn.at(0.5), DVec4::W);
    }

    #[test]
    fn children_follow_their_parents() {
        let still = |translation| Local { translation, ..Local::default() };
        let grows = channel(
            Path::Scale,
            Interpolation::Linear,
            &[0.0, 1.0],
            &[[1.0, 1.0, 1.0, 0.0], [3.0, 1.0, 1.0, 0.0]],
        );
        let joint = |parent, local| Node { parent, local, moves: true, ..Node::default() };
        let rig = NodeTree {
            joints: vec![
                joint(None, Local { channels: vec![grows], ..still(DVec3::Y) }),
                joint(Some(0), still(DVec3::X)),
            ],
        };
        assert_eq!(rig.duration(), 1.0);
        assert_eq!(rig.at(0.5).unwrap().to_world[1].translation, DVec3::new(2.0, 1.0, 0.0));
    }
}
