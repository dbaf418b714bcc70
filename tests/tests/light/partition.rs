//! Statistical tests; those in `long` take minutes.

use caustics::render_config::{Paths, Radius, RenderConfig};
use caustics::scene::texture::Role;
use caustics_kernels::interface::point::PhotonGeometry;
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Height of the ring of O1 over its radius 1.
const HEIGHT: f64 = 0.8;

/// Floor point that light reflected at wall point (t, z) reaches, at 45 degrees.
fn reflected(t: f64, z: f64) -> (f64, f64) {
    (t.cos() - z * (2.0 * t).cos(), t.sin() - z * (2.0 * t).sin())
}

/// Sum over all wall points (t, z) that send light to the floor point p of cos t / |cos t - 2 z|.
fn branches(p: (f64, f64)) -> f64 {
    // The reflected ray's line passes p where this is zero; z is then the distance along it.
    let off = |t: f64| {
        let (x, y) = (p.0 - t.cos(), p.1 - t.sin());
        x * (2.0 * t).sin() - y * (2.0 * t).cos()
    };
    let steps = 4000;
    let at = |step: i32| -FRAC_PI_2 + PI * f64::from(step) / f64::from(steps);
    let mut sum = 0.0;
    for step in 0..steps {
        let (mut low, mut high) = (at(step), at(step + 1));
        if off(low) * off(high) > 0.0 {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if off(low) * off(middle) <= 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        let (x, y) = (p.0 - low.cos(), p.1 - low.sin());
        let z = -(x * (2.0 * low).cos() + y * (2.0 * low).sin());
        if (0.0..=HEIGHT).contains(&z) {
            sum += low.cos() / (low.cos() - 2.0 * z).abs();
        }
    }
    sum
}

/// Mean of `branches` over a disc: the quantity that a count of flux in the disc measures.
fn disc_mean(p: (f64, f64), radius: f64) -> f64 {
    let cells = 24;
    let along = |i: i32| (f64::from(2 * i + 1) / f64::from(cells) - 1.0) * radius;
    let inside = (0..cells * cells)
        .map(|i| (along(i % cells), along(i / cells)))
        .filter(|(x, y)| x.hypot(*y) <= radius);
    let values: Vec<f64> = inside.map(|(x, y)| branches((p.0 + x, p.1 + y))).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// The listed floor points, the sums over their branches, and a disc's radius small enough to stay off the fold.
const LISTED: [(f64, f64, f64, f64); 4] =
    [(0.3, 0.2, 2.532, 0.03), (0.1, 0.75, 1.970, 0.03), (0.9, 0.1, 2.240, 0.02), (1.2, 0.05, 2.085, 0.006)];

/// Irradiance over direct irradiance within discs around the listed points, from single reflections.
/// The near half of the wall is left out: an opaque one would shade the rest.
fn measured(paths: u32) -> [(f64, f64); 4] {
    let mut b = Builder::default();
    let floor = b.material(lambert(1e-6));
    let mirror = b.material(metal(1.0, 0.0));
    b.panel(floor, DVec3::ZERO, 4.0 * DVec3::Z, 4.0 * DVec3::X);
    b.wall(mirror, DVec3::ZERO, 1.0, HEIGHT, -FRAC_PI_2, FRAC_PI_2, 4096);
    b.camera(DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO, 0.5);
    let scene = b.build();
    let config =
        RenderConfig { width: 8, height: 8, light_paths: Paths::Count(paths), ..RenderConfig::default() };
    let world = World::new(&scene, &config);
    let (sin, cos) = (0.5_f32.sqrt(), 0.5_f32.sqrt());
    let direction = Vec3::new(cos, -sin, 0.0);
    let up = Vec3::new(sin, cos, 0.0);
    let beam = Beam {
        centre: up * 0.65 - direction * 3.0,
        direction,
        axes: [Vec3::Z, up * 0.65],
        round: false,
        irradiance: 1.0,
    };
    let photons = world.shoot(&beam);
    LISTED.map(|(t, z, _, radius)| {
        let (x, y) = reflected(t, z);
        let inside = |g: &PhotonGeometry| {
            let p = g.position.as_dvec3();
            g.scatterings == 1 && (p.x - x).hypot(p.z - y) <= radius
        };
        let flux: Vec<f64> = photons.flux().filter(|(g, _)| inside(g)).map(|(_, flux)| flux).collect();
        let scale = 1.0 / (PI * radius * radius * f64::from(sin));
        let squares: f64 = flux.iter().map(|flux| flux * flux).sum();
        (flux.iter().sum::<f64>() * scale, squares.sqrt() * scale)
    })
}

/// Compares the first `points` points of the list; 0.5 % is for 4096 facets and the quadrature over discs.
fn check_ring(paths: u32, points: usize) {
    for ((t, z, listed, radius), (value, error)) in LISTED.into_iter().zip(measured(paths)).take(points) {
        let p = reflected(t, z);
        let (at_point, expected) = (branches(p), disc_mean(p, radius));
        println!(
            "ring ({t}, {z}): {value:.4} +- {error:.4}, expected {expected:.4} over the disc of {radius}, \
             {at_point:.4} at its centre, listed {listed}"
        );
        assert!((at_point - listed).abs() < 1e-3, "branches of ({t}, {z}): {at_point} {listed}");
        assert!((value - expected).abs() < 3.0 * error + 0.005 * expected);
    }
}

/// O1: a ring mirror of radius 1 and height 0.8 in parallel light at 45 degrees, at three of the listed points.
#[test]
fn ring_mirror_makes_its_nephroid() {
    check_ring(1_500_000, 3);
}

/// A closed room with glossy objects (GGX, roughness 0.2 and 0.25). With a threshold below the roughness they are no
/// casters, and the path tracer finds their light. With a threshold above it, their caustics are gathered. The sum is
/// the same.
///
/// `mixed` adds a point light, and swaps a block for a coated one, which casts by its coat and receives by its base.
/// `segments` adds a sphere of facets under smooth normals.
fn glossy_room(mixed: bool, segments: u32) -> Builder {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.6));
    let glossy = b.material(metal(0.9, 0.25));
    let light = b.material(emitter(10.0));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    let block = if mixed { b.material(coated(0.7, 0.2)) } else { glossy };
    if mixed {
        b.light(DVec3::new(0.5, 0.2, 0.3), 0.2);
    }
    if segments > 0 {
        b.sphere(glossy, DVec3::new(0.4, -0.55, -0.2), 0.3, segments, segments / 2);
    }
    b.block(block, DVec3::new(-0.6, -0.9, -0.7), DVec3::new(0.1, -0.2, -0.1), false);
    b.panel(glossy, DVec3::new(0.9, -0.2, 0.0), DVec3::new(0.0, 0.0, 0.6), DVec3::new(0.05, 0.6, 0.0));
    b.panel(light, DVec3::new(0.1, 0.95, 0.0), DVec3::new(0.4, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.4));
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.3, 0.0), 1.0);
    b
}

