//! Records of the rendered frames of an animation.

use std::collections::BTreeMap;
use std::time::Duration;

use caustics::counters::Counters;
use caustics::runner::StepTime;
use serde::Serialize;

/// A rendered frame.
#[derive(Clone, Debug, Serialize)]
pub struct RenderedFrame {
    /// Its index.
    pub frame: u32,
    /// Time that it shows (s).
    pub time_s: f64,
    /// Whether the frame was written; false where it existed and was rendered again for its history.
    pub written: bool,
    /// Wall time of posing and of all passes (ms).
    pub total_ms: f64,
    /// Time of each pass (ms).
    pub pass_ms: BTreeMap<String, f64>,
    /// Counters of the kernels.
    pub counters: Counters,
}

impl RenderedFrame {
    /// Makes the record of a frame from its measures.
    pub fn new(
        (frame, time_s, written): (u32, f64, bool),
        wall: Duration,
        times: &[StepTime],
        counters: Counters,
    ) -> RenderedFrame {
        let mut pass_ms = BTreeMap::new();
        for step in times {
            *pass_ms.entry(step.pass.clone()).or_default() += ms(step.time);
        }
        RenderedFrame { frame, time_s, written, total_ms: ms(wall), pass_ms, counters }
    }
}

/// Sums of the counters of all frames, and mean of their times (ms).
pub fn sums(records: &[RenderedFrame]) -> (Counters, f64) {
    let mut counters = Counters::default();
    for record in records {
        counters.add(&record.counters);
    }
    let total: f64 = records.iter().map(|record| record.total_ms).sum();
    (counters, total / records.len().max(1) as f64)
}

fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}
