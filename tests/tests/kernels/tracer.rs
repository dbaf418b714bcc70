//! The software tracer against an oracle in double precision, and the CPU runner's tracer against the software tracer.

use caustics::scene::{Scene, resolve};
use caustics_kernels::interface::bvh::{BvhNode, LEAF};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::math::max_abs;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::uniform_sphere;
use caustics_kernels::trace::Tracer;
use caustics_kernels::trace::bvh::BvhTracer;
use caustics_kernels::trace::on_cpu::{Bvh8, CpuTracer};
use caustics_tests::rays;
use caustics_tests::scenes::{Builder, lambert};
use glam::{DVec3, Vec3, Vec4};

fn scene(name: &str) -> Scene {
    Scene::load(&resolve(name).unwrap()).unwrap()
}

/// Random rays that start inside of the scene.
fn rays_inside(scene: &Scene, count: u32) -> impl Iterator<Item = Ray> + use<'_> {
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
fn closest_hits_match_a_double_precision_oracle() {
    for name in ["mirror-room", "ring"] {
        let scene = scene(name);
        let mut tracer = scene.tracer(Features(0));
        let mut others = 0;
        for ray in rays_inside(&scene, 3000) {
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
    let lost = rays_inside(&scene, 300_000).filter(|ray| tracer.closest(ray).is_miss()).count();
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
    for ray in rays_inside(&scene, 20_000) {
        let hit = tracer.closest(&ray);
        assert!(tracer.occluded(&Ray { length: hit.distance * 1.001, ..ray }));
        assert!(!tracer.occluded(&Ray { length: hit.distance * 0.999, ..ray }));
    }
}

/// Squares on planes of a lattice, many of them coincident, and rays between lattice points. Most rays have several
/// closest hits at exactly one distance.
fn lattice() -> (Scene, Vec<Ray>) {
    let mut builder = Builder::default();
    let matte = builder.material(lambert(0.5));
    let whole = |path: u32, purpose: u32| {
        let u = Rng::new(Stream::Light, 5, path, purpose).next4();
        (u * 5.0).floor()
    };
    for path in 0..400 {
        let at = whole(path, 0);
        let centre = DVec3::new(at.x.into(), at.y.into(), at.z.into());
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let axis = at.w as usize % 3;
        builder.panel(matte, centre, axes[(axis + 1) % 3] * 1.5, axes[(axis + 2) % 3]);
    }
    let ray = |path| {
        let (from, to) = (whole(path, 1), whole(path, 2));
        let direction = (to - from).truncate();
        (direction != Vec3::ZERO).then(|| Ray::endless(from.truncate() + 0.25, direction))
    };
    (builder.build(), (0..4000).filter_map(ray).collect())
}

#[test]
fn hits_at_equal_distance_resolve_to_the_smallest_id_in_every_bvh() {
    let (scene, rays) = lattice();
    let BvhTracer { blocks, cut_outs, .. } = scene.tracer(Features(0));
    // Search BVHs of one leaf each, so that the closest hit of all depends on no order.
    let everywhere = BvhNode {
        min_x: Vec4::splat(-9.0),
        min_y: Vec4::splat(-9.0),
        min_z: Vec4::splat(-9.0),
        max_x: Vec4::splat(9.0),
        max_y: Vec4::splat(9.0),
        max_z: Vec4::splat(9.0),
        ..BvhNode::default()
    };
    let leaves: Vec<BvhNode> =
        (0..blocks.len() as u32).map(|block| BvhNode { children: [LEAF | block; 4], ..everywhere }).collect();
    let bvh8 = Bvh8::new(&scene.nodes, &scene.instances);
    let mut ties = 0;
    for ray in &rays {
        let in_leaf = |leaf| BvhTracer { nodes: std::slice::from_ref(leaf), blocks, cut_outs }.closest(ray);
        let hits: Vec<Hit> = leaves.iter().map(in_leaf).filter(|hit| !hit.is_miss()).collect();
        let key = |hit: &Hit| (hit.distance.to_bits(), hit.triangle);
        let first = hits.iter().copied().min_by_key(key).unwrap_or(Hit { distance: ray.length, ..Hit::MISS });
        ties += u32::from(
            hits.iter().any(|hit| hit.distance == first.distance && hit.triangle != first.triangle),
        );
        assert_eq!(scene.tracer(Features(0)).closest(ray), first);
        assert_eq!(CpuTracer::new(scene.tracer(Features(0)), bvh8.as_ref()).closest(ray), first);
    }
    assert!(ties > 1000, "{ties} rays of {} have several closest hits", rays.len());
}

#[test]
fn cpu_tracer_matches_the_software_tracer_to_the_bit() {
    for name in ["mirror-room", "textured-room", "moving-caster", "moving-receiver"] {
        let scene = scene(name);
        let Some(bvh8) = Bvh8::new(&scene.nodes, &scene.instances) else {
            eprintln!("this CPU has no BVH of its own");
            return;
        };
        let mut tracer = scene.tracer(Features::ALL);
        let mut own = CpuTracer::new(tracer, Some(&bvh8));
        let rays = rays::through(&scene, 10_000);
        let hits: Vec<Hit> = rays.iter().map(|ray| tracer.closest(ray)).collect();
        let along_axes = rays.iter().map(|ray| {
            let axis = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
            Ray { direction: axis[ray.key as usize % 6], ..*ray }
        });
        let short = rays.iter().zip(&hits).map(|(ray, hit)| Ray { length: hit.distance, ..*ray });
        let others = rays::from_surfaces(&scene, &rays, &hits).into_iter().chain(along_axes).chain(short);
        let mut found = 0;
        for ray in rays.iter().copied().chain(others) {
            let hit = tracer.closest(&ray);
            found += u32::from(!hit.is_miss());
            assert_eq!(own.closest(&ray), hit, "{name}: {ray:?}");
            assert_eq!(own.occluded(&ray), tracer.occluded(&ray), "{name}: {ray:?}");
        }
        assert!(found > 3000, "{name}: {found} hits");
    }
}
