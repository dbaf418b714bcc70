//! Colours and dashes that are told apart on white, by people who see few colours too.

use plotters::style::RGBColor;

/// Colours of Okabe and Ito without the light ones, black first.
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 0, 0),
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(170, 68, 140),
    RGBColor(150, 110, 0),
];
/// Length and gap of dashes (px); no gap is a whole line.
const DASHES: [(u32, u32); 4] = [(1, 0), (8, 4), (3, 3), (14, 5)];

/// Colour of the line of this index.
pub fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

/// Dash of the line of this index: no two of the first 24 share both.
pub fn dash(index: usize) -> (u32, u32) {
    DASHES[(index + index / 12) % DASHES.len()]
}

/// Colour of the piece of this index in a stack.
pub fn piece(index: usize) -> RGBColor {
    let color = colorous::TABLEAU10[index % colorous::TABLEAU10.len()];
    RGBColor(color.r, color.g, color.b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_differ_in_color_or_dash() {
        let mut seen: Vec<_> = (0..24).map(|index| (color(index), dash(index))).collect();
        seen.dedup();
        for (index, one) in seen.iter().enumerate() {
            assert!(!seen[..index].contains(one), "line {index}");
        }
    }
}
