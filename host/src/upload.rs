//! Upload of a pose's changes to the tables of a runner.

use bytemuck::{NoUninit, cast_slice};
use caustics_kernels::interface::environment::Environment;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::light_bvh::LightBvhNode;
use caustics_kernels::interface::triangle::Triangle;

use crate::runner::{RunError, Runner};
use caustics_scene::Scene;
use caustics_scene::instanced::InstanceTransform;
use caustics_scene::mesh::Mesh;

/// Tables of the last pose that a runner received.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Upload {
    lights: Vec<Light>,
    light_bvh: Vec<LightBvhNode>,
    environment: Vec<Environment>,
    instance_transforms: Vec<InstanceTransform>,
    /// Triangles of each deformed mesh.
    deformed: Vec<Vec<Triangle>>,
}

impl Upload {
    /// Starts from a runner that was opened with this scene in this pose.
    pub fn new(scene: &Scene) -> Upload {
        if !scene.is_animated() {
            return Upload::default();
        }
        Upload {
            lights: scene.lights.clone(),
            light_bvh: scene.light_bvh.clone(),
            environment: scene.environment.records.clone(),
            instance_transforms: scene.instanced.instance_transforms().to_vec(),
            deformed: deformed(scene)
                .map(|(_, mesh)| scene.triangles[mesh.triangle_ids()].to_vec())
                .collect(),
        }
    }

    /// Writes the changes of the current pose, and returns whether there were any.
    ///
    /// # Errors
    ///
    /// If the runner fails.
    pub fn run(&mut self, runner: &mut dyn Runner, scene: &Scene) -> Result<bool, RunError> {
        if !scene.is_animated() {
            return Ok(false);
        }
        let now = Upload::new(scene);
        if now.lights != self.lights {
            runner.write("lights", cast_slice(&scene.lights))?;
            // The records of all emitters, from the first to the last, hold their light id.
            let emitters = scene.emitters.iter().map(|emitter| emitter.triangle as usize);
            if let Some((first, last)) = emitters.clone().min().zip(emitters.max()) {
                write_records(runner, "surfaces", &scene.surfaces, first..last + 1)?;
            }
        }
        if now.light_bvh != self.light_bvh {
            runner.write("light_bvh", cast_slice(&scene.light_bvh))?;
        }
        if now.environment != self.environment {
            runner.write("environment", cast_slice(&scene.environment.records))?;
        }
        for (_, mesh) in deformed(scene) {
            write_records(runner, "triangles", &scene.triangles, mesh.triangle_ids())?;
            write_records(runner, "surfaces", &scene.surfaces, mesh.triangle_ids())?;
            if !scene.textures.coordinates.is_empty() {
                write_records(
                    runner,
                    "texture_coordinates",
                    &scene.textures.coordinates,
                    mesh.triangle_ids(),
                )?;
            }
            write_records(runner, "nodes", &scene.nodes, mesh.nodes.clone())?;
            write_records(runner, "blocks", &scene.blocks, mesh.blocks())?;
        }
        if !now.instance_transforms.is_empty() {
            write_records(runner, "nodes", &scene.nodes, 0..scene.instanced.top)?;
            write_records(runner, "instances", &scene.instances, 1..scene.instances.len())?;
            let deformed: Vec<usize> = deformed(scene).map(|(id, _)| id).collect();
            runner.set_instances(&now.instance_transforms, &deformed)?;
        }
        let changed = now != *self;
        *self = now;
        Ok(changed)
    }
}

/// Returns the deformed meshes with their indices.
fn deformed(scene: &Scene) -> impl Iterator<Item = (usize, &Mesh)> {
    let meshes = scene.instanced.meshes.iter().enumerate();
    meshes.filter(|(_, mesh)| mesh.deformation.is_some())
}

/// Writes a range of a table's records.
fn write_records<T: NoUninit>(
    runner: &mut dyn Runner,
    table: &str,
    all: &[T],
    range: std::ops::Range<usize>,
) -> Result<(), RunError> {
    let offset = range.start * size_of::<T>();
    runner.write_at(table, offset, cast_slice(&all[range]))
}