/// Means of path + caustics over blocks of 8 x 8 pixels, frame by frame, and the share of the caustics.
fn blocks(scene: &caustics::scene::Scene, config: &RenderConfig, frames: u32) -> (Vec<Vec<f64>>, f64) {
    let (width, height) = (config.width as usize, config.height as usize);
    let mut caustic = 0.0;
    let mut all = 0.0;
    let rows = render(scene, config, "photons-grid", None, 0, frames)
        .into_iter()
        .map(|(image, counters)| {
            assert!(counters.warnings().is_empty(), "{:?}", counters.warnings());
            caustic += mean_of(&image.caustics);
            all += mean_of(&image.caustics) + mean_of(&image.path);
            let mut sums = vec![0.0; (width / 8) * (height / 8)];
            for (pixel, (a, b)) in image.path.iter().zip(&image.caustics).enumerate() {
                let (x, y) = (pixel % width / 8, pixel / width / 8);
                sums[y * (width / 8) + x] += f64::from(a.x + b.x) / 64.0;
            }
            sums
        })
        .collect();
    (rows, caustic / all)
}

/// z-scores of the difference between two settings: of the whole image, the blocks' mean square, and the largest of the
/// blocks.
fn compare(a: &[Vec<f64>], b: &[Vec<f64>]) -> (f64, f64, f64) {
    let z = |a: Vec<f64>, b: Vec<f64>| {
        let ((mean_a, error_a), (mean_b, error_b)) = (mean_and_error(&a), mean_and_error(&b));
        (mean_a - mean_b) / error_a.hypot(error_b)
    };
    let column = |rows: &[Vec<f64>], i: usize| rows.iter().map(|row| row[i]).collect::<Vec<_>>();
    let whole =
        |rows: &[Vec<f64>]| rows.iter().map(|row| row.iter().sum::<f64>() / row.len() as f64).collect();
    let scores: Vec<f64> = (0..a[0].len()).map(|i| z(column(a, i), column(b, i))).collect();
    let square = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
    (z(whole(a), whole(b)), square, scores.iter().fold(0.0, |worst: f64, z| worst.max(z.abs())))
}

