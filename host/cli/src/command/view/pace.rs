//! Size of frames while something moves: the largest that meets the frame rate.

use std::time::Duration;

/// Sizes to choose from, as factors of an image's sides.
const SHARES: [f64; 8] = [1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.0625];
/// Minimum side (px).
const MIN_SIDE: u32 = 16;
/// Maximum number of pixels of the first frame, whose cost is unknown.
const FIRST: u32 = 320 * 180;
/// Frames get smaller above this factor of the target time, and larger if they would take less than `ROOM` of it.
const TOO_LONG: f64 = 1.25;
const ROOM: f64 = 0.8;
/// Weight of the latest frame in the moving average.
const LATEST: f64 = 0.4;

/// Estimated cost of frames.
#[derive(Debug)]
pub struct Pace {
    level: usize,
    /// Time of a pixel (s); none before the first frame.
    cost: Option<f64>,
}

impl Pace {
    /// Returns an unknown cost.
    pub fn new() -> Pace {
        Pace { level: 0, cost: None }
    }

    /// Learns from the time of a frame of this size.
    pub fn learn(&mut self, [width, height]: [u32; 2], took: Duration) {
        let cost = took.as_secs_f64() / (f64::from(width) * f64::from(height));
        self.cost = Some(self.cost.map_or(cost, |known| known + LATEST * (cost - known)));
    }

    /// Forgets the cost, since the configuration changed; the size does not grow at first.
    pub fn forget(&mut self) {
        self.cost = None;
    }

    /// Returns the size of the next frame of an image of size `full`, at `fps` frames a second.
    pub fn size(&mut self, full: [u32; 2], fps: f64) -> [u32; 2] {
        if let Some(cost) = self.cost {
            let time = |level: usize| cost * f64::from(pixels(full, level)) * fps;
            while self.level + 1 < SHARES.len() && time(self.level) > TOO_LONG {
                self.level += 1;
            }
            while self.level > 0 && time(self.level - 1) < ROOM {
                self.level -= 1;
            }
        } else {
            while self.level + 1 < SHARES.len() && pixels(full, self.level) > FIRST {
                self.level += 1;
            }
        }
        sized(full, SHARES[self.level])
    }
}

fn sized(full: [u32; 2], share: f64) -> [u32; 2] {
    full.map(|side| ((f64::from(side) * share).round() as u32).max(MIN_SIDE.min(side)))
}

fn pixels(full: [u32; 2], level: usize) -> u32 {
    let [width, height] = sized(full, SHARES[level]);
    width * height
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: [u32; 2] = [960, 540];

    #[test]
    fn frames_have_the_largest_size_that_the_rate_allows_and_keep_it() {
        let mut pace = Pace::new();
        // At 1 us a pixel, 0.1 s allow 100,000 px; the whole image has 518,400 px.
        let mut sizes = Vec::new();
        for _ in 0..10 {
            let size = pace.size(FULL, 10.0);
            pace.learn(size, Duration::from_secs_f64(1e-6 * f64::from(size[0] * size[1])));
            sizes.push(size);
        }
        assert_eq!(sizes[0], [240, 135], "nothing is known: a quarter of each side has at most 57,600 px");
        assert_eq!(sizes[1..], [[360, 203]; 9], "three eighths have 72,900 px, one half 129,600");
        assert_eq!(pace.size(FULL, 1.0), FULL);
        assert_eq!(pace.size(FULL, 200.0), [60, 34]);
    }

    #[test]
    fn no_side_vanishes() {
        let mut pace = Pace::new();
        pace.learn(FULL, Duration::from_secs(100));
        assert_eq!(pace.size([20, 8], 240.0), [16, 8]);
    }
}
