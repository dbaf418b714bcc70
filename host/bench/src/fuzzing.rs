//! Readers of others' sweeps and results, from bytes, as `caustics::fuzzing` has those of other files. Each says whether the
//! bytes are accepted.

use crate::error::{FLIP, RELMSE};
use crate::parameter::PATHS_PER_PIXEL;
use crate::report::{self, Request};
use crate::result::{CellError, CellResult, CellTime, Quartiles};
use crate::store;
use crate::sweep::config::SweepConfig;

/// The TOML of a sweep.
pub fn sweep(bytes: &[u8]) -> bool {
    std::str::from_utf8(bytes).is_ok_and(|text| SweepConfig::parse(text).is_ok())
}

/// The JSON of a cell's result, and a report of it.
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

/// A cell that differs from that of a result in its paths and has measures of everyday size, for charts of both.
fn plain(result: &CellResult) -> CellResult {
    let paths = 2.0 * result.cell.number(&PATHS_PER_PIXEL);
    let cell = result.cell.clone().with(&PATHS_PER_PIXEL, &paths.to_string());
    let total_ms = Quartiles { lower: 9.0, median: 10.0, upper: 11.0 };
    let time = CellTime { width: 960, height: 540, light_paths: 1 << 20, total_ms, ..CellTime::default() };
    let error = CellError::default().with(&FLIP, Some(0.1)).with(&RELMSE, Some(0.1));
    CellResult { identity: "0".repeat(16), cell, time: Some(time), error: Some(error), ..result.clone() }
}
