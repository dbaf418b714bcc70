//! Rough glass in scenes: light found through it by light sampling and by refraction, and absorbed behind it.

use caustics::render_config::{Radius, RenderConfig};
use caustics::scene::Scene;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::{FLAG_THIN, Material};
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight};
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::light::emit::EmissionSample;
use caustics_kernels::math::rng::Stream;
use caustics_kernels::pass::shoot::shoot;
use caustics_kernels::path::PathContext;
use caustics_kernels::path::camera_path::{CameraSuffix, trace_camera_path};
use caustics_kernels::path::camera_ray::CameraPathStart;
use caustics_kernels::path::observer::{CollectionPoint, PathObserver};
use caustics_kernels::path::photon_sink::PhotonSink;
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::dispersion::Indices;
use caustics_kernels::surface::scatter::BsdfSample;
use caustics_kernels::surface::{Bsdf, DielectricInterface};
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

use super::{config, near};

/// Mean of the path layer over the pixels, with its standard error.
fn seen(scene: &Scene, side: u32, max_bounces: u32) -> (f64, f64) {
    let world = World::new(scene, &RenderConfig { max_bounces, ..config(side, side, 1) });
    let values: Vec<f64> = world.collect().iter().map(|c| f64::from(c.light.radiance.x)).collect();
    mean_and_error(&values)
}

/// All lobes of a material at normal incidence.
fn seen_from_above(material: Material, eta: f32) -> (Bsdf, DielectricInterface) {
    Bsdf::new(material, Vec3::Z, Indices::new(eta), 0.25, Classes::ALL, false, Features::ALL)
}

/// Mean weight of transmitted samples of this material at normal incidence.
fn transmitted(material: Material, eta: f32) -> f64 {
    use caustics_kernels::math::rng::{Rng, Stream};
    let (surface, interface) = seen_from_above(material, eta);
    let weights = (0..1_000_000).map(|path| {
        let sampled = surface.sample(interface, Rng::new(Stream::Light, 3, path, 0).next4());
        if sampled.transmitted { f64::from(sampled.weight.x) } else { 0.0 }
    });
    weights.sum::<f64>() / 1e6
}

/// A camera over a plane of rough glass; all directions on both sides show radiance 1. Light sampling and refraction
/// find the same emitters: with any weights the sum is R + T eta^2. 2e-3 is for the sampled R and T.
#[test]
fn lights_behind_rough_glass_show_their_radiance_over_the_square_of_the_index() {
    lights_show_their_radiance(&[(0.3, false), (0.5, true)]);
}

fn lights_show_their_radiance(cases: &[(f32, bool)]) {
    for &(roughness, thin) in cases {
        let flags = if thin { FLAG_THIN } else { 0 };
        let material = Material { roughness, flags, ..glass(1.5) };
        let mut b = Builder::default();
        let frosted = b.material(material);
        let light = b.material(emitter(1.0));
        b.panel(frosted, DVec3::ZERO, 2.0 * DVec3::Z, 2.0 * DVec3::X);
        // Emitters enclose both sides.
        b.block(light, DVec3::new(-1.9, -1.0, -1.9), DVec3::new(1.9, 1.9, 1.9), true);
        b.camera(DVec3::new(0.0, 1.0, 0.0), DVec3::ZERO, 0.002);
        let scene = b.build();
        let eta: f32 = if thin { 1.0 } else { 1.0 / 1.5 };
        // Reflected light comes from the emitters above the plane.
        let (surface, interface) = seen_from_above(material, eta);
        let reflected: f64 = (0..1_000_000)
            .map(|path| {
                use caustics_kernels::math::rng::{Rng, Stream};
                let sampled = surface.sample(interface, Rng::new(Stream::Light, 4, path, 0).next4());
                if sampled.transmitted || sampled.direction.z <= 0.0 {
                    0.0
                } else {
                    f64::from(sampled.weight.x)
                }
            })
            .sum::<f64>()
            / 1e6;
        let expected = reflected + transmitted(material, eta) * f64::from(eta * eta);
        let name = format!("lights around rough glass {roughness}, thin {thin}");
        near(&name, seen(&scene, 500, 1), expected, 2e-3);
    }
}

