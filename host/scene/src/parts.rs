//! Parts of a scene, and the tables built from them.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::bvh::BvhNode;
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::animation::{NodeTree, Nodes};
use super::bvh::{self, Bvh, BvhOptions, top};
use super::instanced::Instanced;
use super::media::Media;
use super::mesh::{Mesh, coordinates};
use super::motion::Motion;
use super::texture::{self, TextureParts};
use super::{PunctualLight, Scene, SceneCamera, SceneError, geometry, light};

/// Recentred geometry with materials, lights and cameras. A scene may lack lights and cameras.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Name of the scene, or of the file in messages.
    pub name: String,
    /// Triangles of the world (m).
    pub triangles: Vec<Triangle>,
    /// Surface records of the triangles; `curvature` and `light` are overwritten.
    pub surfaces: Vec<TriangleSurface>,
    /// Materials. A strict order overwrites the priorities, indices the media, and `textures` the flags of textures.
    pub materials: Vec<Material>,
    /// Names of the materials.
    pub material_names: Vec<String>,
    /// Punctual lights.
    pub lights: Vec<PunctualLight>,
    /// Cameras.
    pub cameras: Vec<SceneCamera>,
    /// Textures; empty without any.
    pub textures: TextureParts,
    /// Origin that was subtracted from every position (m).
    pub origin: DVec3,
    /// Meshes besides the world's triangles, and their instances.
    pub instanced: Instanced,
    /// The file's nodes.
    pub rig: NodeTree,
    /// Node of each world triangle; missing entries and [`NONE`] mean no node.
    pub owners: Vec<u32>,
    /// Cameras and lights on nodes.
    pub motion: Option<Motion>,
    /// Lower and upper corner of the box around the subject (m); `None`: around all triangles.
    pub bounds: Option<[Vec3; 2]>,
    /// Options of the BVHs.
    pub bvh: BvhOptions,
}

impl SceneParts {
    /// Builds the tables, with moving objects at time 0. Drops triangles without an area, computes curvatures, and clears normals
    /// that equal face normals. Orders triangles by the BVH, and builds the light table.
    ///
    /// # Errors
    ///
    /// If the parts do not fit together, hold values that no kernel can use, or exceed the tables.
    pub fn build(mut self) -> Result<Scene, SceneError> {
        self.check()?;
        texture::set_flags(&mut self.materials, &self.textures);
        let (instanced, origin) = (&self.instanced, self.origin);
        // Nodes matter only if one moves.
        let nodes = self.motion.as_ref().and_then(|_| self.rig.at(0.0).ok()).unwrap_or_default();
        let mut media =
            Media::for_scene(&self.materials, &self.triangles, &self.surfaces, instanced, &nodes, origin);
        let textures = &mut self.textures.materials;
        media.rank(&mut self.materials, textures, &mut self.surfaces, &mut self.instanced);
        let dropped_triangles = self.drop_degenerate();
        self.check_counts(dropped_triangles)?;
        let bounds = self.bounds.unwrap_or_else(|| self.bounds());

        // Build the BVH over the world; with instances, it lies below a top level.
        let leaves = self.instanced.instances.len() + usize::from(!self.triangles.is_empty());
        let (top, levels) = match self.instanced.instances.is_empty() {
            true => (0, bvh::LEVELS),
            false => (top::node_count(leaves), top::levels_below(leaves)),
        };
        self.check_levels(levels)?;
        let bvh = match self.triangles.is_empty() {
            true => Bvh::default(),
            false => bvh::build(&self.triangles, levels, &self.bvh),
        };
        self.order(&bvh.order);
        let textures = texture::build(&self.name, self.textures, &self.triangles)?;

        let mut scene = Scene {
            name: self.name,
            triangles: self.triangles,
            surfaces: self.surfaces,
            materials: self.materials,
            material_names: self.material_names,
            textures,
            instances: vec![Instance::default()],
            nodes: vec![BvhNode::default(); top],
            cameras: self.cameras,
            punctual_lights: self.lights,
            origin: self.origin,
            bounds,
            has_nested_media: media.are_nested(),
            dropped_triangles,
            rig: self.rig,
            owners: self.owners,
            ..Scene::default()
        };
        bvh.append_to(&mut scene.nodes, &mut scene.blocks);
        self.instanced.append(&mut scene, top, levels, &self.bvh);
        (scene.instanced, scene.motion) = (self.instanced, self.motion);
        scene.start()?;
        scene.mark_hanging_surfaces();
        scene.warnings = media.warnings(&scene);
        Ok(scene)
    }

    /// Whether it has no triangles.
    pub(super) fn is_empty(&self) -> bool {
        self.triangles.len() + self.instanced.triangle_count() == 0
    }

    /// Lower and upper corner of the box around all triangles, over all times (m).
    pub(super) fn bounds(&self) -> [Vec3; 2] {
        let usable = |p: &DVec3| p.is_finite() && p.abs().max_element() <= geometry::MAX_COORDINATE;
        let grow = |bounds: Option<[DVec3; 2]>, p: DVec3| {
            Some(bounds.map_or([p, p], |[lower, upper]| [lower.min(p), upper.max(p)]))
        };
        let still = self.triangles.iter().flat_map(geometry::corners);
        let mut bounds = still.filter(usable).fold(None, grow);
        for nodes in self.looks() {
            let corners = self.instanced.triangles(&nodes).flatten().map(|corner| corner - self.origin);
            bounds = corners.filter(usable).fold(bounds, grow);
        }
        bounds.unwrap_or_default().map(|corner| corner.as_vec3())
    }

