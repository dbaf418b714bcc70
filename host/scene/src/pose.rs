//! Pose of a scene: updates the tables of cameras, lights and meshes for a time.

use caustics_kernels::interface::NONE;

use super::animation::{Nodes, is_singular};
use super::corner::Corner;
use super::{PunctualLight, Scene, SceneError, geometry};
use super::{light, mesh};

impl Scene {
    /// Moves cameras, lights and meshes to a time (s). The current pose becomes the previous one.
    ///
    /// # Errors
    ///
    /// If the pose is invalid at this time; then nothing changes.
    pub fn pose(&mut self, time: f64) -> Result<(), SceneError> {
        self.pose_after(time, |_| {})
    }

    /// Moves cameras, lights and meshes to a time (s), without a previous pose: nothing is in motion.
    ///
    /// # Errors
    ///
    /// As [`Scene::pose`].
    pub fn begin_at(&mut self, time: f64) -> Result<(), SceneError> {
        self.pose_after(time, |scene| scene.instanced.forget())
    }

    /// Moves cameras, lights and meshes to a time (s). Changes the scene before, once the pose is known to be valid.
    fn pose_after(&mut self, time: f64, change: fn(&mut Scene)) -> Result<(), SceneError> {
        let recorded = self.recorded_camera(time)?;
        if let Some(pose) = self.pose_at(time)? {
            change(self);
            self.stand(&pose);
            self.light(&pose.lights);
        }
        if let Some((id, camera)) = recorded {
            self.cameras[id] = camera;
        }
        Ok(())
    }

    /// Moves a complete scene to time 0 and finds its emitters. There is no previous pose.
    pub(super) fn start(&mut self) -> Result<(), SceneError> {
        let pose = self.pose_at(0.0)?;
        self.stand(pose.as_ref().unwrap_or(&Pose::default()));
        self.emitters = light::emitters(self);
        match pose {
            Some(pose) => self.light(&pose.lights),
            None => self.light_again()?,
        }
        Ok(())
    }

    /// Rebuilds the light table, after the environment changed. Moving objects are then at time 0.
    pub(super) fn light_again(&mut self) -> Result<(), SceneError> {
        if self.motion.is_some() {
            return self.pose(0.0);
        }
        let lights = std::mem::take(&mut self.punctual_lights);
        self.light(&lights);
        self.punctual_lights = lights;
        Ok(())
    }

    /// Writes the light table, and the light ids of emissive triangles.
    fn light(&mut self, punctual_lights: &[PunctualLight]) {
        let hull = if self.asks_for_its_hull(punctual_lights) { self.hull() } else { Vec::new() };
        self.environment.enclose(&hull);
        // Keep the keys while the scene moves.
        if self.light_keys.len() != light::key_count(self, punctual_lights) {
            self.light_keys = light::keys(self, punctual_lights);
        }
        let (lights, flux) = light::table(self, &hull, punctual_lights, self.environment.light());
        for emitter in &self.emitters {
            self.surfaces[emitter.triangle as usize].light = NONE;
        }
        for (id, light) in lights.iter().enumerate().filter(|(_, light)| light.triangle != NONE) {
            self.surfaces[light.triangle as usize].light = id as u32;
        }
        self.light_bvh = light::bvh::nodes(self, &lights, f64::from(flux.element_sum() / 3.0));
        (self.lights, self.flux) = (lights, flux);
    }

    /// Whether a directional light or an environment needs the hull of the scene.
    fn asks_for_its_hull(&self, punctual_lights: &[PunctualLight]) -> bool {
        !self.environment.records.is_empty() || punctual_lights.iter().any(PunctualLight::is_directional)
    }

    /// Writes the records of cameras and instances.
    fn stand(&mut self, pose: &Pose) {
        if let Some(motion) = &self.motion {
            for (on_node, camera) in motion.cameras.iter().zip(&mut self.cameras) {
                *camera = on_node.what.placed(&pose.nodes.to_world[on_node.joint], self.origin);
            }
        }
        let mut instanced = std::mem::take(&mut self.instanced);
        instanced.set_pose(self, &pose.nodes, &pose.deformed);
        self.instanced = instanced;
    }

    /// Computes the pose at a time (s) and checks it before anything changes; `None` in a static scene.
    fn pose_at(&self, time: f64) -> Result<Option<Pose>, SceneError> {
        let Some(motion) = &self.motion else { return Ok(None) };
        let wrong = |joint: usize, what: &str| {
            let (file, what) = (motion.file.clone(), format!("at {time} s {what}"));
            let node = self.rig.joints[joint].label.clone();
            match self.rig.upwards(joint).any(|node| !node.local.edits.is_empty()) {
                true => SceneError::Edits {
                    file,
                    what: format!("{node}, as it is edited, cannot be shown: {what}"),
                },
                false => SceneError::Node { file, node, what },
            }
        };
        let time = if time.is_nan() { 0.0 } else { time };
        let nodes =
            self.rig.at(time).map_err(|node| wrong(node, "its transform in the world is not finite"))?;
        let to_world = &nodes.to_world;
        for camera in motion.cameras.iter().filter(|camera| camera.moves) {
            if is_singular(&to_world[camera.joint]) {
                return Err(wrong(
                    camera.joint,
                    "its transform is singular (a scale of zero, or axes in one plane)",
                ));
            }
        }
        let lights = motion.lights.iter();
        // Keep the place of a light that does not shine now, without intensity.
        let lights: Vec<_> = lights
            .map(|light| light.what.placed(&to_world[light.joint], self.origin).unwrap_or_default())
            .collect();
        light::check(&motion.file, &lights)?;
        let deformed = self.instanced.deform(&nodes);
        for instance in &self.instanced.instances {
            let mesh = &self.instanced.meshes[instance.mesh];
            let to_world = instance.world_transform(&nodes);
            let fits = match deformed.iter().find(|(id, _)| *id == instance.mesh) {
                Some((_, vertices)) => mesh::fit(vertices.iter().map(|v| v.position), &to_world, self.origin),
                None => instance.node().is_none() || mesh.fits(&to_world, self.origin),
            };
            if !fits {
                let what = format!("its mesh reaches beyond {:e} m", geometry::MAX_COORDINATE);
                let node = mesh.deformation.as_ref().map(|deformation| deformation.node);
                let node = node.or(instance.node()).unwrap_or_default();
                return Err(wrong(node, &what));
            }
        }
        Ok(Some(Pose { nodes, lights, deformed }))
    }
}

/// A valid pose at a time.
#[derive(Default)]
struct Pose {
    nodes: Nodes,
    /// Punctual lights; those that do not emit at this time have no intensity.
    lights: Vec<PunctualLight>,
    /// Deformed meshes by their index, with their vertices.
    deformed: Vec<(usize, Vec<Corner>)>,
}
