//! Results of all entry points, and their text. The text contains no times: equal modules and drivers give equal bytes.

use std::fmt::Write;

use caustics::vulkan::DeviceInfo;
use serde::Serialize;

use super::figures::Figures;
use super::one::Compiled;

/// An entry point to compile.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CompileJob {
    pub module: &'static str,
    pub entry: String,
    /// Name of the needs: `all`, `none` or a scene.
    pub features: String,
    pub feature_bits: u32,
}

/// Result of an entry point.
#[derive(Clone, Debug, Serialize)]
pub struct EntryPointRecord {
    #[serde(flatten)]
    pub job: CompileJob,
    #[serde(flatten)]
    pub figures: Figures,
    #[serde(flatten)]
    pub compiled: Option<Compiled>,
    /// Reason why the entry point did not compile.
    pub error: Option<String>,
}

/// Everything that is printed.
#[derive(Clone, Debug, Serialize)]
pub struct CompileReport {
    pub device: DeviceInfo,
    /// Names of the modules and their hashes, as in `kernels.lock`.
    pub modules: Vec<(&'static str, String)>,
    pub entry_points: Vec<EntryPointRecord>,
}

/// Returns the columns, the failures and a last line as text.
pub fn text(report: &CompileReport) -> String {
    let device = &report.device;
    let mut out = format!("{} ({})\n", device.name, device.driver);
    for (name, hash) in &report.modules {
        let _ = writeln!(out, "{name} {hash}");
    }
    let entry_width = report.entry_points.iter().map(|record| record.job.entry.len()).max().unwrap_or(0);
    let mut features = "";
    for record in &report.entry_points {
        if record.job.features != features {
            features = &record.job.features;
            let title = format!("features of {features}:");
            let _ = writeln!(
                out,
                "\n{title:<width$} registers  spilled  scratch B  waves  code B",
                width = 13 + 1 + entry_width
            );
        }
        let _ = writeln!(out, "{}", line(record, entry_width));
    }
    let failed: Vec<_> =
        report.entry_points.iter().filter_map(|record| Some((record, record.error.as_ref()?))).collect();
    if !failed.is_empty() {
        out.push('\n');
    }
    for (record, error) in &failed {
        let _ = writeln!(
            out,
            "{} {}, features {}: {error}",
            record.job.module, record.job.entry, record.job.features
        );
    }
    let count = report.entry_points.len();
    let _ = match failed.len() {
        0 => writeln!(out, "\n{count} of {count} entry points compiled"),
        failed => writeln!(out, "\n{failed} of {count} entry points failed"),
    };
    out
}

fn line(record: &EntryPointRecord, entry_width: usize) -> String {
    let label = format!("{:<13} {:<entry_width$}", record.job.module, record.job.entry);
    if record.error.is_some() {
        return format!("{label} failed");
    }
    let figures = &record.figures;
    let number = |figure: Option<u64>| figure.map_or("-".into(), |figure| figure.to_string());
    format!(
        "{label} {:>9}  {:>7}  {:>9}  {:>5}  {:>6}",
        number(figures.registers),
        number(figures.spilled),
        number(figures.scratch_bytes),
        number(figures.waves),
        number(figures.code_bytes)
    )
}

/// A device for tests.
#[cfg(test)]
pub fn test_device() -> DeviceInfo {
    DeviceInfo {
        index: 0,
        name: "GPU".into(),
        driver: "driver 1".into(),
        kind: caustics::vulkan::DeviceKind::Discrete,
        api_version: "1.3.0".into(),
        usable: true,
        ray_queries: true,
        missing: vec![],
        missing_ray_queries: vec![],
        max_storage_buffer_bytes: 1,
        timestamps: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_line_for_each_entry_point_and_no_time() {
        let record = |entry: &str, registers, compile_ms| EntryPointRecord {
            job: CompileJob {
                module: "base.spv",
                entry: entry.into(),
                features: "all".into(),
                feature_bits: 7,
            },
            figures: Figures { registers, ..Figures::default() },
            compiled: Some(Compiled { compile_ms, executables: vec![] }),
            error: None,
        };
        let report = |compile_ms| CompileReport {
            device: test_device(),
            modules: vec![("base.spv", "0123456789abcdef".into())],
            entry_points: vec![record("collect", Some(144), compile_ms), record("display", None, compile_ms)],
        };
        let text = text(&report(1.0));
        assert_eq!(text, super::text(&report(2.0)));
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[..2], ["GPU (driver 1)", "base.spv 0123456789abcdef"]);
        assert!(lines[3].starts_with("features of all:"), "{text}");
        assert_eq!(
            lines[4].split_whitespace().collect::<Vec<_>>(),
            ["base.spv", "collect", "144", "-", "-", "-", "-"]
        );
        assert_eq!(
            lines[5].find('-'),
            lines[4].find("144").map(|at| at + 2),
            "columns are aligned right\n{text}"
        );
        assert_eq!(lines.last(), Some(&"2 of 2 entry points compiled"));
    }
}
