//! Known answers: scenes whose light can be computed by hand.
//!
//! Statistical tolerances are three standard errors, estimated from independent frames or from the binomial law;
//! what is added to them is named.

use caustics::method::settings::Settings;
use caustics::scene::Scene;
use caustics_kernels::gather::accumulator::Sum;
use caustics_kernels::gather::brute::Brute;
use caustics_kernels::gather::contribution::takes;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use caustics_kernels::math::cone::RayCone;
use caustics_kernels::math::offset;
use caustics_kernels::math::ray::Ray;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::pass::collect::{Collected, camera_ray, follow};
use caustics_kernels::trace::Tracer;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

fn settings(width: u32, height: u32, light_paths: u32) -> Settings {
    Settings { width, height, light_paths, ..Settings::default() }
}

/// O2: a plane mirror makes a virtual light: E = rho I cos / d'^2. Direct light is in `path`, once.
#[test]
fn plane_mirror_makes_a_virtual_light() {
    let (rho, intensity, albedo) = (0.8, 5.0, 0.5);
    let mut b = Builder::default();
    let floor = b.material(lambert(albedo));
    let mirror = b.material(metal(rho, 0.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(mirror, DVec3::new(1.0, 1.01, 0.0), DVec3::Z, DVec3::Y);
    b.light(DVec3::new(0.0, 1.0, 0.0), intensity);
    b.camera(DVec3::new(-0.2, 3.0, 0.1), DVec3::new(-0.2, 0.0, 0.1), 0.4);
    let scene = b.build();
    let settings = settings(48, 32, 400_000);
    let points: Vec<_> = World::new(&scene, &settings).collect().iter().map(|c| c.geometry).collect();

    // Irradiance at every pixel's own point. The metal's reflectance is Schlick's at the mirror's cosine.
    let (light, image) = (DVec3::new(0.0, 1.0, 0.0), DVec3::new(2.0, 1.0, 0.0));
    let irradiance = |p: DVec3, from: DVec3| f64::from(intensity) * from.y / (from - p).length().powi(3);
    let (mut direct, mut mirrored) = (Vec::new(), 0.0);
    for point in &points {
        let p = point.position.as_dvec3();
        let cos = ((image - p).x / (image - p).length()).abs();
        let reflectance = f64::from(rho) + (1.0 - f64::from(rho)) * (1.0 - cos).powi(5);
        direct.push(irradiance(p, light) * f64::from(albedo) / PI);
        mirrored += reflectance * irradiance(p, image) / points.len() as f64;
    }
    let frames = render(&scene, &settings, "photons-grid", None, 0, 12);
    for (picture, _) in &frames {
        for (got, want) in picture.path.iter().zip(&direct) {
            assert!((f64::from(got.x) / want - 1.0).abs() < 1e-4, "direct light {} {want}", got.x);
        }
    }
    let measured: Vec<f64> =
        frames.iter().map(|(picture, _)| mean_of(&picture.caustics) * PI / f64::from(albedo)).collect();
    let (mean, error) = mean_and_error(&measured);
    println!("E = {mean:.5} +- {error:.5} W/m^2, expected {mirrored:.5}");
    assert!(error < 0.01 * mirrored, "the test has lost its sharpness");
    assert!((mean - mirrored).abs() < 3.0 * error);
}

/// A glass ball, a metal ring and a lamp before a perfect mirror in the plane z = -1.
fn before_a_mirror() -> (Scene, u32) {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.7));
    let mirror = b.material(metal(1.0, 0.0));
    let ball = b.material(glass(1.5));
    let ring = b.material(metal(0.9, 0.0));
    let lamp = b.material(emitter(200.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(floor, DVec3::new(0.0, 1.0, 2.9), -3.0 * DVec3::X, DVec3::Y);
    b.panel(mirror, DVec3::new(0.0, 0.9, -1.0), 1.5 * DVec3::X, 0.85 * DVec3::Y);
    b.sphere(ball, DVec3::new(-0.4, 0.301, 0.2), 0.3, 96, 48);
    b.wall(ring, DVec3::new(0.5, 0.001, 0.1), 0.35, 0.12, 0.0, 2.0 * PI, 256);
    b.panel(lamp, DVec3::new(0.3, 2.0, 0.6), DVec3::new(0.05, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.05));
    b.camera(DVec3::new(0.1, 1.3, 1.6), DVec3::new(0.0, 0.75, -1.0), 0.7);
    (b.build(), mirror)
}

/// What the camera mirrored at z = `plane` collects at the pixels in which the eye sees the mirror.
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
            // The mirrored path draws eight numbers less: those of the mirror's vertex.
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
            Some(follow(ray, cone, rng, &shorter, world.needs, world.tables(), &mut tracer, &mut tally))
        })
        .collect()
}

