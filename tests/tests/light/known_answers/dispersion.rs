//! Dispersion: each channel is refracted, reflected and passed by its own index of refraction.

use caustics::render_config::RenderConfig;
use caustics_kernels::interface::choice::{Caustics, PixelFilter};
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight};
use caustics_kernels::light::emit::{EmissionSample, Emit};
use caustics_kernels::math::rng::Rng;
use caustics_kernels::pass::shoot::shoot;
use caustics_kernels::path::photon_sink::PhotonSink;
use caustics_kernels::surface::scatter::BsdfSample;
use caustics_tests::direct::*;
use caustics_tests::energy::ledger;
use caustics_tests::scenes::*;
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::FRAC_PI_3;

use super::glass::{radiance_through, transmitted};
use super::{above_a_floor, config, near};

/// Indices of red, green and blue of `flint`, whose Abbe number is 10: (n - 1) / 10 between red and blue.
fn indices(ior: f64) -> [f64; 3] {
    [-1.0, 0.0, 1.0].map(|channel| ior + channel * 0.05 * (ior - 1.0))
}

/// Reflectance of a face, unpolarised, from vacuum into this index at this angle.
fn reflectance(ior: f64, angle: f64) -> f64 {
    let (cos, behind) = (angle.cos(), (angle.sin() / ior).asin().cos());
    let s = (cos - ior * behind) / (cos + ior * behind);
    let p = (ior * cos - behind) / (ior * cos + behind);
    0.5 * (s * s + p * p)
}

/// A prism of 60 degrees, edges along z. Parallel light leaves it in the direction of its channel by Snell's law at
/// both faces, attenuated by both transmittances.
#[test]
fn prism_deviates_each_channel_by_its_index() {
    let ior = 1.5;
    let mut b = Builder::default();
    let (wall, prism) = (b.material(lambert(1e-6)), b.material(flint(ior as f32)));
    b.block(wall, DVec3::splat(-4.0), DVec3::splat(4.0), true);
    let corners = [0.0, 2.0, 4.0].map(|third: f64| DVec2::from_angle(1.5 * FRAC_PI_3 + third * FRAC_PI_3));
    let at = |corner: usize, z: f64| corners[corner % 3].extend(z);
    for corner in 0..3 {
        let (from, to) = (at(corner, 0.0), at(corner + 1, 0.0));
        b.panel(prism, 0.5 * (from + to), 0.5 * (to - from), 0.5 * DVec3::Z);
    }
    for (z, normal) in [(-0.5, DVec3::NEG_Z), (0.5, DVec3::Z)] {
        let [first, second] = if z > 0.0 { [1, 2] } else { [2, 1] };
        b.triangle(prism, [at(0, z), at(first, z), at(second, z)], [normal; 3]);
    }
    b.camera(DVec3::new(0.0, 3.0, 0.0), DVec3::new(0.0, 0.0, 0.1), 0.5);
    let scene = b.build();

    // Green passes at minimum deviation: straight along x inside.
    let incidence = (ior * 0.5_f64).asin();
    let tilt = incidence - 0.5 * FRAC_PI_3;
    let direction = DVec3::new(tilt.cos(), tilt.sin(), 0.0);
    let across = DVec3::new(-tilt.sin(), tilt.cos(), 0.0);
    let entrance = 0.5 * (at(0, 0.0) + at(1, 0.0));
    let beam = Beam {
        centre: (entrance - 2.0 * direction).as_vec3(),
        direction: direction.as_vec3(),
        axes: [0.05 * across.as_vec3(), 0.05 * Vec3::Z],
        round: false,
        irradiance: 1.0,
    };
    let paths = 200_000;
    let world = World::new(&scene, &RenderConfig { max_bounces: 3, ..config(8, 8, paths) });
    let photons = world.shoot(&beam);
    let mut shares = [0.0; 3];
    let mut turns = [0.0; 3];
    for (geometry, light) in photons.geometry.iter().zip(&photons.light) {
        if geometry.scatterings != 2 {
            continue;
        }
        let carried = light.flux * light.to_light.dot(geometry.normal) / beam.area() as f32;
        let channel = (0..3).find(|&channel| carried[channel] > 0.0).expect("it carries light");
        assert_eq!(carried[channel], carried.element_sum(), "a path has one channel");
        shares[channel] += f64::from(carried[channel]);
        // Angle by which the light turned, downwards.
        let leaving = -light.to_light.as_dvec3();
        let turn = tilt - leaving.y.atan2(leaving.x);
        let inside = (incidence.sin() / indices(ior)[channel]).asin();
        let exit = (indices(ior)[channel] * (FRAC_PI_3 - inside).sin()).asin();
        let expected = incidence + exit - FRAC_PI_3;
        // Directions are f32 and refracted twice.
        assert!((turn - expected).abs() < 2e-6 && leaving.z.abs() < 1e-6, "{channel}: {turn} {expected}");
        turns[channel] = turn;
    }
    println!("turned by {:.3?} degrees", turns.map(f64::to_degrees));
    assert!(turns[1] - turns[0] > 0.03 && turns[2] - turns[1] > 0.03, "red is refracted least, blue most");
    for (channel, ior) in indices(ior).into_iter().enumerate() {
        let inside = (incidence.sin() / ior).asin();
        let exit = (ior * (FRAC_PI_3 - inside).sin()).asin();
        let expected = (1.0 - reflectance(ior, incidence)) * (1.0 - reflectance(ior, exit));
        // A third of the paths have the channel, each with three times its light.
        let share = shares[channel];
        near(
            &format!("prism, channel {channel}"),
            (share, (share * (3.0 - share) / f64::from(paths)).sqrt()),
            expected,
            1e-5,
        );
    }
}

