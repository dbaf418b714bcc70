//! `progressive` converges: the error of the caustic layer falls as N^(-2/3), that of the path layer as 1/N.
//!
//! A point light beside a plane mirror: the caustic on the floor is that of a virtual light behind the mirror, known in
//! closed form. Paths have at most two bounces, so that the caustic layer holds nothing else; the light of the walls is
//! in the path layer.

use caustics::render_config::{Paths, Radius};
use std::f64::consts::PI;
use std::fmt::Write;

use caustics::accumulation::Accumulation;
use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::interface::choice::PixelFilter;
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use plotters::prelude::*;

const WIDTH: u32 = 32;
const HEIGHT: u32 = 24;
const LIGHT: DVec3 = DVec3::new(0.2, 0.5, 0.1);
const INTENSITY: f32 = 2.0;
const MIRROR_X: f64 = -0.999;
const ALBEDO: f32 = 0.5;
const REFLECTANCE: f32 = 0.9;
const EYE: DVec3 = DVec3::new(0.2, 0.9, 0.0);
const FOV: f32 = 0.4;

fn scene() -> Scene {
    let mut b = Builder::default();
    let (wall, mirror) = (b.material(lambert(ALBEDO)), b.material(metal(REFLECTANCE, 0.0)));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(mirror, DVec3::X * MIRROR_X, 0.99 * DVec3::NEG_Z, 0.99 * DVec3::Y);
    b.light(LIGHT, INTENSITY);
    b.camera(EYE, EYE.with_y(-1.0), FOV);
    b.build()
}

fn config(light_paths: u32, seed: u32) -> RenderConfig {
    RenderConfig {
        width: WIDTH,
        height: HEIGHT,
        light_paths: Paths::Count(light_paths),
        max_bounces: 2,
        radius: Radius::Px(8.0),
        pixel_filter: PixelFilter::Box,
        seed,
        ..RenderConfig::default()
    }
}

/// Caustic radiance at the middle of each pixel: Lambert's law for the light's virtual image in the mirror.
fn virtual_light() -> Vec<f64> {
    let virtual_image = DVec3::new(2.0 * MIRROR_X - LIGHT.x, LIGHT.y, LIGHT.z);
    // The camera looks straight down with z upwards in the image. Whether x points left or right follows from the
    // scene's camera.
    let camera = &scene().cameras[0];
    let (right, up) = (camera.right.as_dvec3(), camera.up.as_dvec3());
    let half = 1.9 * f64::from(FOV / 2.0).tan();
    let at = |x: u32, y: u32| {
        let across = (2.0 * (f64::from(x) + 0.5) / f64::from(WIDTH) - 1.0) * half * f64::from(WIDTH)
            / f64::from(HEIGHT);
        let along = (1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(HEIGHT)) * half;
        EYE.with_y(-1.0) + across * right + along * up
    };
    let radiance = |position: DVec3| {
        let to_virtual_image = virtual_image - position;
        let distance = to_virtual_image.length();
        // Schlick's reflectance of the mirror, whose normal is x.
        let cos = -to_virtual_image.x / distance;
        let f0 = f64::from(REFLECTANCE);
        let reflectance = f0 + (1.0 - f0) * (1.0 - cos).powi(5);
        let irradiance =
            reflectance * f64::from(INTENSITY) * (to_virtual_image.y / distance) / distance.powi(2);
        irradiance * f64::from(ALBEDO) / PI
    };
    (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).map(|(x, y)| radiance(at(x, y))).collect()
}

fn mean_square(layer: &[Vec3], reference: &[f64]) -> f64 {
    let squares =
        layer.iter().zip(reference).map(|(value, reference)| (f64::from(value.x) / reference - 1.0).powi(2));
    squares.sum::<f64>() / reference.len() as f64
}

/// Renders up to `frames` frames, and passes the mean to `look` at every power of two.
fn progressive(scene: &Scene, config: &RenderConfig, frames: u32, mut look: impl FnMut(u32, &Accumulation)) {
    let features = scene.features(config.specular_roughness);
    let (choice, camera) = (RunnerChoice::Cpu { threads: 0 }, &scene.cameras[0]);
    let mut session = Session::new(
        &choice,
        scene,
        camera,
        &RenderConfig { method: &PROGRESSIVE, ..config.clone() },
        features,
    )
    .unwrap();
    let mut sums = Accumulation::default();
    for frame in 0..frames {
        session.frame(frame).unwrap();
        sums.add(&session.image().unwrap());
        if sums.frames().is_power_of_two() {
            look(sums.frames(), &sums);
        }
    }
}

