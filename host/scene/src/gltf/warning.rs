//! Warnings: one line for each unsupported feature, with the elements that have it.

use std::collections::{HashMap, HashSet};
use std::fmt::Display;

/// Maximum number of elements that a line names.
const MAX_NAMED: usize = 3;
/// Maximum number of lines.
const MAX_LINES: usize = 32;

/// Warnings, grouped by text.
#[derive(Debug, Default)]
pub struct Warnings {
    /// Texts with the names of their first elements, in the order of the notes.
    kinds: Vec<(String, Vec<String>)>,
    /// All elements of each text.
    owners: Vec<HashSet<String>>,
    /// Index in `kinds`, by text.
    known: HashMap<String, usize>,
}

impl Warnings {
    /// Adds a warning of an element (empty: the file). Repeated warnings count once.
    pub fn note(&mut self, owner: &str, what: impl Display) {
        let what = what.to_string();
        let id = *self.known.entry(what).or_insert_with_key(|what| {
            self.kinds.push((what.clone(), Vec::new()));
            self.owners.push(HashSet::new());
            self.kinds.len() - 1
        });
        if !owner.is_empty() && self.owners[id].insert(owner.into()) && self.kinds[id].1.len() < MAX_NAMED {
            self.kinds[id].1.push(owner.into());
        }
    }

    /// Lines of all warnings, each with the name of the file.
    pub fn lines(&self, file: &str) -> Vec<String> {
        let kinds = self.kinds.iter().zip(&self.owners);
        let line = |((what, named), owners): (&(String, Vec<String>), &HashSet<String>)| {
            let names = named.join(", ");
            match owners.len() - named.len() {
                _ if named.is_empty() => format!("{file}: {what}"),
                0 => format!("{file}: {names}: {what}"),
                others => format!("{file}: {names} and {others} more: {what}"),
            }
        };
        let mut lines: Vec<String> = kinds.map(line).take(MAX_LINES).collect();
        if let others @ 1.. = self.kinds.len() - lines.len() {
            lines.push(format!("{file}: and {others} warnings of other kinds"));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_of_one_kind_are_one_line_with_their_count() {
        let mut warnings = Warnings::default();
        warnings.note("node 7", "bent");
        for id in 0..1000 {
            warnings.note(&format!("node {}", id % 500), "left out");
        }
        warnings.note("", "alone");
        warnings.note("", "alone");
        let lines = ["a: node 7: bent", "a: node 0, node 1, node 2 and 497 more: left out", "a: alone"];
        assert_eq!(warnings.lines("a"), lines);
    }

    #[test]
    fn many_kinds_are_counted_too() {
        let mut warnings = Warnings::default();
        (0..1000).for_each(|id| warnings.note("node 0", format!("extension {id}")));
        let lines = warnings.lines("a");
        assert_eq!(lines.len(), MAX_LINES + 1);
        assert_eq!(lines[MAX_LINES], "a: and 968 warnings of other kinds");
    }
}