/// Compares the sums of two thresholds, one on either side of the objects' roughness.
fn sums_agree(what: &str, scene: &caustics::scene::Scene, frames: u32) {
    sums_of_thresholds_agree(what, scene, [0.1, 0.4], frames);
}

/// Compares the sums of these thresholds.
fn sums_of_thresholds_agree(
    what: &str,
    scene: &caustics::scene::Scene,
    [below, above]: [f32; 2],
    frames: u32,
) {
    // Small discs: the loss of discs at the room's edges is a bias of the estimator, not of the split.
    let with = |specular_roughness, seed| RenderConfig {
        width: 64,
        height: 48,
        light_paths: Paths::Count(60_000),
        max_bounces: 4,
        radius: Radius::Px(0.2),
        specular_roughness,
        seed,
        ..RenderConfig::default()
    };
    let (low, low_share) = blocks(scene, &with(below, 1), frames);
    let (high, high_share) = blocks(scene, &with(above, 2), frames);
    let mean = |rows: &[Vec<f64>]| {
        let values: Vec<f64> = rows.iter().map(|row| row.iter().sum::<f64>() / row.len() as f64).collect();
        mean_and_error(&values)
    };
    let (whole, square, worst) = compare(&low, &high);
    println!("{what}, threshold {below}: {:?}, caustic share {low_share:.4}", mean(&low));
    println!("{what}, threshold {above}: {:?}, caustic share {high_share:.4}", mean(&high));
    println!("{what}: z of the whole {whole:.2}, mean square z of 48 blocks {square:.2}, largest {worst:.2}");
    assert!(low_share == 0.0 && high_share > 0.02, "the test has nothing to check");
    assert!(whole.abs() < 3.0, "the whole image: z = {whole}");
    // 48 blocks: their mean square z is 1 +- 0.2; 4.2 is exceeded by one block in 800 such tests.
    assert!(square < 1.8 && worst < 4.2, "blocks: {square} {worst}");
}

mod long {
    use super::*;

    /// Compares all four points of the list, with less noise.
    #[test]
    #[ignore = "16 million light paths: about half a minute on two cores"]
    fn ring_mirror_makes_its_nephroid_sharply() {
        check_ring(16_000_000, 4);
    }

    /// The sum of both layers does not depend on the threshold, in any block of the image.
    #[test]
    #[ignore = "600 frames: about half a minute on two cores"]
    fn sum_of_layers_does_not_depend_on_the_specular_threshold() {
        sums_agree("glossy metal", &glossy_room(false, 0).build(), 300);
    }

    /// One surface casts by one lobe and receives by another, and point lights shine on glossy lobes.
    #[test]
    #[ignore = "600 frames: about half a minute on two cores"]
    fn sum_of_layers_does_not_depend_on_the_threshold_of_mixed_lobes() {
        sums_agree("coat over Lambert", &glossy_room(true, 0).build(), 300);
    }

