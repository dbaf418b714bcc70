//! Frame of a chart: grid, axes, their numbers and their names.

use maud::{Markup, html};

use super::axis::{Axis, Scale};
use super::figure::Size;
use super::number::{at, short};

/// Rectangle of a chart in which data is drawn (px).
#[derive(Clone, Copy, Debug)]
pub struct Area {
    /// Its left edge.
    pub left: f64,
    /// Its right edge.
    pub right: f64,
    /// Its upper edge.
    pub top: f64,
    /// Its lower edge.
    pub bottom: f64,
}

impl Area {
    /// Data area of a chart.
    pub fn new(size: Size) -> Area {
        let (left, right) = if size == Size::Wide { (64.0, 16.0) } else { (48.0, 8.0) };
        Area { left, right: size.width() - right, top: 30.0, bottom: size.height() - 44.0 }
    }

    /// Vertical axis; values grow upwards.
    pub fn upwards(&self, scale: Scale, values: impl Iterator<Item = f64>) -> Option<Axis> {
        Axis::around(scale, values, self.bottom, self.top)
    }

    /// Horizontal axis; values grow to the right.
    pub fn rightwards(&self, scale: Scale, values: impl Iterator<Item = f64>) -> Option<Axis> {
        Axis::around(scale, values, self.left, self.right)
    }

    /// Draws the grid, and numbers and names of both axes.
    pub fn draw(&self, x: &Axis, x_name: &str, y: &Axis, y_name: &str) -> Markup {
        let Area { left, right, top, bottom } = *self;
        let class = |labelled| if labelled { "grid" } else { "grid minor" };
        html! {
            @for tick in x.ticks() {
                @let position = at(x.position(tick.value));
                line class=(class(tick.labelled)) x1=(position) x2=(position) y1=(top) y2=(bottom) {}
                @if tick.labelled {
                    text x=(position) y=(bottom + 18.0) text-anchor="middle" { (short(tick.value)) }
                }
            }
            @for tick in y.ticks() {
                @let position = y.position(tick.value);
                line class=(class(tick.labelled)) x1=(left) x2=(right) y1=(at(position)) y2=(at(position)) {}
                @if tick.labelled {
                    text x=(left - 8.0) y=(at(position + 4.5)) text-anchor="end" { (short(tick.value)) }
                }
            }
            line class="axis" x1=(left) x2=(right) y1=(bottom) y2=(bottom) {}
            line class="axis" x1=(left) x2=(left) y1=(top) y2=(bottom) {}
            text class="name" x=(right) y=(bottom + 37.0) text-anchor="end" { (x_name) }
            text class="name" x="4" y="16" { (y_name) }
        }
    }
}
