//! A figure: drawn for wide and for narrow windows, and as a file with its data beside it.

use maud::{Markup, html};

use super::name::{COLORS, Names};

/// Size of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// For the window of a desktop computer.
    Wide,
    /// For the window of a phone.
    Narrow,
}

impl Size {
    /// Width of a figure (px).
    pub fn width(self) -> f64 {
        match self {
            Size::Wide => 840.0,
            Size::Narrow => 360.0,
        }
    }

    /// Height of a chart (px).
    pub fn height(self) -> f64 {
        match self {
            Size::Wide => 440.0,
            Size::Narrow => 360.0,
        }
    }
}

/// The content of an SVG.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Width (px).
    pub width: f64,
    /// Height (px).
    pub height: f64,
    /// Markup inside the SVG element.
    pub content: Markup,
}

/// A line of a legend: the class of its colour, the outline of its mark (a bar where it has none), and its name.
#[derive(Clone, Debug)]
pub struct LegendEntry {
    /// Class of the colour.
    pub color: String,
    /// Outline around 0.
    pub shape: Option<&'static str>,
    /// Name beside the mark.
    pub name: String,
    /// Index of the series whose marks the line can hide.
    pub series: Option<usize>,
}

impl LegendEntry {
    /// Legend line of a series.
    pub fn new(names: &Names, series: usize) -> LegendEntry {
        LegendEntry {
            color: names.color(series),
            shape: Some(names.shape(series)),
            name: names.get(series).name(),
            series: Some(series),
        }
    }

    fn sample(&self) -> Markup {
        html! {
            @if let Some(shape) = self.shape {
                path class={ "mark " (self.color) } d=(shape) transform="translate(8 8)" {}
            } @else {
                rect class=(self.color) x="1" y="2" width="14" height="12" rx="2" {}
            }
        }
    }
}

/// A figure of the report.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Stem of its file names.
    pub name: String,
    /// Title.
    pub title: String,
    /// Drawing for wide windows.
    pub wide: Drawing,
    /// Drawing for narrow windows.
    pub narrow: Drawing,
    /// Its legend.
    pub legend: Vec<LegendEntry>,
    /// Notes on what is left out, and why.
    pub notes: Vec<String>,
    /// Its data; the first row has the headings.
    pub rows: Vec<Vec<String>>,
}

impl Figure {
    /// Returns both drawings; the style sheet shows the one that fits.
    pub fn inline(&self) -> Markup {
        let svg = |class: &str, drawing: &Drawing| {
            let size = format!("0 0 {} {}", drawing.width, drawing.height.round());
            html! {
                svg class={ "chart " (class) } viewBox=(size) role="group" aria-label=(self.title) { (drawing.content) }
            }
        };
        html! {
            (svg("wide", &self.wide))
            (svg("narrow", &self.narrow))
            @for note in &self.notes { p .note { (note) } }
        }
    }

    /// The legend, for a page.
    pub fn legend(&self) -> Markup {
        html! {
            ul .legend {
                @for entry in &self.legend {
                    li {
                        @let sample = html! { svg viewBox="0 0 16 16" aria-hidden="true" { (entry.sample()) } };
                        @if let Some(series) = entry.series {
                            button type="button" data-toggle=(series) aria-pressed="true" { (sample) span { (entry.name) } }
                        } @else {
                            span .entry { (sample) span { (entry.name) } }
                        }
                    }
                }
            }
        }
    }

    /// The wide drawing as a file, with title, legend and style.
    pub fn file(&self) -> String {
        let (side, head, line) = (12.0, 36.0, 24.0);
        let columns = 2;
        let rows = self.legend.len().div_ceil(columns);
        let (width, drawing) = (self.wide.width + 2.0 * side, self.wide.height.round());
        let height = head + drawing + 24.0 + line * rows as f64;
        let content = html! {
            style { (maud::PreEscaped(STYLE)) (maud::PreEscaped(colors())) }
            rect class="paper" width=(width) height=(height) {}
            text class="title" x="16" y="24" { (self.title) }
            g transform={ "translate(" (side) " " (head) ")" } { (self.wide.content) }
            @for (index, entry) in self.legend.iter().enumerate() {
                @let x = 16.0 + (index / rows) as f64 * (width / columns as f64);
                @let y = head + drawing + 10.0 + line * (index % rows) as f64;
                g transform={ "translate(" (x) " " (y) ")" } {
                    (entry.sample())
                    text x="24" y="13" { (entry.name) }
                }
            }
        };
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
             {height}\">{}</svg>\n",
            content.into_string().replace(is_forbidden, "\u{fffd}")
        )
    }
}

/// Whether XML forbids a character, even escaped.
fn is_forbidden(letter: char) -> bool {
    (letter < ' ' && !"\t\n\r".contains(letter)) || "\u{fffe}\u{ffff}".contains(letter)
}

/// Style of a figure's file, which has no page around it.
const STYLE: &str = include_str!("figure.css");
/// Colours of the classes `c0` to `c9` on white: those of `report.css` in light mode.
const ON_WHITE: [&str; COLORS] = [
    "#4a515c", "#0072b2", "#d55e00", "#009e73", "#aa4499", "#b07d00", "#3aa5dd", "#7a3b10", "#d6456b",
    "#5b53c4",
];

/// CSS rules of the colours. They use no variables, which few programs but browsers support.
fn colors() -> String {
    let rules = ON_WHITE.iter().enumerate().map(|(index, color)| {
        let class = format!("c{index}");
        format!(
            ".{class}.mark, rect.{class} {{ fill: {color}; }} .{class}.hollow {{ fill: #ffffff; stroke: {color}; stroke-width: 2; }}\n\
             .{class}.line {{ stroke: {color}; stroke-width: 2; }} .{class}.family {{ stroke: {color}; stroke-opacity: 0.35; }}\n"
        )
    });
    rules.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_files_are_those_of_the_page_in_light() {
        let page = include_str!("report.css");
        let light = page.split("@media (prefers-color-scheme: dark)").next().unwrap();
        for (index, color) in ON_WHITE.iter().enumerate() {
            assert!(light.contains(&format!("--{index}: {color};")), "{index}");
        }
        assert!(!colors().contains("var(") && !STYLE.contains("var("));
    }
}
