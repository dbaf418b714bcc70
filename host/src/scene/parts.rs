//! What a scene is made of, and the tables made of it.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::texture::TextureCoordinates;
use caustics_kernels::interface::tree::TreeNode;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DVec3, Vec3};

use super::media::Media;
use super::motion::Motion;
use super::moving::MovingMesh;
use super::texture::{self, TextureParts};
use super::tree::{self, Tree, top};
use super::{PunctualLight, Scene, SceneCamera, SceneError, geometry, light};

/// Triangles of a scene in which meshes move, at most: an instance carries the id of its first one in 24 bits.
const MAX_TRIANGLES: usize = 1 << 24;

/// Geometry, recentred, with its materials, lights and cameras. A scene may be dark or have no camera.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Name of the scene, or the file for messages.
    pub name: String,
    /// Triangles that do not move (m).
    pub triangles: Vec<Triangle>,
    /// What they have beside their corners, one row per triangle; `curvature` and `light` are overwritten.
    pub surfaces: Vec<TriangleSurface>,
    /// Materials; their priorities are overwritten by a strict order, and their flags of textures by `textures`.
    pub materials: Vec<Material>,
    /// Names of the materials.
    pub material_names: Vec<String>,
    /// Lights that are no triangles.
    pub lights: Vec<PunctualLight>,
    /// Cameras.
    pub cameras: Vec<SceneCamera>,
    /// Textures; all empty where nothing is textured.
    pub textures: TextureParts,
    /// What was subtracted from every position (m).
    pub origin: DVec3,
    /// What moves, beside the triangles.
    pub motion: Option<Motion>,
    /// Lower and upper corner of the box around what is to be seen (m); none: around all triangles.
    pub bounds: Option<[Vec3; 2]>,
}

impl SceneParts {
    /// Makes the tables: drops triangles without an area, computes curvatures, clears normals that are the face's, orders
    /// triangles by the tree, and builds the light table. What moves stands where it is at time 0.
    ///
    /// # Errors
    ///
    /// If the parts do not belong together, hold values that no kernel can use, or more than the tables can.
    pub fn build(mut self) -> Result<Scene, SceneError> {
        self.check()?;
        texture::set_flags(&mut self.materials, &self.textures);
        let media = Media::of(&self.materials, &self.triangles, &self.surfaces, self.motion.as_ref());
        media.rank(&mut self.materials);
        let dropped_triangles = self.drop_degenerate();
        self.check_counts(dropped_triangles)?;
        let bounds = self.bounds.unwrap_or_else(|| self.bounds());

        // The tree over what stands still; below a top level where meshes move.
        let leaves = self.meshes().len() + usize::from(!self.triangles.is_empty());
        let (top, levels) = match self.meshes() {
            [] => (0, tree::LEVELS),
            _ => (top::node_count(leaves), top::levels_below(leaves)),
        };
        let tree = match self.triangles.is_empty() {
            true => Tree::default(),
            false => tree::build_within(&self.triangles, levels),
        };
        self.order(&tree.order);
        let textures = texture::build(&self.name, self.textures, &self.triangles)?;

        let mut scene = Scene {
            name: self.name,
            triangles: self.triangles,
            surfaces: self.surfaces,
            materials: self.materials,
            material_names: self.material_names,
            textures,
            instances: vec![Instance::default()],
            nodes: vec![TreeNode::default(); top],
            cameras: self.cameras,
            origin: self.origin,
            bounds,
            has_nested_media: media.are_nested(),
            dropped_triangles,
            ..Scene::default()
        };
        tree.append_to(&mut scene.nodes, &mut scene.blocks);
        match self.motion {
            None => {
                scene.punctual_lights = self.lights;
                scene.light_again()?;
            }
            Some(motion) => set_in_motion(&mut scene, motion, top, levels)?,
        }
        scene.mark_hanging_sheets();
        scene.warnings = media.warnings(&scene);
        Ok(scene)
    }

    /// Meshes that move.
    fn meshes(&self) -> &[MovingMesh] {
        self.motion.as_ref().map_or(&[], |motion| &motion.meshes)
    }

    /// Whether it has no triangles.
    pub(super) fn is_empty(&self) -> bool {
        self.triangles.len() + self.moving_triangles() == 0
    }

