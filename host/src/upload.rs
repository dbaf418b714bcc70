//! What a pose changes in a scene's tables, written to a runner.

use bytemuck::{NoUninit, cast_slice};
use caustics_kernels::interface::environment::Environment;
use caustics_kernels::interface::light::Light;

use crate::runner::{RunError, Runner};
use crate::scene::Scene;
use crate::scene::motion::Placement;

/// What a runner holds of the pose before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Upload {
    light_ids: Vec<u32>,
    lights: Vec<Light>,
    environment: Vec<Environment>,
    placements: Vec<Placement>,
}

impl Upload {
    /// For a runner that was opened with this scene at this pose.
    pub fn new(scene: &Scene) -> Upload {
        let Some(motion) = &scene.motion else { return Upload::default() };
        Upload {
            light_ids: motion.still_light_ids(&scene.surfaces),
            lights: scene.lights.clone(),
            environment: scene.environment.rows.clone(),
            placements: motion.placements.clone(),
        }
    }

    /// Writes what the pose at hand changed; whether it changed anything.
    ///
    /// # Errors
    ///
    /// If the runner fails.
    pub fn run(&mut self, runner: &mut dyn Runner, scene: &Scene) -> Result<bool, RunError> {
        let Some(motion) = &scene.motion else { return Ok(false) };
        let now = Upload::new(scene);
        if now.lights != self.lights {
            runner.write("lights", cast_slice(&scene.lights))?;
        }
        if now.environment != self.environment {
            runner.write("environment", cast_slice(&scene.environment.rows))?;
        }
        if now.light_ids != self.light_ids {
            // The rows of emitters that stand still, from the first to the last.
            let still = motion.emitters.iter().map(|emitter| emitter.triangle as usize);
            let still: Vec<_> = still.filter(|&triangle| triangle < motion.still).collect();
            if let (Some(&first), Some(&last)) = (still.first(), still.last()) {
                rows(runner, "surfaces", &scene.surfaces, first..last + 1)?;
            }
        }
        if !motion.meshes.is_empty() {
            rows(runner, "triangles", &scene.triangles, motion.still..scene.triangles.len())?;
            rows(runner, "surfaces", &scene.surfaces, motion.still..scene.surfaces.len())?;
            let coordinates = &scene.textures.coordinates;
            rows(
                runner,
                "texture_coordinates",
                coordinates,
                motion.still.min(coordinates.len())..coordinates.len(),
            )?;
            rows(runner, "nodes", &scene.nodes, 0..motion.top)?;
            rows(runner, "instances", &scene.instances, 1..scene.instances.len())?;
            for ((mesh, placement), before) in
                motion.meshes.iter().zip(&motion.placements).zip(&self.placements)
            {
                if placement.mirrored != before.mirrored {
                    rows(runner, "blocks", &scene.blocks, mesh.blocks.clone())?;
                    let first = placement.first as usize - motion.still;
                    let range = first..first + placement.count as usize;
                    rows(runner, "object_triangles", &scene.object_triangles, range)?;
                }
            }
            runner.place(&motion.placements)?;
        }
        let changed = now != *self;
        *self = now;
        Ok(changed)
    }
}

/// Writes some rows of a table.
fn rows<T: NoUninit>(
    runner: &mut dyn Runner,
    table: &str,
    all: &[T],
    range: std::ops::Range<usize>,
) -> Result<(), RunError> {
    let offset = range.start * size_of::<T>();
    runner.write_at(table, offset, cast_slice(&all[range]))
}
