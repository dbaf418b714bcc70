//! Emission by power starves where casters are small in a light's reach. Aimed paths bring the same light, and enough
//! of them.

use std::f64::consts::PI;

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::Session;
use caustics_kernels::emission::{AIMED, Emission, GUIDED};
use caustics_kernels::light::aimed::Aimed;
use caustics_tests::direct::World;
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use glam::DVec3;

const PATHS: u32 = 20_000;

/// Photons of ten frames by power and aimed: their number, and their flux (W).
fn both(scene: &Scene) -> [(u32, Mean); 2] {
    let mut world = World::new(
        scene,
        &RenderConfig { light_paths: Paths::Count(PATHS), emission: &AIMED, ..RenderConfig::default() },
    );
    let mut measure = |is_aimed: bool| {
        let mut count = 0;
        let frame = |frame| {
            world.params.frame = frame;
            let power = world.by_power();
            let photons = if is_aimed { world.shoot(&Aimed { power }) } else { world.shoot(&power) };
            count += photons.len();
            photons.flux().map(|(_, flux)| flux).sum::<f64>()
        };
        let fluxes: Vec<f64> = (0..10).map(frame).collect();
        (count, Mean::from_samples(&fluxes))
    };
    [measure(false), measure(true)]
}

/// A glass ball over a floor of +- `reach` m, under a directional light.
fn under_the_sun(reach: f64) -> Scene {
    let mut b = Builder::default();
    let (floor, ball) = (b.material(lambert(0.6)), b.material(glass(1.5)));
    b.panel(floor, DVec3::ZERO, reach * DVec3::Z, reach * DVec3::X);
    b.sphere(ball, DVec3::new(0.0, 0.4, 0.0), 0.3, 48, 24);
    b.directional(DVec3::new(0.3, -1.0, 0.1), 2.0);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.9);
    b.build()
}

/// A floor a hundred times wider takes ten thousand times the sun's light: by power, next to no path meets the ball.
#[test]
fn aimed_emission_keeps_half_the_photons_over_a_floor_100_times_wider() {
    let [near, far] = [1.0, 100.0].map(|reach| both(&under_the_sun(reach)));
    println!(
        "small floor: power {:?}, aimed {:?}; wide floor: power {:?}, aimed {:?}",
        near[0], near[1], far[0], far[1]
    );
    assert!(far[0].0 < near[0].0 / 500, "the test has nothing to check");
    assert!(2 * far[1].0 > near[0].0 && 2 * far[1].0 > near[1].0);
    // All have the same light; a floor of 1 m loses light that leaves the ball at a slant.
    let [power, aimed] = [near[0].1, near[1].1];
    assert!(power.agrees(&aimed, 3.0) && aimed.error < 0.01 * aimed.value, "{power:?} {aimed:?}");
    let wide = far[1].1;
    assert!(
        wide.error < 0.02 * wide.value && (1.0..1.2).contains(&(wide.value / aimed.value)),
        "{wide:?} {aimed:?}"
    );
}

/// A ball of a hundredth of a room under a point light gets 7e-6 of the light, which arrives at nearly black walls.
#[test]
fn aimed_emission_reaches_a_ball_of_a_hundredth_of_the_room() {
    let mut b = Builder::default();
    let (wall, ball) = (b.material(lambert(0.01)), b.material(glass(1.5)));
    let (light, centre, radius) = (DVec3::new(0.0, 0.9, 0.0), DVec3::new(0.3, -0.9, 0.2), 0.01);
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, centre, radius, 64, 32);
    b.light(light, 1.0);
    b.camera(DVec3::new(0.0, 0.0, 0.9), DVec3::ZERO, 1.0);
    let [power, aimed] = both(&b.build());
    let cos = (1.0 - (radius / light.distance(centre)).powi(2)).sqrt();
    let expected = 2.0 * PI * (1.0 - cos) * 1.01;
    println!("power {power:?}, aimed {aimed:?}, expected {expected:e}");
    assert!(power.0 < 20 && aimed.0 > 100_000);
    // The silhouette of a ball of 64 x 32 facets is up to 0.6 % smaller.
    let ratio = aimed.1.value / expected;
    assert!((0.99..1.003).contains(&ratio) && aimed.1.error < 0.002 * expected, "{ratio}");
}

