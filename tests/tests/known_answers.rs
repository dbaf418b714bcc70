//! Known answers: scenes whose light can be computed by hand.
//!
//! Statistical tolerances are three standard errors, estimated from independent frames or from the binomial law;
//! what is added to them is named.

#[path = "known_answers/cones.rs"]
mod cones;
#[path = "known_answers/estimator.rs"]
mod estimator;
#[path = "known_answers/glass.rs"]
mod glass;
#[path = "known_answers/lights.rs"]
mod lights;
#[path = "known_answers/mirror.rs"]
mod mirror;
#[path = "known_answers/rooms.rs"]
mod rooms;

use caustics::method::settings::Settings;
use caustics_tests::scenes::*;
use glam::DVec3;

fn settings(width: u32, height: u32, light_paths: u32) -> Settings {
    Settings { width, height, light_paths, ..Settings::default() }
}

/// A floor 2 m below the origin that hardly reflects, seen by a camera 3 m above.
fn above_a_floor() -> Builder {
    let mut b = Builder::default();
    // Dark enough that what it reflects does not come back (1e-6), bright enough to take deposits.
    let floor = b.material(lambert(1e-6));
    b.panel(floor, DVec3::new(0.0, -2.0, 0.0), 8.0 * DVec3::Z, 8.0 * DVec3::X);
    b.camera(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO, 0.002);
    b
}

fn near(what: &str, (value, error): (f64, f64), expected: f64, slack: f64) {
    println!("{what}: {value:.6} +- {error:.6}, expected {expected:.6}");
    assert!((value - expected).abs() < 3.0 * error + slack, "{what}: {value} +- {error} {expected}");
}
