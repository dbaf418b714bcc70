//! Samplers of lights against their densities: light samples and starts of light paths.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::light::area::pdf_solid_angle;
use caustics_kernels::light::emit::Emit;
use caustics_kernels::light::light_bvh::LightBvh;
use caustics_kernels::light::light_sampling::LightCandidates;
use caustics_kernels::math::PI;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::trace::Tracer;
use caustics_tests::chi_square::{Fit, SphereCells};
use caustics_tests::direct::{World, mean_and_error};
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

const SAMPLES: u32 = 400_000;

/// Three emitters of different sizes and powers (one on both sides) and a point light; none hides another from the
/// origin.
fn scene_of_lights() -> Builder {
    let mut b = Builder::default();
    let (dim, bright, both) =
        (b.material(emitter(1.0)), b.material(emitter(7.0)), b.material(emitter_both(2.0)));
    b.panel(dim, DVec3::new(0.0, 2.0, 0.0), DVec3::X, DVec3::Z);
    b.panel(bright, DVec3::new(1.5, 0.0, 0.0), 0.2 * DVec3::Z, 0.4 * DVec3::Y);
    b.panel(both, DVec3::new(0.0, -0.5, -1.0), 0.5 * DVec3::X, DVec3::new(0.0, 0.3, 0.3));
    b.light(DVec3::new(0.0, 0.0, 3.0), 0.5);
    b.camera(DVec3::ZERO, DVec3::Z, 1.0);
    b
}

/// Directions of light samples on area lights fall into cells by the density at the hit of a ray in that direction.
#[test]
fn light_samples_follow_their_density() {
    let scene = scene_of_lights().build();
    let world = World::new(&scene, &Default::default());
    let cells = SphereCells { rows: 64, columns: 64 };
    let mut seen = vec![0; cells.count()];
    let lights = scene.lights.len() as u32;
    let (mut to_points, mut bad) = (0, 0);
    for path in 0..SAMPLES {
        let u = Rng::new(Stream::Camera, 10, path, 0).next4();
        let c = LightCandidates::ONE.sample_light(0, world.tables(), lights, world.features, Vec3::ZERO, u);
        if c.radiance_over_pdf == Vec3::ZERO {
            continue; // the dark side of an emitter
        }
        if c.pdf_solid_angle == 0.0 {
            to_points += 1;
            continue;
        }
        seen[cells.cell_index(c.to_light)] += 1;
        // The density of a sample is the density at the hit of its ray.
        let hit = world.tracer().closest(&Ray::endless(Vec3::ZERO, c.to_light));
        let found = if hit.is_miss() { 0.0 } else { density(&world, c.to_light) };
        bad += u32::from((found - c.pdf_solid_angle).abs() > 1e-3 * c.pdf_solid_angle);
    }
    // A ray at the rim of an emitter may miss it.
    assert!(bad <= 5, "{bad} light samples with another density than a ray finds");
    let expected = cells.integrate([24, 24], |d| f64::from(density(&world, d)) * f64::from(SAMPLES));
    let fit = Fit::new(&seen, &expected);
    println!("light samples: {:.0} of {}", fit.chi_square, fit.cells);
    assert!(fit.passes(), "{fit:?}");
    let probability = f64::from(scene.lights.iter().find(|l| l.triangle == NONE).unwrap().pdf_light_choice);
    let error = (probability * (1.0 - probability) / f64::from(SAMPLES)).sqrt();
    assert!((f64::from(to_points) / f64::from(SAMPLES) - probability).abs() < 4.0 * error);
}

