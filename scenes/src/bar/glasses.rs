//! Glasses: thin walls with inner and outer surfaces, and their fillings.
//!
//! A liquid overlaps the wall around it a little, so that no air lies between. Light enters the liquid at its own face; the inner
//! face of the glass does not refract there.

use super::Palette;
use crate::gltf::{Document, MaterialId, Shape};
use crate::lathe::{Piece, curve, filling, lathe, line, round};

/// Number of segments around the axis.
pub const SEGMENTS: u32 = 44;
/// Overlap of a liquid with the wall (m).
const OVERLAP: f64 = 0.0003;

/// Shapes of the glasses, empty and filled.
pub struct Glasses {
    /// Low and wide.
    pub tumbler: Shape,
    /// A tumbler of whiskey.
    pub whiskey: Shape,
    /// High and straight.
    pub highball: Shape,
    /// A highball of water.
    pub water: Shape,
    /// A bowl on a stem.
    pub wine: Shape,
    /// A glass of red wine.
    pub red_wine: Shape,
    /// A cone on a stem.
    pub martini: Shape,
    /// Narrow, on a stem.
    pub flute: Shape,
    /// A flute of sparkling wine.
    pub sparkling: Shape,
}

/// Outline of a glass in parts.
pub struct Glass {
    /// Outside, from the rim down to the axis.
    outside: Vec<Piece>,
    /// Hollow, from the axis up to the rim.
    hollow: Vec<Piece>,
    /// Rim, from the hollow outwards.
    rim: Piece,
}

impl Glass {
    /// The complete outline.
    fn outline(&self) -> Vec<Piece> {
        self.outside.iter().chain(&self.hollow).chain([&self.rim]).cloned().collect()
    }
}

impl Glasses {
    /// Adds all shapes.
    pub fn new(document: &mut Document, palette: &Palette) -> Self {
        let mut add = |name: &str, glass: Glass, liquid: Option<(MaterialId, f64)>| {
            let wall = lathe(SEGMENTS, &glass.outline());
            match liquid {
                None => document.shape(name, &[(palette.glass, &wall)]),
                Some((liquid, level)) => {
                    let inside = lathe(SEGMENTS, &filling(&glass.hollow, level, OVERLAP));
                    document.shape(name, &[(palette.glass, &wall), (liquid, &inside)])
                }
            }
        };
        Glasses {
            tumbler: add("tumbler", tumbler(), None),
            whiskey: add("tumbler of whiskey", tumbler(), Some((palette.whiskey, 0.042))),
            highball: add("highball", highball(), None),
            water: add("highball of water", highball(), Some((palette.water, 0.115))),
            wine: add("wine glass", wine(), None),
            red_wine: add("glass of red wine", wine(), Some((palette.red_wine, 0.142))),
            martini: add("martini glass", martini(), None),
            flute: add("flute", flute(), None),
            sparkling: add("flute of sparkling wine", flute(), Some((palette.sparkling, 0.190))),
        }
    }
}

fn tumbler() -> Glass {
    straight(0.041, 0.039, 0.091, 0.0025, 0.012)
}

fn highball() -> Glass {
    straight(0.033, 0.031, 0.150, 0.002, 0.010)
}

/// A glass with straight walls: radii of rim and foot, height, thickness of wall and bottom (m).
fn straight(rim: f64, foot: f64, height: f64, wall: f64, bottom: f64) -> Glass {
    let edge = 0.004;
    let inner_foot = foot - wall;
    Glass {
        outside: vec![
            line([rim, height], [foot, edge]),
            round([foot, edge], [foot - edge, 0.0], true, 6),
            line([foot - edge, 0.0], [0.0, 0.0]),
        ],
        hollow: vec![
            line([0.0, bottom], [inner_foot - edge, bottom]),
            round([inner_foot - edge, bottom], [inner_foot, bottom + edge], false, 6),
            line([inner_foot, bottom + edge], [rim - wall, height]),
        ],
        rim: rim_between(rim - wall, rim, height),
    }
}

