//! Sharing plan: selects the meshes that are stored once for many nodes.
//!
//! Moving meshes are stored once, except their emissive primitives: the light table refers to one instance. Copies of resting
//! meshes trace faster in the world's space. Above a number of triangles, the meshes with the largest copies are stored once.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use super::mesh::{self, Extent};
use super::node::WorldMesh;
use crate::SceneError;
use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;

/// Maximum number of triangles of a scene: ids have 31 bits, and this number fills the memory of a large machine.
const MAX_TRIANGLES: u64 = 1 << 28;
/// Maximum number of vertices that are read; a copied mesh counts for each node. Reading them takes a minute.
const MAX_VERTICES: u64 = 1 << 31;
/// Maximum memory of a triangle while its scene is read (bytes). Measured as the growth of the peak memory of `scene info` with
/// triangles: 711 plain, 806 to 832 with texture coordinates and tangents.
pub const TRIANGLE_BYTES: u64 = 850;
/// Temporary memory of a primitive's vertex, until its triangles are made (bytes). Measured likewise, with vertices that one
/// triangle refers to: 104 plain, 128 with texture coordinates and tangents.
const VERTEX_BYTES: u64 = 130;

/// Memory of an instance of a resting mesh that is stored once (bytes): its record, and its leaf of the BVH.
const INSTANCE_BYTES: u64 = 1024;

/// Sharing plan of the meshes of a file.
pub struct Sharing {
    /// Extents by the index of the mesh.
    extents: HashMap<usize, Extent>,
    /// Resting meshes with several instances that are stored once.
    spared: Vec<usize>,
    /// Maximum number of triangles of the world.
    pub in_world: usize,
}

impl Sharing {
    /// Plans from the accessors of every mesh and its nodes, and reserves memory for all triangles.
    pub fn plan(
        document: &Document,
        context: &mut ImportContext<'_>,
        meshes: &[WorldMesh],
    ) -> Result<Sharing, SceneError> {
        let mut sharing = Sharing { extents: HashMap::new(), spared: Vec::new(), in_world: 0 };
        let mut still: HashMap<usize, u64> = HashMap::new();
        for instance in meshes {
            let id = instance.mesh.value();
            if let Entry::Vacant(entry) = sharing.extents.entry(id) {
                entry.insert(mesh::extent(document, context, instance)?);
            }
            *still.entry(id).or_default() += u64::from(!instance.moves);
        }
        sharing.spare(&still, context.options.copies);
        sharing.take(context, meshes)?;
        Ok(sharing)
    }

    /// Stores meshes once, the largest copies first, until the remaining copies stay within the limit.
    fn spare(&mut self, still: &HashMap<usize, u64>, copies: u64) {
        let of_mesh = |(&id, &uses): (&usize, &u64)| {
            let Extent { triangles, emitting, .. } = self.extents[&id];
            (uses.saturating_sub(1).saturating_mul(triangles - emitting), id)
        };
        let mut all: Vec<(u64, usize)> = still.iter().map(of_mesh).filter(|(extra, _)| *extra > 0).collect();
        all.sort_by_key(|&(extra, id)| (std::cmp::Reverse(extra), id));
        let mut left = all.iter().fold(0_u64, |sum, (extra, _)| sum.saturating_add(*extra));
        for (extra, id) in all {
            if left <= copies {
                break;
            }
            left -= extra.min(left);
            self.spared.push(id);
        }
    }

    /// Reserves memory for all triangles.
    fn take(&mut self, context: &mut ImportContext<'_>, meshes: &[WorldMesh]) -> Result<(), SceneError> {
        let mut seen = HashSet::new();
        let (mut stored, mut in_world, mut vertices, mut read, mut instances) =
            (0_u64, 0_u64, 0_u64, 0_u64, 0_u64);
        for instance in meshes {
            let extent = self.extents[&instance.mesh.value()];
            let is_first = seen.insert(instance.mesh.value());
            let shares = self.is_stored_once(instance);
            if shares && is_first || !shares && instance.moves {
                stored = stored.saturating_add(extent.triangles);
            } else if !instance.moves {
                let triangles = if shares { extent.emitting } else { extent.triangles };
                in_world = in_world.saturating_add(triangles);
            }
            instances += u64::from(shares && !instance.moves);
            if !shares || is_first || extent.emitting > 0 {
                read = read.saturating_add(extent.vertices);
            }
            vertices = vertices.max(extent.vertices);
            if read > MAX_VERTICES {
                let what = format!("reads more than {MAX_VERTICES} vertices in all");
                return Err(context.mesh_error(&instance.node, what));
            }
            if stored.saturating_add(in_world) > MAX_TRIANGLES {
                let what = format!("makes more than {MAX_TRIANGLES} triangles in all");
                return Err(context.mesh_error(&instance.node, what));
            }
        }
        let triangles = stored + in_world;
        let bytes =
            triangles * TRIANGLE_BYTES + vertices.saturating_mul(VERTEX_BYTES) + instances * INSTANCE_BYTES;
        context.take(bytes, format_args!("its {triangles} triangles"))?;
        self.in_world = in_world as usize;
        Ok(())
    }

    /// Whether the non-emissive primitives of a mesh are stored once for all instances like this.
    pub fn is_stored_once(&self, instance: &WorldMesh) -> bool {
        let id = instance.mesh.value();
        if instance.skin.is_some() {
            return false;
        }
        if instance.moves { !self.emits(instance) } else { self.spared.contains(&id) }
    }

    /// Whether a primitive of the instance's mesh emits.
    pub fn emits(&self, instance: &WorldMesh) -> bool {
        self.extents.get(&instance.mesh.value()).is_some_and(|extent| extent.emitting > 0)
    }
}
