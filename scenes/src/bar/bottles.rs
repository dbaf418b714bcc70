//! Bottles: closed solids of tinted glass, full to the cork, with caps and labels; and an empty carafe.

use super::Palette;
use crate::gltf::{Document, MaterialId, Shape};
use crate::lathe::{Piece, curve, lathe, line, round};

/// Number of segments around the axis.
const SEGMENTS: u32 = 40;
/// Gap between faces of a bottle, its cap and its label (m).
const GAP: f64 = 0.0003;
/// Thickness of a label (m).
const PAPER: f64 = 0.0004;

/// Outline, mouth and label of a bottle.
struct Bottle {
    /// Outline of the glass.
    outline: Vec<Piece>,
    /// Radius and height of the mouth (m).
    mouth: [f64; 2],
    /// Radius of the body, lower and upper edge of the label (m).
    label: Option<[f64; 3]>,
}

/// Adds all kinds of bottles; the carafe is the last.
pub fn add(document: &mut Document, palette: &Palette) -> Vec<Shape> {
    let kinds = [
        ("bottle of wine", wine(), palette.green, palette.foil),
        ("bottle of whiskey", whiskey(), palette.amber, palette.cork),
        ("bottle of vodka", vodka(), palette.clear, palette.steel),
        ("bottle of gin", vodka(), palette.blue, palette.foil),
        ("bottle of bitter", liqueur(), palette.red, palette.brass),
        ("bottle of liqueur", liqueur(), palette.amber, palette.brass),
    ];
    let mut shapes: Vec<Shape> = kinds
        .into_iter()
        .map(|(name, bottle, glass, cap)| {
            let body = lathe(SEGMENTS, &bottle.outline);
            let cap_mesh = lathe(SEGMENTS, &cap_of(bottle.mouth));
            let mut parts: Vec<(MaterialId, _)> = vec![(glass, body), (cap, cap_mesh)];
            if let Some(label) = bottle.label {
                parts.push((palette.paper, lathe(SEGMENTS, &label_of(label))));
            }
            let parts: Vec<_> = parts.iter().map(|(material, mesh)| (*material, mesh)).collect();
            document.shape(name, &parts)
        })
        .collect();
    shapes.push(document.shape("carafe", &[(palette.glass, &lathe(SEGMENTS, &carafe()))]));
    shapes
}

/// Outline of a stopper on the mouth.
fn cap_of([radius, height]: [f64; 2]) -> Vec<Piece> {
    let (bottom, top, radius) = (height + GAP, height + 0.022, radius + 0.001);
    vec![
        line([0.0, top], [radius - 0.002, top]),
        round([radius - 0.002, top], [radius, top - 0.002], false, 4),
        line([radius, top - 0.002], [radius, bottom]),
        line([radius, bottom], [0.0, bottom]),
    ]
}

/// Outline of a label around the body.
fn label_of([radius, lower, upper]: [f64; 3]) -> Vec<Piece> {
    let (inner, outer) = (radius + GAP, radius + GAP + PAPER);
    vec![
        line([outer, upper], [outer, lower]),
        line([outer, lower], [inner, lower]),
        line([inner, lower], [inner, upper]),
        line([inner, upper], [outer, upper]),
    ]
}

/// A bottle of a mouth, a neck along these points, a straight body and a concave bottom.
fn bottle(neck: &[[f64; 2]], label: Option<[f64; 2]>) -> Bottle {
    let ([mouth, top], [body, shoulder]) = (neck[0], neck[neck.len() - 1]);
    let lip = [mouth + 0.001, top + 0.012];
    let outline = vec![
        line([0.0, lip[1]], lip),
        line(lip, [lip[0], top + 0.001]),
        line([lip[0], top + 0.001], neck[0]),
        curve(neck, 6),
        line([body, shoulder], [body, 0.005]),
        round([body, 0.005], [body - 0.005, 0.0], true, 6),
        curve(&[[body - 0.005, 0.0], [0.5 * body, 0.007], [0.0, 0.010]], 5),
    ];
    Bottle { outline, mouth: lip, label: label.map(|[lower, upper]| [body, lower, upper]) }
}

fn wine() -> Bottle {
    let neck = [
        [0.0125, 0.284],
        [0.0128, 0.235],
        [0.0150, 0.216],
        [0.0280, 0.200],
        [0.0360, 0.182],
        [0.0370, 0.165],
    ];
    bottle(&neck, Some([0.045, 0.125]))
}

fn whiskey() -> Bottle {
    let neck = [
        [0.0135, 0.222],
        [0.0138, 0.195],
        [0.0170, 0.178],
        [0.0340, 0.168],
        [0.0435, 0.158],
        [0.0450, 0.145],
    ];
    bottle(&neck, Some([0.035, 0.105]))
}

fn vodka() -> Bottle {
    let neck = [
        [0.0125, 0.300],
        [0.0128, 0.262],
        [0.0160, 0.246],
        [0.0270, 0.236],
        [0.0345, 0.224],
        [0.0360, 0.210],
    ];
    bottle(&neck, None)
}

fn liqueur() -> Bottle {
    let neck = [
        [0.0120, 0.205],
        [0.0123, 0.165],
        [0.0160, 0.140],
        [0.0340, 0.120],
        [0.0500, 0.090],
        [0.0520, 0.060],
        [0.0450, 0.030],
    ];
    bottle(&neck, None)
}

/// An open, empty carafe with a wall of 3 mm.
fn carafe() -> Vec<Piece> {
    let outside = [
        [0.0320, 0.250],
        [0.0220, 0.215],
        [0.0200, 0.185],
        [0.0330, 0.140],
        [0.0600, 0.085],
        [0.0680, 0.045],
        [0.0560, 0.008],
        [0.0500, 0.000],
    ];
    let inside = [
        [0.0, 0.008],
        [0.0300, 0.0085],
        [0.0530, 0.014],
        [0.0645, 0.045],
        [0.0570, 0.085],
        [0.0300, 0.140],
        [0.0170, 0.185],
        [0.0192, 0.215],
        [0.0292, 0.250],
    ];
    vec![
        curve(&outside, 6),
        line([0.0500, 0.0], [0.0, 0.0]),
        curve(&inside, 6),
        curve(&[[0.0292, 0.250], [0.0306, 0.2512], [0.0320, 0.250]], 3),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lathe::tests::assert_solid;

    #[test]
    fn bottles_caps_and_labels_are_solids() {
        for (name, bottle) in
            [("wine", wine()), ("whiskey", whiskey()), ("vodka", vodka()), ("liqueur", liqueur())]
        {
            assert_solid(name, &lathe(SEGMENTS, &bottle.outline));
            assert_solid(name, &lathe(SEGMENTS, &cap_of(bottle.mouth)));
            if let Some(label) = bottle.label {
                assert_solid(name, &lathe(SEGMENTS, &label_of(label)));
            }
        }
        assert_solid("carafe", &lathe(SEGMENTS, &carafe()));
    }
}