/// Mean caustic radiance of frames with these light paths, for several seeds.
fn seen(scene: &Scene, emission: &'static Emission, frames: std::ops::Range<u32>) -> Mean {
    let means = (0..6).map(|seed| {
        let config = RenderConfig {
            width: 48,
            height: 48,
            seed,
            light_paths: Paths::Count(PATHS),
            emission,
            ..RenderConfig::default()
        };
        let mut session = Session::builder(scene).config(config).build().expect("a session");
        let mut sum = 0.0;
        for frame in 0..frames.end {
            session.frame(frame).expect("a frame runs");
            if frames.contains(&frame) {
                let image = session.image().expect("an image");
                sum += image.caustics.iter().map(|light| f64::from(light.element_sum())).sum::<f64>();
            }
        }
        sum / f64::from(frames.len() as u32)
    });
    Mean::from_samples(&means.collect::<Vec<_>>())
}

/// Photons of a caster that is tiny in the reach of the sun carry less than a quantum each; none of their light is lost.
#[test]
fn a_caustic_keeps_its_light_whatever_the_size_of_the_floor() {
    let near = seen(&under_the_sun(4.0), &AIMED, 0..2);
    for reach in [150.0, 400.0, 2000.0] {
        let far = seen(&under_the_sun(reach), &AIMED, 0..2);
        println!("{reach} m: {far:?}, 4 m: {near:?}");
        assert!(near.error < 0.01 * near.value && far.error < 0.02 * far.value);
        assert!(far.agrees(&near, 4.0), "{reach} m");
    }
}

/// A lamp over a glass ball in a closed box, and other lights outside.
fn lamp_in_a_box(add_others: fn(&mut Builder)) -> Scene {
    let mut b = Builder::default();
    let (wall, ball) = (b.material(lambert(0.6)), b.material(glass(1.5)));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, DVec3::new(0.0, -0.5, 0.0), 0.3, 48, 24);
    b.block(wall, DVec3::splat(-1.1), DVec3::splat(1.1), false);
    add_others(&mut b);
    b.light(DVec3::new(0.0, 0.9, 0.0), 1.0);
    b.camera(DVec3::new(0.0, 0.0, 0.95), DVec3::new(0.0, -1.0, 0.0), 1.2);
    b.build()
}

/// A sun over a floor of 1 km.
fn sun(b: &mut Builder) {
    let floor = b.material(lambert(0.6));
    b.panel(floor, DVec3::NEG_Y, 1000.0 * DVec3::Z, 1000.0 * DVec3::X);
    b.directional(DVec3::new(0.3, -1.0, 0.1), 400.0);
}

/// In a far corner, which is the first in the order of space: a light of three million times the lamp's power, and 20 lamps. Around the
/// box: 40 lamps.
fn many_lamps(b: &mut Builder) {
    b.light(DVec3::splat(-60.0), 3.0e6);
    for id in 0..20 {
        b.light(DVec3::splat(-59.0 + 0.1 * f64::from(id)), 1.0);
    }
    for id in 0..40 {
        b.light(DVec3::new(f64::from(id % 8), f64::from(id / 8), 0.0) * 3.0 + 3.0, 1.0);
    }
}

/// The lamp has less than a hundred-millionth of the power, and comes behind the sun in the table: guiding learns it.
#[test]
fn guided_emission_learns_a_dim_lamp_beside_a_sun() {
    let alone = seen(&lamp_in_a_box(|_| {}), &GUIDED, 16..20);
    let scene = lamp_in_a_box(sun);
    let shares: Vec<f32> = scene.lights.iter().map(|light| light.pdf_light_choice).collect();
    assert!(shares[1] < 1e-8 && shares[0] > 0.5, "{shares:?}");
    let beside = seen(&scene, &GUIDED, 16..20);
    println!("alone {alone:?}, beside a sun {beside:?}");
    assert!(beside.agrees(&alone, 4.0) && alone.error < 0.02 * alone.value);
    assert!(beside.error < 0.03 * beside.value, "{beside:?}");
}

/// Sums of power that f32 rounds bias no light that shares its maps with others.
#[test]
fn dim_lamps_that_share_maps_behind_a_bright_light_keep_their_light() {
    let alone = seen(&lamp_in_a_box(|_| {}), &GUIDED, 16..20);
    let scene = lamp_in_a_box(many_lamps);
    assert!(
        scene.lights.len() == 62 && scene.lights[0].pdf_light_choice > 0.5,
        "the bright light comes first"
    );
    let among = seen(&scene, &GUIDED, 16..20);
    println!("alone {alone:?}, among many {among:?}");
    assert!(among.agrees(&alone, 4.0) && among.error < 0.05 * among.value, "{among:?}");
}
