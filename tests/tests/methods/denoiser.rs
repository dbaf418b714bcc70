//! The denoiser of path-traced light: what it keeps, what it mixes, and the edges that it must respect.

use bytemuck::cast_slice;
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::texture::Role;
use caustics::session::{self, RunnerChoice, Session};
use caustics_kernels::declare::{Step, buffers};
use caustics_kernels::denoiser::{self, ATROUS};
use caustics_kernels::interface::material::{FLAG_COLOR_TEXTURE, Material};
use caustics_kernels::interface::packed::to_half;
use caustics_kernels::interface::point::{PointGeometry, PointShading};
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::pass::collect::COLLECT;
use caustics_tests::compare::{Tolerance, floats};
use caustics_tests::gpu::watched_gpu;
use caustics_tests::parity::{self, RunnerPair, load};
use caustics_tests::scenes::{Builder, lambert};
use caustics_tests::table::Table;
use glam::{DVec3, Vec3};

/// Pixel pitch of a plane seen from the front: 1.77 radii, the side of a square with the area of a disc.
const PITCH: f32 = 1.772_453_9;
/// Material with a textured base colour; materials before it are plain.
const TEXTURED: u32 = 2;

/// Input of the filter.
#[derive(Clone)]
struct Input {
    width: u32,
    height: u32,
    radiance: Vec<Vec3>,
    prefix: Vec<Vec3>,
    geometry: Vec<PointGeometry>,
    shading: Vec<PointShading>,
    /// One plus the relative variance of each pixel, as a history knows it; 0 without a history.
    noise: f32,
}

impl Input {
    /// A plane of one material under light of this brightness.
    fn plane(width: u32, height: u32, light: impl Fn(u32, u32) -> f32) -> Input {
        let pixels: Vec<_> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
        let geometry = |&(x, y): &(u32, u32)| PointGeometry {
            position: Vec3::new(x as f32 * PITCH, y as f32 * PITCH, 0.0),
            radius: 1.0,
            normal: Vec3::Z,
            depth: 1,
        };
        let shading = PointShading { throughput: Vec3::ONE, to_viewer: Vec3::Z, ..PointShading::default() };
        Input {
            width,
            height,
            radiance: pixels.iter().map(|&(x, y)| Vec3::new(1.0, 0.5, 0.25) * light(x, y)).collect(),
            prefix: vec![Vec3::ZERO; pixels.len()],
            geometry: pixels.iter().map(geometry).collect(),
            shading: vec![shading; pixels.len()],
            noise: 0.0,
        }
    }

    /// A plane whose right half differs, lit on the left.
    fn halves(change: impl Fn(&mut PointGeometry, &mut PointShading)) -> Input {
        let mut input = Input::plane(64, 32, |x, _| if x < 32 { 1.0 } else { 0.0 });
        for pixel in (0..64 * 32).filter(|pixel| pixel % 64 >= 32) {
            change(&mut input.geometry[pixel], &mut input.shading[pixel]);
        }
        input
    }

    /// Share of the light that reached the right half.
    fn crossed(&self) -> f64 {
        let filtered = self.filtered();
        let right = filtered.iter().enumerate().filter(|(pixel, _)| pixel % 64 >= 32);
        right.map(|(_, light)| f64::from(light.x)).sum::<f64>() / energy(&filtered, 0)
    }

    /// Random input of all kinds: light of a few bright samples, bumps, materials, textures, throughputs, gaps.
    fn noisy(width: u32, height: u32, seed: u32) -> Input {
        let mut input = Input::plane(width, height, |_, _| 0.0);
        for pixel in 0..input.radiance.len() {
            let mut rng = Rng::new(Stream::Camera, seed, pixel as u32, 0);
            let (a, b, c) = (rng.next4(), rng.next4(), rng.next4());
            input.prefix[pixel] = Vec3::new(a.x, a.y, 0.0) * 0.3;
            let bright = if a.w < 0.01 { 1000.0 } else { 1.0 };
            input.radiance[pixel] = input.prefix[pixel] + Vec3::new(a.y, a.z, a.x * 0.01) * bright;
            let geometry = &mut input.geometry[pixel];
            geometry.position.z = b.x;
            geometry.radius = 0.5 + b.y;
            geometry.normal = (Vec3::Z + Vec3::new(b.z, b.w, 0.0) * 0.3).normalize();
            geometry.depth = if c.x < 0.1 { 0 } else { 1 + u32::from(c.x > 0.6) };
            let shading = &mut input.shading[pixel];
            shading.throughput = Vec3::new(0.1 + c.y, 0.5, c.z * c.z);
            shading.material = (c.w * 3.0) as u32;
            shading.red_green = to_half(c.y) | to_half(c.z) << 16;
            shading.blue_roughness_metallic = to_half(b.z);
        }
        input
    }