/// Slope of the regression of ln y on ln x.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let (x, y) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    covariance / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// Plots both layers over the number of frames, with the expected lines.
fn plot(
    file: &std::path::Path,
    caustics: &[(f64, f64)],
    path: &[(f64, f64)],
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::new(file, (720, 480)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(16)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .caption("progressive: error of the mean of N frames", ("sans-serif", 20))
        .build_cartesian_2d((7.0..1200.0).log_scale(), (1e-4..1e-1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("frames N")
        .y_desc("relative mean squared error")
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .draw()?;
    for (points, exponent, color, name) in
        [(caustics, -2.0 / 3.0, RED, "caustics; line N^(-2/3)"), (path, -1.0, BLUE, "path; line N^(-1)")]
    {
        let (first, error) = points[0];
        let line = points.iter().map(|&(n, _)| (n, error * (n / first).powf(exponent)));
        chart.draw_series(LineSeries::new(line, color.mix(0.4)))?;
        chart
            .draw_series(points.iter().map(|&point| Circle::new(point, 4, color.filled())))?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 8, y), 4, color.filled()));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .border_style(BLACK)
        .background_style(WHITE)
        .draw()?;
    root.present()?;
    Ok(())
}

#[test]
fn regression_slope_of_a_power_law_is_its_exponent() {
    let power =
        |exponent: f64| (1..9).map(|i| (f64::from(i), 3.0 * f64::from(i).powf(exponent))).collect::<Vec<_>>();
    assert!((slope(&power(-0.7)) + 0.7).abs() < 1e-12);
    assert!((slope(&power(-0.5)) + 2.0 / 3.0).abs() > 0.1, "a slope of -0.5 passes as -2/3");
}

mod long {
    use super::*;

    #[test]
    #[ignore = "20,000 small frames: a minute on two cores"]
    fn progressive_error_falls_as_n_to_minus_2_3_in_caustics_and_minus_1_in_paths() {
        let scene = scene();
        let caustic_reference = virtual_light();
        let mut path_reference = Vec::new();
        // Camera paths alone find this layer.
        progressive(&scene, &config(1, 99), 16_384, |frames, sums| {
            if frames == 16_384 {
                path_reference = sums.mean().path.iter().map(|value| f64::from(value.x)).collect();
            }
        });
        let runs = 4;
        let mut errors = vec![(0.0, 0.0); 11];
        for seed in 0..runs {
            progressive(&scene, &config(20_000, seed), 1024, |frames, sums| {
                let mean = sums.mean();
                let error = &mut errors[frames.trailing_zeros() as usize];
                error.0 += mean_square(&mean.caustics, &caustic_reference) / f64::from(runs);
                error.1 += mean_square(&mean.path, &path_reference) / f64::from(runs);
            });
        }
        let mut table = String::from("frames,caustics_relmse,path_relmse\n");
        let (mut caustics, mut path) = (Vec::new(), Vec::new());
        for (power, (caustic_error, path_error)) in errors.into_iter().enumerate().skip(3) {
            let frames = f64::from(1 << power);
            writeln!(table, "{frames},{caustic_error:.4e},{path_error:.4e}").unwrap();
            caustics.push((frames, caustic_error));
            path.push((frames, path_error));
        }
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
        plot(&folder.join("convergence.svg"), &caustics, &path).unwrap();
        let (caustics, path) = (slope(&caustics), slope(&path));
        println!(
            "{table}caustics fall as N^{caustics:.3}, path as N^{path:.3}; plot in {}",
            folder.display()
        );
        std::fs::write(folder.join("convergence.csv"), table).unwrap();
        assert!((caustics + 2.0 / 3.0).abs() <= 0.1, "{caustics}");
        assert!((path + 1.0).abs() <= 0.1, "{path}");
    }
}