/// A dispersive slab transmits (1-r)/(1+r) of each channel with that channel's r, as flux and as radiance.
#[test]
fn dispersive_slab_transmits_each_channel_by_its_index() {
    let build = || {
        let mut b = above_a_floor();
        let slab = b.material(flint(2.0));
        b.block(slab, DVec3::new(-3.0, -0.25, -3.0), DVec3::new(3.0, 0.25, 3.0), false);
        b
    };
    let expected = indices(2.0).map(|ior| (1.0 - reflectance(ior, 0.0)) / (1.0 + reflectance(ior, 0.0)));
    assert!(expected[0] - expected[2] > 0.02);
    let measured = radiance_through(build(), 30, 32);
    for channel in 0..3 {
        near(&format!("radiance, channel {channel}"), measured[channel], expected[channel], 1e-5);
    }
    let paths = 1_000_000;
    let (share, _) = transmitted(&build().build(), paths, 30, |_| true);
    let error = (share * (3.0 - share) / f64::from(paths)).sqrt();
    near("flux of red", (share, error), expected[0], 1e-5);
}

/// Plain glass in a dispersive liquid: the inner faces reflect each channel by the relative index of that channel.
#[test]
fn glass_in_a_dispersive_liquid_reflects_by_the_relative_index() {
    let mut b = above_a_floor();
    let (liquid, ice) = (b.material(flint(2.0)), b.material(glass(1.2)));
    b.block(liquid, DVec3::new(-3.0, -1.0, -3.0), DVec3::new(3.0, 1.0, 3.0), false);
    b.block(ice, DVec3::new(-2.0, -0.4, -2.0), DVec3::new(2.0, 0.4, 2.0), false);
    let passes = |ratio: f64| 1.0 - ((ratio - 1.0) / (ratio + 1.0)).powi(2);
    let expected = indices(2.0).map(|ior| passes(ior).powi(2) * passes(ior / 1.2).powi(2));
    // Four bounces leave only the straight path.
    let measured = radiance_through(b, 4, 16);
    for channel in 0..3 {
        near(&format!("channel {channel}"), measured[channel], expected[channel], 1e-5);
    }
}

/// Light of one colour keeps its channel: glass samples no channel that the light lacks.
#[test]
fn dispersive_glass_samples_no_channel_that_a_light_lacks() {
    let mut b = above_a_floor();
    let ball = b.material(flint(1.5));
    b.sphere(ball, DVec3::ZERO, 0.5, 96, 48);
    b.colored_light(DVec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 1.0));
    let scene = b.build();
    let world = World::new(&scene, &config(8, 8, 20_000));
    let photons = world.shoot(&world.by_power());
    assert!(photons.len() > 200);
    assert!(photons.light.iter().all(|light| light.flux.x == 0.0 && light.flux.y == 0.0));
}

