//! The value that a given part of all values does not exceed.

/// The smallest of the values that at least `part` of all do not exceed (nearest rank); no number if any is none.
pub fn percentile(values: &[f64], part: f64) -> f64 {
    if values.is_empty() || values.iter().any(|value| value.is_nan()) {
        return f64::NAN;
    }
    let mut sorted = values.to_vec();
    let rank = ((part * values.len() as f64 - 1e-9).ceil() as usize).clamp(1, values.len());
    *sorted.select_nth_unstable_by(rank - 1, f64::total_cmp).1
}
