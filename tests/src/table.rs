//! A table of differences, printed at the end of a parity test.

use std::fmt;

use crate::compare::Difference;

/// Differences, and the passes in which they occurred.
#[derive(Clone, Debug, Default)]
pub struct Table {
    title: String,
    rows: Vec<(String, Difference)>,
}

impl Table {
    /// Creates an empty table.
    pub fn new(title: &str) -> Table {
        Table { title: title.into(), rows: vec![] }
    }

    /// Adds the differences of a pass or step.
    pub fn add(&mut self, pass: &str, differences: impl IntoIterator<Item = Difference>) {
        self.rows.extend(differences.into_iter().map(|difference| (pass.to_string(), difference)));
    }

    /// Rows that exceed their tolerance, as text.
    pub fn failures(&self) -> Vec<String> {
        let failed = self.rows.iter().filter(|(_, difference)| !difference.passes());
        let describe = |(pass, d): &(String, Difference)| {
            let allowed = d.tolerance.allowed(d.count);
            format!(
                "{pass} {}: {} of {} exceed (allowed {allowed}), first at {:?}, by {:e}; the tolerance stands for: {}",
                d.name, d.exceeding, d.count, d.first, d.max_abs, d.tolerance.reason
            )
        };
        failed.map(describe).collect()
    }

    /// Prints the table and panics if a row exceeds its tolerance.
    pub fn finish(&self) {
        eprintln!("{self}");
        let failures = self.failures();
        assert!(failures.is_empty(), "{}\n{}", self.title, failures.join("\n"));
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n{}", self.title)?;
        let head = ("pass", "field", "elements", "max abs", "max rel", "exceeding", "allowed");
        writeln!(
            f,
            "{:<22} {:<22} {:>9} {:>10} {:>10} {:>9} {:>7}  tolerance",
            head.0, head.1, head.2, head.3, head.4, head.5, head.6
        )?;
        for (pass, d) in &self.rows {
            let allowed = d.tolerance.allowed(d.count);
            write!(f, "{pass:<22} {:<22} {:>9} {:>10.2e} {:>10.2e} ", d.name, d.count, d.max_abs, d.max_rel)?;
            let mark = if d.passes() { "" } else { "  FAILS" };
            let (absolute, relative) = (d.tolerance.absolute, d.tolerance.relative);
            writeln!(f, "{:>9} {allowed:>7}  {absolute:.1e} + {relative:.1e} rel{mark}", d.exceeding)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{Tolerance, floats};

    fn table(value: f32) -> Table {
        let mut table = Table::new("CPU against itself");
        table.add("display", [floats("color", 1, &[1.0, 2.0], &[1.0, value], Tolerance::EXACT)]);
        table
    }

    #[test]
    fn a_table_without_differences_passes() {
        assert_eq!(table(2.0).failures(), [""; 0]);
        table(2.0).finish();
    }

    #[test]
    #[should_panic(expected = "display color: 1 of 2 exceed (allowed 0), first at Some(1)")]
    fn a_table_with_a_difference_fails() {
        assert!(table(2.5).to_string().contains("FAILS"));
        table(2.5).finish();
    }
}
