//! Significance of a change: the part of a sum of paired differences that noise does not explain.
//!
//! Each path gives one difference: the light that its random numbers bring now, less the light that they brought in the previous
//! frame. The sum of differences estimates the change of the light, and their scatter the variance of that sum. Paths that fade
//! alike have no scatter about their mean, so that the first path is enough. Paths that take turns cancel out.

/// Standard deviations of the sum that count as noise.
const NOISE_SIGMAS: f32 = 1.2;

/// Magnitude of a sum of differences without its noise, by the variance of the sum. It is zero up to 1.2 standard deviations.
/// Above, it is `(sum^2 - (1.2 sigma)^2) / |sum|`, which hardly reduces a clear change.
#[inline(always)]
pub fn significant_change(sum: f32, variance: f32) -> f32 {
    let noise = NOISE_SIGMAS * NOISE_SIGMAS * variance;
    if sum * sum <= noise { 0.0 } else { sum.abs() - noise / sum.abs() }
}

/// Unbiased estimate of the variance of a sum of `count` differences, by the sum of their squares. A single difference has no
/// scatter.
#[inline(always)]
pub fn variance_of_sum(sum: f32, squares: f32, count: u32) -> f32 {
    let count = count as f32;
    (count * squares - sum * sum).max(0.0) / (count - 1.0).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_fades_are_significant_from_the_first_path_on() {
        for count in [1u32, 2, 6, 50] {
            let n = count as f32;
            let variance = variance_of_sum(-0.07 * n, 0.07 * 0.07 * n, count);
            let change = significant_change(-0.07 * n, variance);
            // Tolerance: rounding of the difference of two equal squares.
            assert!((change - 0.07 * n).abs() < 1.0e-5 * n, "{count}: {change}");
        }
    }

    #[test]
    fn single_path_that_changes_among_others_is_noise() {
        for count in [2u32, 6, 50] {
            let variance = variance_of_sum(-1.0, 1.0, count);
            assert!((variance - 1.0).abs() < 1.0e-6, "{count}: {variance}");
            assert_eq!(significant_change(-1.0, variance), 0.0);
        }
    }

    #[test]
    fn changes_that_cancel_out_are_noise() {
        assert_eq!(significant_change(0.0, variance_of_sum(0.0, 2.0, 2)), 0.0);
        // 55 of 100 paths gain what the others lose: one standard deviation.
        assert_eq!(significant_change(10.0, variance_of_sum(10.0, 100.0, 100)), 0.0);
    }

    #[test]
    fn squares_that_round_to_zero_give_no_nan() {
        assert_eq!(significant_change(0.0, variance_of_sum(0.0, 0.0, 0)), 0.0);
        assert!(significant_change(1.0e-30, 0.0) >= 0.0);
    }
}