    fn config(&self) -> RenderConfig {
        RenderConfig { width: self.width, height: self.height, denoiser: &ATROUS, ..RenderConfig::default() }
    }

    fn filtered(&self) -> Vec<Vec3> {
        self.filtered_by(&RunnerChoice::Cpu { threads: 2 })
    }

    fn filtered_by(&self, choice: &RunnerChoice) -> Vec<Vec3> {
        let mut builder = Builder::default();
        builder.material(lambert(0.5));
        builder.material(lambert(0.5));
        let base_color = builder.texture(Role::Color, 1, 1, |_, _| [255; 4]);
        let flags = FLAG_COLOR_TEXTURE;
        let id = builder.textured(
            Material { flags, ..lambert(1.0) },
            MaterialTextures { base_color, ..MaterialTextures::default() },
        );
        assert_eq!(id, TEXTURED);
        builder.panel(0, DVec3::ZERO, DVec3::X, DVec3::Y);
        builder.panel(TEXTURED, DVec3::Z, DVec3::X, DVec3::Y);
        builder.camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, 0.7);
        let scene = builder.build();
        let config = self.config();
        let params = config.params(&scene, &scene.cameras[0], 0);
        let mut steps = (ATROUS.steps)(&params);
        let denoisers = steps.len();
        steps.push(Step::new(&COLLECT, &params));
        let buffers = buffers(&steps, &params);
        let mut runner = session::open(choice, &scene, scene.features(0.25), &buffers).unwrap();
        runner.write("path_radiance", cast_slice(&self.radiance)).unwrap();
        runner.write("prefix_radiance", cast_slice(&self.prefix)).unwrap();
        runner.write("point_geometry", cast_slice(&self.geometry)).unwrap();
        runner.write("point_shading", cast_slice(&self.shading)).unwrap();
        runner.write("path_noise", cast_slice(&vec![self.noise; self.radiance.len()])).unwrap();
        runner.run(&params, &steps[..denoisers]).unwrap();
        parity::records(&mut *runner, "path_radiance")
    }
}

/// Sum of a channel.
fn energy(image: &[Vec3], channel: usize) -> f64 {
    image.iter().map(|pixel| f64::from(pixel[channel])).sum()
}

/// Asserts that both have the same sum in every channel. A pixel's rounding is 9 halves of an ulp per level, and the
/// roundings of many pixels cancel.
fn assert_energy_stays(before: &[Vec3], after: &[Vec3]) {
    for channel in 0..3 {
        let (before, after) = (energy(before, channel), energy(after, channel));
        assert!(
            (before - after).abs() <= 1.0e-6 * before.abs(),
            "channel {channel}: {before} became {after}"
        );
    }
}

#[test]
fn denoiser_keeps_energy_to_1e_6() {
    for (width, height) in [(1, 1), (17, 9), (3, 200), (128, 96)] {
        let input = Input::noisy(width, height, 5);
        let filtered = input.filtered();
        assert_energy_stays(&input.radiance, &filtered);
        assert!(filtered.iter().all(|light| light.min_element() >= 0.0), "{width}x{height}");
        assert!(width < 17 || filtered != input.radiance, "nothing was filtered");
    }
}

#[test]
fn denoiser_keeps_even_light_to_the_bit() {
    for (width, height) in [(1, 1), (17, 9), (100, 50)] {
        let input = Input::plane(width, height, |_, _| 3.0);
        for (before, after) in input.radiance.iter().zip(input.filtered()) {
            // All exchanges are exactly 0.
            assert_eq!(*before, after);
        }
    }
}

/// The filter does not smear the detail of a mirror's throughput or of a texture in even light.
#[test]
fn denoiser_keeps_textures_and_throughputs_to_1e_5() {
    let mut input = Input::plane(64, 48, |_, _| 0.0);
    for pixel in 0..input.radiance.len() {
        let u = Rng::new(Stream::Camera, 1, pixel as u32, 0).next4();
        let shading = &mut input.shading[pixel];
        shading.material = TEXTURED;
        shading.throughput = Vec3::splat(0.1 + u.x);
        // Quarters are exact as half floats.
        let red = (u.y * 4.0).ceil() / 4.0;
        shading.red_green = to_half(red) | to_half(1.0) << 16;
        shading.blue_roughness_metallic = to_half(0.5);
        input.radiance[pixel] = shading.throughput * Vec3::new(red, 1.0, 0.5);
        input.prefix[pixel] = Vec3::ZERO;
    }
    for (before, after) in input.radiance.iter().zip(input.filtered()) {
        assert!((*before - after).abs().max_element() <= 1.0e-5, "{before} became {after}");
    }
}

