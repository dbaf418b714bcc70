//! Tooltip of a run configuration's mark: its name and its numbers, line by line.

use super::load::Measured;
use super::name::Names;
use super::number::number;
use crate::error::{MEASURES, Measure};
use crate::parameter::{PARAMETERS, PATHS_PER_PIXEL, Parameter, VisualEncoding};

/// Returns the name, then one line per number that is known.
pub fn tip(run: &Measured, names: &Names) -> String {
    let config = &run.result.config;
    let mut lines = vec![names.label(run)];
    if let Some(time) = &run.result.time {
        let total_ms = time.total_ms;
        lines.push(format!(
            "time {} ms ({} to {})",
            number(total_ms.median),
            number(total_ms.lower),
            number(total_ms.upper)
        ));
        lines.push(format!("timed at {}×{}, {} light paths", time.width, time.height, time.light_paths));
    }
    if let Some(error) = &run.result.error {
        let value = |measure: &Measure| {
            let off =
                error.standard_error(measure).map_or(String::new(), |off| format!(" ± {}", number(off)));
            Some(format!("{} {}{off}", measure.head, number(error.get(measure)?)))
        };
        lines.extend(MEASURES.into_iter().filter_map(value));
        lines.push(format!("errors at {}×{}, {} seeds", error.width, error.height, error.seeds));
    }
    let words = |parameter: &Parameter| match (parameter.shown, config.text(parameter)) {
        (VisualEncoding::Words(_, words), text) if !text.is_empty() && *parameter != PATHS_PER_PIXEL => {
            Some(words(&text))
        }
        _ => None,
    };
    lines.push(PARAMETERS.into_iter().filter_map(words).collect::<Vec<_>>().join(", "));
    lines.join("\n")
}
