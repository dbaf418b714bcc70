//! Memory of a run configuration, buffer by buffer, for the frames of its plan.

use std::collections::BTreeMap;

use serde::Serialize;

use super::plan::MeasurementPlan;
use super::run_config::RunConfig;
use caustics::scene::Scene;
use caustics_kernels::method::frame::frame_buffers;

/// Bytes of the buffers of a run configuration, scene tables aside.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BufferMemory {
    /// All buffers together.
    pub total_bytes: usize,
    /// Each buffer by name.
    pub buffers_bytes: BTreeMap<&'static str, usize>,
}

/// Returns the buffers that a session of the run configuration allocates when it is opened at the scene's pose. None where
/// the scene lacks the plan's camera.
pub fn memory(plan: &MeasurementPlan, run: &RunConfig, scene: &Scene) -> Option<BufferMemory> {
    let camera = scene.camera(Some(&plan.camera)).ok()?;
    let config = run.config.with_image_of(&plan.config);
    let params = config.largest(scene, camera);
    let buffers = frame_buffers(config.method, config.parts(), &params);
    let buffers_bytes: BTreeMap<_, _> = buffers.iter().map(|buffer| (buffer.name, buffer.bytes)).collect();
    Some(BufferMemory { total_bytes: buffers_bytes.values().sum(), buffers_bytes })
}