/// Compares each edge with a pair of the same kind that must mix.
#[test]
fn denoiser_moves_no_light_across_an_edge() {
    let tilted = |degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        move |geometry: &mut PointGeometry, _: &mut PointShading| {
            let along = geometry.position.x - 31.5 * PITCH;
            geometry.position.x = 31.5 * PITCH + along * cos;
            geometry.position.z = -along * sin;
            geometry.normal = Vec3::new(sin, 0.0, cos);
        }
    };
    let behind =
        |radii: f32| move |geometry: &mut PointGeometry, _: &mut PointShading| geometry.position.z = radii;
    let edges = [
        ("material", Input::halves(|_, shading| shading.material = 1)),
        ("corner", Input::halves(tilted(90.0))),
        ("roof of 120 degrees", Input::halves(tilted(60.0))),
        ("behind", Input::halves(behind(-8.0))),
        ("in front", Input::halves(behind(8.0))),
        ("mirror's border", Input::halves(|geometry, _| geometry.depth = 2)),
        ("instance", Input::halves(|_, shading| shading.instance = 1)),
        ("no point", Input::halves(|geometry, _| geometry.depth = 0)),
    ];
    for (name, input) in edges {
        let crossed = input.crossed();
        // cos^64 of 60 degrees is 5e-20; everything else is an exact 0.
        assert!(crossed <= 1.0e-18, "{crossed} of the light crosses: {name}");
    }
    // Differences on both sides make no edge.
    let even = |change: fn(&mut PointGeometry, &mut PointShading)| {
        let mut input = Input::halves(|_, _| ());
        input
            .geometry
            .iter_mut()
            .zip(&mut input.shading)
            .for_each(|(geometry, shading)| change(geometry, shading));
        input
    };
    let mixed = [
        ("plane", Input::halves(|_, _| ())),
        ("one material", even(|_, shading| shading.material = 1)),
        ("3 degrees", Input::halves(tilted(3.0))),
        ("a tenth of a radius behind", Input::halves(behind(-0.1))),
        ("behind one mirror", even(|geometry, _| geometry.depth = 2)),
        ("one instance", even(|_, shading| shading.instance = 1)),
    ];
    for (name, input) in mixed {
        let crossed = input.crossed();
        assert!(crossed > 0.005, "only {crossed} of the light crosses: {name}");
    }
}

#[test]
fn denoiser_keeps_the_radiance_of_prefixes_to_the_bit() {
    let mut input = Input::plane(33, 21, |_, _| 1.0);
    for (pixel, prefix) in input.prefix.iter_mut().enumerate() {
        *prefix = if pixel % 7 == 0 { Vec3::splat(16.0) } else { Vec3::ZERO };
        input.radiance[pixel] += *prefix;
    }
    for (before, after) in input.radiance.iter().zip(input.filtered()) {
        assert_eq!(*before, after);
    }
}

/// Little light crosses a shadow's edge, where brightness alone differs.
#[test]
fn denoiser_blurs_shadow_edges_by_less_than_10_pixels() {
    let input = Input::plane(128, 64, |x, _| if x < 64 { 1.0 } else { 0.02 });
    let filtered = input.filtered();
    let row = &filtered[32 * 128..33 * 128];
    assert!(row[64 + 10].x < 0.1 && row[63 - 10].x > 0.9, "{} and {}", row[74].x, row[53].x);
    assert_energy_stays(&input.radiance, &filtered);
}

/// Light that a long history knows to have no noise stays as it is, to the bit; noise is spread.
#[test]
fn denoiser_keeps_shadow_edges_without_noise_to_the_bit() {
    let shadow = Input::plane(128, 64, |x, _| if x < 64 { 1.0 } else { 0.02 });
    let known = Input { noise: 1.0, ..shadow.clone() };
    assert_eq!(known.filtered(), shadow.radiance);
    let blurred = Input { noise: 1.0e6, ..shadow };
    assert!(blurred.filtered()[32 * 128 + 70].x > 0.1);
}

