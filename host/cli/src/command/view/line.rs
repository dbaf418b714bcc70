//! What a connection bears: whether images are sent as they are, or as JPEG, and how fine.

use std::time::{Duration, Instant};

/// How an image is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Three bytes a pixel.
    Raw,
    /// JPEG of this quality, 1 to 100.
    Jpeg(u8),
}

/// Time from sending an image to its being shown that nobody minds.
const PROMPT: Duration = Duration::from_millis(60);
/// Time that is too long.
const SLOW: Duration = Duration::from_millis(250);
/// Images that must be prompt in a row before larger ones are tried.
const TRIES: u32 = 8;
/// Time after which a connection that once was too slow is tried with raw images again.
const PATIENCE: Duration = Duration::from_secs(30);
const COARSEST: u8 = 40;
const FINEST: u8 = 92;
/// Quality to begin with.
const DEFAULT_QUALITY: u8 = 80;

/// A connection, by how soon the images that were sent over it were shown.
#[derive(Debug)]
pub struct Line {
    format: Format,
    prompt: u32,
    no_raw_before: Option<Instant>,
}

impl Line {
    /// One that nothing is known of.
    pub fn new() -> Line {
        Line { format: Format::Jpeg(DEFAULT_QUALITY), prompt: 0, no_raw_before: None }
    }

    /// How to send the next image.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Learns of an image how long it took until it was shown.
    pub fn learn(&mut self, took: Duration, now: Instant) {
        self.prompt = if took <= PROMPT { self.prompt + 1 } else { 0 };
        match self.format {
            Format::Raw if took > SLOW => {
                self.format = Format::Jpeg(DEFAULT_QUALITY);
                self.no_raw_before = Some(now + PATIENCE);
            }
            Format::Raw => {}
            Format::Jpeg(quality) if took > SLOW => {
                self.format = Format::Jpeg(quality.saturating_sub(10).max(COARSEST));
            }
            Format::Jpeg(quality) if self.prompt >= TRIES => {
                self.prompt = 0;
                let may_be_raw = self.no_raw_before.is_none_or(|time| now >= time);
                self.format = match quality {
                    FINEST.. if may_be_raw => Format::Raw,
                    _ => Format::Jpeg((quality + 4).min(FINEST)),
                };
            }
            Format::Jpeg(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn learn(line: &mut Line, times: u32, took: u64, now: Instant) {
        (0..times).for_each(|_| line.learn(Duration::from_millis(took), now));
    }

    #[test]
    fn what_is_shown_at_once_becomes_raw_and_what_is_slow_coarse() {
        let now = Instant::now();
        let mut line = Line::new();
        learn(&mut line, 40, 10, now);
        assert_eq!(line.format(), Format::Raw);
        learn(&mut line, 1, 400, now);
        assert_eq!(line.format(), Format::Jpeg(DEFAULT_QUALITY));
        learn(&mut line, 100, 10, now);
        assert_eq!(line.format(), Format::Jpeg(FINEST), "raw was too much a moment ago");
        learn(&mut line, 100, 10, now + PATIENCE);
        assert_eq!(line.format(), Format::Raw);
        learn(&mut line, 100, 25_000, now);
        assert_eq!(line.format(), Format::Jpeg(COARSEST));
        learn(&mut line, 100, 100, now);
        assert_eq!(line.format(), Format::Jpeg(COARSEST), "neither prompt nor slow");
    }
}
