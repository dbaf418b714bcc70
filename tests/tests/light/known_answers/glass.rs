//! Glass: thin walls, slabs, nested media, and a sphere in parallel light.

use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics_kernels::interface::choice::ThinWalls;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::point::PhotonGeometry;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

use super::{above_a_floor, config, near};

/// Share of a beam straight down that reaches the floor by a number of scatterings that `filter` accepts, and its
/// standard error. Thin walls are events, so that photons behind them are stored.
pub fn transmitted(scene: &Scene, paths: u32, max_bounces: u32, filter: impl Fn(u32) -> bool) -> (f64, f64) {
    let thin_walls = ThinWalls::Event;
    let world = World::new(scene, &RenderConfig { max_bounces, thin_walls, ..config(8, 8, paths) });
    let beam = Beam {
        centre: Vec3::new(0.01, 2.0, 0.02),
        direction: Vec3::NEG_Y,
        axes: [0.5 * Vec3::X, 0.5 * Vec3::Z],
        round: false,
        irradiance: 1.0,
    };
    let photons = world.shoot(&beam);
    let on_floor = |g: &PhotonGeometry| g.position.y < -1.99 && filter(g.scatterings);
    let flux: f64 = photons.flux().filter(|(g, _)| on_floor(g)).map(|(_, flux)| flux).sum();
    let share = flux / beam.area();
    (share, (share * (1.0 - share) / f64::from(paths)).sqrt())
}

/// Radiance of an emitter of radiance 1 seen straight through a scene: mean over frames of 256 x 256 pixels. Its
/// standard error comes from the pixels; each is an independent path of the same expectation.
pub fn radiance_through(mut builder: Builder, max_bounces: u32, frames: u32) -> [(f64, f64); 3] {
    let light = builder.material(emitter(1.0));
    builder.panel(light, DVec3::new(0.0, -1.5, 0.0), 2.0 * DVec3::Z, 2.0 * DVec3::X);
    let scene = builder.build();
    let config = RenderConfig { max_bounces, ..config(256, 256, 1) };
    let frames = render(&scene, &config, "photons-grid", None, 0, frames);
    [0, 1, 2].map(|channel| {
        let values: Vec<f64> =
            frames.iter().flat_map(|(p, _)| &p.path).map(|v| f64::from(v[channel])).collect();
        mean_and_error(&values)
    })
}