/// A sample 10^4 times as bright as the rest is spread without loss.
#[test]
fn denoiser_lowers_a_firefly_to_3_percent_and_keeps_its_energy() {
    let input = Input::plane(65, 65, |x, y| if (x, y) == (32, 32) { 1.0e4 } else { 1.0 });
    let filtered = input.filtered();
    assert_energy_stays(&input.radiance, &filtered);
    let peak = filtered.iter().fold(0.0f32, |largest, light| largest.max(light.x));
    // The first level, which compares nothing, leaves a quarter; the others see its variance.
    assert!(peak < 0.03 * 1.0e4, "{peak}");
}

/// Weights of the filter of five levels along one axis.
fn theory() -> Vec<f64> {
    let spline = [0.25, 0.5, 0.25];
    (0..5).fold(vec![1.0], |weights, level| {
        let mut wider = vec![0.0; weights.len() + (2 << level)];
        for (i, weight) in weights.iter().enumerate() {
            spline.iter().enumerate().for_each(|(k, share)| wider[i + (k << level)] += weight * share);
        }
        wider
    })
}

/// Faint noise on a plane is averaged with the weights of the a-trous kernel: its variance falls by the sum of their
/// squares.
#[test]
fn denoiser_lowers_variance_by_the_sum_of_squared_weights() {
    let one_axis: f64 = theory().iter().map(|weight| weight * weight).sum();
    let expected = one_axis * one_axis;
    let squares = |image: &[Vec3], mean: f64| {
        image.iter().map(|light| (f64::from(light.x) - mean).powi(2)).sum::<f64>()
    };
    // The response to one pixel gives the weights: 63 pixels wide. Brightness differs too little to stop the filter.
    let noisy = |input: Input| Input { noise: 1.0e6, ..input };
    let input = noisy(Input::plane(129, 129, |x, y| if (x, y) == (64, 64) { 1.125 } else { 1.0 }));
    let response = squares(&input.filtered(), 1.0) / squares(&input.radiance, 1.0);
    // Roundings at 1 are 6e-8, weights times 1/8 are 1e-4.
    assert!((response / expected - 1.0).abs() < 0.01, "{response}, expected {expected}");

    // Measure noise itself. Its average has about (2 sqrt(pi) 13)^2 = 46^2 pixels in common. So 32 frames of 128^2 are
    // 250 independent values: 9 %, four sigma.
    let (mut before, mut after) = (0.0, 0.0);
    let size = 128 + 2 * 62;
    for seed in 0..32 {
        let noise =
            |x: u32, y: u32| 1.0 + 0.02 * (Rng::new(Stream::Camera, seed, y * size + x, 0).next4().x - 0.5);
        let input = noisy(Input::plane(size, size, noise));
        let inner = |image: &[Vec3]| {
            let inside = |pixel: &usize| {
                [pixel % size as usize, pixel / size as usize].iter().all(|c| (62..190).contains(c))
            };
            (0..image.len()).filter(inside).map(|pixel| image[pixel]).collect::<Vec<_>>()
        };
        before += squares(&inner(&input.radiance), 1.0);
        after += squares(&inner(&input.filtered()), 1.0);
    }
    let measured = after / before;
    eprintln!("variance of noise: {measured:.3e}, of the response {response:.3e}, theory {expected:.3e}");
    assert!((measured / expected - 1.0).abs() < 0.4, "{measured}, expected {expected}");
}

#[test]
fn threads_change_no_bit_of_the_denoiser() {
    let input = Input::noisy(131, 77, 9);
    let one = input.filtered_by(&RunnerChoice::Cpu { threads: 1 });
    assert_eq!(one, input.filtered_by(&RunnerChoice::Cpu { threads: 3 }));
}

/// No direction of the image is special: an image upside down is filtered to the result upside down.
#[test]
fn denoiser_filters_an_image_upside_down_to_the_result_upside_down() {
    let input = Input::noisy(61, 45, 3);
    let mut turned = input.clone();
    turned.radiance.reverse();
    turned.prefix.reverse();
    turned.geometry.reverse();
    turned.shading.reverse();
    let mut back = turned.filtered();
    back.reverse();
    for (a, b) in input.filtered().iter().zip(&back) {
        // Sums of 9 in another order, five times.
        assert!((*a - *b).abs().max_element() <= 1.0e-5 * (1.0 + a.max_element()), "{a} and {b}");
    }
}

