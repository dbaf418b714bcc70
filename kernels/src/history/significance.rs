//! Significance of a change: how much of a sum of paired differences says that light changed, and how much is noise.
//!
//! Each path gives one difference, between the light that it brought in the frame before and the light that the same random
//! numbers bring now. Their sum estimates the change of the light, and their scatter the variance of that sum. Paths that fade
//! alike have no scatter about their mean: the first says all. Paths that take turns cancel out.

/// Standard deviations of the sum that say nothing.
const NOISE_SIGMAS: f32 = 1.2;

/// Magnitude of a sum of differences less its noise, by the variance of the sum. Zero up to 1.2 standard deviations;
/// above, the square of the noise is taken from the square of the sum, so that a clear change is hardly made smaller.
#[inline(always)]
pub fn significant_change(sum: f32, variance: f32) -> f32 {
    let noise = NOISE_SIGMAS * NOISE_SIGMAS * variance;
    if sum * sum <= noise { 0.0 } else { sum.abs() - noise / sum.abs() }
}

/// Unbiased estimate of the variance of a sum of `count` differences, by the sum of their squares; a single one has no scatter.
#[inline(always)]
pub fn variance_of_sum(sum: f32, squares: f32, count: u32) -> f32 {
    let count = count as f32;
    (count * squares - sum * sum).max(0.0) / (count - 1.0).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_fade_alike_are_beyond_chance_from_the_first_on() {
        for count in [1u32, 2, 6, 50] {
            let n = count as f32;
            let variance = variance_of_sum(-0.07 * n, 0.07 * 0.07 * n, count);
            let change = significant_change(-0.07 * n, variance);
            // Rounding of the difference of two equal squares.
            assert!((change - 0.07 * n).abs() < 1.0e-5 * n, "{count}: {change}");
        }
    }

    #[test]
    fn one_path_that_changes_among_others_is_chance() {
        for count in [2u32, 6, 50] {
            let variance = variance_of_sum(-1.0, 1.0, count);
            assert!((variance - 1.0).abs() < 1.0e-6, "{count}: {variance}");
            assert_eq!(significant_change(-1.0, variance), 0.0);
        }
    }

    #[test]
    fn what_one_path_loses_and_another_gains_is_chance() {
        assert_eq!(significant_change(0.0, variance_of_sum(0.0, 2.0, 2)), 0.0);
        // 55 of 100 paths gain what the others lose: one standard deviation.
        assert_eq!(significant_change(10.0, variance_of_sum(10.0, 100.0, 100)), 0.0);
    }

    #[test]
    fn squares_that_round_to_nothing_are_no_number_that_is_lost() {
        assert_eq!(significant_change(0.0, variance_of_sum(0.0, 0.0, 0)), 0.0);
        assert!(significant_change(1.0e-30, 0.0) >= 0.0);
    }
}
