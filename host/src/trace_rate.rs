//! Speed of a runner's tracer.

use bytemuck::cast_slice;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::{max_abs, warp};
use caustics_kernels::pass::collect::{COLLECT, pixel_order};
use caustics_kernels::pass::step::STEP_HIT;

use crate::render_config::RenderConfig;
use crate::session::{RunnerChoice, SessionError, open};
use caustics_kernels::declare::{Step, buffers};
use caustics_scene::{Scene, SceneCamera};

/// Measures closest hits per second of a runner's tracer on incoherent rays. The rays start at the camera paths' vertices
/// of a small image and have random directions. Returns the best of five rounds.
///
/// # Errors
///
/// If the runner cannot be opened, or fails.
pub fn closest_hits_per_second(
    choice: &RunnerChoice,
    scene: &Scene,
    camera: &SceneCamera,
    features: Features,
) -> Result<f64, SessionError> {
    const SIDE: u32 = 512;
    let config = RenderConfig { width: SIDE, height: SIDE, ..RenderConfig::default() };
    let params = FrameParams { light_path_batch: SIDE * SIDE, ..config.params(scene, camera, 0) };
    let pixels = params.pixel_count() as usize;
    let (collect, hit) = (Step::new(&COLLECT, &params), Step::new(&STEP_HIT, &params));
    let mut runner = open(choice, scene, features, &buffers(&[collect, hit], &params))?;
    runner.write("pixel_order", cast_slice(&pixel_order(SIDE, SIDE)))?;
    runner.run(&params, &[collect])?;
    let points: Vec<PointGeometry> = bytemuck::pod_collect_to_vec(&runner.read("point_geometry")?);
    let rays: Vec<Ray> = points
        .iter()
        .enumerate()
        .map(|(index, point)| {
            let u = Rng::new(Stream::Light, 0, index as u32, 0).next4();
            let direction = warp::uniform_sphere(u.x, u.y);
            let side = if direction.dot(point.normal) < 0.0 { -1.0 } else { 1.0 };
            let lift = point.normal * (1.0e-4 * side * max_abs(point.position));
            Ray::endless(point.position + lift, direction)
        })
        .collect();
    runner.write("rays", cast_slice(&rays))?;
    let mut best = f64::MAX;
    for _ in 0..5 {
        let seconds: f64 = runner.run(&params, &[hit])?.iter().map(|step| step.time.as_secs_f64()).sum();
        best = best.min(seconds);
    }
    Ok(pixels as f64 / best)
}