/// A rounded rim.
fn rim_between(inner: f64, outer: f64, height: f64) -> Piece {
    let middle = [0.5 * (inner + outer), height + 0.4 * (outer - inner)];
    curve(&[[inner, height], middle, [outer, height]], 3)
}

/// The underside of a foot of this radius (m).
fn underside(radius: f64) -> [Piece; 2] {
    let edge = curve(&[[radius, 0.003], [radius + 0.001, 0.0015], [radius, 0.0]], 3);
    [edge, line([radius, 0.0], [0.0, 0.0])]
}

fn wine() -> Glass {
    let bowl_and_stem = [
        [0.0330, 0.210],
        [0.0400, 0.175],
        [0.0430, 0.145],
        [0.0360, 0.112],
        [0.0180, 0.094],
        [0.0055, 0.084],
        [0.0040, 0.060],
        [0.0042, 0.025],
        [0.0080, 0.010],
        [0.0200, 0.0055],
        [0.0365, 0.003],
    ];
    let hollow =
        [[0.0, 0.0955], [0.016, 0.0975], [0.0343, 0.114], [0.0413, 0.145], [0.0384, 0.175], [0.0316, 0.210]];
    on_stem(&bowl_and_stem, vec![curve(&hollow, 5)], [0.0316, 0.0330, 0.210])
}

fn flute() -> Glass {
    let bowl_and_stem = [
        [0.0240, 0.225],
        [0.0280, 0.185],
        [0.0275, 0.150],
        [0.0220, 0.115],
        [0.0100, 0.092],
        [0.0045, 0.080],
        [0.0040, 0.050],
        [0.0045, 0.020],
        [0.0100, 0.008],
        [0.0200, 0.005],
        [0.0310, 0.003],
    ];
    let hollow =
        [[0.0, 0.0995], [0.008, 0.1015], [0.0204, 0.118], [0.0259, 0.150], [0.0265, 0.185], [0.0227, 0.225]];
    on_stem(&bowl_and_stem, vec![curve(&hollow, 5)], [0.0227, 0.0240, 0.225])
}

fn martini() -> Glass {
    let stem = [
        [0.0100, 0.098],
        [0.0045, 0.088],
        [0.0040, 0.050],
        [0.0045, 0.020],
        [0.0100, 0.008],
        [0.0220, 0.005],
        [0.0350, 0.003],
    ];
    let cone = line([0.055, 0.165], stem[0]);
    let hollow = vec![
        curve(&[[0.0, 0.1005], [0.008, 0.1020], [0.0125, 0.1044]], 4),
        line([0.0125, 0.1044], [0.0532, 0.165]),
    ];
    let outside = [cone, curve(&stem, 4)].into_iter().chain(underside(0.0350)).collect();
    Glass { outside, hollow, rim: rim_between(0.0532, 0.055, 0.165) }
}

/// A glass whose bowl, stem and foot are one curve; `rim` is inner radius, outer radius and height (m).
fn on_stem(bowl_and_stem: &[[f64; 2]], hollow: Vec<Piece>, rim: [f64; 3]) -> Glass {
    let foot = bowl_and_stem[bowl_and_stem.len() - 1][0];
    let outside = [curve(bowl_and_stem, 4)].into_iter().chain(underside(foot)).collect();
    Glass { outside, hollow, rim: rim_between(rim[0], rim[1], rim[2]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lathe::tests::assert_solid;

    #[test]
    fn glasses_are_solids_with_walls() {
        let glasses = [
            ("tumbler", tumbler()),
            ("highball", highball()),
            ("wine", wine()),
            ("flute", flute()),
            ("martini", martini()),
        ];
        for (name, glass) in glasses {
            assert_solid(name, &lathe(SEGMENTS, &glass.outline()));
        }
    }

    #[test]
    fn fillings_are_solids() {
        for (name, glass, level) in [
            ("tumbler", tumbler(), 0.042),
            ("highball", highball(), 0.115),
            ("wine", wine(), 0.142),
            ("flute", flute(), 0.19),
        ] {
            assert_solid(name, &lathe(SEGMENTS, &filling(&glass.hollow, level, OVERLAP)));
        }
    }
}
