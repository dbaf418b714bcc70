//! Animations: what keys say of a time, and where nodes stand then. All in f64.

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};

/// Parts of the animations' time, at whose ends one looks where meshes are.
const LOOKS: u32 = 8;

/// Which part of a node's transform keys set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Path {
    /// Its translation (m).
    Translation,
    /// Its rotation, a quaternion.
    Rotation,
    /// Its scale.
    Scale,
    /// Weights of morph targets of its mesh, four a channel.
    Weights,
}

/// How values between keys come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The key before holds.
    Step,
    /// On a line; rotations on the shorter arc.
    Linear,
    /// Hermite splines; rotations are normalised after.
    Cubic,
}

/// The keys of one part of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What it sets.
    pub path: Path,
    /// How.
    pub interpolation: Interpolation,
    /// Times of the keys (s), at least one, ascending.
    pub times: Vec<f64>,
    /// A value a key; of a spline three: the tangent before [1/s], the value, the tangent after [1/s].
    pub values: Vec<DVec4>,
}

impl Channel {
    /// The value at a time (s); before the first key and after the last the nearest one's. A rotation is of unit length.
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

    /// A rotation normalised; a spline that passes through zero keeps its key's.
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
    /// In place of rotation and scale, which are as near to it as they come, of a node that no animation moves.
    pub matrix: Option<DMat3>,
    /// What sets parts of it.
    pub channels: Vec<Channel>,
    /// What a person sets instead.
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
    /// The transform at a time (s); none if it is not finite or has no rotation.
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
    /// How messages call it.
    pub label: String,
    /// Which node of the file it is; none of what the file does not have as one.
    pub of_file: Option<OfFile>,
    /// Index of its parent, which comes before it.
    pub parent: Option<usize>,
    /// Its own transform.
    pub local: Local,
    /// Whether it or a node above it has channels, or may be edited.
    pub moves: bool,
    /// How its mesh's morph targets are weighted.
    pub morph: Morph,
}

/// A node as the file has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OfFile {
    /// Its index.
    pub index: usize,
    /// Its name.
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
    /// Without channels, one a target.
    pub weights: Vec<f64>,
    /// What sets them, four at a time; empty or all.
    pub channels: Vec<Channel>,
}

impl Morph {
    /// The weights at a time (s), one a target.
    pub fn at(&self, time: f64) -> Vec<f64> {
        if self.channels.is_empty() {
            return self.weights.clone();
        }
        let all = self.channels.iter().flat_map(|channel| channel.at(time).to_array());
        all.take(self.weights.len()).collect()
    }
}

/// Where nodes are at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Nodes {
    /// From each node to the world.
    pub to_world: Vec<DAffine3>,
    /// Weights of each node's morph targets.
    pub weights: Vec<Vec<f64>>,
}

/// The node tree, parents first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeTree {
    /// Nodes.
    pub joints: Vec<Node>,
}

impl Node {
    /// All that its animations and a person's edits set.
    fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.local.channels.iter().chain(&self.morph.channels).chain(&self.local.edits)
    }
}

impl NodeTree {
    /// Where every node is at a time (s), or the index of the one whose transform is not finite.
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

    /// A node and those above it.
    pub fn upwards(&self, joint: usize) -> impl Iterator<Item = &Node> {
        let node = |id: usize| self.joints.get(id);
        std::iter::successors(node(joint), move |child| node(child.parent?))
    }

    /// Where nodes are at some times of the animations; a time at which that is not finite is left out.
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
    // Written so that what is not finite counts as singular.
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
    fn steps_hold_and_lines_join_and_ends_are_kept() {
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
        // A quarter turn about z, its end written once as q and once as -q, and at half length.
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
        // From 0 to 1 in two seconds, leaving at 3 per second and arriving at -1 per second. In the middle:
        // (p0 + p1) / 2 + (m0 - m1) / 8 with m = 2 s times the tangents.
        let x = |value: f64| [value, 0.0, 0.0, 0.0];
        let values = [x(9.0), x(0.0), x(3.0), x(-1.0), x(1.0), x(9.0)];
        let spline = channel(Path::Translation, Interpolation::Cubic, &[1.0, 3.0], &values);
        assert_eq!(spline.at(2.0).x, 0.5 + (6.0 + 2.0) / 8.0);
        assert_eq!(
            (spline.at(0.0).x, spline.at(1.0).x, spline.at(3.0).x, spline.at(4.0).x),
            (0.0, 0.0, 1.0, 1.0)
        );
        // The slope at the start, by a small step.
        assert!((spline.at(1.0 + 1e-6).x / 1e-6 - 3.0).abs() < 1e-4);

        let zero = [0.0; 4];
        let (from, to) = ([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0]);
        let turn =
            channel(Path::Rotation, Interpolation::Cubic, &[0.0, 1.0], &[zero, from, zero, zero, to, zero]);
        let middle = turn.at(0.5);
        assert!((middle - DVec4::new(0.0, 0.0, 0.5, 0.5).normalize()).length() < 1e-15);
        // A spline from q to -q passes through zero, where no rotation is: its key's holds.
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
