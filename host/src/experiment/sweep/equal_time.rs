//! Light paths by which a frame takes a given time: the root of a function that is measured, noisy and grows.
//!
//! A frame takes a time that does not depend on its light paths, and one in proportion to them; so the secant of two measures
//! is a good guess. Guesses stay between the last known too little and too much.

/// Off from the time asked for, at most, relative to it.
pub const TOLERANCE: f64 = 0.02;
/// Numbers of light paths that are tried, at most.
const MOST_STEPS: u32 = 16;
/// A guess is at most this many times the last one, or that part of it: one measure says little of far ones.
const LONGEST_STEP: f64 = 8.0;

/// Light paths and the time that they took [ms].
type Trial = (u32, f64);

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Light paths.
    pub paths: u32,
    /// The time that they take [ms].
    pub ms: f64,
    /// Numbers of light paths that were tried.
    pub steps: u32,
}

impl Found {
    /// Whether it takes the time asked for.
    pub fn is_met(&self, target_ms: f64) -> bool {
        is_met(self.ms, target_ms)
    }
}

/// Whether a time is the one asked for, as far as it can be.
pub fn is_met(ms: f64, target_ms: f64) -> bool {
    (ms / target_ms - 1.0).abs() <= TOLERANCE
}

/// The number of light paths from 1 to `most` whose measured time [ms] is nearest to the target; the search ends with the
/// first that meets it.
pub fn search(
    target_ms: f64,
    start: u32,
    most: u32,
    measure: &mut dyn FnMut(u32) -> anyhow::Result<f64>,
) -> anyhow::Result<Found> {
    let mut paths = start.clamp(1, most);
    let (mut below, mut above, mut last): (Option<Trial>, Option<Trial>, Option<Trial>) = (None, None, None);
    let mut best: Option<Found> = None;
    for steps in 1..=MOST_STEPS {
        let ms = measure(paths)?;
        let off = |ms: f64| (ms / target_ms).ln().abs();
        if best.is_none_or(|best| off(ms) < off(best.ms)) {
            best = Some(Found { paths, ms, steps });
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
        let one = f64::from(paths);
        let slope = |(a, a_ms): Trial, (b, b_ms): Trial| {
            f64::from(a) + (target_ms - a_ms) * (f64::from(b) - f64::from(a)) / (b_ms - a_ms)
        };
        let guess = match (below, above, last) {
            (Some(below), Some(above), _) => slope(below, above),
            (_, _, Some(last)) if last.0 != paths => slope(last, (paths, ms)),
            _ => one * target_ms / ms,
        };
        let next = match (below, above) {
            // A measure was disturbed, or there is no number between.
            (Some(below), Some(above)) if above.0 <= below.0 + 1 => break,
            (Some(below), Some(above)) => {
                // Away from both ends: a measure near one says little that is new.
                let (a, b) = (f64::from(below.0), f64::from(above.0));
                let margin = (0.02 * (b - a)).max(1.0);
                guess.clamp(a + margin.min(0.5 * (b - a)), b - margin.min(0.5 * (b - a)))
            }
            // What was measured says that more paths take no more time, or that they take it all.
            (Some(_), None) if guess.is_finite() && guess > one => {
                guess.clamp(one + 1.0, one * LONGEST_STEP + 1.0)
            }
            (Some(_), None) => one * LONGEST_STEP,
            _ if guess.is_finite() && guess < one => guess.max(one / LONGEST_STEP).min(one - 1.0),
            _ => one / LONGEST_STEP,
        };
        let next = (next.round() as u32).clamp(1, most);
        if next == paths {
            // At an end of the range.
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

    fn find(target: f64, start: u32, most: u32, time: impl Fn(f64, u32) -> f64) -> Found {
        let mut step = 0;
        let mut measure = |paths| {
            step += 1;
            Ok(time(f64::from(paths), step))
        };
        search(target, start, most, &mut measure).unwrap()
    }

    #[test]
    fn times_that_grow_as_the_paths_are_met_in_few_steps() {
        for (constant, each) in [(0.0, 1e-3), (90.0, 1e-3), (5.0, 1e-6), (99.0, 1e-4), (50.0, 1.0)] {
            for start in [1, 1000, 10_000_000] {
                let found = find(100.0, start, u32::MAX / 6, |paths, _| constant + each * paths);
                assert!(found.is_met(100.0) && found.steps <= 14, "{constant} {each} {start}: {found:?}");
            }
        }
    }

    #[test]
    fn curved_and_noisy_times_are_met() {
        let curved = |paths: f64, _| 3.0 + 1e-4 * paths * (paths + 2.0).log2();
        assert!(find(100.0, 64, 1 << 30, curved).is_met(100.0));
        // Caches: four times the price beyond a size.
        let steep = |paths: f64, _| 1e-3 * paths.min(5e4) + 4e-3 * (paths - 5e4).max(0.0);
        assert!(find(100.0, 64, 1 << 30, steep).is_met(100.0));
        // A percent of noise, another one each time.
        let noisy = |paths: f64, step: u32| {
            (10.0 + 1e-3 * paths) * (1.0 + 0.01 * f64::from(step * 7 % 5) / 2.0 - 0.01)
        };
        assert!(find(100.0, 64, 1 << 30, noisy).is_met(100.0));
    }

    #[test]
    fn what_cannot_be_met_ends_at_the_nearest() {
        let slow = find(100.0, 10_000, 1 << 30, |paths, _| 150.0 + 1e-3 * paths);
        assert!(!slow.is_met(100.0) && slow.paths == 1, "{slow:?}");
        let fast = find(100.0, 10_000, 100_000, |paths, _| 1e-4 * paths);
        assert!(!fast.is_met(100.0) && fast.paths == 100_000, "{fast:?}");
        let leap = find(100.0, 10_000, 1 << 30, |paths, _| if paths < 5000.0 { 50.0 } else { 500.0 });
        assert!(!leap.is_met(100.0) && leap.ms == 50.0 && leap.paths < 5000, "{leap:?}");
    }
}
