//! The file's nodes: the node that a hit belongs to, and the nodes' transforms.

use glam::{DAffine3, DQuat, DVec3};

use super::animation::OfFile;
use super::instanced::MeshInstance;
use super::{Scene, SceneError};

/// A node of the file, without animations and edits.
#[derive(Clone, Debug, PartialEq)]
pub struct FileNode {
    /// Index among the file's nodes.
    pub index: usize,
    /// Name; not necessarily unique.
    pub name: Option<String>,
    /// Index of the parent.
    pub parent: Option<usize>,
    /// Translation in the parent's space (m), before any animation or edit.
    pub translation: DVec3,
    /// Rotation in the parent's space, of unit length.
    pub rotation: DQuat,
    /// Scale in the parent's space.
    pub scale: DVec3,
    /// Whether it has a mesh.
    pub has_mesh: bool,
    /// Whether it has a punctual light.
    pub has_light: bool,
    /// Whether it has a camera.
    pub has_camera: bool,
    /// Whether [`Scene::edit`] may set it: it or an ancestor is animated, or among
    /// [`LoadOptions::grabbed`](super::LoadOptions::grabbed).
    pub moves: bool,
}

impl Scene {
    /// Index of the file's node whose mesh has this triangle; arguments are those of a hit. `None` for the floor and for tables
    /// that a caller built.
    pub fn node_of(&self, instance: u32, triangle: u32) -> Option<usize> {
        let owner = match (instance as usize).checked_sub(1) {
            None => *self.owners.get(triangle as usize)? as usize,
            Some(id) => self.instanced.instances.get(id)?.owner,
        };
        self.rig.upwards(owner).find_map(|node| Some(node.of_file.as_ref()?.index))
    }

    /// The nodes that the scene shows, parents first.
    pub fn node_tree(&self) -> Vec<FileNode> {
        let index_of = |joint: usize| Some(self.rig.joints.get(joint)?.of_file.as_ref()?.index);
        let node = self.rig.joints.iter().filter_map(|node| {
            let OfFile { index, name, has_mesh, has_light, has_camera } = node.of_file.clone()?;
            let parent = node.parent.and_then(index_of);
            let (translation, scale) = (node.local.translation, node.local.scale);
            let (rotation, moves) = (node.local.rotation.normalize(), node.moves);
            Some(FileNode {
                index,
                name,
                parent,
                translation,
                rotation,
                scale,
                has_mesh,
                has_light,
                has_camera,
                moves,
            })
        });
        node.collect()
    }

    /// Transform from a node of the file to the world (m) at a time (s), in the file's coordinates, with animations and edits.
    /// `None` if the scene has no such node, or a transform is not finite at that time.
    pub fn node_to_world(&self, node: usize, time: f64) -> Option<DAffine3> {
        let of_file = |of_file: &OfFile| of_file.index == node;
        let joint = self.rig.joints.iter().position(|joint| joint.of_file.as_ref().is_some_and(of_file))?;
        let mut chain = self.rig.upwards(joint);
        let to_world = chain.try_fold(DAffine3::IDENTITY, |below, node| Some(node.local.at(time)? * below));
        to_world.filter(DAffine3::is_finite)
    }

    /// Names of the nodes whose cameras, lights and meshes move.
    pub fn moving_nodes(&self) -> Vec<&str> {
        let Some(motion) = &self.motion else { return Vec::new() };
        let instanced = &self.instanced;
        let cameras = motion.cameras.iter().filter(|camera| camera.moves).map(|camera| camera.joint);
        let lights = motion.lights.iter().filter(|light| light.moves).map(|light| light.joint);
        let meshes = instanced.instances.iter().filter_map(MeshInstance::node);
        let deformed = instanced.meshes.iter().filter_map(|mesh| Some(mesh.deformation.as_ref()?.node));
        let mut joints: Vec<_> = cameras.chain(lights).chain(meshes).chain(deformed).collect();
        joints.sort_unstable();
        joints.dedup();
        joints.into_iter().map(|joint| self.rig.joints[joint].label.as_str()).collect()
    }
}

/// Error for a node that the scene does not show.
pub fn no_node(file: &str, node: usize) -> SceneError {
    let what = format!("its scene has no node {node}, which the edits are of; are they of another file?");
    SceneError::Edits { file: file.into(), what }
}
