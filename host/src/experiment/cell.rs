//! Cells: the ways to render that an experiment holds against each other.

use crate::method::Method;
use crate::method::filter::Filter;
use crate::method::history::{self, History};

/// A way to render.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// What a frame consists of.
    pub method: &'static Method,
    /// What the frame before lends.
    pub history: &'static History,
    /// What smooths the path-traced part.
    pub filter: &'static Filter,
}

impl Cell {
    /// All combinations, methods first, then filters, then histories.
    pub fn all(
        methods: &[&'static Method],
        histories: &[&'static History],
        filters: &[&'static Filter],
    ) -> Vec<Cell> {
        let mut cells = Vec::new();
        for &method in methods {
            for &filter in filters {
                cells.extend(histories.iter().map(|&history| Cell { method, history, filter }));
            }
        }
        cells
    }

    /// Its name in tables: `basic-paper`, `basic-paper-atrous` with a filter.
    pub fn name(&self) -> String {
        let name = format!("{}-{}", self.method.name, self.history.name);
        if self.filter.name == "none" { name } else { format!("{name}-{}", self.filter.name) }
    }

    /// Name of the cell that differs from this one in its history only, and has none.
    pub fn baseline(&self) -> String {
        Cell { history: &history::NONE, ..*self }.name()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::basic::BASIC;
    use crate::method::filter;

    #[test]
    fn every_history_has_a_cell_and_the_same_baseline() {
        let cells = Cell::all(&[&BASIC], history::ALL, &[&filter::NONE]);
        assert_eq!(cells.len(), history::ALL.len());
        assert!(cells.iter().all(|cell| cell.baseline() == "basic-none"));
        assert_eq!(cells[0].name(), "basic-none");
    }
}
