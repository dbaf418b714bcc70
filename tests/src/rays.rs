//! Random rays through a scene, with keys of their own, and scattering events at their hits.

use caustics::scene::Scene;
use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::interface::step::ScatterIn;
use caustics_kernels::math::offset;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::uniform_sphere;
use caustics_kernels::surface::vertex::vertex;

fn rng(index: usize, purpose: u32) -> Rng {
    Rng::new(Stream::Camera, 0x7177, index as u32, purpose)
}

/// Returns `count` rays from random positions in the scene's bounds in random directions.
pub fn through(scene: &Scene, count: usize) -> Vec<Ray> {
    let [low, high] = scene.bounds;
    let ray = |index| {
        let mut rng = rng(index, 0);
        let (u_position, to) = (rng.next4(), rng.next4());
        let key = rng.ray_key(0);
        Ray { key, ..Ray::endless(low + (high - low) * u_position.truncate(), uniform_sphere(to.x, to.y)) }
    };
    (0..count).map(ray).collect()
}

/// Returns a ray from each of these hits, to either side of its triangle; misses start none.
pub fn from_surfaces(scene: &Scene, rays: &[Ray], hits: &[Hit]) -> Vec<Ray> {
    let leave = |(index, (ray, hit)): (usize, (&Ray, &Hit))| {
        let here = vertex(scene.tables(), Features::ALL, ray, hit, 0.0);
        let mut rng = rng(index, 1);
        let (key, u) = (rng.ray_key(0), rng.next4());
        let direction = uniform_sphere(u.x, u.y);
        let origin = offset::leave(here.position, here.face_normal, direction, here.clearance);
        Ray { key, ..Ray::endless(origin, direction) }
    };
    rays.iter().zip(hits).enumerate().filter(|(_, (_, hit))| !hit.is_miss()).map(leave).collect()
}

/// Returns a scattering event at each hit, with an evaluation in a random direction. Rays that meet glass from behind
/// are inside it; every fourth of them is wrongly in vacuum.
pub fn events(scene: &Scene, rays: &[Ray], hits: &[Hit]) -> Vec<ScatterIn> {
    let event = |(index, (&ray, &hit)): (usize, (&Ray, &Hit))| {
        let here = vertex(scene.tables(), Features::ALL, &ray, &hit, 0.0);
        let is_glass = scene.materials[here.material as usize].transmission > 0.0;
        let inside = if is_glass && !here.front && index % 4 != 0 { here.material } else { NONE };
        let mut rng = rng(index, 2);
        let (uniform, to) = (rng.next4().to_array(), rng.next4());
        ScatterIn { ray, hit, uniform, towards: uniform_sphere(to.x, to.y), inside }
    };
    rays.iter().zip(hits).enumerate().filter(|(_, (_, hit))| !hit.is_miss()).map(event).collect()
}