/// Emitted flux is absorbed, or escapes: sampling channels neither creates nor loses light, path by path.
#[test]
fn ledger_balances_in_dispersive_glass() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.6));
    let smooth = b.material(flint(1.5));
    let tinted = b.material(Material { absorption: Vec3::new(0.5, 1.0, 2.0), roughness: 0.2, ..flint(1.8) });
    b.panel(floor, DVec3::new(0.0, -1.0, 0.0), 1.2 * DVec3::Z, 1.2 * DVec3::X);
    b.sphere(smooth, DVec3::new(-0.4, -0.5, 0.0), 0.35, 96, 48);
    b.sphere(tinted, DVec3::new(0.4, -0.5, 0.0), 0.35, 96, 48);
    b.directional(DVec3::new(-0.2, -1.0, 0.1), 1.5);
    b.camera(DVec3::new(0.1, 0.4, 1.6), DVec3::new(0.0, -0.8, 0.0), 0.9);
    let scene = b.build();
    let config = RenderConfig { max_bounces: 8, caustics: Caustics::Any, ..config(8, 8, 1 << 16) };
    let world = World::new(&scene, &config);
    let energy = ledger(&world, &world.by_power(), 0);
    println!("{energy:?}");
    // As under a sky: noise of the floor's scattering.
    assert!(energy.residual.abs() < 4e-3, "{energy:?}");
}

/// Light that the scene's own lights emit on the left of the scene: the beam.
struct OfBeam<'a, E>(&'a E);

impl<E: Emit> Emit for OfBeam<'_, E> {
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        loop {
            let emission = self.0.sample(rng);
            if emission.ray.origin.x < -1.2 {
                return emission;
            }
        }
    }
}

/// Directions in which light enters the prism and leaves it, by its channel.
#[derive(Default)]
struct Images(Vec<(usize, DVec3, DVec3)>);

impl PhotonSink for Images {
    /// The direction from the light, and faces passed.
    type PathState = (Vec3, u32);

    fn start(&mut self, path_state: &mut (Vec3, u32), emission: &EmissionSample) {
        *path_state = (emission.ray.direction, 0);
    }

    fn scatter(&mut self, path_state: &mut (Vec3, u32), departure: &BsdfSample, _: Vec3) {
        path_state.1 += u32::from(departure.sampled.transmitted);
    }

    fn store_photon(&mut self, path_state: &mut (Vec3, u32), geometry: PhotonGeometry, light: PhotonLight) {
        if (geometry.scatterings, path_state.1) == (2, 2) {
            let channel = (0..3).find(|&channel| light.flux[channel] > 0.0).expect("it carries light");
            assert_eq!(light.flux[channel], light.flux.element_sum(), "a path has one channel");
            self.0.push((channel, path_state.0.as_dvec3(), -light.to_light.as_dvec3()));
        }
    }
}

/// The scene `prism` deviates the three images of the beam by at least 2 asin(n sin(A / 2)) - A. At any incidence the
/// deviation follows Snell's law at both faces. Each is within 0.02 degrees.
#[test]
fn images_of_the_scene_prism_are_deviated_by_their_index() {
    let scene = committed("prism");
    let world = World::new(&scene, &config(8, 8, 1));
    let (mut tracer, mut tally, mut images) = (world.tracer(), Tally::default(), Images::default());
    let by_power = world.by_power();
    for path in 0..40_000 {
        let (params, features, tables) = (&world.params, world.features, world.tables());
        shoot(path, params, features, tables, &OfBeam(&by_power), &mut tracer, &mut images, &mut tally);
    }
    // The prism of `scenes/src/prism.rs`: turned by -0.6, its faces look up at 150 and 30 degrees from that.
    let (turn, ior) = (-0.6, 1.6);
    let normal = |angle: f64| DVec2::from_angle(angle.to_radians() + turn).extend(0.0);
    let refracted = |direction: DVec3, normal: DVec3, eta: f64| {
        let cos = -direction.dot(normal);
        direction * eta + normal * (eta * cos - (1.0 - eta * eta * (1.0 - cos * cos)).sqrt())
    };
    let tolerance = 0.02_f64.to_radians();
    for (channel, n) in indices(ior).into_iter().enumerate() {
        let of_channel: Vec<_> = images.0.iter().filter(|image| image.0 == channel).collect();
        let (mut min_deviation, mut worst) = (f64::MAX, 0.0_f64);
        for (_, entering, leaving) in &of_channel {
            let inside = refracted(*entering, normal(150.0), 1.0 / n);
            let expected = refracted(inside, -normal(30.0), n);
            worst = worst.max(expected.angle_between(*leaving));
            min_deviation = min_deviation.min(entering.angle_between(*leaving));
        }
        let known = 2.0 * (n * (0.5 * FRAC_PI_3).sin()).asin() - FRAC_PI_3;
        println!(
            "n = {n:.3}: {} paths, least deviation {:.4}, known {:.4}; off Snell's law by {worst:.1e}",
            of_channel.len(),
            min_deviation.to_degrees(),
            known.to_degrees()
        );
        assert!(of_channel.len() > 1_000);
        assert!(
            (min_deviation - known).abs() < tolerance && worst < tolerance,
            "{channel}: {min_deviation} {known} {worst}"
        );
    }
}

