//! What moves in a scene.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::Transform;
use caustics_kernels::interface::triangle::TriangleSurface;
use glam::{DAffine3, DVec3};
use obvhs::aabb::Aabb;

use super::animation::{NodeTree, is_singular};
use super::light::Emitter;
use super::moving::MovingMesh;
use super::{PunctualLight, SceneCamera};

/// Parts of the animations' time, at whose ends one looks where meshes are.
const LOOKS: u32 = 8;

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
    /// Rows that the light table can have at most.
    pub fn most_lights(&self) -> usize {
        self.emitters.len() + self.lights.len()
    }

    /// Whether there can be light at some time.
    pub fn has_light(&self) -> bool {
        self.features().has(caustics_kernels::light::TYPES)
    }

    /// Where the corners of its meshes come to at some times of its animations, around an origin (m); those of a mesh that is hidden
    /// then are left out.
    pub fn corners(&self, origin: DVec3) -> impl Iterator<Item = DVec3> + '_ {
        let last = self.rig.duration();
        let times = (0..=LOOKS).map(move |look| last * f64::from(look) / f64::from(LOOKS));
        let places = times.filter_map(|time| self.rig.at(time).ok());
        places.flat_map(move |places| {
            let meshes = self.meshes.iter().map(move |mesh| (mesh, places[mesh.joint]));
            let seen = meshes.filter(|(_, place)| !is_singular(place));
            seen.flat_map(move |(mesh, place)| mesh.world(&place).map(move |corner| corner - origin))
        })
    }

    /// Its punctual lights at time 0, around an origin (m).
    pub(super) fn lights_at_first(&self, origin: DVec3) -> Vec<PunctualLight> {
        let places = self.rig.at(0.0).unwrap_or_default();
        let placed = |light: &OnNode<PunctualLight>| light.what.placed(places.get(light.joint)?, origin);
        self.lights.iter().filter_map(placed).collect()
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
    pub fn still_light_ids(&self, surfaces: &[TriangleSurface]) -> Vec<u32> {
        let still = self.emitters.iter().filter(|emitter| (emitter.triangle as usize) < self.still);
        still.map(|emitter| surfaces.get(emitter.triangle as usize).map_or(NONE, |s| s.light)).collect()
    }
}
