//! Rows of `frames.csv`: a frame of a cell and every measure of it.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Context;

/// Names of the measures that are there or empty in every table, in the order of its columns, units at the end of the
/// name; ratios, FLIP and relative errors have none. After them comes a column `pass.NAME_ms` for each pass.
pub const MEASURES: [&str; 19] = [
    "turn",
    "total_ms",
    "animate_ms",
    "pose_ms",
    "camera_rays",
    "shadow_rays",
    "light_rays",
    "light_paths",
    "deposits",
    "gathered",
    "faults",
    "flip",
    "flip_caustics",
    "relmse",
    "relmse_caustics",
    "flicker",
    "flicker_caustics",
    "caustics_variance_radiance2",
    "gain",
];

/// What leads a row.
const HEAD: [&str; 4] = ["frame", "time_s", "cell", "identity"];

/// A frame of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Index of the frame.
    pub frame: u32,
    /// Time that it shows (s).
    pub time: f64,
    /// Name of the cell.
    pub cell: String,
    /// Hash of all that decides the row.
    pub identity: String,
    /// Measures by the name of their column.
    pub values: BTreeMap<String, f64>,
}

impl Row {
    /// A measure.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.values.get(name).copied()
    }

    /// Sets a measure, if there is one.
    pub fn set(&mut self, name: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.values.insert(name.to_string(), value);
        }
    }

    /// Times of the passes (ms).
    pub fn passes<'a>(&'a self) -> impl Iterator<Item = (&'a str, f64)> {
        let pass = |name: &'a str| name.strip_prefix("pass.")?.strip_suffix("_ms");
        self.values.iter().filter_map(move |(name, value)| Some((pass(name)?, *value)))
    }
}

/// The table of the rows.
pub fn encode(rows: &[Row]) -> anyhow::Result<Vec<u8>> {
    let passes: BTreeSet<&str> = rows
        .iter()
        .flat_map(|row| row.values.keys())
        .map(String::as_str)
        .filter(|n| n.starts_with("pass."))
        .collect();
    let columns: Vec<&str> = MEASURES.into_iter().chain(passes).collect();
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(HEAD.iter().chain(&columns))?;
    for row in rows {
        let head = [row.frame.to_string(), row.time.to_string(), row.cell.clone(), row.identity.clone()];
        let value = |name: &&str| row.get(name).map(|value| value.to_string()).unwrap_or_default();
        table.write_record(head.into_iter().chain(columns.iter().map(value)))?;
    }
    Ok(table.into_inner()?)
}

/// Rows of a table.
pub fn decode(bytes: &[u8]) -> anyhow::Result<Vec<Row>> {
    let mut table = csv::Reader::from_reader(bytes);
    let names: Vec<String> = table.headers()?.iter().map(String::from).collect();
    anyhow::ensure!(names.iter().take(HEAD.len()).eq(HEAD), "its columns are not those of frames.csv");
    let mut rows = Vec::new();
    for record in table.records() {
        let record = record?;
        let mut row = Row {
            frame: record[0].parse().context("its frame is no index")?,
            time: record[1].parse().context("its time is no number")?,
            cell: record[2].into(),
            identity: record[3].into(),
            ..Row::default()
        };
        for (name, text) in names.iter().zip(&record).skip(HEAD.len()).filter(|(_, text)| !text.is_empty()) {
            row.values.insert(name.clone(), text.parse().with_context(|| format!("{name} is no number"))?);
        }
        rows.push(row);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(frame: u32, values: &[(&str, f64)]) -> Row {
        let values = values.iter().map(|(name, value)| (name.to_string(), *value)).collect();
        Row { frame, time: f64::from(frame) / 24.0, cell: "a".into(), identity: "0f".into(), values }
    }

    #[test]
    fn a_table_is_read_back_to_the_bit() {
        let rows = [
            row(0, &[("total_ms", 0.1 + 0.2), ("pass.collect_ms", 1e-7)]),
            row(1, &[("gain", 9.0), ("pass.reuse_ms", 2.0)]),
        ];
        let bytes = encode(&rows).unwrap();
        let header = String::from_utf8(bytes.clone()).unwrap().lines().next().unwrap().to_string();
        assert!(header.starts_with("frame,time_s,cell,identity,turn,total_ms,"), "{header}");
        assert!(header.ends_with("gain,pass.collect_ms,pass.reuse_ms"), "{header}");
        assert_eq!(decode(&bytes).unwrap(), rows);
        assert_eq!(rows[0].passes().collect::<Vec<_>>(), [("collect", 1e-7)]);
    }

    #[test]
    fn another_table_is_no_table_of_rows() {
        assert!(decode(b"a,b\n1,2\n").is_err());
        assert!(decode(b"frame,time_s,cell,identity,gain\n1,2,a,b,nine\n").is_err());
    }
}
