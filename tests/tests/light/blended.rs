//! Caustics on blended surfaces: alpha counts once.

use caustics::render_config::{Paths, RenderConfig};
use caustics::session::Session;
use caustics_kernels::emission::POWER;
use caustics_kernels::interface::choice::PixelFilter;
use caustics_kernels::interface::material::Material;
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};

/// Caustics in eight frames of a floor beside a mirror, with this share of the floor there.
fn caustics(share: f32, seed: u32) -> f64 {
    let mut b = Builder::default();
    let floor = b.textured(lambert(0.5), veil(share));
    let mirror = b.material(metal(1.0, 0.0));
    let lamp = b.material(Material { emission: Vec3::splat(10.0), ..emitter(0.0) });
    b.panel(floor, DVec3::ZERO, DVec3::Z, DVec3::X);
    b.panel(mirror, DVec3::new(-1.0, 1.0, 0.0), -DVec3::Z, DVec3::Y);
    b.panel(lamp, DVec3::new(0.9, 1.0, 0.0), 0.1 * DVec3::Z, 0.1 * DVec3::Y);
    b.camera(DVec3::new(0.0, 2.5, 0.1), DVec3::ZERO, 0.6);
    let config = RenderConfig {
        width: 32,
        height: 32,
        seed,
        light_paths: Paths::Count(100_000),
        emission: &POWER,
        pixel_filter: PixelFilter::Box,
        ..RenderConfig::default()
    };
    let mut session = Session::builder(&b.build()).config(config).build().expect("a session");
    let mut sum = 0.0;
    for frame in 0..8 {
        session.frame(frame).expect("a frame");
        let image = session.image().expect("an image");
        sum += image.caustics.iter().map(|light| f64::from(light.element_sum())).sum::<f64>();
    }
    sum
}

#[test]
fn a_caustic_on_a_blended_floor_is_as_bright_as_its_alpha() {
    for share in [0.5, 0.2] {
        let ratios: Vec<f64> =
            (0..6).map(|seed| caustics(share, seed) / caustics(1.0, seed) / f64::from(share)).collect();
        let ratio = Mean::from_samples(&ratios);
        println!("alpha {share}: {ratio:?}");
        assert!((ratio.value - 1.0).abs() < 0.05 && ratio.error < 0.02, "alpha {share}: {ratio:?}");
    }
}