/// A light's highlight on dispersive glass has the hue of its Fresnel reflectances after 32 frames, because each
/// reflection shows all channels.
#[test]
fn a_highlight_on_dispersive_glass_has_its_hue_after_32_frames() {
    let mut b = Builder::default();
    // Light that enters is absorbed, so that the ball's back shows nothing of the light.
    let ball = b.material(Material { absorption: Vec3::splat(20.0), ..flint(1.5) });
    let light = b.material(emitter(50.0));
    b.sphere(ball, DVec3::ZERO, 1.0, 192, 96);
    // Seen in the front of the ball at 30 degrees.
    let (to_light, to_eye) = (DVec3::new(3.0_f64.sqrt() / 2.0, 0.0, 0.5), DVec3::Z);
    let across = DVec3::new(0.5, 0.0, -3.0_f64.sqrt() / 2.0);
    b.panel(light, 6.0 * to_light, 2.5 * DVec3::Y, 2.5 * across);
    b.camera(6.0 * to_eye, DVec3::ZERO, 0.45);
    let scene = b.build();
    let (side, middle) = (64, (0.5_f64, 0.0));
    let config = RenderConfig { pixel_filter: PixelFilter::Box, ..config(side, side, 1) };
    let frames = render(&scene, &config, "photons-grid", None, 0, 32);
    // The pixels around the point of mirror reflection, where the light's image covers 14 x 11.
    let scale = 0.5 * f64::from(side) / (0.5_f64 * 0.45).tan();
    let (column, row) = (
        0.5 * f64::from(side) + scale * middle.0 / (6.0 - 0.75_f64.sqrt()),
        0.5 * f64::from(side) - scale * middle.1,
    );
    let mut sum = DVec3::ZERO;
    let mut seen = 0;
    for (image, _) in &frames {
        for y in -4..=4 {
            for x in -4..=4 {
                let (x, y) = (column as i32 + x, row as i32 + y);
                sum += image.path[(y * side as i32 + x) as usize].as_dvec3();
                seen += 1;
            }
        }
    }
    let mean = sum / f64::from(seen);
    let expected = DVec3::from(indices(1.5).map(|ior| 50.0 * reflectance(ior, 30.0_f64.to_radians())));
    println!("{mean:.4?} of {expected:.4?}");
    // A path in 25 reflects, some hundred of them here: the brightness has a deviation of 10 %, the hue has none.
    assert!((mean.y / expected.y - 1.0).abs() < 0.3, "the highlight is not in these pixels");
    let hue = (mean / mean.y) / (expected / expected.y);
    assert!((hue - 1.0).abs().max_element() < 0.01, "{hue}");
    assert!((expected / expected.y - 1.0).abs().max_element() > 0.05, "hues differ");
}

/// Collection points on a partly dispersive surface keep all channels.
#[test]
fn collection_points_on_dispersive_glass_keep_all_channels() {
    let mut b = Builder::default();
    let material = Material { transmission: 0.5, base_color: Vec3::splat(0.8), ..flint(1.5) };
    let block = b.material(material);
    b.block(block, DVec3::splat(-1.0), DVec3::new(1.0, 0.0, 1.0), false);
    b.light(DVec3::new(0.0, 1.0, 0.0), 1.0);
    b.camera(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO, 0.3);
    let scene = b.build();
    let world = World::new(&scene, &config(32, 32, 1));
    let points = world.collect();
    let first = points.iter().filter(|collected| collected.point.geometry.depth == 1);
    let mut count = 0;
    for collected in first {
        let throughput = collected.point.shading.throughput;
        assert!(throughput.min_element() > 0.0, "{throughput}");
        count += 1;
    }
    assert!(count > 300, "{count}");
}
