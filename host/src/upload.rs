//! What a pose changes in a scene's tables, written to a runner.

use bytemuck::{NoUninit, cast_slice};
use caustics_kernels::interface::environment::Environment;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::triangle::Triangle;

use crate::runner::{RunError, Runner};
use caustics_scene::Scene;
use caustics_scene::instanced::InstanceTransform;
use caustics_scene::mesh::Mesh;

/// What a runner holds of the pose before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Upload {
    lights: Vec<Light>,
    environment: Vec<Environment>,
    instance_transforms: Vec<InstanceTransform>,
    /// Triangles of each mesh that is deformed.
    deformed: Vec<Vec<Triangle>>,
}

impl Upload {
    /// For a runner that was opened with this scene at this pose.
    pub fn new(scene: &Scene) -> Upload {
        if !scene.is_animated() {
            return Upload::default();
        }
        Upload {
            lights: scene.lights.clone(),
            environment: scene.environment.records.clone(),
            instance_transforms: scene.instanced.instance_transforms().to_vec(),
            deformed: deformed(scene)
                .map(|(_, mesh)| scene.triangles[mesh.triangle_ids()].to_vec())
                .collect(),
        }
    }

    /// Writes what the pose at hand changed; whether it changed anything.
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
            // The rows of all that emit, from the first to the last, say which light they are.
            let emitters = scene.emitters.iter().map(|emitter| emitter.triangle as usize);
            if let Some((first, last)) = emitters.clone().min().zip(emitters.max()) {
                write_records(runner, "surfaces", &scene.surfaces, first..last + 1)?;
            }
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

/// Meshes that are deformed, by their index.
fn deformed(scene: &Scene) -> impl Iterator<Item = (usize, &Mesh)> {
    let meshes = scene.instanced.meshes.iter().enumerate();
    meshes.filter(|(_, mesh)| mesh.deformation.is_some())
}

/// Writes some records of a table.
fn write_records<T: NoUninit>(
    runner: &mut dyn Runner,
    table: &str,
    all: &[T],
    range: std::ops::Range<usize>,
) -> Result<(), RunError> {
    let offset = range.start * size_of::<T>();
    runner.write_at(table, offset, cast_slice(&all[range]))
}
