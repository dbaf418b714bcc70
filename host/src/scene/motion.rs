//! What moves in a scene, and the scene's tables at a time.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::{Instance, Transform};
use caustics_kernels::interface::tree::INSTANCE;
use glam::{DAffine3, DVec3};
use obvhs::aabb::Aabb;

use super::animation::{Node, NodeTree, is_singular};
use super::light::{self, Emitter};
use super::moving::MovingMesh;
use super::tree::top::{self, Leaf};
use super::{PunctualLight, Scene, SceneCamera, SceneError, geometry, tree};

/// Something on a node.
#[derive(Clone, Debug, PartialEq)]
pub struct OnNode<T> {
    /// Its node.
    pub joint: usize,
    /// Whether the node moves.
    pub moves: bool,
    /// What it is, not yet placed.
    pub what: T,
}

/// Where a moving mesh stands, for structures that are built over the mesh's own triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Id of its first triangle.
    pub first: u32,
    /// Triangles.
    pub count: u32,
    /// From its own space to the world; none while a scale of zero hides it.
    pub to_world: Option<Transform>,
    /// Whether corners b and c of its own triangles are exchanged, as a mirrored mesh needs it.
    pub mirrored: bool,
}

/// What moves in a scene.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// The file, for messages.
    pub file: String,
    /// The nodes.
    pub rig: NodeTree,
    /// Cameras, in the scene's order.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
    /// Meshes, in the order of the instances behind the world's.
    pub meshes: Vec<MovingMesh>,
    /// Triangles that emit, moving or not.
    pub emitters: Vec<Emitter>,
    /// Triangles that do not move; they come first.
    pub still: usize,
    /// Nodes at the head that the top level takes.
    pub top: usize,
    /// Where the meshes are.
    pub placements: Vec<Placement>,
    /// Box of what does not move (m).
    pub still_bounds: Option<Aabb>,
    /// From each mesh's own space to the world, at the pose at hand.
    pub(super) places: Vec<DAffine3>,
}

impl Motion {
    /// Brings the scene to a time (s).
    pub fn pose(&mut self, scene: &mut Scene, time: f64) -> Result<(), SceneError> {
        let file = self.file.clone();
        let wrong = |joint: &Node, what: &str| SceneError::Node {
            file: file.clone(),
            node: joint.label.clone(),
            what: format!("at {time} s {what}"),
        };
        let time = if time.is_nan() { 0.0 } else { time };
        let places =
            self.rig.at(time).map_err(|joint| wrong(joint, "its place in the world is not finite"))?;

        // Check all, so that a time that cannot be shown changes nothing.
        for camera in self.cameras.iter().filter(|camera| camera.moves) {
            if is_singular(&places[camera.joint]) {
                return Err(wrong(
                    &self.rig.joints[camera.joint],
                    "its transform is singular (a scale of zero, or axes in one plane)",
                ));
            }
        }
        let lights: Vec<_> = self
            .lights
            .iter()
            .filter_map(|light| light.what.placed(&places[light.joint], scene.origin))
            .collect();
        light::check(&file, &lights)?;
        for mesh in &self.meshes {
            if !mesh.fits(&places[mesh.joint], scene.origin) {
                let what = format!("its mesh reaches beyond {:e} m", geometry::MAX_COORDINATE);
                return Err(wrong(&self.rig.joints[mesh.joint], &what));
            }
        }

        for (mounted, camera) in self.cameras.iter().zip(&mut scene.cameras) {
            *camera = mounted.what.placed(&places[mounted.joint], scene.origin);
        }
        let mut leaves = Vec::new();
        if let Some(bounds) = self.still_bounds {
            leaves.push(Leaf { bounds, child: self.top as u32 });
        }
        for id in 0..self.meshes.len() {
            let bounds = self.pose_mesh(scene, id, &places);
            leaves.extend(bounds.map(|bounds| Leaf { bounds, child: INSTANCE | (id as u32 + 1) }));
        }
        if !self.meshes.is_empty() {
            top::build(&mut scene.nodes[..self.top], leaves);
        }
        light::apply(scene, &self.emitters, &lights);
        Ok(())
    }

