//! Conditions that end a run.

use std::time::Duration;

/// Minimum number of frames of a reliable error estimate.
const MIN_FRAMES: u32 = 64;

/// Conditions that end a run; the first one reached ends it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stop {
    /// Number of frames.
    pub frames: Option<u32>,
    /// Time of all frames.
    pub time: Option<Duration>,
    /// Estimated relative mean square error.
    pub relative_error: Option<f64>,
}

impl Stop {
    /// Finished share of the run; 1 or more when it is complete.
    pub fn progress(&self, frames: u32, spent: Duration, relative_error: f64) -> f64 {
        let by_frames = self.frames.map(|limit| f64::from(frames) / f64::from(limit));
        // A mean needs two frames to have a variance.
        let by_time =
            self.time.filter(|_| frames >= 2).map(|limit| spent.as_secs_f64() / limit.as_secs_f64());
        // A few frames may all miss a small light and underestimate their error; require 16 times as many for an estimate
        // of 0.
        let known = frames >= if relative_error > 0.0 { MIN_FRAMES } else { 16 * MIN_FRAMES };
        let by_error = self.relative_error.filter(|_| known).map(|target| target / relative_error);
        [by_frames, by_time, by_error].into_iter().flatten().fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_stop_that_is_reached_ends_the_run() {
        let second = Duration::from_secs(1);
        let frames = Stop { frames: Some(10), ..Stop::default() };
        assert_eq!(frames.progress(5, second, f64::INFINITY), 0.5);
        let all = Stop { frames: Some(10), time: Some(4 * second), relative_error: Some(0.1) };
        assert_eq!(all.progress(2, second, f64::INFINITY), 0.25);
        assert_eq!(all.progress(1, 5 * second, f64::INFINITY), 0.1, "one frame has no variance");
        let error = Stop { relative_error: Some(0.1), ..Stop::default() };
        assert_eq!(error.progress(64, second, 0.125), 0.8);
        assert!(error.progress(64, second, 0.1) >= 1.0);
        // Frames that all miss the light agree perfectly.
        assert_eq!(error.progress(63, second, 0.01), 0.0);
        assert_eq!(error.progress(100, second, 0.0), 0.0);
        assert!(error.progress(1024, second, 0.0) >= 1.0, "a dark scene ends too");
    }
}