/// Light sampling alone finds a point light below a plane of rough glass. Its radiance f eta^2 cos I / d^2 is absorbed
/// on its side of the plane. 1e-3 is for the field of view.
#[test]
fn point_light_behind_rough_glass_is_sampled_and_absorbed() {
    let build = |sigma: f32| {
        let material = Material { roughness: 0.4, absorption: Vec3::splat(sigma), ..glass(1.5) };
        let mut b = Builder::default();
        let frosted = b.material(material);
        b.block(frosted, DVec3::new(-2.0, -1.0, -2.0), DVec3::new(2.0, 0.0, 2.0), false);
        b.light(DVec3::new(0.2, -0.5, 0.0), 3.0);
        b.camera(DVec3::new(0.0, 2.0, 0.0), DVec3::ZERO, 0.0005);
        (b.build(), material)
    };
    let (scene, material) = build(0.0);
    let to_light = Vec3::new(0.2, -0.5, 0.0);
    let (square, cos) = (f64::from(to_light.length_squared()), f64::from(0.5 / to_light.length()));
    // The frame's tangents turn around the normal, which changes nothing here: the view is along it.
    let local = Vec3::new(to_light.x, to_light.z, to_light.y).normalize();
    let eta = 1.0 / 1.5;
    let (surface, _) = seen_from_above(material, eta);
    let f = f64::from(surface.eval(local, Classes::SPECULAR).f.x);
    assert!(f > 0.02, "the test has nothing to check: {f}");
    let expected = f * f64::from(eta * eta) * cos * 3.0 / square;
    let clear = seen(&scene, 16, 1).0;
    assert!((clear / expected - 1.0).abs() < 1e-3, "{clear} {expected}");
    let absorbed = seen(&build(2.0).0, 16, 1).0;
    let beer = (-2.0 * square.sqrt()).exp();
    assert!((absorbed / clear / beer - 1.0).abs() < 1e-3, "{} {beer}", absorbed / clear);
}