    /// Smooth normals over coarse facets: the adjoint correction of light paths.
    #[test]
    #[ignore = "600 frames: about half a minute on two cores"]
    fn sum_of_layers_does_not_depend_on_the_threshold_at_smooth_normals() {
        sums_agree("smooth normals over 10 x 5 facets", &glossy_room(false, 10).build(), 300);
    }

    /// A spot and a directional light, which only light sampling and light paths find. Lobes are rougher, as is the
    /// threshold: few paths meet the peak of a sharp lobe, and 300 frames of those follow no normal law.
    #[test]
    #[ignore = "600 frames: about half a minute on two cores"]
    fn sum_of_layers_does_not_depend_on_the_threshold_under_spot_and_directional_lights() {
        let mut b = Builder::default();
        let floor = b.material(lambert(0.6));
        let glossy = b.material(metal(0.9, 0.6));
        let coat = b.material(coated(0.7, 0.6));
        b.panel(floor, DVec3::ZERO, 1.5 * DVec3::Z, 1.5 * DVec3::X);
        b.panel(floor, DVec3::new(0.0, 0.7, -1.2), 1.5 * DVec3::X, 0.7 * DVec3::Y);
        b.block(coat, DVec3::new(-0.6, 0.05, -0.7), DVec3::new(0.1, 0.7, -0.1), false);
        b.panel(glossy, DVec3::new(0.8, 0.5, -0.2), DVec3::new(0.0, 0.0, 0.6), DVec3::new(0.05, 0.45, 0.0));
        b.spot(DVec3::new(-0.3, 1.3, 0.6), DVec3::new(1.1, -0.8, -0.8), 0.2, 0.6, 1.0);
        b.directional(DVec3::new(0.5, -0.7, -0.4), 0.5);
        b.camera(DVec3::new(0.0, 0.9, 1.3), DVec3::new(0.1, 0.3, -0.4), 0.8);
        sums_of_thresholds_agree("spot and sun", &b.build(), [0.1, 0.7], 300);
    }

    /// Textures: a base colour and bumps on the walls, and a metal of roughness 0.15 to 0.35 with tilted normals. Both
    /// thresholds use the finest level only: a path's level depends on its prefix, and so on the threshold, by design.
    #[test]
    #[ignore = "600 frames: about half a minute on two cores"]
    fn sum_of_layers_does_not_depend_on_the_threshold_of_textured_surfaces() {
        let mut b = Builder::default();
        let noise = |x: u32, y: u32| Rng::new(Stream::Camera, 17, x, y).next4().to_array();
        let base_color = b.texture(Role::Color, 8, 8, |x, y| noise(x, y).map(|u| (255.0 - 90.0 * u) as u8));
        let normal = b.texture(Role::Normal, 8, 8, |x, y| {
            let [u, v, ..] = noise(x, y);
            [(88.0 + 80.0 * u) as u8, (88.0 + 80.0 * v) as u8, 240, 255]
        });
        let metallic_roughness =
            b.texture(Role::Data, 8, 8, |x, y| [0, (38.0 + 51.0 * noise(x, y)[2]) as u8, 255, 255]);
        let plain = MaterialTextures::default();
        let wall = b.textured(lambert(0.7), MaterialTextures { base_color, normal, ..plain });
        let record = MaterialTextures { metallic_roughness, normal, normal_scale: 0.5, ..plain };
        let glossy = b.textured(metal(0.9, 1.0), record);
        let light = b.material(emitter(10.0));
        b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
        b.block(glossy, DVec3::new(-0.6, -0.9, -0.7), DVec3::new(0.1, -0.2, -0.1), false);
        b.panel(glossy, DVec3::new(0.9, -0.2, 0.0), DVec3::new(0.0, 0.0, 0.6), DVec3::new(0.05, 0.6, 0.0));
        b.panel(light, DVec3::new(0.1, 0.95, 0.0), DVec3::new(0.4, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.4));
        b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.3, 0.0), 1.0);
        let mut scene = b.build();
        scene.textures.textures.iter_mut().for_each(|texture| texture.level_count = 1);
        sums_agree("textured surfaces", &scene, 300);
    }
}
