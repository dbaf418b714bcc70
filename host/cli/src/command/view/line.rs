//! Capacity of a connection: whether images are sent raw or as JPEG, and the JPEG quality.

use std::time::{Duration, Instant};

/// Encoding of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Three bytes a pixel.
    Raw,
    /// JPEG of this quality, 1 to 100.
    Jpeg(u8),
}

/// Time from sending an image to showing it that counts as prompt.
const PROMPT: Duration = Duration::from_millis(60);
/// Time from sending an image to showing it that counts as slow.
const SLOW: Duration = Duration::from_millis(250);
/// Number of prompt images in a row before larger ones are tried.
const TRIES: u32 = 8;
/// Time after which a connection that was too slow for raw images tries them again.
const PATIENCE: Duration = Duration::from_secs(30);
const COARSEST: u8 = 40;
const FINEST: u8 = 92;
/// Initial quality.
const DEFAULT_QUALITY: u8 = 80;

/// A connection, judged by the time in which its images were shown.
#[derive(Debug)]
pub struct Line {
    format: Format,
    prompt: u32,
    no_raw_before: Option<Instant>,
}

impl Line {
    /// Returns a connection of unknown capacity.
    pub fn new() -> Line {
        Line { format: Format::Jpeg(DEFAULT_QUALITY), prompt: 0, no_raw_before: None }
    }

    /// Encoding of the next image.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Learns from the time until an image was shown.
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
    fn prompt_pages_get_raw_images_and_slow_pages_coarse_ones() {
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
