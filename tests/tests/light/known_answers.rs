//! Known answers: scenes with light that can be computed by hand.
//!
//! | | case | file | test |
//! |---|---|---|---|
//! | O1 | ring mirror | `partition.rs` | `ring_mirror_makes_its_nephroid` |
//! | O2 | plane mirror | `mirror.rs` | `plane_mirror_makes_a_virtual_light` |
//! | | | `lights.rs` | `plane_mirror_makes_a_virtual_spot` |
//! | | | `lights.rs` | `plane_mirror_turns_directional_light` |
//! | O3 | view in a mirror | `mirror.rs` | `view_in_a_perfect_mirror_equals_the_view_of_the_mirrored_camera` |
//! | O4 | slab | `glass.rs` | `slab_with_all_bounces_transmits_as_much_as_a_thin_wall` |
//! | | | `glass.rs` | `thin_wall_transmits_as_much_as_a_slab` |
//! | O5 | glass sphere | `glass.rs` | `glass_sphere_transmits_and_focuses_parallel_light` |
//! | | | `lights.rs` | `glass_sphere_focuses_a_directional_light` |
//! | O6 | parabola, ellipse | `focus.rs` | `parabola_sends_all_light_to_its_focus` |
//! | | | `focus.rs` | `ellipse_sends_all_light_from_focus_to_focus` |
//! | O7 | density estimate | `estimator.rs` | `disc_estimate_is_exact_on_even_light_and_off_by_r2_over_4_on_x2` |
//! | O8 | history | `reuse.rs` | `paper_history_keeps_a_ninth_of_the_variance` |
//! | | | `stability.rs` | `paper_history_fades_by_0_8_a_frame_and_validated_at_once_after_a_light_goes_out` |
//! | O9 | invariances | `invariances.rs` | all |
//! | O10 | energy | `energy.rs` | all |
//! | | | `rooms.rs` | `lossless_objects_in_a_uniform_room_are_invisible` |
//! | | | `rooms.rs` | `room_without_casters_has_no_caustics_and_traces_no_light_path` |
//! | O11 | gathers | `gathers.rs` | `every_gather_matches_brute_force_to_the_bit` |
//! | | | `gathers.rs` | `gathers_agree_to_the_bit_on_committed_scenes` |
//!
//! Statistical tolerances are three standard errors, estimated from independent frames or from the binomial law;
//! further terms are named.

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
    // Dark enough that its reflected light does not come back (1e-6), bright enough to take photons.
    let floor = b.material(lambert(1e-6));
    b.panel(floor, DVec3::new(0.0, -2.0, 0.0), 8.0 * DVec3::Z, 8.0 * DVec3::X);
    b.camera(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO, 0.002);
    b
}

fn near(what: &str, (value, error): (f64, f64), expected: f64, slack: f64) {
    println!("{what}: {value:.6} +- {error:.6}, expected {expected:.6}");
    assert!((value - expected).abs() < 3.0 * error + slack, "{what}: {value} +- {error} {expected}");
}