/// Light samples give the known irradiance of an emitter overhead, in units of its radiance. Near the emitter they
/// leave only the noise of the cosine and of the choice between its triangles. Samples by area would deviate by 6.6 at
/// the lowest emitter.
#[test]
fn light_samples_of_a_near_area_light_have_bounded_deviation() {
    for (height, max_deviation) in [(0.05, 1.1), (0.4, 0.8), (0.9, 0.5), (8.0, 0.1)] {
        let mut b = Builder::default();
        let light = b.material(emitter(1.0));
        b.panel(light, DVec3::new(0.3, height, 0.2), 0.5 * DVec3::X, 0.5 * DVec3::Z);
        b.camera(DVec3::ZERO, DVec3::Z, 1.0);
        let scene = b.build();
        let world = World::new(&scene, &Default::default());
        let irradiance = |path| {
            let u = Rng::new(Stream::Camera, 12, path, 0).next4();
            let c = LightCandidates::ONE.sample_light(0, world.tables(), 2, world.features, Vec3::ZERO, u);
            f64::from(c.radiance_over_pdf.x * c.to_light.y)
        };
        let found: Vec<f64> = (0..SAMPLES).map(irradiance).collect();
        let (mean, error) = mean_and_error(&found);
        // By the edges of the emitter [Lambert 1760].
        let corner = |x: f64, z: f64| DVec3::new(x, height, z).normalize();
        let corners = [corner(-0.2, -0.3), corner(-0.2, 0.7), corner(0.8, 0.7), corner(0.8, -0.3)];
        let edge = |i: usize| {
            let (from, to) = (corners[i], corners[(i + 1) % 4]);
            0.5 * from.cross(to).normalize().y * from.angle_between(to)
        };
        let expected = (0..4).map(edge).sum::<f64>().abs();
        let deviation = error * f64::from(SAMPLES).sqrt() / mean;
        println!("{height} m: {mean:.5} +- {error:.5}, known {expected:.5}; deviation {deviation:.3}");
        assert!((mean - expected).abs() < 4.0 * error + 1.0e-5 * expected);
        assert!(deviation < max_deviation, "{height} m: {deviation}");
    }
}

