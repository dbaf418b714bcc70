//! The scene's tables at a time: cameras, lights and meshes where their nodes stand.

use caustics_kernels::interface::NONE;

use super::animation::{Nodes, is_singular};
use super::corner::Corner;
use super::{PunctualLight, Scene, SceneError, geometry};
use super::{light, mesh};

impl Scene {
    /// Brings cameras, lights and meshes to where they stand at a time (s). The pose before becomes the previous one.
    ///
    /// # Errors
    ///
    /// If something cannot be shown at this time; then nothing changes.
    pub fn pose(&mut self, time: f64) -> Result<(), SceneError> {
        let recorded = self.recorded_camera(time)?;
        if let Some(pose) = self.pose_at(time)? {
            self.stand(&pose);
            self.light(&pose.lights);
        }
        if let Some((id, camera)) = recorded {
            self.cameras[id] = camera;
        }
        Ok(())
    }

    /// Brings a scene that was edited to time 0, as if it had never stood otherwise: there is no previous pose.
    pub(super) fn begin(&mut self) -> Result<(), SceneError> {
        self.instanced.forget();
        self.pose(0.0)
    }

    /// Brings a scene that has all its rows to time 0, and finds what emits. There is no previous pose.
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

    /// Makes the light table of a scene whose environment is another; what moves then stands where it does at time 0.
    pub(super) fn light_again(&mut self) -> Result<(), SceneError> {
        if self.motion.is_some() {
            return self.pose(0.0);
        }
        let lights = std::mem::take(&mut self.punctual_lights);
        self.light(&lights);
        self.punctual_lights = lights;
        Ok(())
    }

    /// Writes the light table, and its ids into the triangles that emit.
    fn light(&mut self, punctual_lights: &[PunctualLight]) {
        let hull = if self.asks_for_its_hull(punctual_lights) { self.hull() } else { Vec::new() };
        self.environment.enclose(&hull);
        let (lights, flux) = light::table(self, &hull, punctual_lights, self.environment.light());
        for emitter in &self.emitters {
            self.surfaces[emitter.triangle as usize].light = NONE;
        }
        for (id, light) in lights.iter().enumerate().filter(|(_, light)| light.triangle != NONE) {
            self.surfaces[light.triangle as usize].light = id as u32;
        }
        (self.lights, self.flux) = (lights, flux);
    }

    /// Whether some light comes from beyond all that can be met.
    fn asks_for_its_hull(&self, punctual_lights: &[PunctualLight]) -> bool {
        !self.environment.records.is_empty() || punctual_lights.iter().any(PunctualLight::is_directional)
    }

    /// Writes the rows of cameras and instances.
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

    /// The pose at a time (s), checked whole, so that a time that cannot be shown changes nothing; none where nothing moves.
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
        let lights: Vec<_> =
            lights.filter_map(|light| light.what.placed(&to_world[light.joint], self.origin)).collect();
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

/// Where everything stands at a time that can be shown.
#[derive(Default)]
struct Pose {
    nodes: Nodes,
    /// Lights that shine then.
    lights: Vec<PunctualLight>,
    /// Meshes that are deformed, with their vertices.
    deformed: Vec<(usize, Vec<Corner>)>,
}
