//! The speed of a tracer alone.

use bytemuck::cast_slice;
use caustics_kernels::gather::variant;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::math::ray::{Hit, Ray};
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::{max_abs, warp};

use crate::method::settings::Settings;
use crate::method::{BufferSpec, Step, basic};
use crate::scene::{Scene, SceneCamera};
use crate::session::{RunnerChoice, open};

/// Closest hits per second of a runner's tracer alone, on incoherent rays: from the camera paths' vertices of a small
/// picture into random directions. The best of several rounds.
pub fn closest_hits_per_second(
    choice: &RunnerChoice,
    scene: &Scene,
    camera: &SceneCamera,
    needs: Needs,
) -> anyhow::Result<f64> {
    const SIDE: u32 = 512;
    let settings = Settings { width: SIDE, height: SIDE, ..Settings::default() };
    let params = FrameParams { light_path_batch: SIDE * SIDE, ..settings.params(scene, camera, 0) };
    let pixels = params.pixel_count() as usize;
    let mut buffers = basic::buffers(&variant::BRUTE, &FrameParams { light_path_count: 0, ..params });
    buffers.push(BufferSpec { name: "rays", bytes: size_of::<Ray>() * pixels });
    buffers.push(BufferSpec { name: "hits", bytes: size_of::<Hit>() * pixels });
    let mut runner = open(choice, scene, needs, &buffers)?;
    runner.write("pixel_order", cast_slice(&basic::pixel_order(SIDE, SIDE)))?;
    runner.run(&[Step::Dispatch { pass: "collect", count: params.pixel_count(), params }])?;
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
    let hit = Step::Dispatch { pass: "step.hit", count: params.pixel_count(), params };
    let mut best = f64::MAX;
    for _ in 0..5 {
        let seconds: f64 = runner.run(&[hit])?.iter().map(|step| step.time.as_secs_f64()).sum();
        best = best.min(seconds);
    }
    Ok(pixels as f64 / best)
}
