//! The software tracer against an oracle in double precision.

use caustics::scene::{Scene, resolve};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::math::max_abs;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::uniform_sphere;
use caustics_kernels::trace::Tracer;
use glam::{DVec3, Vec3};

fn scene(name: &str) -> Scene {
    Scene::load(&resolve(name).unwrap()).unwrap()
}

/// Random rays that start inside of the scene.
fn rays(scene: &Scene, count: u32) -> impl Iterator<Item = Ray> + use<'_> {
    (0..count).map(|path| {
        let mut rng = Rng::new(Stream::Camera, 11, path, 0);
        let (u, v) = (rng.next4(), rng.next4());
        let triangle = scene.triangles[(u.x * scene.triangles.len() as f32) as usize];
        let middle = (triangle.a + triangle.b + triangle.c) / 3.0;
        let origin = (middle * 0.98).lerp(Vec3::new(v.x, v.y, v.z) - Vec3::splat(0.5), 0.05 + 0.9 * u.y);
        Ray::endless(origin, uniform_sphere(u.z, u.w))
    })
}

/// Distance to a triangle by Moeller and Trumbore, in double precision.
fn distance(ray: &Ray, triangle: &Triangle) -> Option<f64> {
    let (o, d): (DVec3, DVec3) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (a, b, c) = (triangle.a.as_dvec3(), triangle.b.as_dvec3(), triangle.c.as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let p = d.cross(e2);
    let determinant = e1.dot(p);
    let s = o - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = d.dot(q) / determinant;
    let t = e2.dot(q) / determinant;
    (determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

#[test]
fn closest_hits_are_the_oracles() {
    for name in ["mirror-room", "ring"] {
        let scene = scene(name);
        let mut tracer = scene.tracer(Features(0));
        let mut others = 0;
        for ray in rays(&scene, 3000) {
            let hit = tracer.closest(&ray);
            let oracle = scene
                .triangles
                .iter()
                .enumerate()
                .filter_map(|(id, triangle)| distance(&ray, triangle).map(|t| (t, id as u32)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((t, id)) = oracle else {
                // A ray along an edge may be hit in single and missed in double precision.
                others += u32::from(!hit.is_miss());
                continue;
            };
            // A few ulp of the coordinates, over a grazing cosine of 1 %.
            let slack = 1e-4 * f64::from(max_abs(ray.origin).max(hit.distance));
            let same = !hit.is_miss() && (f64::from(hit.distance) - t).abs() <= slack;
            others += u32::from(!same);
            if same && hit.triangle == id {
                let triangle = &scene.triangles[id as usize];
                let point =
                    triangle.a + (triangle.b - triangle.a) * hit.u + (triangle.c - triangle.a) * hit.v;
                let along = ray.origin + ray.direction * hit.distance;
                assert!((point - along).length() <= 1e-4 * max_abs(along).max(1.0), "{name}: {hit:?}");
            }
        }
        assert!(others <= 3, "{name}: {others} of 3000 rays hit something else");
    }
}

#[test]
fn no_ray_slips_out_of_a_closed_room() {
    let scene = scene("mirror-room");
    let mut tracer = scene.tracer(Features(0));
    let lost = rays(&scene, 300_000).filter(|ray| tracer.closest(ray).is_miss()).count();
    assert_eq!(lost, 0, "rays between the triangles of a watertight room");
}

#[test]
fn rays_through_shared_corners_and_edges_hit() {
    // A fan of triangles round a corner, met exactly at the corner and along its edges from many sides.
    let scene = scene("mirror-room");
    let mut tracer = scene.tracer(Features(0));
    let mut lost = 0;
    for (path, triangle) in scene.triangles.iter().enumerate().step_by(7) {
        let u = Rng::new(Stream::Light, 3, path as u32, 0).next4();
        let origin = uniform_sphere(u.x, u.y) * 0.3;
        for target in [triangle.a, triangle.b, triangle.c, (triangle.a + triangle.b) * 0.5] {
            let ray = Ray::endless(origin, (target - origin).normalize());
            lost += u32::from(tracer.closest(&ray).is_miss());
        }
    }
    assert_eq!(lost, 0);
}

#[test]
fn occlusion_agrees_with_the_closest_hit() {
    let scene = scene("mirror-room");
    let mut tracer = scene.tracer(Features(0));
    for ray in rays(&scene, 20_000) {
        let hit = tracer.closest(&ray);
        assert!(tracer.occluded(&Ray { length: hit.distance * 1.001, ..ray }));
        assert!(!tracer.occluded(&Ray { length: hit.distance * 0.999, ..ray }));
    }
}
