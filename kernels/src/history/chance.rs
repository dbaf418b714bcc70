//! Change beyond chance: how much of a sum of paired differences says that light changed, and how much is noise.
//!
//! Each path gives one difference, between the light that it brought in the frame before and the light that the same random
//! numbers bring now. Their sum estimates the change of the light, and the sum of their squares the variance of that sum. Paths
//! that fade alike have a sum far above its standard deviation, from two paths on; paths that take turns cancel out.

/// Standard deviations of the sum that say nothing.
const NOISE_SIGMAS: f32 = 1.2;

/// Magnitude of a sum of differences less what chance makes of it, by the sum of their squares. Zero up to 1.2 standard deviations;
/// above, the square of the noise is taken from the square of the sum, so that a clear change is hardly made smaller.
#[inline(always)]
pub fn beyond_chance(sum: f32, squares: f32) -> f32 {
    let noise = NOISE_SIGMAS * NOISE_SIGMAS * squares;
    if sum * sum <= noise { 0.0 } else { sum.abs() - noise / sum.abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_fade_alike_are_beyond_chance_from_two_on() {
        for count in [2.0f32, 6.0, 50.0] {
            let beyond = beyond_chance(-0.07 * count, 0.07 * 0.07 * count);
            let expected = 0.07 * (count - 1.44);
            assert!((beyond - expected).abs() < 1.0e-5, "{count}: {beyond} should be {expected}");
        }
        assert_eq!(beyond_chance(0.07, 0.07 * 0.07), 0.0);
    }

    #[test]
    fn what_one_path_loses_and_another_gains_is_chance() {
        assert_eq!(beyond_chance(0.0, 2.0), 0.0);
        // 55 of 100 paths gain what the others lose: one standard deviation.
        assert_eq!(beyond_chance(10.0, 100.0), 0.0);
    }

    #[test]
    fn squares_that_round_to_nothing_are_no_number_that_is_lost() {
        assert_eq!(beyond_chance(0.0, 0.0), 0.0);
        assert!(beyond_chance(1.0e-30, 0.0) >= 0.0);
    }
}
