//! Search for the number of light paths with which a frame takes a given time: the root of a measured, noisy, growing
//! function.
//!
//! Part of a frame's time is fixed and part is proportional to its light paths, so the secant of two measurements is a good
//! guess. Guesses stay between the largest known number that is too small and the smallest that is too large. Where these
//! meet before the time is met, a measurement was disturbed, and the older one is dropped.

/// Maximum deviation from the target time, relative to it.
pub const TOLERANCE: f64 = 0.02;
/// Maximum number of trials.
const MAX_STEPS: u32 = 16;
/// Maximum factor between consecutive guesses: one measurement says little about distant numbers.
const MAX_STEP: f64 = 8.0;

/// Light paths and the time that they took (ms).
type Trial = (u32, f64);

/// Result of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualTimeResult {
    /// Light paths.
    pub paths: u32,
    /// Time that they take (ms).
    pub ms: f64,
    /// Number of trials.
    pub steps: u32,
}

impl EqualTimeResult {
    /// Whether the paths take the target time.
    pub fn is_met(&self, target_ms: f64) -> bool {
        is_met(self.ms, target_ms)
    }
}

/// Whether a time equals the target time within [`TOLERANCE`].
pub fn is_met(ms: f64, target_ms: f64) -> bool {
    (ms / target_ms - 1.0).abs() <= TOLERANCE
}

/// Returns the time of a run configuration and the time to compare it with (ms). `first` is given where the first
/// configuration of the turns has the same target: the median ratio to it, and its time. The ratio replaces the clock then,
/// since a machine that slows down slows both. The first configuration's time replaces the target where it meets the
/// target.
pub fn held(own_ms: f64, first: Option<(f64, f64)>, target_ms: f64) -> (f64, f64) {
    match first {
        None => (own_ms, target_ms),
        Some((ratio, first_ms)) if is_met(first_ms, target_ms) => (ratio * first_ms, first_ms),
        Some((ratio, first_ms)) => (ratio * first_ms, target_ms),
    }
}

