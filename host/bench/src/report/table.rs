//! A table that the page can sort by any column, and its data as CSV.

use maud::{Markup, html};

use super::number::number;

/// Content of a table cell.
#[derive(Clone, Debug, PartialEq)]
pub enum TableValue {
    /// Words.
    Text(String),
    /// A number, and its text.
    Number(f64, String),
    /// Nothing.
    None,
}

impl TableValue {
    /// A number as text with three significant digits.
    pub fn number(value: Option<f64>) -> TableValue {
        value.map_or(TableValue::None, |value| TableValue::Number(value, number(value)))
    }

    fn raw(&self) -> String {
        match self {
            TableValue::Text(text) => text.clone(),
            TableValue::Number(value, _) => value.to_string(),
            TableValue::None => String::new(),
        }
    }

    fn cell(&self) -> Markup {
        match self {
            TableValue::Text(text) => html! { td .long[text.len() > 60] { (text) } },
            TableValue::Number(value, text) => html! { td .number data-value=(value) { (text) } },
            TableValue::None => html! { td .number.none { "–" } },
        }
    }
}

/// A column: its heading on the page, its key in the file, and its values.
#[derive(Clone, Debug)]
pub struct Column {
    /// Heading on the page.
    pub head: &'static str,
    /// Key in the file.
    pub key: String,
    /// Values, one per row.
    pub values: Vec<TableValue>,
}

/// A table.
#[derive(Clone, Debug)]
pub struct Table {
    /// Stem of its file.
    pub name: String,
    /// Title.
    pub title: String,
    /// Its columns, of equal length.
    pub columns: Vec<Column>,
}

impl Table {
    fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Removes columns without values.
    pub fn without_empty(mut self) -> Table {
        self.columns.retain(|column| column.values.iter().any(|value| *value != TableValue::None));
        self
    }

    /// The table for the page; it scrolls within its box.
    pub fn inline(&self) -> Markup {
        let is_number =
            |column: &Column| column.values.iter().any(|value| matches!(value, TableValue::Number(..)));
        html! {
            div .table tabindex="0" role="region" aria-label=(self.title) {
                table data-sortable[self.len() > 1] {
                    thead {
                        tr {
                            @for column in &self.columns {
                                th scope="col" class=[is_number(column).then_some("number")] {
                                    @if self.len() > 1 { button type="button" { (column.head) } } @else { (column.head) }
                                }
                            }
                        }
                    }
                    tbody {
                        @for row in 0..self.len() { tr { @for column in &self.columns { (column.values[row].cell()) } } }
                    }
                }
            }
        }
    }

    /// Its data; the first row has the keys.
    pub fn rows(&self) -> Vec<Vec<String>> {
        let heads = self.columns.iter().map(|column| column.key.clone()).collect();
        let row = |index: usize| self.columns.iter().map(|column| column.values[index].raw()).collect();
        [heads].into_iter().chain((0..self.len()).map(row)).collect()
    }
}

/// Writes rows as CSV.
pub fn csv(rows: &[Vec<String>]) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(row)?;
    }
    Ok(writer.into_inner()?)
}
