//! Repeated work that takes at most a share of the time.

use std::time::{Duration, Instant};

/// Limiter of repeated work.
#[derive(Debug)]
pub struct Share {
    parts: u32,
    min_pause: Duration,
    not_before: Option<Instant>,
}

impl Share {
    /// Limits the work to 1 / `parts` of the time, with at least `min_pause` between repetitions.
    pub fn new(parts: u32, min_pause: Duration) -> Share {
        Share { parts, min_pause, not_before: None }
    }

    /// Whether the work may be done now.
    pub fn is_due(&self, now: Instant) -> bool {
        self.not_before.is_none_or(|time| now >= time)
    }

    /// Accounts for work that was done between two times.
    pub fn spent(&mut self, start: Instant, end: Instant) {
        self.not_before = Some(end + ((end - start) * self.parts).max(self.min_pause));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_work_is_repeated_rarely() {
        let mut share = Share::new(8, Duration::from_millis(500));
        let start = Instant::now();
        let after = |ms| start + Duration::from_millis(ms);
        assert!(share.is_due(start));
        share.spent(start, after(10));
        assert!(!share.is_due(after(509)) && share.is_due(after(510)));
        share.spent(start, after(100));
        assert!(!share.is_due(after(899)) && share.is_due(after(900)));
    }
}