/// Finds the number of light paths from 1 to `max_paths` whose measured time (ms) is nearest to the target. The search ends
/// with the first number that meets it.
pub fn search(
    target_ms: f64,
    start: u32,
    max_paths: u32,
    measure: &mut dyn FnMut(u32) -> anyhow::Result<f64>,
) -> anyhow::Result<EqualTimeResult> {
    let mut paths = start.clamp(1, max_paths);
    let (mut below, mut above, mut last): (Option<Trial>, Option<Trial>, Option<Trial>) = (None, None, None);
    let mut best: Option<EqualTimeResult> = None;
    for steps in 1..=MAX_STEPS {
        let ms = measure(paths)?;
        let off = |ms: f64| (ms / target_ms).ln().abs();
        if best.is_none_or(|best| off(ms) < off(best.ms)) {
            best = Some(EqualTimeResult { paths, ms, steps });
        }
        if is_met(ms, target_ms) {
            break;
        }
        if ms < target_ms {
            below =
                Some(below.map_or((paths, ms), |known| if known.0 > paths { known } else { (paths, ms) }));
        } else {
            above =
                Some(above.map_or((paths, ms), |known| if known.0 < paths { known } else { (paths, ms) }));
        }
        let is_narrow = |(below, above): (Trial, Trial)| {
            f64::from(above.0) - f64::from(below.0) < TOLERANCE * f64::from(above.0)
        };
        if below.zip(above).is_some_and(is_narrow) {
            (below, above) = if ms < target_ms { (below, None) } else { (None, above) };
            last = None;
        }
        let one = f64::from(paths);
        let slope = |(a, a_ms): Trial, (b, b_ms): Trial| {
            f64::from(a) + (target_ms - a_ms) * (f64::from(b) - f64::from(a)) / (b_ms - a_ms)
        };
        let guess = match (below, above, last) {
            // Use the bracket, unless the last two trials are on one side: they predict better than an old one on the
            // other.
            (Some(below), Some(above), last)
                if last.is_none_or(|last| (last.1 < target_ms) != (ms < target_ms)) =>
            {
                slope(below, above)
            }
            (_, _, Some(last)) if last.0 != paths => slope(last, (paths, ms)),
            _ => one * target_ms / ms,
        };
        let next = match (below, above) {
            (Some(below), Some(above)) => {
                // Stay away from both ends: a trial near one of them adds little.
                let (a, b) = (f64::from(below.0), f64::from(above.0));
                let margin = (0.02 * (b - a)).max(1.0);
                guess.clamp(a + margin.min(0.5 * (b - a)), b - margin.min(0.5 * (b - a)))
            }
            // Follow the guess if it asks for more paths; noise may make it negative or infinite.
            (Some(_), None) if guess.is_finite() && guess > one => {
                guess.clamp(one + 1.0, one * MAX_STEP + 1.0)
            }
            (Some(_), None) => one * MAX_STEP,
            _ if guess.is_finite() && guess < one => guess.max(one / MAX_STEP).min(one - 1.0),
            _ => one / MAX_STEP,
        };
        let next = (next.round() as u32).clamp(1, max_paths);
        if next == paths {
            // The search has reached an end of the range.
            break;
        }
        last = Some((paths, ms));
        paths = next;
    }
    best.ok_or_else(|| anyhow::anyhow!("no number of light paths was tried"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find(target: f64, start: u32, max_paths: u32, time: impl Fn(f64, u32) -> f64) -> EqualTimeResult {
        let mut step = 0;
        let mut measure = |paths| {
            step += 1;
            Ok(time(f64::from(paths), step))
        };
        search(target, start, max_paths, &mut measure).unwrap()
    }

    #[test]
    fn linear_times_are_met_in_few_steps() {
        for (constant, each) in [(0.0, 1e-3), (90.0, 1e-3), (5.0, 1e-6), (99.0, 1e-4), (50.0, 1.0)] {
            for start in [1, 1000, 10_000_000] {
                let found = find(100.0, start, u32::MAX / 6, |paths, _| constant + each * paths);
                assert!(found.is_met(100.0) && found.steps <= 14, "{constant} {each} {start}: {found:?}");
            }
        }
    }

    #[test]
    fn configurations_with_one_target_are_compared_within_their_turns() {
        let met = |held: (f64, f64)| is_met(held.0, held.1);
        assert!(met(held(101.0, None, 100.0)) && !met(held(105.0, None, 100.0)));
        // The machine was slow during this configuration's turns, and as slow for the first one.
        assert!(met(held(105.0, Some((1.01, 99.0)), 100.0)));
        assert!(!met(held(100.0, Some((1.05, 99.0)), 100.0)));
        // The first one misses the time, and this one is equal to it: both go on.
        assert!(!met(held(110.0, Some((1.0, 110.0)), 100.0)));
    }

    #[test]
    fn curved_and_noisy_times_are_met() {
        let curved = |paths: f64, _| 3.0 + 1e-4 * paths * (paths + 2.0).log2();
        assert!(find(100.0, 64, 1 << 30, curved).is_met(100.0));
        // Caches: a path costs four times as much beyond a size.
        let steep = |paths: f64, _| 1e-3 * paths.min(5e4) + 4e-3 * (paths - 5e4).max(0.0);
        assert!(find(100.0, 64, 1 << 30, steep).is_met(100.0));
        // One percent of noise, different in each trial.
        let noisy = |paths: f64, step: u32| {
            (10.0 + 1e-3 * paths) * (1.0 + 0.01 * f64::from(step * 7 % 5) / 2.0 - 0.01)
        };
        assert!(find(100.0, 64, 1 << 30, noisy).is_met(100.0));
    }

    #[test]
    fn a_disturbed_measurement_is_dropped() {
        for disturbed in 1..5 {
            for factor in [0.5, 0.7, 1.4, 2.0] {
                let time =
                    |paths: f64, step| (50.0 + 1e-3 * paths) * if step == disturbed { factor } else { 1.0 };
                let found = find(100.0, 5000, 1 << 30, time);
                assert!(found.is_met(100.0), "{disturbed} {factor}: {found:?}");
            }
        }
    }

    #[test]
    fn unreachable_times_end_at_the_nearest() {
        let slow = find(100.0, 10_000, 1 << 30, |paths, _| 150.0 + 1e-3 * paths);
        assert!(!slow.is_met(100.0) && slow.paths == 1, "{slow:?}");
        let fast = find(100.0, 10_000, 100_000, |paths, _| 1e-4 * paths);
        assert!(!fast.is_met(100.0) && fast.paths == 100_000, "{fast:?}");
        let leap = find(100.0, 10_000, 1 << 30, |paths, _| if paths < 5000.0 { 50.0 } else { 500.0 });
        assert!(!leap.is_met(100.0) && leap.ms == 50.0 && leap.paths < 5000, "{leap:?}");
    }
}
