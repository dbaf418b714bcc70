//! Cost model of a frame's passes: expected rays and bytes, beside measured times.
//!
//! With W x H pixels, N light paths and b bounces at most:
//!
//! | pass | expected work of a frame |
//! |---|---|
//! | `collect` | W H r_c closest hits and W H s_c shadow rays. r_c <= b + 1 vertices of a camera path: about 1, plus the probability of a specular first hit, plus the probability of a bounce off the first non-specular vertex, and so on; s_c: one per vertex and class of lobes |
//! | `shoot` | N r_l closest hits, r_l <= b; 1.6 in a room whose walls reflect half |
//! | `shoot.store`, `index.*`, `gather.*` | 64 bytes a photon: written once, moved to its cell, read by each point nearby |
//! | `reuse`, `validate` | the previous points near each of W H points, at the bytes of the history's buffers a pixel, read once and written once; `validate` also re-traces its share of N r_l rays |
//! | `resolve`, `display` | 120 and 36 bytes a pixel: a point's 96, its sum of 12, and colours of 12, in and out |
//!
//! A pass that traces should take its rays divided by the rate of the tracer alone; the excess is shading. A pass over
//! pixels should take its bytes divided by the memory's bandwidth; a far longer time points to computation or scattered
//! accesses.

use std::collections::BTreeMap;

use caustics_kernels::declare::Work;
use caustics_kernels::interface::point::{PointGeometry, PointShading};
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::memory::memory;
use super::plan::MeasurementPlan;
use super::record::FrameRecord;
use super::run_config::RunConfig;
use caustics::scene::Scene;
use caustics_kernels::history;
use caustics_kernels::method::frame::work;

/// Cost of a pass, or of the passes of one kind: measured and expected.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Mean time in a frame (ms).
    pub ms: f64,
    /// Rays in a frame; only of passes that trace and count them.
    pub rays: Option<f64>,
    /// Bytes read and written in a frame; only of passes over pixels.
    pub bytes: Option<f64>,
    /// Rays or bytes over the time [1/s or bytes/s].
    pub rate_per_s: f64,
    /// Rays over the rate of the tracer alone (ms).
    pub expected_ms: Option<f64>,
}

/// Returns the costs of the passes that the model knows, from the records of a run configuration. `hits_per_s` is the rate
/// of the tracer alone. None where the scene lacks the plan's camera.
pub fn costs(
    plan: &MeasurementPlan,
    scene: &Scene,
    run: &RunConfig,
    records: &[&FrameRecord],
    hits_per_s: f64,
) -> Option<BTreeMap<String, Cost>> {
    let without_history = memory(plan, &run.clone().with(|config| config.history = &history::NONE), scene)?;
    let memory = memory(plan, run, scene)?;
    let frames = records.len() as f64;
    let count = |name: &str| records.iter().filter_map(|record| record.get(name)).sum::<f64>() / frames;
    let ms = |kind: Work| {
        let passes =
            records.iter().flat_map(|record| record.passes()).filter(|(pass, _)| work(pass) == Some(kind));
        passes.map(|(_, ms)| ms).sum::<f64>() / frames
    };
    let pixels = f64::from(plan.config.width) * f64::from(plan.config.height);
    let color = size_of::<Vec3>();
    let point = size_of::<PointGeometry>() + size_of::<PointShading>();
    let resolve = point + caustics_kernels::gather::accumulator::WORDS as usize * 4 + color;
    let history = memory.total_bytes.saturating_sub(without_history.total_bytes) as f64;
    let known = [
        (Work::Camera, "collect", Some(count("camera_rays") + count("shadow_rays")), None),
        (Work::Light, "shoot", Some(count("light_rays")), None),
        (Work::Reuse, "reuse", None, Some(history)),
        (Work::Resolve, "resolve", None, Some(pixels * resolve as f64)),
        (Work::Display, "display", None, Some(pixels * (3 * color) as f64)),
    ];
    let mut costs = BTreeMap::new();
    for (kind, pass, rays, bytes) in known {
        let (ms, amount) = (ms(kind), rays.or(bytes).unwrap_or(0.0));
        if ms > 0.0 && amount > 0.0 {
            let expected_ms = rays.map(|rays| 1e3 * rays / hits_per_s);
            let rate_per_s = 1e3 * amount / ms;
            costs.insert(pass.to_string(), Cost { ms, rays, bytes, rate_per_s, expected_ms });
        }
    }
    Some(costs)
}