/// Whether the reflection of rough glass is specular decides which paths compute its light, not its amount. The mean of
/// a room's image is the same with the threshold below and above its roughness. 0.5 % is for the loss of discs at
/// borders, which lie elsewhere.
#[test]
fn specular_class_of_rough_glass_moves_light_between_layers_alone() {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.6));
    let frosted = b.material(Material { roughness: 0.3, ..glass(1.7) });
    let mirror = b.material(metal(0.9, 0.0));
    let light = b.material(emitter(10.0));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.block(frosted, DVec3::new(-0.7, -0.9, -0.7), DVec3::new(0.5, -0.6, 0.5), false);
    b.panel(mirror, DVec3::new(0.9, 0.0, 0.0), 0.4 * DVec3::Z, DVec3::new(-0.2, 0.4, 0.0));
    b.panel(light, DVec3::new(0.0, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.camera(DVec3::new(0.0, 0.3, 0.95), DVec3::new(0.0, -0.6, 0.0), 1.0);
    let scene = b.build();
    let means = |specular_roughness: f32| {
        let config = RenderConfig {
            specular_roughness,
            radius: Radius::Px(0.5),
            max_bounces: 6,
            ..config(64, 48, 100_000)
        };
        let frames = render(&scene, &config, "photons-grid", None, 0, 24);
        let caustics: Vec<f64> = frames.iter().map(|(p, _)| mean_of(&p.caustics)).collect();
        let path: Vec<f64> = frames.iter().map(|(p, _)| mean_of(&p.path)).collect();
        let sum: Vec<f64> = caustics.iter().zip(&path).map(|(a, b)| a + b).collect();
        (mean_and_error(&sum), mean_and_error(&caustics).0)
    };
    let ((below, below_error), below_caustics) = means(0.2);
    let ((above, above_error), above_caustics) = means(0.4);
    println!("caustics {below_caustics:.5} and {above_caustics:.5}");
    assert!((above_caustics / below_caustics - 1.0).abs() > 0.02, "the test has nothing to check");
    near("rough glass by class", (below, below_error.hypot(above_error)), above, 5e-3 * above);
}

/// Throughputs of camera paths where they leave the scene.
#[derive(Default)]
struct Escapes(Vec<f64>);

impl PathObserver for Escapes {
    type Kept = ();

    fn collect(&mut self, (): &mut (), _: &CollectionPoint) {}
    fn end(&mut self, (): &mut (), _: Vec3) {}
    fn escape(&mut self, _: &Ray, throughput: Vec3) {
        self.0.push(f64::from(throughput.x));
    }
}

/// Largest flux of a light path, over its emitted flux.
#[derive(Default)]
struct Fluxes(Vec<f64>);

impl PhotonSink for Fluxes {
    type PathState = f32;

    fn start(&mut self, path_state: &mut f32, emission: &EmissionSample) {
        *path_state = emission.flux.x;
    }
    fn scatter(&mut self, path_state: &mut f32, _: &BsdfSample, flux: Vec3) {
        self.0.push(f64::from(flux.x / *path_state));
    }
    fn store_photon(&mut self, _: &mut f32, _: PhotonGeometry, _: PhotonLight) {}
}

/// In a white furnace a path through white rough glass has the masking as its weight, after any number of scatterings.
/// The second moment of paths without light sampling is at most 1, behind a collection point and for light paths too.
/// Prefixes choose before the facet, and their weights grow.
#[test]
fn weights_of_paths_through_white_rough_glass_have_a_second_moment_of_at_most_1() {
    let furnace = |roughness: f32, suffix: CameraSuffix| {
        let mut b = Builder::default();
        let frosted = b.material(Material { roughness, ..glass(1.5) });
        b.sphere(frosted, DVec3::ZERO, 1.0, 96, 48);
        b.camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.3);
        let scene = b.build();
        let mut world = World::new(&scene, &RenderConfig { max_bounces: 64, ..config(128, 128, 20_000) });
        // The scene has no light to derive the unit from.
        world.params.quantum = 2.0f32.powi(-40);
        let (mut tracer, mut tally, mut escapes) = (world.tracer(), Tally::default(), Escapes::default());
        for pixel in 0..world.params.pixel_count() {
            let start = CameraPathStart::new(Stream::Reference, 0, pixel, &world.params);
            let context =
                PathContext { params: &world.params, features: world.features, scene: world.tables() };
            trace_camera_path(start, suffix, context, &mut tracer, &mut escapes, &mut tally);
        }
        let paths = f64::from(world.params.pixel_count());
        let mean = escapes.0.iter().sum::<f64>() / paths;
        let second = escapes.0.iter().map(|throughput| throughput * throughput).sum::<f64>() / paths;
        let beam = Beam {
            centre: Vec3::new(0.0, 0.0, 4.0),
            direction: Vec3::NEG_Z,
            axes: [0.9 * Vec3::X, 0.9 * Vec3::Y],
            round: true,
            irradiance: 1.0,
        };
        let mut fluxes = Fluxes::default();
        for path in 0..20_000 {
            let features = world.features;
            let tables = world.tables();
            shoot(path, &world.params, features, tables, &beam, &mut tracer, &mut fluxes, &mut tally);
        }
        let largest = fluxes.0.iter().fold(0.0, |largest: f64, flux| largest.max(*flux));
        println!(
            "roughness {roughness}, {suffix:?}: mean {mean:.4}, second moment {second:.4}, light paths at most {largest:.4}"
        );
        (mean, second, largest)
    };
    for roughness in [0.1, 0.2, 0.3, 0.5, 1.0] {
        let (mean, second, largest) = furnace(roughness, CameraSuffix::ALL);
        // The camera sees the ball alone. Facets have f / pdf in f32: 1e-3 per scattering.
        assert!(
            mean < 1.0 && second <= mean + 0.005 && largest < 1.01,
            "{roughness}: {mean} {second} {largest}"
        );
    }
    // Measure a prefix that may end at a point, before that point is reached.
    let (mean, second, _) =
        furnace(0.5, CameraSuffix { follows: Classes::ALL, finds: Classes::NON_SPECULAR });
    assert!(second > 1.1 * mean, "a choice before the facet is noisier: {mean} {second}");
}

mod long {
    use super::*;

    #[test]
    #[ignore = "ten seconds"]
    fn lights_behind_glass_of_any_roughness_show_their_radiance() {
        lights_show_their_radiance(&[(0.1, false), (0.7, false), (1.0, false)]);
    }
}
