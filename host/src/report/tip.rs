//! What is said of a cell beside its mark: a name, and its numbers line by line.

use super::load::Measured;
use super::name::Names;
use super::number::{number, short};

/// The name, then a line a number; numbers that are missing have none.
pub fn tip(cell: &Measured, names: &Names) -> String {
    let config = &cell.result.cell;
    let mut lines = vec![names.label(cell)];
    if let Some(time) = &cell.result.time {
        let of = time.total_ms;
        lines.push(format!("time {} ms ({} to {})", number(of.median), number(of.lower), number(of.upper)));
        lines.push(format!("timed at {}×{}, {} light paths", time.width, time.height, time.light_paths));
    }
    if let Some(error) = &cell.result.error {
        let values = [
            ("FLIP", error.flip),
            ("FLIP of caustics", error.flip_caustics),
            ("relMSE", error.relmse),
            ("relMSE of caustics", error.relmse_caustics),
        ];
        lines.extend(values.iter().filter_map(|(name, value)| Some(format!("{name} {}", number((*value)?)))));
        lines.push(format!("errors at {}×{}, {} seeds", error.width, error.height, error.seeds));
    }
    let place = [config.runner.as_str(), &format!("{} bounces", config.max_bounces)].join(", ");
    lines.push(format!("{place}, radius {} px", short(f64::from(config.radius_px))));
    lines.join("\n")
}
