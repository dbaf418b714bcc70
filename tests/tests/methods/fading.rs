//! Light that fades, grows or shrinks: histories keep its energy.

use caustics::render_config::Paths;
use caustics::render_config::RenderConfig;
use caustics_kernels::history::VALIDATED;
use caustics_tests::fading::{Caster, Fade, Fading, Punctual};

/// Largest relative error of the caustics' energy that a history may have.
const MAX_CAUSTICS: f64 = 0.02;
/// Largest relative error of the path-traced light's energy.
const MAX_PATHS: f64 = 0.01;

/// Asserts the energy of both layers over the frames of a fade, each relative to that without a history.
fn keeps_up(fading: &Fading, seeds: u32) {
    keeps_up_with(fading, 2 * 96 * 60, seeds);
}

/// Asserts the energies with this number of light paths, whose noise is that of the comparison.
fn keeps_up_with(fading: &Fading, light_paths: u32, seeds: u32) {
    let config = RenderConfig {
        width: 96,
        height: 60,
        light_paths: Paths::Count(light_paths),
        ..RenderConfig::default()
    };
    let [caustics, paths] = fading.kept(&VALIDATED, &config, seeds);
    println!("{fading:?}: caustics {caustics:?}, path-traced {paths:?}");
    assert!((caustics.value - 1.0).abs() < MAX_CAUSTICS, "{fading:?}: {caustics:?}");
    assert!((paths.value - 1.0).abs() < MAX_PATHS, "{fading:?}: {paths:?}");
}

fn still(caster: Caster, fade: Fade) -> Fading {
    Fading { caster, fade, moves: false }
}

/// Before paths were compared in pairs, histories showed 1.11 and 0.83 of the caustics.
#[test]
fn histories_keep_the_energy_of_an_area_light_that_shrinks_or_grows() {
    keeps_up(&still(Caster::Metal, Fade::Light(1.0, 0.5)), 2);
    keeps_up(&still(Caster::Metal, Fade::Light(0.25, 1.0)), 2);
}

/// Eight of a point light's 4096 validation paths meet the ring. When two near each other had to agree, histories
/// showed 1.16 and 0.75 of the caustics.
#[test]
fn histories_keep_the_energy_of_a_point_light_that_fades_or_grows() {
    keeps_up(&still(Caster::Metal, Fade::Power(Punctual::Point, 0.93)), 2);
    keeps_up(&still(Caster::Metal, Fade::Power(Punctual::Point, 1.2)), 2);
}

mod release {
    use super::*;

    /// The last factor is 1:16 over the 18 frames.
    const FACTORS: [f64; 5] = [0.93, 1.07, 0.99, 1.2, 0.8495];

    fn powers(punctual: Punctual, light_paths: u32, seeds: u32) {
        for caster in CASTERS {
            for factor in FACTORS {
                for moves in [false, true] {
                    let fading = Fading { caster, fade: Fade::Power(punctual, factor), moves };
                    keeps_up_with(&fading, light_paths, seeds);
                }
            }
        }
    }

    #[test]
    #[ignore = "20 animations with and without a history: some minutes"]
    fn histories_keep_the_energy_of_a_point_light_of_changing_power() {
        // 32768 light paths have 4096 validation paths, as fewer light paths do.
        powers(Punctual::Point, 32768, 16);
    }

    #[test]
    #[ignore = "20 animations with and without a history: some minutes"]
    fn histories_keep_the_energy_of_one_of_two_point_lights_of_changing_power() {
        powers(Punctual::OneOfTwoPoints, 32768, 16);
    }

    #[test]
    #[ignore = "20 animations with and without a history: some minutes"]
    fn histories_keep_the_energy_of_a_spot_light_of_changing_power() {
        powers(Punctual::Spot, 2 * 96 * 60, 6);
    }

    #[test]
    #[ignore = "20 animations with and without a history: some minutes"]
    fn histories_keep_the_energy_of_a_directional_light_of_changing_power() {
        powers(Punctual::Sun, 2 * 96 * 60, 12);
    }

    const CASTERS: [Caster; 2] = [Caster::Metal, Caster::Glass];

    #[test]
    #[ignore = "20 animations with and without a history: some minutes"]
    fn histories_keep_the_energy_of_area_lights_of_changing_size() {
        for caster in CASTERS {
            for (from, to) in [(1.0, 0.5), (1.0, 0.25), (0.25, 1.0), (8.0, 4.0), (2.0, 8.0)] {
                for moves in [false, true] {
                    keeps_up(&Fading { caster, fade: Fade::Light(from, to), moves }, 6);
                }
            }
        }
    }

    #[test]
    #[ignore = "six animations with and without a history: some minutes"]
    fn histories_keep_the_energy_of_a_light_that_fades_beside_another_or_moves_away() {
        for fade in [Fade::OneOfTwo(1.0, 0.5), Fade::OneOfTwo(0.25, 1.0), Fade::Away(1.7)] {
            for moves in [false, true] {
                keeps_up(&Fading { caster: Caster::Metal, fade: fade.clone(), moves }, 6);
            }
        }
    }
}