fn relative(a: Vec3, b: Vec3) -> f32 {
    (a - b).length() / b.length().max(1e-20)
}

/// Pixels in the mirror: those whose paths agree to 1e-4, and how far they do.
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
        let (g, h) = (&a.geometry, &b.geometry);
        let same_depth = if g.depth == 0 { h.depth == 0 } else { g.depth == h.depth + 1 && h.depth > 0 };
        let here = [
            relative(h.position, g.position),
            if g.depth == 0 { 0.0 } else { (h.radius / g.radius - 1.0).abs() },
            (h.normal - g.normal).length(),
            if g.depth == 0 { 0.0 } else { relative(b.shading.throughput, a.shading.throughput) },
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

/// The comparison of O3 sees a mirror that is 1 mm off.
#[test]
fn a_mirror_that_is_a_millimetre_off_is_detected() {
    let (scene, mirror) = before_a_mirror();
    let world = World::new(&scene, &settings(48, 32, 1));
    let (seen, off) = (world.collect(), mirrored_view(&world, mirror, -0.999));
    let views = compare_views(&seen, &off);
    assert!(views.parted * 10 > views.in_mirror * 9, "{} of {}", views.parted, views.in_mirror);
}

/// O3, the mission's own test: a view through a perfect plane mirror is the view of the mirrored camera.
#[test]
fn view_through_a_perfect_mirror_is_the_mirrored_cameras() {
    let (scene, mirror) = before_a_mirror();
    let world = World::new(&scene, &settings(96, 64, 40_000));
    let seen = world.collect();
    let mirrored = mirrored_view(&world, mirror, -1.0);
    let shorter = caustics_kernels::interface::frame::FrameParams {
        max_bounces: world.params.max_bounces - 1,
        ..world.params
    };

    // Keep the pixels that show the mirror, and of those the paths that take the same turns: an ulp decides
    // between reflection and refraction, or at an object's outline, in one path of hundreds.
    let Views { pairs, in_mirror, parted, worst } = compare_views(&seen, &mirrored);
    let points = pairs.iter().filter(|(a, _)| a.geometry.depth > 0).count();
    let deep = pairs.iter().filter(|(a, _)| a.geometry.depth > 2).count();
    println!(
        "{in_mirror} pixels in the mirror, {points} points ({deep} of them behind glass or metal), {parted} parted; \
         largest differences: position {:e}, radius {:e}, normal {:e}, throughput {:e}",
        worst[0], worst[1], worst[2], worst[3]
    );
    assert!(in_mirror > 2000 && points > 1500 && deep > 100, "the test has lost its subject");
    assert!(parted * 500 <= in_mirror, "{parted} of {in_mirror} paths parted: more than 0.2 %");

    // Non-caustic light: the same but for shadow rays that graze an edge.
    let differs = |(a, b): &&(&Collected, &Collected)| {
        (a.radiance - b.radiance).length() > 1e-3 * (a.radiance.length() + 1e-3)
    };
    let radiances = pairs.iter().filter(differs).count();
    println!("{radiances} pixels' path radiance differs by more than 1e-3");
    assert!(radiances * 200 <= in_mirror);

    // The same light paths, gathered over both sets of points.
    let deposits = world.shoot(&world.by_power());
    let split = |pick: &dyn Fn(&(&Collected, &Collected)) -> Collected| -> (Vec<_>, Vec<_>) {
        pairs.iter().map(|pair| (pick(pair).geometry, pick(pair).shading)).unzip()
    };
    let (near, near_shading) = split(&|pair| *pair.0);
    let (far, far_shading) = split(&|pair| *pair.1);
    let images: Vec<Vec<Vec3>> = [(&near, &near_shading, world.params), (&far, &far_shading, shorter)]
        .into_iter()
        .map(|(points, shadings, params)| {
            let materials = &scene.materials;
            let brute = Brute { count: deposits.len() };
            let words = gather(points, shadings, &deposits, brute, materials, world.needs, &params);
            let grid = Grid::build(points, &deposits, &params);
            let (sorted, neighbours) = (&grid.sorted, grid.neighbours());
            let found = gather(points, shadings, sorted, neighbours, materials, world.needs, &params);
            assert!(words == found, "photons-grid differs from brute");
            resolved(points, shadings, &words, &params)
        })
        .collect();

    // A deposit that only one of the two takes lies at the bound of the disc, or of what its normal may be.
    let (mut taken, mut only_one) = (0, 0);
    for (pixel, (g, h)) in near.iter().zip(&far).enumerate() {
        let (mut common, mut different) = (0, 0);
        for deposit in &deposits.geometry {
            let (one, other) =
                (takes(g, deposit, world.params.max_bounces), takes(h, deposit, shorter.max_bounces));
            common += u32::from(one && other);
            if one == other {
                continue;
            }
            different += 1;
            let along = deposit.position - g.position;
            let normals = (g.normal + deposit.normal).normalize();
            let slack = (h.position - g.position).length() + (h.radius - g.radius).abs() + 1e-5 * g.radius;
            let at_bound = (along.length() - g.radius).abs() <= slack
                || (along.dot(normals).abs() - 0.1 * g.radius).abs() <= slack
                || (g.normal.dot(deposit.normal) - 0.9).abs() <= 1e-4;
            assert!(at_bound, "{g:?} {h:?} {deposit:?}");
        }
        taken += common;
        only_one += different;
        if different == 0 {
            let (a, b) = (images[0][pixel], images[1][pixel]);
            assert!((a - b).length() <= 1e-3 * a.length(), "pixel {pixel}: {a} {b}");
        }
    }
    let (a, b) = (mean_of(&images[0]), mean_of(&images[1]));
    println!("{taken} deposits taken by both, {only_one} by one; mean caustic {a:.6} and {b:.6}");
    assert!(taken > 2000, "the test has lost its subject: {taken}");
    assert!(only_one * 1000 <= taken, "{only_one} of {taken} differ");
    assert!((a / b - 1.0).abs() < 2e-3);
}

/// A floor 2 m below the origin that hardly reflects, seen by a camera 3 m above.
fn above_a_floor() -> Builder {
    let mut b = Builder::default();
    // Dark enough that what it reflects does not come back (1e-6), bright enough to take deposits.
    let floor = b.material(lambert(1e-6));
    b.panel(floor, DVec3::new(0.0, -2.0, 0.0), 8.0 * DVec3::Z, 8.0 * DVec3::X);
    b.camera(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO, 0.002);
    b
}

/// Share of a beam straight down that reaches the floor through `filter` scatterings, and its standard error.
fn transmitted(scene: &Scene, paths: u32, max_bounces: u32, filter: impl Fn(u32) -> bool) -> (f64, f64) {
    let world = World::new(scene, &Settings { max_bounces, ..settings(8, 8, paths) });
    let beam = Beam {
        centre: Vec3::new(0.01, 2.0, 0.02),
        direction: Vec3::NEG_Y,
        axes: [0.5 * Vec3::X, 0.5 * Vec3::Z],
        round: false,
        irradiance: 1.0,
    };
    let deposits = world.shoot(&beam);
    let on_floor = |g: &DepositGeometry| g.position.y < -1.99 && filter(g.scatterings);
    let flux: f64 = deposits.flux().filter(|(g, _)| on_floor(g)).map(|(_, flux)| flux).sum();
    let share = flux / beam.area();
    (share, (share * (1.0 - share) / f64::from(paths)).sqrt())
}

/// Radiance of an emitter of radiance 1 seen straight through a scene: mean over 4 frames of 256 x 256 pixels, and
/// its standard error from the pixels (each an independent path of the same expectation).
fn radiance_through(mut builder: Builder, max_bounces: u32) -> [(f64, f64); 3] {
    let lamp = builder.material(emitter(1.0));
    builder.panel(lamp, DVec3::new(0.0, -1.5, 0.0), 2.0 * DVec3::Z, 2.0 * DVec3::X);
    let scene = builder.build();
    let settings = Settings { max_bounces, ..settings(256, 256, 1) };
    let frames = render(&scene, &settings, "photons-grid", None, 0, 4);
    [0, 1, 2].map(|channel| {
        let values: Vec<f64> =
            frames.iter().flat_map(|(p, _)| &p.path).map(|v| f64::from(v[channel])).collect();
        mean_and_error(&values)
    })
}

fn near(what: &str, (value, error): (f64, f64), expected: f64, slack: f64) {
    println!("{what}: {value:.6} +- {error:.6}, expected {expected:.6}");
    assert!((value - expected).abs() < 3.0 * error + slack, "{what}: {value} +- {error} {expected}");
}

/// O4: a thin wall of index 1.5 transmits T = (1-r)/(1+r), as flux and as radiance.
#[test]
fn thin_wall_transmits_what_a_slab_does() {
    let build = || {
        let mut b = above_a_floor();
        let thin = b.material(pane(1.5));
        b.panel(thin, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
        b
    };
    let expected = 0.96 / 1.04;
    near("thin wall, flux", transmitted(&build().build(), 1_000_000, 5, |_| true), expected, 1e-5);
    near("thin wall, radiance", radiance_through(build(), 5)[0], expected, 1e-5);
}

fn slab(absorption: Vec3, thickness: f64) -> Builder {
    let mut b = above_a_floor();
    let solid = b.material(Material { absorption, ..glass(1.5) });
    b.block(solid, DVec3::new(-3.0, -0.5 * thickness, -3.0), DVec3::new(3.0, 0.5 * thickness, 3.0), false);
    b
}

/// O4: a slab with a volume and all bounces transmits the same. 30 bounces leave out 0.04^28.
#[test]
fn slab_with_all_bounces_transmits_what_a_thin_wall_does() {
    let expected = 0.96 / 1.04;
    let scene = slab(Vec3::ZERO, 0.5).build();
    near("slab, flux", transmitted(&scene, 1_000_000, 30, |_| true), expected, 1e-5);
    near("slab, radiance", radiance_through(slab(Vec3::ZERO, 0.5), 30)[0], expected, 1e-5);
    let single = transmitted(&scene, 1_000_000, 30, |k| k == 2);
    near("slab, flux without inner reflections", single, 0.96 * 0.96, 1e-5);
}

/// Light and radiance are absorbed by exp(-sigma t) at every crossing of a slab: with r the reflectance and a the
/// absorption of one crossing, T = (1-r)^2 a / (1 - r^2 a^2).
#[test]
fn slab_absorbs_by_beer() {
    let sigma = Vec3::new(0.5, 1.0, 2.0);
    let through = |sigma: f32| {
        let a = (-f64::from(sigma) * 0.5).exp();
        0.96 * 0.96 * a / (1.0 - 0.0016 * a * a)
    };
    let measured = radiance_through(slab(sigma, 0.5), 30);
    for channel in 0..3 {
        let name = format!("absorbing slab, radiance, sigma {}", sigma[channel]);
        near(&name, measured[channel], through(sigma[channel]), 1e-5);
    }
    let scene = slab(sigma, 0.5).build();
    near("absorbing slab, flux, sigma 0.5", transmitted(&scene, 1_000_000, 30, |_| true), through(0.5), 1e-5);
}

/// Glass in water: the inner faces reflect by the relative index (1.5 / 1.33), four faces in a row.
#[test]
fn glass_in_water_reflects_by_the_relative_index() {
    let build = || {
        let mut b = above_a_floor();
        let water = b.material(glass(1.33));
        let ice = b.material(glass(1.5));
        b.block(water, DVec3::new(-3.0, -1.0, -3.0), DVec3::new(3.0, 1.0, 3.0), false);
        b.block(ice, DVec3::new(-2.0, -0.4, -2.0), DVec3::new(2.0, 0.4, 2.0), false);
        b
    };
    let passes = |ratio: f64| 1.0 - ((ratio - 1.0) / (ratio + 1.0)).powi(2);
    let expected = passes(1.33).powi(2) * passes(1.5 / 1.33).powi(2);
    near("glass in water, flux", transmitted(&build().build(), 1_000_000, 12, |k| k == 4), expected, 1e-5);
    // Four bounces leave the straight path only.
    near("glass in water, radiance", radiance_through(build(), 4)[0], expected, 1e-5);
}

/// O5: impact parameter, angles inside, transmittance of one face of a sphere of index 1.5.
fn sphere_ray(b: f64) -> (f64, f64, f64) {
    let (i, t) = (b.asin(), (b / 1.5).asin());
    let s = ((i.cos() - 1.5 * t.cos()) / (i.cos() + 1.5 * t.cos())).powi(2);
    let p = ((1.5 * i.cos() - t.cos()) / (1.5 * i.cos() + t.cos())).powi(2);
    (i, t, 1.0 - 0.5 * (s + p))
}

/// O5: a glass sphere passes 0.8355 of parallel light by two refractions, and where it should. The beam is exactly
/// parallel; 1e-3 is for 512 x 256 facets (their outline, and shading normals that face away at the rim).
#[test]
fn glass_sphere_transmits_and_focuses_parallel_light() {
    let mut b = Builder::default();
    let wall = b.material(lambert(1e-6));
    let ball = b.material(glass(1.5));
    let floor = 1.2;
    b.block(wall, DVec3::new(-9.0, -floor, -9.0), DVec3::new(9.0, 9.0, 9.0), true);
    b.sphere(ball, DVec3::ZERO, 1.0, 512, 256);
    b.camera(DVec3::new(0.0, 8.0, 0.0), DVec3::ZERO, 0.5);
    let scene = b.build();
    let paths = 1_000_000;
    let world = World::new(&scene, &Settings { max_bounces: 40, ..settings(8, 8, paths) });
    let beam = Beam {
        centre: Vec3::new(0.0, 3.0, 0.0),
        direction: Vec3::NEG_Y,
        axes: [Vec3::X, Vec3::Z],
        round: true,
        irradiance: 1.0,
    };
    let deposits = world.shoot(&beam);
    let share = |keep: &dyn Fn(Vec3) -> bool| {
        let inside = deposits.flux().filter(|(g, _)| g.scatterings == 2 && keep(g.position));
        let share = inside.map(|(_, flux)| flux).sum::<f64>() / PI;
        (share, (share * (1.0 - share) / f64::from(paths)).sqrt())
    };
    near("glass sphere, two refractions", share(&|_| true), 0.8355, 1e-3);
    let all: f64 = deposits.flux().map(|(_, flux)| flux).sum::<f64>() / PI;
    near("glass sphere, all that arrives anywhere", (all, 0.0), 1.0, 1e-3);

    // Within circles on the floor 1.2 R below the centre, in front of the focus at 1.5 R.
    for radius in [0.05, 0.1, 0.2, 0.3] {
        let steps = 200_000;
        let ring = |step: i32| {
            let b = (f64::from(step) + 0.5) / f64::from(steps);
            let (i, t, passes) = sphere_ray(b);
            let rho = (2.0 * t - i).sin() - (floor - (2.0 * t - i).cos()) * (2.0 * (i - t)).tan();
            let reaches = 2.0 * (i - t) < 0.5 * PI && rho.abs() <= radius;
            if reaches { passes * passes * 2.0 * b / f64::from(steps) } else { 0.0 }
        };
        let expected: f64 = (0..steps).map(ring).sum();
        let inside = |p: Vec3| {
            let p = p.as_dvec3();
            p.y < -floor + 1e-3 && p.x.hypot(p.z) <= radius
        };
        near(&format!("glass sphere, within {radius} R"), share(&inside), expected, 1e-3);
    }
}

/// O7 by the kernels' own gather and resolve: points in the plane z = 0 over deposits of density `flux(x, y)` per
/// area in [-1, 1]^2, arriving straight. Mean of pi L / albedo over the points and its standard error.
fn estimated(radius: f32, at: impl Fn(u32) -> (f32, f32), flux: impl Fn(f32, f32) -> f32) -> (f64, f64) {
    let (albedo, count, batches) = (0.5, 40_000_u32, 12);
    let materials = [lambert(albedo)];
    let settings = settings(20, 20, 1);
    let mut b = above_a_floor();
    b.light(DVec3::Y, 1.0);
    let scene = b.build();
    let mut params = World::new(&scene, &settings).params;
    params.cell_mask = (1 << 16) - 1;
    (params.quantum, params.inverse_quantum) = (2.0_f32.powi(-40), 2.0_f32.powi(40));
    let points: Vec<_> = (0..400)
        .map(|id| {
            let (x, y) = at(id);
            PointGeometry { position: Vec3::new(x, y, 0.0), radius, normal: Vec3::Z, depth: 1 }
        })
        .collect();
    let shading = PointShading {
        to_viewer: Vec3::new(0.6, 0.0, 0.8),
        shading_normal: Vec3::Z,
        throughput: Vec3::ONE,
        ..PointShading::default()
    };
    let shadings = vec![shading; points.len()];
    let values: Vec<f64> = (0..batches)
        .map(|batch| {
            let mut deposits = Deposits::default();
            for path in 0..count {
                let u = Rng::new(Stream::Light, 3, path, batch).next4();
                let (x, y) = (2.0 * u.x - 1.0, 2.0 * u.y - 1.0);
                let geometry = DepositGeometry {
                    position: Vec3::new(x, y, 0.0),
                    scatterings: 1,
                    normal: Vec3::Z,
                    padding: 0,
                };
                let flux = Vec3::splat(flux(x, y) * 4.0 / count as f32);
                deposits.push(geometry, DepositLight { to_light: Vec3::Z, flux, ..DepositLight::default() });
            }
            let grid = Grid::build(&points, &deposits, &params);
            let (sorted, neighbours) = (&grid.sorted, grid.neighbours());
            let words = gather(&points, &shadings, sorted, neighbours, &materials, Needs::RECEIVERS, &params);
            assert!(words.iter().any(|&word| word != 0));
            mean_of(&resolved(&points, &shadings, &words, &params)) * PI / f64::from(albedo)
        })
        .collect();
    mean_and_error(&values)
}

/// O7: uniform light is exact, x^2 is off by r^2 / 4, an edge gives a half and a corner a quarter.
#[test]
fn disc_estimates_as_its_bias_says() {
    let scattered = |id: u32| {
        let u = Rng::new(Stream::Camera, 9, id, 0).next4();
        (1.4 * u.x - 0.7, 1.4 * u.y - 0.7)
    };
    near("uniform", estimated(0.1, scattered, |_, _| 2.0), 2.0, 1e-5);
    let along_x = |id: u32| (0.0, 1.4 * Rng::new(Stream::Camera, 9, id, 0).next4().y - 0.7);
    near("x^2 at 0, r = 0.2", estimated(0.2, along_x, |x, _| 3.0 * x * x), 0.03, 1e-6);
    near("straight edge", estimated(0.1, along_x, |x, _| f32::from(u8::from(x < 0.0))), 0.5, 1e-5);
    let corner = |x: f32, y: f32| f32::from(u8::from(x < 0.0 && y < 0.0));
    near("corner", estimated(0.2, |_| (0.0, 0.0), corner), 0.25, 1e-5);
}

/// Irradiance over truth on a cylinder of radius 1 with `facets` under smooth normals, by discs of 0.05; mean over
/// points anywhere on it and its standard error (from batches of deposits).
fn on_facets(facets: u32) -> (f64, f64) {
    let place = |around: f64, y: f64| {
        let step = 2.0 * PI / f64::from(facets);
        let left = (around * f64::from(facets)).floor() * step;
        let at = |angle: f64| DVec3::new(angle.cos(), 0.0, angle.sin());
        let (a, b) = (at(left), at(left + step));
        let share = (around * f64::from(facets)).fract();
        let position = a.lerp(b, share) + y * DVec3::Y;
        (position.as_vec3(), a.lerp(b, share).normalize().as_vec3())
    };
    let area = f64::from(facets) * 2.0 * (PI / f64::from(facets)).sin();
    let points: Vec<_> = (0..200)
        .map(|id| {
            let u = Rng::new(Stream::Camera, 11, id, facets).next4();
            let (position, normal) = place(f64::from(u.x), 0.6 * f64::from(u.z) - 0.3);
            PointGeometry { position, radius: 0.05, normal, depth: 1 }
        })
        .collect();
    let count = 30_000;
    let batches: Vec<f64> = (0..12)
        .map(|batch| {
            // An even lattice (the plastic number's), shifted at random: each batch is unbiased, and sharp.
            let shift = Rng::new(Stream::Light, 12, 0, batch).next4();
            let mut taken = 0_u32;
            for path in 0..count {
                let around = (f64::from(shift.x) + f64::from(path) * 0.754_877_666_246_692_8).fract();
                let y = (f64::from(shift.y) + f64::from(path) * 0.569_840_290_998_053_3).fract();
                let (position, normal) = place(around, y - 0.5);
                let deposit = DepositGeometry { position, scatterings: 1, normal, padding: 0 };
                taken += points.iter().map(|point| u32::from(takes(point, &deposit, 5))).sum::<u32>();
            }
            f64::from(taken) / 200.0 / f64::from(count) * area / (PI * 0.05 * 0.05)
        })
        .collect();
    mean_and_error(&batches)
}

/// The test of the disc loses nothing on smooth normals over facets up to 11 degrees apart; coarser ones are printed.
#[test]
fn disc_loses_nothing_on_smooth_normals_over_facets() {
    for facets in [128, 64, 32] {
        near(&format!("{facets} facets"), on_facets(facets), 1.0, 2e-3);
    }
    for facets in [24, 16, 12] {
        let (share, error) = on_facets(facets);
        println!("{facets} facets: {share:.4} +- {error:.4} of the light is found");
    }
}

/// No caster: the caustic layer is exactly zero and no light path is shot, whatever the needs.
#[test]
fn plain_room_has_no_caustic_and_shoots_no_light_path() {
    let scene = committed("plain-room");
    for needs in [None, Some(Needs::ALL)] {
        let (picture, counters) =
            render(&scene, &settings(96, 54, 100_000), "photons-grid", needs, 0, 1).remove(0);
        assert!(picture.caustics.iter().all(|&value| value == Vec3::ZERO));
        assert!(picture.deposits.iter().all(|&count| count == 0.0));
        for counter in [Counter::LightPaths, Counter::LightRays, Counter::Deposits, Counter::Gathered] {
            assert_eq!(counters.get(counter), 0, "{counter:?}");
        }
        assert!(mean_of(&picture.path) > 0.0);
    }
}

/// A closed room whose walls emit 1 and reflect a half holds radiance sum 0.5^k = 2 everywhere; lossless things in
/// it are invisible. 1e-3 is for paths that glass makes longer than 20 bounces and for discs cut by the room's edges.
#[test]
fn lossless_things_in_a_uniform_room_are_invisible() {
    let mut b = Builder::default();
    let wall = b.material(Material { emission: Vec3::ONE, ..lambert(0.5) });
    let ball = b.material(glass(1.5));
    let mirror = b.material(metal(1.0, 0.0));
    let thin = b.material(pane(1.5));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, DVec3::new(-0.4, -0.3, 0.0), 0.35, 128, 64);
    b.sphere(mirror, DVec3::new(0.4, -0.3, -0.3), 0.3, 64, 32);
    b.panel(thin, DVec3::new(0.3, 0.5, 0.2), 0.3 * DVec3::X, DVec3::new(0.0, 0.2, 0.2));
    b.camera(DVec3::new(0.0, 0.1, 0.95), DVec3::new(0.0, -0.1, 0.0), 1.0);
    let scene = b.build();
    let settings = Settings { max_bounces: 20, radius_px: 0.3, ..settings(64, 48, 100_000) };
    let frames = render(&scene, &settings, "photons-grid", None, 0, 10);
    let sums: Vec<f64> = frames.iter().map(|(p, _)| mean_of(&p.path) + mean_of(&p.caustics)).collect();
    let caustics: Vec<f64> = frames.iter().map(|(p, _)| mean_of(&p.caustics)).collect();
    println!("caustic part {:.4}", mean_and_error(&caustics).0);
    assert!(mean_and_error(&caustics).0 > 0.05, "the test has lost its subject");
    near("uniform room", mean_and_error(&sums), 2.0, 2e-3);
}

/// The same with black walls: every pixel shows exactly 1, through glass and mirrors, but for paths that end at the
/// length limit or at a facet's wrong side.
#[test]
fn glass_in_a_black_glowing_room_shows_its_radiance_in_every_pixel() {
    let mut b = Builder::default();
    let wall = b.material(emitter(1.0));
    let ball = b.material(Material { absorption: Vec3::ZERO, ..glass(1.5) });
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, DVec3::ZERO, 0.5, 128, 64);
    b.camera(DVec3::new(0.0, 0.0, 0.95), DVec3::ZERO, 1.0);
    let scene = b.build();
    let settings = Settings { max_bounces: 40, ..settings(128, 96, 1) };
    let (picture, _) = render(&scene, &settings, "photons-grid", None, 0, 1).remove(0);
    let total = picture.path.len() as f64;
    let off = picture.path.iter().filter(|v| (v.x - 1.0).abs() > 1e-4).count() as f64 / total;
    println!("mean {:.6}, pixels off by more than 1e-4: {:.5}", mean_of(&picture.path), off);
    assert!(picture.path.iter().all(|v| v.x < 1.0 + 1e-4));
    assert!((mean_of(&picture.path) - 1.0).abs() < 2e-3);
}

