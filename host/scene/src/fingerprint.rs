//! Fingerprint of a scene, by which checkpoints, references, animations and results recognise it.

use glam::Vec3;

use super::animation::{Channel, Node};
use super::corner::Corner;
use super::deformation::Deformation;
use super::instanced::{MeshInstance, Stand};
use super::{Recorded, Scene};
use caustics_files::hash::Digest;

/// Code of a missing index.
const NO_INDEX: u64 = u64::MAX;

impl Scene {
    /// Returns the BLAKE3 of everything that paths can meet, at the current pose and at any other, in hexadecimal digits.
    pub fn fingerprint(&self) -> String {
        let mut digest = Digest::default();
        // Tables at the current pose
        self.buffers().iter().for_each(|(_, table)| digest.add(table));
        // Node tree and keys
        let mut words = Words::default();
        words.count(self.rig.joints.len());
        self.rig.joints.iter().for_each(|joint| words.node(joint));
        self.recorded
            .iter()
            .flat_map(|recorded: &Recorded| &recorded.channels)
            .for_each(|channel| words.channel(channel));
        digest.add(&words.0);
        // Objects on nodes
        let mut words = Words::default();
        self.instanced.instances.iter().for_each(|instance| words.instance(instance));
        digest.add(&words.0);
        if let Some(motion) = &self.motion {
            digest.add(format!("{:?} {:?}", motion.cameras, motion.lights).as_bytes());
        }
        // Deformations
        for deformation in self.instanced.meshes.iter().filter_map(|mesh| mesh.deformation.as_ref()) {
            let mut words = Words::default();
            words.deformation(deformation);
            digest.add(&words.0);
        }
        digest.finish()
    }
}

/// Little-endian numbers, one after another; every list follows its length.
#[derive(Default)]
struct Words(Vec<u8>);

impl Words {
    fn index(&mut self, index: Option<usize>) {
        self.0.extend(index.map_or(NO_INDEX, |index| index as u64).to_le_bytes());
    }

    fn count(&mut self, count: usize) {
        self.index(Some(count));
    }

    fn doubles(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.0.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
    }

    fn floats(&mut self, numbers: impl IntoIterator<Item = f32>) {
        self.0.extend(numbers.into_iter().flat_map(f32::to_le_bytes));
    }

    fn channel(&mut self, channel: &Channel) {
        self.count(channel.path as usize);
        self.count(channel.interpolation as usize);
        self.count(channel.times.len());
        self.doubles(channel.times.iter().copied());
        self.count(channel.values.len());
        self.doubles(channel.values.iter().flat_map(|value| value.to_array()));
    }

    fn node(&mut self, node: &Node) {
        let Node { parent, local, morph, label: _, of_file: _, moves: _ } = node;
        self.index(*parent);
        self.doubles(local.translation.to_array());
        self.doubles(local.rotation.to_array());
        self.doubles(local.scale.to_array());
        self.count(usize::from(local.matrix.is_some()));
        self.doubles(local.matrix.iter().flat_map(|matrix| matrix.to_cols_array()));
        self.count(morph.weights.len());
        self.doubles(morph.weights.iter().copied());
        for channels in [&local.channels, &morph.channels, &local.edits] {
            self.count(channels.len());
            channels.iter().for_each(|channel| self.channel(channel));
        }
    }

    fn instance(&mut self, instance: &MeshInstance) {
        self.count(instance.mesh);
        match instance.stand {
            Stand::Node(node) => self.index(Some(node)),
            Stand::Still(to_world) => {
                self.index(None);
                self.doubles(to_world.to_cols_array());
            }
        }
    }

    fn deformation(&mut self, deformation: &Deformation) {
        let Deformation { node, rest, targets, joints, pulls, faces } = deformation;
        self.count(*node);
        self.count(rest.len());
        rest.iter().for_each(|corner| self.corner(corner));
        self.count(targets.len());
        for target in targets {
            self.count(target.len());
            let numbers = target.iter().flat_map(|delta| [delta.position, delta.normal, delta.tangent]);
            self.floats(numbers.flat_map(|number: Vec3| number.to_array()));
        }
        self.count(joints.len());
        for (joint, bound) in joints {
            self.count(*joint);
            self.doubles(bound.to_cols_array());
        }
        self.count(pulls.len());
        for pull in pulls {
            self.0.extend(pull.joints.iter().flat_map(|joint| joint.to_le_bytes()));
            self.floats(pull.weights);
        }
        self.count(faces.len());
        self.0.extend(faces.iter().flatten().flat_map(|vertex| vertex.to_le_bytes()));
    }

    fn corner(&mut self, corner: &Corner) {
        let Corner { position, normal, uv, tangent } = corner;
        self.doubles(position.to_array());
        self.floats(uv.to_array());
        self.count(usize::from(normal.is_some()));
        self.floats(normal.iter().flat_map(|normal| normal.to_array()));
        self.count(usize::from(tangent.is_some()));
        self.floats(tangent.iter().flat_map(|tangent| tangent.to_array()));
    }
}