#[test]
fn denoiser_does_not_spread_non_finite_light() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut input = Input::plane(33, 17, |x, _| 1.0 + x as f32);
        let mut gap = input.clone();
        let at = 8 * 33 + 16;
        input.radiance[at].y = bad;
        gap.geometry[at].depth = 0;
        let (filtered, expected) = (input.filtered(), gap.filtered());
        for pixel in 0..filtered.len() {
            let original = if pixel == at { input.radiance[at] } else { expected[pixel] };
            assert_eq!(filtered[pixel].to_array().map(f32::to_bits), original.to_array().map(f32::to_bits));
        }
    }
}

/// Frames of a room: caustics keep their bits, path-traced light keeps its energy, and at least 40 % of its error goes.
#[test]
fn denoiser_keeps_the_energy_of_a_room_and_removes_40_percent_of_its_error() {
    let scene = load("mirror-room");
    let open = |denoiser| {
        let config = RenderConfig {
            width: 160,
            height: 90,
            light_paths: Paths::Count(20_000),
            denoiser,
            ..RenderConfig::default()
        };
        let (camera, features) = (&scene.cameras[0], scene.features(config.specular_roughness));
        let cpu = RunnerChoice::Cpu { threads: 0 };
        Session::new(&cpu, &scene, camera, &config, features).unwrap()
    };
    let frame = |session: &mut Session, index| {
        session.frame(index).unwrap();
        session.image().unwrap()
    };
    let mut plain = open(&denoiser::NONE);
    let mut reference = vec![Vec3::ZERO; 160 * 90];
    for index in 1..=100 {
        let image = frame(&mut plain, index);
        reference.iter_mut().zip(&image.path).for_each(|(mean, light)| *mean += *light / 100.0);
    }
    let (noisy, filtered) = (frame(&mut plain, 0), frame(&mut open(&ATROUS), 0));
    assert!(noisy.caustics == filtered.caustics && energy(&noisy.caustics, 0) > 0.0);
    assert_energy_stays(&noisy.path, &filtered.path);
    let error = |image: &[Vec3]| {
        image.iter().zip(&reference).map(|(a, b)| f64::from((*a - *b).abs().element_sum())).sum::<f64>()
    };
    let (before, after) = (error(&noisy.path), error(&filtered.path));
    eprintln!("mean absolute error: {:.3} of what it was", after / before);
    assert!(after < 0.6 * before, "{after} of {before}");
}

/// The features of a room, on the CPU and on the GPU.
#[test]
fn gpu_matches_cpu_on_denoised_features() {
    let Some(gpu) = watched_gpu() else { return };
    for &hardware in gpu.tracers() {
        let mut table = Table::new(&format!("filter, CPU against {} (hardware {hardware})", gpu.info.name));
        for name in ["mirror-room", "textured-room"] {
            let scene = load(name);
            let config = RenderConfig {
                width: 191,
                height: 107,
                light_paths: Paths::Count(1),
                ..RenderConfig::default()
            };
            let mut runners = RunnerPair::open(&gpu, hardware, &scene, &config);
            let params = runners.params;
            runners.cpu.run(&params, &[Step::new(&COLLECT, &params)]).unwrap();
            let filter = (ATROUS.steps)(&params);
            runners.copy_to_gpu(&filter);
            let (before, _) = runners.records::<f32>("path_radiance");
            runners.run(&params, &filter);
            let (cpu, gpu_records) = runners.records::<f32>("path_radiance");
            assert!(cpu != before, "nothing was filtered");
            let scale = cpu.iter().sum::<f32>() / cpu.len() as f32;
            let near =
                Tolerance::relative(1.0e-4, scale, "the parity rule: weights are smooth in their inputs");
            table.add(name, [floats("path_radiance", 3, &cpu, &gpu_records, near)]);
            // The comparer must reject the unfiltered input.
            assert!(!floats("unfiltered", 3, &before, &gpu_records, near).passes());
        }
        for (width, height) in [(1, 1), (17, 9), (131, 77)] {
            let input = Input::noisy(width, height, 11);
            let (cpu, gpu_records) = (input.filtered(), input.filtered_by(&gpu.choice(hardware)));
            let near = Tolerance::relative(1.0e-4, 1.0, "the parity rule");
            table.add(
                &format!("noise, {width}x{height}"),
                [floats("path_radiance", 3, cast_slice(&cpu), cast_slice(&gpu_records), near)],
            );
        }
        table.finish();
    }
}
