//! Plane mirrors: the virtual light, and the view through a mirror.

use caustics::scene::Scene;
use caustics_kernels::gather::contribution::takes;
use caustics_kernels::gather::variant::{self, BRUTE};
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::math::cone::RayCone;
use caustics_kernels::math::offset;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::path::camera_path::CameraSuffix;
use caustics_kernels::path::camera_ray::{CameraPathStart, camera_ray};
use caustics_kernels::trace::Tracer;
use caustics_tests::collected::{Collected, collected};
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

use super::config;

/// O2: a plane mirror makes a virtual light: E = rho I cos / d'^2. Direct light is in `path`, once.
#[test]
fn plane_mirror_makes_a_virtual_light() {
    virtual_light(0.0);
}

/// O2 on a floor of which 60 % is a mirror and the rest takes photons. A point is created with the probability of its
/// class, and divided by it once.
#[test]
fn floor_of_60_percent_mirror_takes_40_percent_of_the_virtual_light() {
    virtual_light(0.6);
}

/// Checks the irradiance on a floor with this share of perfect metal, which itself mirrors all light out of sight.
fn virtual_light(metallic: f32) {
    let (rho, intensity, base) = (0.8, 5.0, 0.5);
    let mut b = Builder::default();
    let floor = b.material(Material { metallic, roughness: 0.0, ..lambert(base) });
    let albedo = base * (1.0 - metallic);
    let mirror = b.material(metal(rho, 0.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(mirror, DVec3::new(1.0, 1.01, 0.0), DVec3::Z, DVec3::Y);
    b.light(DVec3::new(0.0, 1.0, 0.0), intensity);
    b.camera(DVec3::new(-0.2, 3.0, 0.1), DVec3::new(-0.2, 0.0, 0.1), 0.4);
    let scene = b.build();
    let config = config(48, 32, 400_000);
    let params = World::new(&scene, &config).params;
    let on_floor = |pixel| {
        let ray = camera_ray(&params, pixel, &mut Rng::new(Stream::Camera, 0, pixel, 0));
        (ray.origin - ray.direction * (ray.origin.y / ray.direction.y)).as_dvec3()
    };
    let points: Vec<DVec3> = (0..params.pixel_count()).map(on_floor).collect();

    // Irradiance at every pixel's own point. The metal's reflectance is Schlick's at the mirror's cosine.
    let (light, virtual_image) = (DVec3::new(0.0, 1.0, 0.0), DVec3::new(2.0, 1.0, 0.0));
    let irradiance = |p: DVec3, from: DVec3| f64::from(intensity) * from.y / (from - p).length().powi(3);
    let (mut direct, mut mirrored) = (Vec::new(), 0.0);
    for &p in &points {
        let cos = ((virtual_image - p).x / (virtual_image - p).length()).abs();
        let reflectance = f64::from(rho) + (1.0 - f64::from(rho)) * (1.0 - cos).powi(5);
        direct.push(irradiance(p, light) * f64::from(albedo) / PI);
        mirrored += reflectance * irradiance(p, virtual_image) / points.len() as f64;
    }
    let frames = render(&scene, &config, "photons-grid", None, 0, 30);
    for (image, _) in &frames {
        for (got, want) in image.path.iter().zip(&direct) {
            assert!((f64::from(got.x) / want - 1.0).abs() < 1e-4, "direct light {} {want}", got.x);
        }
    }
    let measured: Vec<f64> =
        frames.iter().map(|(image, _)| mean_of(&image.caustics) * PI / f64::from(albedo)).collect();
    let (mean, error) = mean_and_error(&measured);
    println!("E = {mean:.5} +- {error:.5} W/m^2, expected {mirrored:.5}");
    assert!(error < 0.01 * mirrored, "the standard error is too large");
    assert!((mean - mirrored).abs() < 3.0 * error);
}

/// A glass ball, a metal ring and a light before a perfect mirror in the plane z = -1.
fn before_a_mirror() -> (Scene, u32) {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.7));
    let mirror = b.material(metal(1.0, 0.0));
    let ball = b.material(glass(1.5));
    let ring = b.material(metal(0.9, 0.0));
    let light = b.material(emitter(200.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(floor, DVec3::new(0.0, 1.0, 2.9), -3.0 * DVec3::X, DVec3::Y);
    b.panel(mirror, DVec3::new(0.0, 0.9, -1.0), 1.5 * DVec3::X, 0.85 * DVec3::Y);
    b.sphere(ball, DVec3::new(-0.4, 0.301, 0.2), 0.3, 96, 48);
    b.wall(ring, DVec3::new(0.5, 0.001, 0.1), 0.35, 0.12, 0.0, 2.0 * PI, 256);
    b.panel(light, DVec3::new(0.3, 2.0, 0.6), DVec3::new(0.05, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.05));
    b.camera(DVec3::new(0.1, 1.3, 1.6), DVec3::new(0.0, 0.75, -1.0), 0.7);
    (b.build(), mirror)
}

/// Collection points of the camera mirrored at z = `plane`, at the pixels in which the original camera sees the mirror.
fn mirrored_view(world: &World<'_>, mirror: u32, plane: f64) -> Vec<Option<Collected>> {
    let params = &world.params;
    let shorter =
        caustics_kernels::interface::frame::FrameParams { max_bounces: params.max_bounces - 1, ..*params };
    let through = |v: DVec3| DVec3::new(v.x, v.y, -v.z);
    let eye = params.camera.position.as_dvec3();
    let mirrored_eye = through(eye) + 2.0 * plane * DVec3::Z;
    let (mut tracer, mut tally) = (world.tracer(), Tally::default());
    (0..params.pixel_count())
        .map(|pixel| {
            let mut rng = Rng::new(Stream::Camera, params.seed, pixel, params.frame);
            let ray = camera_ray(params, pixel, &mut rng);
            let hit = tracer.closest(&ray);
            if hit.is_miss() || world.scene.surfaces[hit.triangle as usize].material != mirror {
                return None;
            }
            // The mirrored path samples eight numbers less: those of the mirror's vertex.
            rng.next4();
            rng.next4();
            let direction = ray.direction.as_dvec3();
            let distance = (plane - eye.z) / direction.z;
            let mirrored = through(direction);
            let start = (mirrored_eye + distance * mirrored).as_vec3();
            let triangle = &world.scene.triangles[hit.triangle as usize];
            let clearance = offset::clearance(offset::magnitude(triangle.a, triangle.b, triangle.c));
            let origin = offset::leave(start, Vec3::Z, mirrored.as_vec3(), clearance);
            let cone = RayCone {
                width: params.pixel_spread * distance as f32,
                ..RayCone::at_eye(params.pixel_spread)
            };
            let ray = Ray::endless(origin, mirrored.as_vec3());
            Some(collected(
                CameraPathStart { ray, cone, rng },
                CameraSuffix::new(&shorter),
                &shorter,
                world.features,
                world.tables(),
                &mut tracer,
                &mut tally,
            ))
        })
        .collect()
}

fn relative(a: Vec3, b: Vec3) -> f32 {
    (a - b).length() / b.length().max(1e-20)
}

/// Pixels in the mirror whose paths agree to 1e-4, and their differences.
struct Views<'a> {
    pairs: Vec<(&'a Collected, &'a Collected)>,
    in_mirror: usize,
    parted: usize,
    /// Largest differences: position, radius, normal, throughput.
    worst: [f32; 4],
}

fn compare_views<'a>(seen: &'a [Collected], mirrored: &'a [Option<Collected>]) -> Views<'a> {
    let mut views = Views { pairs: Vec::new(), in_mirror: 0, parted: 0, worst: [0.0; 4] };
    for (a, b) in seen.iter().zip(mirrored).filter_map(|(a, b)| Some((a, b.as_ref()?))) {
        views.in_mirror += 1;
        let (g, h) = (&a.point.geometry, &b.point.geometry);
        let same_depth = if g.depth == 0 { h.depth == 0 } else { g.depth == h.depth + 1 && h.depth > 0 };
        let here = [
            relative(h.position, g.position),
            if g.depth == 0 { 0.0 } else { (h.radius / g.radius - 1.0).abs() },
            (h.normal - g.normal).length(),
            if g.depth == 0 { 0.0 } else { relative(b.point.shading.throughput, a.point.shading.throughput) },
        ];
        if !same_depth || here.iter().any(|&difference| difference > 1e-4) {
            views.parted += 1;
            continue;
        }
        (0..4).for_each(|i| views.worst[i] = views.worst[i].max(here[i]));
        views.pairs.push((a, b));
    }
    views
}

/// The comparison of O3 detects a mirror that is 1 mm off.
#[test]
fn detects_a_mirror_that_is_1_mm_off() {
    let (scene, mirror) = before_a_mirror();
    let world = World::new(&scene, &config(48, 32, 1));
    let (seen, off) = (world.collect(), mirrored_view(&world, mirror, -0.999));
    let views = compare_views(&seen, &off);
    assert!(views.parted * 10 > views.in_mirror * 9, "{} of {}", views.parted, views.in_mirror);
}

/// O3: the view in a perfect plane mirror is the view of the mirrored camera.
#[test]
fn view_in_a_perfect_mirror_equals_the_view_of_the_mirrored_camera() {
    let (scene, mirror) = before_a_mirror();
    let world = World::new(&scene, &config(96, 64, 40_000));
    let seen = world.collect();
    let mirrored = mirrored_view(&world, mirror, -1.0);
    let shorter = caustics_kernels::interface::frame::FrameParams {
        max_bounces: world.params.max_bounces - 1,
        ..world.params
    };

    // Keep the pixels that show the mirror, and of those the paths that take the same turns. In one path of hundreds an
    // ulp decides between reflection and refraction, or at an object's outline.
    let Views { pairs, in_mirror, parted, worst } = compare_views(&seen, &mirrored);
    let points = pairs.iter().filter(|(a, _)| a.point.geometry.depth > 0).count();
    let deep = pairs.iter().filter(|(a, _)| a.point.geometry.depth > 2).count();
    println!(
        "{in_mirror} pixels in the mirror, {points} points ({deep} of them behind glass or metal), {parted} parted; \
         largest differences: position {:e}, radius {:e}, normal {:e}, throughput {:e}",
        worst[0], worst[1], worst[2], worst[3]
    );
    assert!(in_mirror > 2000 && points > 1500 && deep > 100, "the test has nothing to check");
    assert!(parted * 500 <= in_mirror, "{parted} of {in_mirror} paths parted: more than 0.2 %");

    // Light without caustics is equal except for shadow rays that graze an edge.
    let differs = |(a, b): &&(&Collected, &Collected)| {
        (a.light.radiance - b.light.radiance).length() > 1e-3 * (a.light.radiance.length() + 1e-3)
    };
    let radiances = pairs.iter().filter(differs).count();
    println!("{radiances} pixels' path radiance differs by more than 1e-3");
    assert!(radiances * 200 <= in_mirror);

    // Gather the same light paths over both sets of points.
    let photons = world.shoot(&world.by_power());
    let split = |pick: &dyn Fn(&(&Collected, &Collected)) -> Collected| -> (Vec<_>, Vec<_>) {
        pairs.iter().map(|pair| (pick(pair).point.geometry, pick(pair).point.shading)).unzip()
    };
    let (near, near_shading) = split(&|pair| *pair.0);
    let (far, far_shading) = split(&|pair| *pair.1);
    let images: Vec<Vec<Vec3>> = [(&near, &near_shading, world.params), (&far, &far_shading, shorter)]
        .into_iter()
        .map(|(points, shadings, params)| {
            let materials = &scene.materials;
            let words = gather(&BRUTE, points, shadings, &photons, materials, world.features, &params);
            for variant in variant::ALL.iter().filter(|variant| !variant.hardware) {
                let found = gather(variant, points, shadings, &photons, materials, world.features, &params);
                assert!(words == found, "{} differs from brute", variant.name);
            }
            resolved(points, shadings, &words, &params)
        })
        .collect();

    // A photon that only one of the two takes lies at the bound of the disc, or of the test of normals.
    let (mut taken, mut only_one) = (0, 0);
    for (pixel, (g, h)) in near.iter().zip(&far).enumerate() {
        let (mut common, mut different) = (0, 0);
        for photon in &photons.geometry {
            let (one, other) =
                (takes(g, photon, world.params.max_bounces), takes(h, photon, shorter.max_bounces));
            common += u32::from(one && other);
            if one == other {
                continue;
            }
            different += 1;
            let along = photon.position - g.position;
            let normals = (g.normal + photon.normal).normalize();
            let slack = (h.position - g.position).length() + (h.radius - g.radius).abs() + 1e-5 * g.radius;
            let at_bound = (along.length() - g.radius).abs() <= slack
                || (along.dot(normals).abs() - 0.1 * g.radius).abs() <= slack
                || (g.normal.dot(photon.normal) - 0.9).abs() <= 1e-4;
            assert!(at_bound, "{g:?} {h:?} {photon:?}");
        }
        taken += common;
        only_one += different;
        if different == 0 {
            let (a, b) = (images[0][pixel], images[1][pixel]);
            assert!((a - b).length() <= 1e-3 * a.length(), "pixel {pixel}: {a} {b}");
        }
    }
    let (a, b) = (mean_of(&images[0]), mean_of(&images[1]));
    println!("{taken} photons taken by both, {only_one} by one; mean caustic {a:.6} and {b:.6}");
    assert!(taken > 2000, "the test has nothing to check: {taken}");
    assert!(only_one * 1000 <= taken, "{only_one} of {taken} differ");
    assert!((a / b - 1.0).abs() < 2e-3);
}
