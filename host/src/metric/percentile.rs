//! Percentiles: the nearest rank, or interpolated between ranks.

/// Returns the smallest value that is at least as large as a `part` (0 to 1) of all values (nearest rank). NaN if any value
/// is NaN.
pub fn percentile(values: &[f64], part: f64) -> f64 {
    if values.is_empty() || values.iter().any(|value| value.is_nan()) {
        return f64::NAN;
    }
    let mut sorted = values.to_vec();
    let rank = ((part * values.len() as f64 - 1e-9).ceil() as usize).clamp(1, values.len());
    *sorted.select_nth_unstable_by(rank - 1, f64::total_cmp).1
}

/// Returns the quantile, interpolated linearly between order statistics. A median of two values is their mean. NaN if any
/// value is NaN.
pub fn quantile(values: &[f64], part: f64) -> f64 {
    if values.is_empty() || values.iter().any(|value| value.is_nan()) {
        return f64::NAN;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = part.clamp(0.0, 1.0) * (sorted.len() - 1) as f64;
    let below = sorted[rank.floor() as usize];
    below + (sorted[rank.ceil() as usize] - below) * rank.fract()
}
