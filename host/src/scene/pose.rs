//! The scene's tables at a time: cameras, lights and meshes where their nodes stand.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::instance::{Instance, Transform};
use caustics_kernels::interface::tree::INSTANCE;
use glam::{DAffine3, DVec3};
use obvhs::aabb::Aabb;

use super::animation::{Node, is_singular};
use super::light::{self, Emitter};
use super::motion::{Motion, Placement};
use super::moving::MovingMesh;
use super::tree::top::{self, Leaf};
use super::{PunctualLight, Scene, SceneError, geometry, tree};

mod mesh;

impl Scene {
    /// Brings cameras, lights and meshes to where they stand at a time (s). The pose before becomes the previous one.
    ///
    /// # Errors
    ///
    /// If something cannot be shown at this time; then nothing changes.
    pub fn pose(&mut self, time: f64) -> Result<(), SceneError> {
        let Some(mut motion) = self.motion.take() else { return Ok(()) };
        let posed = motion.pose(self, time);
        self.motion = Some(motion);
        posed
    }

    /// Makes the light table of a scene whose environment is another; what moves then stands where it does at time 0.
    pub(super) fn light_again(&mut self) -> Result<(), SceneError> {
        match self.motion.take() {
            None => {
                let punctual_lights = std::mem::take(&mut self.punctual_lights);
                self.light(&light::emitters(self.tables()), &punctual_lights);
                self.punctual_lights = punctual_lights;
                Ok(())
            }
            Some(mut motion) => {
                let posed = motion.pose(self, 0.0);
                self.motion = Some(motion);
                posed
            }
        }
    }

    /// Writes the light table, and its ids into the triangles that emit.
    pub(super) fn light(&mut self, emitters: &[Emitter], punctual_lights: &[PunctualLight]) {
        self.place_environment();
        let (lights, flux) = light::table(self.tables(), emitters, punctual_lights, self.environment.light());
        for emitter in emitters {
            self.surfaces[emitter.triangle as usize].light = NONE;
        }
        for (id, light) in lights.iter().enumerate().filter(|(_, light)| light.triangle != NONE) {
            self.surfaces[light.triangle as usize].light = id as u32;
        }
        (self.lights, self.flux) = (lights, flux);
    }
}

/// Where everything stands at a time that can be shown.
struct Pose {
    /// From each node to the world.
    places: Vec<DAffine3>,
    /// Lights that shine then.
    lights: Vec<PunctualLight>,
}

impl Motion {
    /// Brings a scene that has rows for its meshes to time 0 and finds what emits. There is no previous pose.
    pub(super) fn start(&mut self, scene: &mut Scene) -> Result<(), SceneError> {
        self.prepare();
        let pose = self.at(scene.origin, 0.0)?;
        self.place(scene, &pose);
        // Emission is sampled on meshes that are posed: they know their texture coordinates.
        self.emitters = light::emitters(scene.tables());
        scene.light(&self.emitters, &pose.lights);
        Ok(())
    }

    /// Brings the scene to a time (s).
    fn pose(&mut self, scene: &mut Scene, time: f64) -> Result<(), SceneError> {
        let pose = self.at(scene.origin, time)?;
        self.place(scene, &pose);
        scene.light(&self.emitters, &pose.lights);
        Ok(())
    }

    /// The pose at a time (s), checked whole, so that a time that cannot be shown changes nothing.
    fn at(&self, origin: DVec3, time: f64) -> Result<Pose, SceneError> {
        let wrong = |node: &Node, what: &str| SceneError::Node {
            file: self.file.clone(),
            node: node.label.clone(),
            what: format!("at {time} s {what}"),
        };
        let time = if time.is_nan() { 0.0 } else { time };
        let places = self.rig.at(time).map_err(|node| wrong(node, "its place in the world is not finite"))?;
        for camera in self.cameras.iter().filter(|camera| camera.moves) {
            if is_singular(&places[camera.joint]) {
                return Err(wrong(
                    &self.rig.joints[camera.joint],
                    "its transform is singular (a scale of zero, or axes in one plane)",
                ));
            }
        }
        let lights: Vec<_> =
            self.lights.iter().filter_map(|light| light.what.placed(&places[light.joint], origin)).collect();
        light::check(&self.file, &lights)?;
        for mesh in &self.meshes {
            if !mesh.fits(&places[mesh.joint], origin) {
                let what = format!("its mesh reaches beyond {:e} m", geometry::MAX_COORDINATE);
                return Err(wrong(&self.rig.joints[mesh.joint], &what));
            }
        }
        Ok(Pose { places, lights })
    }

    /// Writes the rows of cameras and meshes, and the tree above the meshes.
    fn place(&mut self, scene: &mut Scene, pose: &Pose) {
        for (on_node, camera) in self.cameras.iter().zip(&mut scene.cameras) {
            *camera = on_node.what.placed(&pose.places[on_node.joint], scene.origin);
        }
        let mut leaves = Vec::new();
        if let Some(bounds) = self.still_bounds {
            leaves.push(Leaf { bounds, child: self.top as u32 });
        }
        for id in 0..self.meshes.len() {
            let bounds = self.pose_mesh(scene, id, &pose.places);
            leaves.extend(bounds.map(|bounds| Leaf { bounds, child: INSTANCE | (id as u32 + 1) }));
        }
        if !self.meshes.is_empty() {
            top::build(&mut scene.nodes[..self.top], leaves);
        }
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
    fn prepare(&mut self) {
        self.places = vec![DAffine3::NAN; self.meshes.len()];
        let placement = |mesh: &MovingMesh| Placement {
            first: mesh.first,
            count: mesh.corners.len() as u32,
            ..Placement::default()
        };
        self.placements = self.meshes.iter().map(placement).collect();
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
