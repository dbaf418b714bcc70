//! Known answers: scenes whose light can be computed by hand.
//!
//! | | case | test |
//! |---|---|---|
//! | O1 | ring mirror | `partition.rs`: `ring_mirror_makes_its_nephroid`, and sharply among the long tests |
//! | O2 | plane mirror | `mirror`: `plane_mirror_makes_a_virtual_light`; `lights`: `plane_mirror_makes_a_virtual_spot`, `plane_mirror_turns_directional_light` |
//! | O3 | view through a mirror | `mirror`: `view_through_a_perfect_mirror_is_the_mirrored_cameras` |
//! | O4 | slab | `glass`: `slab_with_all_bounces_transmits_what_a_thin_wall_does`, `thin_wall_transmits_what_a_slab_does` |
//! | O5 | glass sphere | `glass`: `glass_sphere_transmits_and_focuses_parallel_light`; `lights`: `glass_sphere_focuses_a_directional_light` |
//! | O6 | parabola, ellipse | `focus`: `parabola_sends_all_light_to_its_focus`, `ellipse_sends_all_light_from_focus_to_focus` |
//! | O7 | the density estimate | `estimator`: `disc_estimates_as_its_bias_says` |
//! | O8 | history | `reuse.rs`: `the_paper_keeps_a_ninth_of_the_variance`; `stability.rs`: `a_lamp_that_goes_out_leaves_no_ghost` |
//! | O9 | invariances | `invariances.rs` |
//! | O10 | energy | `energy.rs`; `rooms`: `lossless_things_in_a_uniform_room_are_invisible`, `plain_room_has_no_caustic_and_shoots_no_light_path` |
//! | O11 | gathers | `gathers.rs`: `every_gather_finds_what_brute_force_finds`, `gathers_agree_on_real_scenes` |
//!
//! Statistical tolerances are three standard errors, estimated from independent frames or from the binomial law;
//! what is added to them is named.

mod cones;
mod dispersion;
mod estimator;
mod focus;
mod glass;
mod inside_glass;
mod lights;
mod mirror;
mod plains;
mod rooms;
mod rough_glass;

use caustics::render_config::Paths;
use caustics::render_config::RenderConfig;
use caustics_tests::scenes::*;
use glam::DVec3;

fn config(width: u32, height: u32, light_paths: u32) -> RenderConfig {
    RenderConfig { width, height, light_paths: Paths::Count(light_paths), ..RenderConfig::default() }
}

/// A floor 2 m below the origin that hardly reflects, seen by a camera 3 m above.
fn above_a_floor() -> Builder {
    let mut b = Builder::default();
    // Dark enough that what it reflects does not come back (1e-6), bright enough to take photons.
    let floor = b.material(lambert(1e-6));
    b.panel(floor, DVec3::new(0.0, -2.0, 0.0), 8.0 * DVec3::Z, 8.0 * DVec3::X);
    b.camera(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO, 0.002);
    b
}

fn near(what: &str, (value, error): (f64, f64), expected: f64, slack: f64) {
    println!("{what}: {value:.6} +- {error:.6}, expected {expected:.6}");
    assert!((value - expected).abs() < 3.0 * error + slack, "{what}: {value} +- {error} {expected}");
}
