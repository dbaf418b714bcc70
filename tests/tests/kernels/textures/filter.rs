//! Two filters of a texture in a pixel: the mean of its lit texels, or the lighting of its mean texel.

use caustics::image_file::Encoding;
use caustics::metric::flip_ldr::flip_ldr;
use caustics::metric::pixels::Pixels;
use caustics::render_config::RenderConfig;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::interface::choice::{PixelFilter, TextureFilter};
use caustics_kernels::method::path::PATH;
use caustics_tests::scenes::committed;
use glam::DVec3;

/// Size of the image (px), and the factor by which the reference is larger each way.
const WIDTH: usize = 96;
const HEIGHT: usize = 54;
const FINER: usize = 8;

/// `textured-room` under direct light alone, which takes few samples: the mean of `samples` per pixel.
fn render(texture_filter: TextureFilter, scale: usize, samples: u32, seed: u32) -> Pixels {
    let (width, height) = (scale * WIDTH, scale * HEIGHT);
    let config = RenderConfig {
        width: width as u32,
        height: height as u32,
        max_bounces: 1,
        pixel_filter: PixelFilter::Box,
        texture_filter: Some(texture_filter),
        seed,
        ..RenderConfig::default()
    };
    let (choice, scene) = (RunnerChoice::Cpu { threads: 0 }, committed("textured-room"));
    let features = scene.features(config.specular_roughness);
    let mut session = Session::new(
        &choice,
        &scene,
        &scene.cameras[0],
        &RenderConfig { method: &PATH, ..config.clone() },
        features,
    )
    .unwrap();
    let mut values = vec![DVec3::ZERO; WIDTH * HEIGHT];
    let share = 1.0 / (f64::from(samples) * (scale * scale) as f64);
    for sample in 0..samples {
        session.frame(sample).unwrap();
        for (pixel, radiance) in session.image().unwrap().path.iter().enumerate() {
            let (x, y) = (pixel % width / scale, pixel / width / scale);
            values[y * WIDTH + x] += radiance.as_dvec3() * share;
        }
    }
    Pixels { width: WIDTH, height: HEIGHT, values }
}

/// The finest level under many rays matches the image of eight times the size, averaged. There even a cone is an eighth
/// as wide, so that the reference does not depend on the filter under test. The level of the cone gives another image.
#[test]
fn finest_level_matches_8_times_supersampling_and_ray_cone_level_does_not() {
    let reference = render(TextureFilter::Cone, FINER, 4, 1);
    let compare = |filter, seed| {
        let image = render(filter, 1, 256, seed);
        let ratio = image.values.iter().sum::<DVec3>() / reference.values.iter().sum::<DVec3>();
        let flip = flip_ldr(&image, &reference, Encoding::Linear, 0.0, 67.0).mean();
        println!("{}: energy {ratio:.4}, FLIP {flip:.4}", filter.name());
        (ratio, flip)
    };
    let (finest, cone) = (compare(TextureFilter::Finest, 2), compare(TextureFilter::Cone, 3));
    // Rare paths find the light by the polished panel. 1.3 million leave 0.8 % of noise in a channel, and most of the
    // remaining FLIP of 0.04. The cone's FLIP is 0.066.
    assert!((finest.0 - 1.0).abs().max_element() < 0.02, "{}", finest.0);
    assert!(cone.1 > 1.4 * finest.1, "{} {}", cone.1, finest.1);
}