/// The disc of a point seen directly has the area of its pixel's real footprint, from rays through the pixel's
/// corners; 3 % for the spread that is one for all pixels and for footprints that are no parallelograms.
#[test]
fn disc_has_the_area_of_the_pixels_footprint() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    b.panel(floor, DVec3::ZERO, 9.0 * DVec3::Z, 9.0 * DVec3::X);
    b.light(DVec3::new(0.0, 2.0, 0.0), 1.0);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.15);
    let scene = b.build();
    let world = World::new(&scene, &settings(36, 24, 1));
    let camera = &world.params.camera;
    let on_floor = |x: f64, y: f64| {
        let along_x = camera.right.as_dvec3() * (2.0 * x / 36.0 - 1.0);
        let along_y = camera.up.as_dvec3() * (1.0 - 2.0 * y / 24.0);
        let direction = camera.forward.as_dvec3() + along_x + along_y;
        camera.position.as_dvec3() - direction * f64::from(camera.position.y) / direction.y
    };
    for (pixel, collected) in world.collect().iter().enumerate() {
        let (x, y) = ((pixel % 36) as f64, (pixel / 36) as f64);
        let diagonals =
            (on_floor(x + 1.0, y + 1.0) - on_floor(x, y)).cross(on_floor(x, y + 1.0) - on_floor(x + 1.0, y));
        let footprint = 0.5 * diagonals.length();
        let disc = PI * f64::from(collected.geometry.radius).powi(2);
        assert!((disc / footprint - 1.0).abs() < 0.03, "pixel {pixel}: {disc:e} {footprint:e}");
    }
}

