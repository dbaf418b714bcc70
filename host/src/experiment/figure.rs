//! Figures as SVG: lines over frames (a line a cell), and bars of stacked passes (a bar a cell).

mod bars;
mod lines;
mod palette;

pub use bars::passes;
pub use lines::{Series, lines};

/// Size of a figure (px).
const SIZE: (u32, u32) = (840, 480);
/// Letters of axes and legends.
const LETTERS: (&str, u32) = ("sans-serif", 15);
/// Letters of the title.
const TITLE: (&str, u32) = ("sans-serif", 19);

/// Why a figure cannot be drawn.
fn failed(error: impl std::fmt::Display) -> anyhow::Error {
    anyhow::anyhow!("drawing a figure: {error}")
}