/// O4: a thin wall of index 1.5 transmits T = (1-r)/(1+r), as flux and as radiance.
#[test]
fn thin_wall_transmits_as_much_as_a_slab() {
    let build = || {
        let mut b = above_a_floor();
        let thin = b.material(pane(1.5));
        b.panel(thin, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
        b
    };
    let expected = 0.96 / 1.04;
    near("thin wall, flux", transmitted(&build().build(), 1_000_000, 5, |_| true), expected, 1e-5);
    near("thin wall, radiance", radiance_through(build(), 5, 4)[0], expected, 1e-5);
}

fn slab(absorption: Vec3, thickness: f64) -> Builder {
    let mut b = above_a_floor();
    let solid = b.material(Material { absorption, ..glass(1.5) });
    b.block(solid, DVec3::new(-3.0, -0.5 * thickness, -3.0), DVec3::new(3.0, 0.5 * thickness, 3.0), false);
    b
}

/// O4: a slab with a volume and all bounces transmits as much. 30 bounces leave out 0.04^28.
#[test]
fn slab_with_all_bounces_transmits_as_much_as_a_thin_wall() {
    let expected = 0.96 / 1.04;
    let scene = slab(Vec3::ZERO, 0.5).build();
    near("slab, flux", transmitted(&scene, 1_000_000, 30, |_| true), expected, 1e-5);
    near("slab, radiance", radiance_through(slab(Vec3::ZERO, 0.5), 30, 4)[0], expected, 1e-5);
    let single = transmitted(&scene, 1_000_000, 30, |k| k == 2);
    near("slab, flux without inner reflections", single, 0.96 * 0.96, 1e-5);
}

/// Light and radiance are absorbed by exp(-sigma t) at every crossing of a slab. With the reflectance r and the
/// absorption a of one crossing, T = (1-r)^2 a / (1 - r^2 a^2).
#[test]
fn slab_absorbs_by_beers_law() {
    let sigma = Vec3::new(0.5, 1.0, 2.0);
    let through = |sigma: f32| {
        let a = (-f64::from(sigma) * 0.5).exp();
        0.96 * 0.96 * a / (1.0 - 0.0016 * a * a)
    };
    let measured = radiance_through(slab(sigma, 0.5), 30, 4);
    for channel in 0..3 {
        let name = format!("absorbing slab, radiance, sigma {}", sigma[channel]);
        near(&name, measured[channel], through(sigma[channel]), 1e-5);
    }
    let scene = slab(sigma, 0.5).build();
    near("absorbing slab, flux, sigma 0.5", transmitted(&scene, 1_000_000, 30, |_| true), through(0.5), 1e-5);
}

/// A point light inside of an absorbing block lights a floor in it: direct light is absorbed too. Only paths that enter
/// by refraction see the floor, and both scenes sample the same ones.
#[test]
fn direct_light_inside_a_medium_is_absorbed() {
    let seen = |sigma: f32| {
        let mut b = Builder::default();
        let floor = b.material(lambert(0.5));
        let solid = b.material(Material { absorption: Vec3::splat(sigma), ..glass(1.5) });
        b.block(solid, DVec3::new(-2.0, -0.5, -2.0), DVec3::new(2.0, 1.0, 2.0), false);
        b.panel(floor, DVec3::ZERO, 1.5 * DVec3::Z, 1.5 * DVec3::X);
        b.light(DVec3::new(0.0, 0.5, 0.0), 1.0);
        b.camera(DVec3::new(0.0, 4.0, 0.0), DVec3::ZERO, 0.004);
        let scene = b.build();
        let config = RenderConfig { max_bounces: 2, ..config(16, 16, 1) };
        let radiance: f64 =
            World::new(&scene, &config).collect().iter().map(|c| f64::from(c.light.radiance.x)).sum();
        radiance / 256.0
    };
    let (clear, absorbing) = (seen(0.0), seen(2.0));
    // 0.96 of the paths are refracted; radiance falls by n^2; I / d^2 = 4.
    let expected = 0.96 * 0.5 / PI * 4.0 / 2.25;
    assert!((clear / expected - 1.0).abs() < 0.05, "{clear} {expected}");
    // 0.5 m from the light and 1 m to the surface; 1e-4 for the field of view.
    assert!((absorbing / clear - (-3.0f64).exp()).abs() < 1e-4, "{}", absorbing / clear);
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
    // Four bounces leave only the straight path.
    near("glass in water, radiance", radiance_through(build(), 4, 4)[0], expected, 1e-5);
}

/// O5: impact parameter, angles inside, transmittance of one face of a sphere of index 1.5.
fn sphere_ray(b: f64) -> (f64, f64, f64) {
    let (i, t) = (b.asin(), (b / 1.5).asin());
    let s = ((i.cos() - 1.5 * t.cos()) / (i.cos() + 1.5 * t.cos())).powi(2);
    let p = ((1.5 * i.cos() - t.cos()) / (1.5 * i.cos() + t.cos())).powi(2);
    (i, t, 1.0 - 0.5 * (s + p))
}

/// O5: share of parallel light on a sphere that reaches a floor `below` its centre within `radius` of the axis. Light
/// takes two refractions; lengths are in radii of the sphere.
pub fn within_on_floor(below: f64, radius: f64) -> f64 {
    let steps = 200_000;
    let ring = |step: i32| {
        let b = (f64::from(step) + 0.5) / f64::from(steps);
        let (i, t, passes) = sphere_ray(b);
        let rho = (2.0 * t - i).sin() - (below - (2.0 * t - i).cos()) * (2.0 * (i - t)).tan();
        let reaches = 2.0 * (i - t) < 0.5 * PI && rho.abs() <= radius;
        if reaches { passes * passes * 2.0 * b / f64::from(steps) } else { 0.0 }
    };
    (0..steps).map(ring).sum()
}

/// O5: a glass sphere transmits 0.8355 of parallel light by two refractions, to the expected positions. The beam is
/// exactly parallel; 1e-3 is for 512 x 256 facets (their outline, and shading normals that face away at the rim).
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
    let world = World::new(&scene, &RenderConfig { max_bounces: 40, ..config(8, 8, paths) });
    let beam = Beam {
        centre: Vec3::new(0.0, 3.0, 0.0),
        direction: Vec3::NEG_Y,
        axes: [Vec3::X, Vec3::Z],
        round: true,
        irradiance: 1.0,
    };
    let photons = world.shoot(&beam);
    let share = |keep: &dyn Fn(Vec3) -> bool| {
        let inside = photons.flux().filter(|(g, _)| g.scatterings == 2 && keep(g.position));
        let share = inside.map(|(_, flux)| flux).sum::<f64>() / PI;
        (share, (share * (1.0 - share) / f64::from(paths)).sqrt())
    };
    near("glass sphere, two refractions", share(&|_| true), 0.8355, 1e-3);
    let all: f64 = photons.flux().map(|(_, flux)| flux).sum::<f64>() / PI;
    near("glass sphere, all that arrives anywhere", (all, 0.0), 1.0, 1e-3);

    // Within circles on the floor 1.2 R below the centre, in front of the focus at 1.5 R.
    for radius in [0.05, 0.1, 0.2, 0.3] {
        let expected = within_on_floor(floor, radius);
        let inside = |p: Vec3| {
            let p = p.as_dvec3();
            p.y < -floor + 1e-3 && p.x.hypot(p.z) <= radius
        };
        near(&format!("glass sphere, within {radius} R"), share(&inside), expected, 1e-3);
    }
}

