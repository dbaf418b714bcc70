//! The page: all parts in order, with style and script inline.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::figure::Figure;
use super::speed::{Chart, list};
use super::table::Table;

/// Content security policy: nothing may be loaded. Images, style and script are in the file.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      base-uri 'none'; form-action 'none'";

/// Style of a report's page (colours, type, tables), also used by pages that accompany it.
pub const STYLE: &str = include_str!("report.css");

/// A section of the page with an entry in its table of contents.
pub struct Section {
    /// Anchor.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Content.
    pub content: Markup,
}

/// Returns the whole file.
pub fn page(title: &str, lead: &str, sections: &[Section], images: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="color-scheme" content="light dark";
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) }
            }
            body {
                (images)
                header {
                    h1 { (title) }
                    p .lead { (lead) }
                    nav aria-label="Contents" { ul { @for section in sections { li { a href={ "#" (section.id) } { (section.title) } } } } }
                }
                main {
                    @for section in sections {
                        section id=(section.id) { h2 { (section.title) } (section.content) }
                    }
                }
                div #tip role="status" hidden {}
                script { (PreEscaped(include_str!("report.js"))) }
            }
        }
    };
    page.into_string()
}

/// Charts of a scene, shown one at a time, with buttons to choose.
pub fn charts(charts: &[Chart]) -> Markup {
    html! {
        div .panel data-charts {
            @if charts.len() > 1 {
                div .switch role="group" aria-label="Error measure" {
                    @for (index, chart) in charts.iter().enumerate() {
                        button type="button" data-show=(chart.measure.slug()) aria-pressed=(index == 0) { (chart.measure.head) }
                    }
                }
            }
            @for chart in charts {
                div data-chart=(chart.measure.slug()) {
                    (chart.figure.inline())
                    (list(chart))
                }
            }
            // Show the longest legend: charts of a scene have the same series unless a measure is missing.
            @if let Some(largest) = charts.iter().max_by_key(|chart| chart.figure.legend.len()) { (largest.figure.legend()) }
            p .note {
                "Each mark is a run configuration; thin lines join those that differ in their number of light paths only. "
                "Left is fast, below is accurate; the steps are the Pareto front, beyond which no configuration reaches. "
                "Point at a mark, tap it, or move through them with the arrow keys."
            }
        }
    }
}

/// A figure with its heading and legend.
pub fn figure(figure: &Figure, head: &str, note: &str) -> Markup {
    html! {
        h3 { (head) }
        div .panel {
            (figure.inline())
            (figure.legend())
            @if !note.is_empty() { p .note { (note) } }
        }
    }
}

/// A table with its heading.
pub fn table(table: &Table, head: &str, note: &str) -> Markup {
    html! {
        h3 { (head) }
        @if !note.is_empty() { p .note { (note) } }
        (table.inline())
    }
}