/// Seen in a convex sphere mirror, the cone is as wide in the plane of incidence as neighbouring rays part, to 10 %
/// up to 60 degrees (facets of 256 x 128 and their interpolated normals).
#[test]
fn cone_behind_a_convex_mirror_is_as_wide_as_neighbouring_rays_part() {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.5));
    let ball = b.material(metal(1.0, 0.0));
    b.block(wall, DVec3::splat(-8.0), DVec3::splat(8.0), true);
    b.sphere(ball, DVec3::ZERO, 1.0, 256, 128);
    b.light(DVec3::new(0.0, 6.0, 0.0), 1.0);
    b.camera(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 0.4);
    let scene = b.build();
    let world = World::new(&scene, &settings(8, 8, 1));
    let spread = 1e-4_f64;

    // A ray from the eye towards the sphere's point at `phi` in the plane y = x / 3, its mirror image, and the wall.
    let eye = DVec3::new(0.0, 0.0, 5.0);
    let across = DVec3::new(3.0, 1.0, 0.0).normalize();
    let turned = |angle: f64| -DVec3::Z * angle.cos() + across * angle.sin();
    let mirrored = |angle: f64| {
        let direction = turned(angle);
        let half = eye.dot(direction);
        let distance = -half - (half * half - eye.length_squared() + 1.0).sqrt();
        let hit = eye + distance * direction;
        (hit, direction - 2.0 * direction.dot(hit) * hit, -direction.dot(hit))
    };
    let (mut tracer, mut tally) = (world.tracer(), Tally::default());
    let mut worst = 0.0_f64;
    for step in 1..=24 {
        let angle = 0.1705 * f64::from(step) / 24.0;
        let (hit, direction, cos) = mirrored(angle);
        if cos < 0.5 {
            break;
        }
        let ray = Ray::endless(eye.as_vec3(), turned(angle).as_vec3());
        let rng = Rng::new(Stream::Camera, 0, step as u32, 0);
        let cone = RayCone::at_eye(spread as f32);
        let collected =
            follow(ray, cone, rng, &world.params, world.needs, world.tables(), &mut tracer, &mut tally);
        let point = collected.geometry;
        assert_eq!(point.depth, 2);
        let receiving = f64::from(collected.shading.to_viewer.dot(point.normal));
        let width = f64::from(point.radius) * (PI * receiving).sqrt();

        // Finite difference at the same distance behind the mirror.
        let distance = (point.position.as_dvec3() - hit).length();
        let (hit_2, direction_2, _) = mirrored(angle + 1e-6);
        let parted = (hit_2 + distance * direction_2) - (hit + distance * direction);
        let parted = (parted - direction * parted.dot(direction)).length() / 1e-6 * spread;
        worst = worst.max((width / parted - 1.0).abs());
        println!("incidence {:.1} degrees: width {:.5} {:.5}", cos.acos().to_degrees(), width, parted);
        assert!((width / parted - 1.0).abs() < 0.1);
    }
    println!("largest difference {worst:.4}");
}

/// Unused words of the accumulator stay zero where no point is.
#[test]
fn pixels_without_a_point_take_nothing() {
    let points = vec![PointGeometry::default(); 4];
    let shadings = vec![PointShading::default(); 4];
    let mut deposits = Deposits::default();
    deposits.push(DepositGeometry::default(), DepositLight::default());
    let scene = above_a_floor().build();
    let world = World::new(&scene, &settings(2, 2, 1));
    let brute = Brute { count: 1 };
    let words = gather(&points, &shadings, &deposits, brute, &scene.materials, world.needs, &world.params);
    assert!(words.iter().all(|&word| word == 0));
    assert_eq!(Sum::read(&words, 3, 1.0), (Vec3::ZERO, 0));
}