/// A room with lamps, a point light, a spot light and a sun. Lights of the light BVH are sampled with their probability, which adds
/// up to one over all lights with a place. On average over positions it follows their light more closely than their power does.
#[test]
fn lights_of_the_light_bvh_follow_their_probability() {
    let mut b = room_of_lights(20);
    b.light(DVec3::new(0.3, -0.2, 0.4), 0.5);
    b.spot(DVec3::new(0.0, 0.9, 0.0), -DVec3::Y, 0.2, 0.5, 2.0);
    b.directional(-DVec3::Y, 1.0);
    let scene = b.build();
    let world = World::new(&scene, &Default::default());
    let count = scene.lights.len() as u32;
    assert_eq!(count, 43);
    let bvh = LightBvh { nodes: &scene.light_bvh, light_count: count };
    let probabilities_at = |position: Vec3| -> Vec<f64> {
        (0..count).map(|light_id| f64::from(bvh.probability(position, light_id))).collect()
    };
    // Irradiance of a light at normal incidence, without occluders.
    let each = LightCandidates { is_all: true, ..LightCandidates::ONE };
    let irradiance = |light_id: u32, position: Vec3| {
        let sample = |path| {
            let u = Rng::new(Stream::Camera, 14, path, 0).next4();
            let sample = each.sample_light(light_id, world.tables(), count, world.features, position, u);
            f64::from(sample.radiance_over_pdf.element_sum() / 3.0)
        };
        let by_power = f64::from(scene.lights[light_id as usize].pdf_light_choice);
        (0..100).map(sample).sum::<f64>() / 100.0 * by_power
    };
    let mut ratios = vec![];
    for position in [Vec3::ZERO, Vec3::new(0.6, 0.85, 0.1), Vec3::new(-0.3, -0.9, 0.8)] {
        let probabilities = probabilities_at(position);
        let sum: f64 = probabilities.iter().sum();
        assert!((sum - 1.0).abs() < 1e-5, "{position}: {sum}");
        let mut seen = vec![0; count as usize];
        let samples = SAMPLES / 4;
        for path in 0..samples {
            let sampled = bvh.sample(position, Rng::new(Stream::Camera, 13, path, 0).next4().x);
            let expected = probabilities[sampled.light_id as usize];
            assert!((f64::from(sampled.probability) / expected - 1.0).abs() < 1e-5);
            seen[sampled.light_id as usize] += 1;
        }
        let fit = |probabilities: &[f64]| {
            let expected: Vec<f64> = probabilities.iter().map(|p| p * f64::from(samples)).collect();
            Fit::new(&seen, &expected)
        };
        assert!(fit(&probabilities).passes(), "{position}: {:?}", fit(&probabilities));
        assert!(!fit(&probabilities_at(position + 0.1 * Vec3::X)).passes(), "positions do not matter");

        // Second moment of a light's irradiance over its probability
        let (mut by_bvh, mut by_power, mut power) = (0.0, 0.0, 0.0);
        for (light_id, light) in scene.lights.iter().enumerate() {
            let probability = probabilities[light_id];
            if light.is_endless() {
                assert_eq!(probability, 0.0, "the sun has no place");
                continue;
            }
            let square = irradiance(light_id as u32, position).powi(2);
            assert!(square == 0.0 || probability > 0.0, "light {light_id} shines to {position}");
            by_bvh += if square > 0.0 { square / probability } else { 0.0 };
            by_power += square / f64::from(light.pdf_light_choice);
            power += f64::from(light.pdf_light_choice);
        }
        println!("{position}: second moment {by_bvh:.3}, by power {:.3}", by_power * power);
        ratios.push(by_bvh / (by_power * power));
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!(mean < 0.6, "{ratios:?}");
}

/// Density of light sampling along a direction from the origin.
fn density(world: &World<'_>, direction: Vec3) -> f32 {
    let hit = world.tracer().closest(&Ray::endless(Vec3::ZERO, direction));
    if hit.is_miss() {
        return 0.0;
    }
    let light = world.scene.lights[world.scene.surfaces[hit.triangle as usize].light as usize];
    let t = world.scene.triangles[hit.triangle as usize];
    let cos = -direction.dot((t.b - t.a).cross(t.c - t.a).normalize());
    if cos < 0.0 && light.sides != 2 {
        return 0.0;
    }
    pdf_solid_angle(
        &light,
        world.tables(),
        caustics_kernels::interface::features::Features::ALL,
        Vec3::ZERO,
        hit.distance * hit.distance,
        cos,
    )
}

/// Starts fall into lights by their power, and evenly into the quarters of a triangle and into cells of cos^2. Each
/// carries the whole flux of the scene in the mean of its channels.
#[test]
fn emission_by_power_follows_power_area_and_cosine() {
    let scene = scene_of_lights().build();
    let world = World::new(&scene, &Default::default());
    let emit = world.by_power();
    let count = scene.lights.len();
    let mut seen = vec![0; count * 16];
    for path in 0..SAMPLES {
        let mut rng = Rng::new(Stream::Light, 11, path, 0);
        let emission = emit.sample(&mut rng);
        let (origin, to) = (emission.ray.origin, emission.ray.direction);
        let on = |t: &caustics_kernels::interface::triangle::Triangle| {
            let n = (t.b - t.a).cross(t.c - t.a);
            let p = origin - t.a;
            let b = n.dot(p.cross(t.c - t.a)) / n.length_squared();
            let c = n.dot((t.b - t.a).cross(p)) / n.length_squared();
            let height = p.dot(n.normalize());
            (height.abs() < 1e-4 && b.min(c) > -1e-4 && b + c < 1.0 + 1e-4).then_some((b, c, height, n))
        };
        let found = scene.lights.iter().enumerate().find_map(|(id, light)| match light.triangle {
            NONE => None,
            triangle => on(&scene.triangles[triangle as usize]).map(|at| (id, at)),
        });
        let cell = match found {
            Some((id, (b, c, height, normal))) => {
                let quarter = [b > 0.5, c > 0.5, b + c < 0.5].iter().position(|&q| q).unwrap_or(3);
                let cos = to.dot(normal.normalize()) * height.signum();
                assert!(cos > 0.0, "starts into its own light");
                id * 16 + quarter * 4 + ((cos * cos * 4.0) as usize).min(3)
            }
            None => {
                let id = scene.lights.iter().position(|light| light.triangle == NONE).unwrap();
                // Uniform: sixteen cells of z.
                id * 16 + ((to.z * 0.5 + 0.5) * 16.0).min(15.0) as usize
            }
        };
        seen[cell] += 1;
        let whole = scene.flux.element_sum();
        assert!((emission.flux.element_sum() - whole).abs() < 1e-4 * whole);
    }
    let expected: Vec<f64> = (0..count * 16)
        .map(|cell| f64::from(scene.lights[cell / 16].pdf_light_choice) * f64::from(SAMPLES) / 16.0)
        .collect();
    let fit = Fit::new(&seen, &expected);
    println!("starts: {:.0} of {}", fit.chi_square, fit.cells);
    assert!(fit.passes(), "{fit:?}");
    let power = |l: &caustics_kernels::interface::light::Light| match l.triangle {
        NONE => 4.0 * PI * l.emission.element_sum(),
        _ => PI * l.area * l.sides as f32 * l.emission.element_sum(),
    };
    for light in &scene.lights {
        assert!((power(light) / scene.flux.element_sum() / light.pdf_light_choice - 1.0).abs() < 1e-4);
    }
}