    /// Lower and upper corner of the box around all triangles, wherever they move (m).
    pub(super) fn bounds(&self) -> [Vec3; 2] {
        let still = self.triangles.iter().flat_map(geometry::corners);
        let moving = self.motion.iter().flat_map(|motion| motion.corners(self.origin));
        let usable = |p: &DVec3| p.is_finite() && p.abs().max_element() <= geometry::MAX_COORDINATE;
        let grow = |bounds: Option<[DVec3; 2]>, p: DVec3| {
            Some(bounds.map_or([p, p], |[lower, upper]| [lower.min(p), upper.max(p)]))
        };
        let bounds = still.chain(moving).filter(usable).fold(None, grow);
        bounds.unwrap_or_default().map(|corner| corner.as_vec3())
    }

    /// Triangles of the meshes that move.
    fn moving_triangles(&self) -> usize {
        self.meshes().iter().map(|mesh| mesh.corners.len()).sum()
    }

    /// Refuses parts that do not belong together, and values that no kernel can use.
    fn check(&mut self) -> Result<(), SceneError> {
        geometry::check(&self.name, &self.triangles, &self.surfaces, &self.materials, &self.material_names)?;
        light::check(&self.name, &self.lights)?;
        // The coordinates of what moves stand behind the others while they are checked.
        if !self.textures.textures.is_empty() {
            let moving: Vec<_> = self.meshes().iter().flat_map(MovingMesh::coordinates).collect();
            self.textures.coordinates.extend(moving);
        }
        let count = self.triangles.len() + self.moving_triangles();
        texture::check(&self.name, &self.textures, count, &self.material_names)?;
        self.textures.coordinates.truncate(self.triangles.len());
        Ok(())
    }

    /// Leaves out triangles without an area, with their rows; returns how many.
    fn drop_degenerate(&mut self) -> usize {
        let keep: Vec<bool> = self.triangles.iter().map(geometry::has_area).collect();
        geometry::retain(&mut self.triangles, &keep);
        geometry::retain(&mut self.surfaces, &keep);
        geometry::retain(&mut self.textures.coordinates, &keep);
        keep.iter().filter(|keep| !**keep).count()
    }

    /// Refuses a scene of no triangles, or of more that move than the tables hold.
    fn check_counts(&self, dropped: usize) -> Result<(), SceneError> {
        let (meshes, moving) = (self.meshes().len(), self.moving_triangles());
        let what = if self.triangles.len() + moving == 0 {
            return Err(SceneError::NoGeometry { file: self.name.clone(), dropped });
        } else if meshes > top::MAX_MESHES {
            format!("{meshes} meshes move, but at most {} may", top::MAX_MESHES)
        } else if moving > 0 && self.triangles.len() + moving > MAX_TRIANGLES {
            "a scene with meshes that move has more than 2^24 triangles".into()
        } else {
            return Ok(());
        };
        Err(SceneError::Tables { file: self.name.clone(), what })
    }

    /// Brings the rows of triangles into the order of the tree, and completes them.
    fn order(&mut self, order: &[u32]) {
        self.triangles = order.iter().map(|&id| self.triangles[id as usize]).collect();
        self.surfaces = order.iter().map(|&id| self.surfaces[id as usize]).collect();
        for (triangle, surface) in self.triangles.iter().zip(&mut self.surfaces) {
            surface.curvature = geometry::curvature(triangle, surface);
            geometry::flatten(triangle, surface);
            surface.light = NONE;
        }
        let coordinates = &mut self.textures.coordinates;
        if !coordinates.is_empty() {
            *coordinates = order.iter().map(|&id| coordinates[id as usize]).collect();
        }
    }
}

/// Appends the rows of what moves to those that stand still, and brings it to time 0.
fn set_in_motion(scene: &mut Scene, mut motion: Motion, top: usize, levels: u32) -> Result<(), SceneError> {
    (motion.top, motion.still) = (top, scene.triangles.len());
    motion.still_bounds = scene.triangles.iter().map(tree::bounds).reduce(|all, next| all.union(&next));
    for (id, mesh) in motion.meshes.iter_mut().enumerate() {
        mesh.append(scene, id as u32 + 1, levels);
    }
    if !scene.textures.textures.is_empty() {
        scene.textures.coordinates.resize(scene.triangles.len(), TextureCoordinates::default());
    }
    motion.start(scene)?;
    scene.motion = Some(motion);
    Ok(())
}