    /// Poses a mesh: its triangles, its instance. Its box in the world, unless it is hidden.
    fn pose_mesh(&mut self, scene: &mut Scene, id: usize, places: &[DAffine3]) -> Option<Aabb> {
        let mesh = &mut self.meshes[id];
        let to_world = places[mesh.joint];
        let place =
            DAffine3::from_translation(-scene.origin) * to_world * DAffine3::from_translation(mesh.centre);
        let before = std::mem::replace(&mut self.places[id], place);
        let is_hidden = is_hidden(&place);
        let mirrored = !is_hidden && place.matrix3.determinant() < 0.0;
        mesh.mirror(scene, self.still, mirrored);
        mesh.pose(scene, &to_world, is_hidden);

        let range = mesh.first as usize..mesh.first as usize + mesh.corners.len();
        let placement = &mut self.placements[id];
        (placement.mirrored, placement.to_world) = (mirrored, (!is_hidden).then(|| transform(&place)));
        let instance = &mut scene.instances[id + 1];
        if is_hidden {
            *instance = Instance { root: instance.root, ..Instance::default() };
            return None;
        }
        let to_object = place.inverse();
        instance.to_object = transform(&to_object);
        instance.to_previous =
            if before.is_nan() { Transform::IDENTITY } else { transform(&(before * to_object)) };
        let bounds = scene.triangles[range].iter().fold(Aabb::empty(), |all, t| all.union(&tree::bounds(t)));
        // The mesh's own space rounds differently: a few ulp of the largest coordinate.
        let most = bounds.min.abs().max(bounds.max.abs()).max_element();
        Some(Aabb { min: bounds.min - most * 2e-6, max: bounds.max + most * 2e-6 })
    }

    /// Makes room for what poses fill in: before the first pose there is no previous one.
    pub fn prepare(&mut self) {
        self.places = vec![DAffine3::NAN; self.meshes.len()];
        let placement = |mesh: &MovingMesh| Placement {
            first: mesh.first,
            count: mesh.corners.len() as u32,
            ..Placement::default()
        };
        self.placements = self.meshes.iter().map(placement).collect();
    }

    /// Rows that the light table can have at most.
    pub fn most_lights(&self) -> usize {
        self.emitters.len() + self.lights.len()
    }

    /// Whether there can be light at some time.
    pub fn has_light(&self) -> bool {
        self.features().has(caustics_kernels::light::TYPES)
    }

    /// What it takes at any time.
    pub fn features(&self) -> Features {
        let mut features = if self.meshes.is_empty() { Features(0) } else { Features::INSTANCES };
        if !self.emitters.is_empty() {
            features = features | Features::AREA_LIGHTS;
        }
        for light in self.lights.iter().filter(|light| light.what.intensity.max_element() > 0.0) {
            features = features | light.what.shape.feature();
        }
        features
    }

    /// Names of the nodes whose cameras, lights and meshes move.
    pub fn names(&self) -> Vec<&str> {
        let cameras = self.cameras.iter().filter(|camera| camera.moves).map(|camera| camera.joint);
        let lights = self.lights.iter().filter(|light| light.moves).map(|light| light.joint);
        let mut joints: Vec<_> =
            cameras.chain(lights).chain(self.meshes.iter().map(|mesh| mesh.joint)).collect();
        joints.sort_unstable();
        joints.dedup();
        joints.into_iter().map(|joint| self.rig.joints[joint].label.as_str()).collect()
    }

    /// Ids of the lights of the emitters that do not move: these rows of the surfaces change with the light table.
    pub fn still_light_ids(&self, scene: &Scene) -> Vec<u32> {
        let still = self.emitters.iter().filter(|emitter| (emitter.triangle as usize) < self.still);
        still.map(|emitter| scene.surfaces.get(emitter.triangle as usize).map_or(NONE, |s| s.light)).collect()
    }
}

/// Whether a scale is zero, or so near that f32 cannot carry the inverse.
fn is_hidden(place: &DAffine3) -> bool {
    let inverse = place.inverse();
    let columns = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
    is_singular(place) || columns.into_iter().any(|axis: DVec3| axis.length() > 1e9)
}

fn transform(place: &DAffine3) -> Transform {
    Transform {
        x: place.x_axis.as_vec3(),
        y: place.y_axis.as_vec3(),
        z: place.z_axis.as_vec3(),
        offset: place.translation.as_vec3(),
    }
}
