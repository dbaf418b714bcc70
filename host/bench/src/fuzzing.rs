//! Entry points of fuzzing for sweeps and results; `caustics::fuzzing` has those of other files. Each returns whether the
//! bytes are accepted.

use crate::error::{FLIP, RELMSE};
use crate::parameter::PATHS_PER_PIXEL;
use crate::report::{self, Request};
use crate::result::{ErrorResult, Quartiles, RunResult, TimeResult};
use crate::store;
use crate::sweep::config::SweepConfig;

/// Reads the TOML of a sweep.
pub fn sweep(bytes: &[u8]) -> bool {
    std::str::from_utf8(bytes).is_ok_and(|text| SweepConfig::parse(text).is_ok())
}

/// Reads the JSON of a result, and makes a report of it.
pub fn result(bytes: &[u8]) -> bool {
    store::parse(bytes, "0123456789abcdef").is_ok_and(|result| {
        let request = Request {
            folders: Vec::new(),
            baseline: Vec::new(),
            title: "Report".into(),
            images: 4,
            output: "a.html".into(),
        };
        report::from_results(vec![plain(&result), result], &request).is_ok()
    })
}

/// Returns a result with other paths and with measures of ordinary size, so that charts hold both.
fn plain(result: &RunResult) -> RunResult {
    let paths = 2.0 * result.config.number(&PATHS_PER_PIXEL);
    let config = result.config.clone().with(&PATHS_PER_PIXEL, &paths.to_string());
    let total_ms = Quartiles { lower: 9.0, median: 10.0, upper: 11.0 };
    let time =
        TimeResult { width: 960, height: 540, light_paths: 1 << 20, total_ms, ..TimeResult::default() };
    let error = ErrorResult::default().with(&FLIP, Some(0.1)).with(&RELMSE, Some(0.1));
    RunResult { identity: "0".repeat(16), config, time: Some(time), error: Some(error), ..result.clone() }
}