/// A point light in the middle of an absorbing glass ball meets its surface straight on at every reflection. T = (1 -
/// r) a / (1 - r a^2) leaves, with a = exp(-sigma R). The path starts inside of the glass.
#[test]
fn light_that_starts_inside_of_glass_is_absorbed() {
    let mut b = Builder::default();
    let wall = b.material(lambert(1e-6));
    let ball = b.material(Material { absorption: Vec3::splat(0.8), ..glass(1.5) });
    b.block(wall, DVec3::splat(-3.0), DVec3::splat(3.0), true);
    b.sphere(ball, DVec3::ZERO, 1.0, 128, 64);
    b.light(DVec3::ZERO, 1.0);
    b.camera(DVec3::new(0.0, 0.0, 2.5), DVec3::ZERO, 0.5);
    let scene = b.build();
    let paths = 400_000;
    let world = World::new(&scene, &RenderConfig { max_bounces: 12, ..config(8, 8, paths) });
    let photons = world.shoot(&world.by_power());
    let flux: f64 = photons.flux().map(|(_, flux)| flux).sum();
    let (a, r) = ((-0.8_f64).exp(), 0.04);
    let expected = (1.0 - r) * a / (1.0 - r * a * a);
    let share = flux / (4.0 * PI);
    // Facets lie up to 0.12 % nearer than their sphere.
    near("ball around a light", (share, (share / f64::from(paths)).sqrt()), expected, 1e-3);
}

/// A camera inside of absorbing glass sees a light in it by Beer's law: L exp(-sigma d).
#[test]
fn camera_inside_absorbing_glass_sees_a_light_by_beers_law() {
    let mut b = Builder::default();
    let block = b.material(Material { absorption: Vec3::new(0.0, 0.5, 1.0), ..glass(1.5) });
    let light = b.material(emitter(1.0));
    b.block(block, DVec3::splat(-2.0), DVec3::splat(2.0), false);
    b.panel(light, DVec3::new(0.0, 0.0, -1.0), 1.0 * DVec3::X, 1.0 * DVec3::Y);
    b.camera(DVec3::ZERO, DVec3::NEG_Z, 0.02);
    let scene = b.build();
    let (image, _) = render(&scene, &config(4, 4, 1), "photons-grid", None, 0, 1).remove(0);
    for pixel in image.path {
        let expected = Vec3::new(1.0, (-0.5_f32).exp(), (-1.0_f32).exp());
        assert!((pixel - expected).abs().max_element() < 2e-4, "{pixel} {expected}");
    }
}