    /// Poses of the nodes at sampled times.
    fn looks(&self) -> Vec<Nodes> {
        self.motion.as_ref().map_or_else(|| vec![Nodes::default()], |_| self.rig.looks().collect())
    }

    /// Refuses parts that do not fit together, and values that no kernel can use.
    fn check(&mut self) -> Result<(), SceneError> {
        geometry::check(&self.name, &self.triangles, &self.surfaces, &self.materials, &self.material_names)?;
        if self.owners.len() > self.triangles.len() {
            let what = "there are nodes for more triangles than it has".into();
            return Err(SceneError::Tables { file: self.name.clone(), what });
        }
        light::check(&self.name, &self.lights)?;
        // Append the coordinates of meshes while they are checked.
        if !self.textures.textures.is_empty() {
            let corners = self.instanced.meshes.iter().flat_map(|mesh| &mesh.corners);
            self.textures.coordinates.extend(corners.map(coordinates));
        }
        let count = self.triangles.len() + self.instanced.triangle_count();
        texture::check(&self.name, &self.textures, count, &self.material_names)?;
        self.textures.coordinates.truncate(self.triangles.len());
        self.check_instances()
    }

    /// Refuses instances of a missing mesh, and an emissive mesh with several instances.
    fn check_instances(&self) -> Result<(), SceneError> {
        let Instanced { meshes, instances, .. } = &self.instanced;
        if let Some(instance) = instances.iter().find(|instance| instance.mesh >= meshes.len()) {
            let what = format!("there is no mesh {} for an instance", instance.mesh);
            return Err(SceneError::Tables { file: self.name.clone(), what });
        }
        let uses = self.instanced.uses();
        let emits = |mesh: &Mesh| {
            let mut materials = mesh.materials.iter().filter_map(|&id| self.materials.get(id as usize));
            materials.any(|material| material.emission != Vec3::ZERO)
        };
        if let Some(id) = (0..meshes.len()).find(|&id| uses[id] > 1 && emits(&meshes[id])) {
            let what = format!("mesh {id} emits and has {} instances; give each a mesh of its own", uses[id]);
            return Err(SceneError::Tables { file: self.name.clone(), what });
        }
        Ok(())
    }

    /// Drops triangles without an area, with their records; returns their number.
    fn drop_degenerate(&mut self) -> usize {
        let keep: Vec<bool> = self.triangles.iter().map(geometry::has_area).collect();
        geometry::retain(&mut self.triangles, &keep);
        geometry::retain(&mut self.surfaces, &keep);
        geometry::retain(&mut self.textures.coordinates, &keep);
        geometry::retain(&mut self.owners, &keep);
        keep.iter().filter(|keep| !**keep).count()
    }

    /// Refuses a scene without triangles, or with more instances than the tables hold.
    fn check_counts(&self, dropped: usize) -> Result<(), SceneError> {
        if self.is_empty() {
            return Err(SceneError::NoGeometry { file: self.name.clone(), dropped });
        }
        let count = self.instanced.instances.len();
        if count > top::MAX_INSTANCES {
            let what = format!("{count} meshes are placed, but at most {} may be", top::MAX_INSTANCES);
            return Err(SceneError::Tables { file: self.name.clone(), what });
        }
        Ok(())
    }

    /// Refuses geometry that a BVH of `levels` levels cannot hold.
    fn check_levels(&self, levels: u32) -> Result<(), SceneError> {
        let meshes = self.instanced.meshes.iter().map(|mesh| mesh.count as usize);
        let largest = meshes.chain([self.triangles.len()]).max().unwrap_or(0);
        if bvh::fits(largest, levels) {
            return Ok(());
        }
        let what =
            format!("a mesh of {largest} triangles beside {} instances", self.instanced.instances.len());
        Err(SceneError::Tables { file: self.name.clone(), what: format!("{what} makes its BVH too deep") })
    }

    /// Reorders the records of triangles by the BVH, and completes them.
    fn order(&mut self, order: &[u32]) {
        self.triangles = order.par_iter().map(|&id| self.triangles[id as usize]).collect();
        let surface = |(&id, triangle): (&u32, &Triangle)| {
            let mut surface = self.surfaces[id as usize];
            geometry::complete(triangle, &mut surface);
            TriangleSurface { light: NONE, ..surface }
        };
        self.surfaces = order.par_iter().zip(&self.triangles).map(surface).collect();
        if !self.owners.is_empty() {
            let owner = |&id: &u32| self.owners.get(id as usize).copied().unwrap_or(NONE);
            self.owners = order.iter().map(owner).collect();
        }
        let coordinates = &mut self.textures.coordinates;
        if !coordinates.is_empty() {
            *coordinates = order.iter().map(|&id| coordinates[id as usize]).collect();
        }
    }
}
