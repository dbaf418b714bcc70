//! Meshes whose corners move relative to each other: skins and morph targets [glTF 2.0, section 3.7].

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::animation::Nodes;
use super::corner::Corner;

/// Maximum number of joints that move a vertex: two sets of four.
pub const MAX_PULLS: usize = 8;

/// A skin and morph targets of a deforming mesh.
#[derive(Clone, Debug, Default)]
pub struct Deformation {
    /// Node of the mesh, which gives the weights of the targets.
    pub node: usize,
    /// Vertices at rest, in the node's space.
    pub rest: Vec<Corner>,
    /// Morph targets: an offset for every vertex.
    pub targets: Vec<Vec<Delta>>,
    /// Joints of the skin: node, and inverse bind matrix. With a skin, vertices are in the world. Empty without a skin.
    pub joints: Vec<(usize, DAffine3)>,
    /// Joints and weights of each vertex; empty without a skin.
    pub pulls: Vec<Pull>,
    /// Vertices of the triangles, in the order of the mesh's records.
    pub faces: Vec<[u32; 3]>,
}

/// Offset of a vertex by a morph target of weight 1.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delta {
    /// Offset of the position (m).
    pub position: Vec3,
    /// Offset of the normal.
    pub normal: Vec3,
    /// Offset of the tangent.
    pub tangent: Vec3,
}

/// Joints that move a vertex, and their weights.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pull {
    /// Indices into the joints.
    pub joints: [u16; MAX_PULLS],
    /// Weights, of any sum. Where all are zero the first joint moves the vertex.
    pub weights: [f32; MAX_PULLS],
}

impl Deformation {
    /// Whether it has a skin, whose vertices are in the world, independent of the mesh's node.
    pub fn is_skinned(&self) -> bool {
        !self.joints.is_empty()
    }

    /// Deforms the vertices for a pose of the nodes. The result is in the world with a skin, else in the space of the mesh's node.
    pub fn deform(&self, nodes: &Nodes) -> Vec<Corner> {
        let joint = |(node, bound): &(usize, DAffine3)| nodes.to_world[*node] * *bound;
        let joints: Vec<DAffine3> = self.joints.iter().map(joint).collect();
        let weights = nodes.weights.get(self.node).map_or(&[][..], Vec::as_slice);
        let deform = |id: usize| {
            let vertex = self.morphed(id, weights);
            self.pulls.get(id).map_or(vertex, |pull| pull.pulled(&vertex, &joints))
        };
        (0..self.rest.len()).into_par_iter().map(deform).collect()
    }

    /// Corners of the triangles with these vertices.
    pub fn corners<'a>(&'a self, vertices: &'a [Corner]) -> impl Iterator<Item = [Corner; 3]> + 'a {
        self.faces.iter().map(|face| face.map(|id| vertices[id as usize]))
    }

    fn morphed(&self, id: usize, weights: &[f64]) -> Corner {
        let mut vertex = self.rest[id];
        let (mut normal, mut tangent) = (DVec3::ZERO, DVec3::ZERO);
        for (target, &weight) in self.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            let delta = &target[id];
            vertex.position += weight * delta.position.as_dvec3();
            normal += weight * delta.normal.as_dvec3();
            tangent += weight * delta.tangent.as_dvec3();
        }
        let add = |to: Vec3, what: DVec3| (to.as_dvec3() + what).try_normalize().map(|unit| unit.as_vec3());
        if normal != DVec3::ZERO {
            vertex.normal = vertex.normal.and_then(|known| add(known, normal));
        }
        if tangent != DVec3::ZERO {
            let turn = |known: Vec4| Some(add(known.truncate(), tangent)?.extend(known.w));
            vertex.tangent = vertex.tangent.and_then(turn);
        }
        vertex
    }
}

impl Pull {
    /// Moves a vertex with its joints: linear blend skinning.
    fn pulled(&self, vertex: &Corner, joints: &[DAffine3]) -> Corner {
        let sum: f64 = self.weights.iter().map(|&weight| f64::from(weight)).sum();
        let mut blended = joints[self.joints[0] as usize];
        if sum > 0.0 {
            blended = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
            for (&joint, &weight) in
                self.joints.iter().zip(&self.weights).filter(|(_, weight)| **weight != 0.0)
            {
                let (share, joint) = (f64::from(weight) / sum, joints[joint as usize]);
                blended.matrix3 += joint.matrix3 * share;
                blended.translation += joint.translation * share;
            }
        }
        let turn = blended.matrix3.inverse().transpose();
        vertex.placed(&blended, &turn)
    }
}
