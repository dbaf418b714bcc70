//! The bar's materials.

use crate::gltf::{Document, MaterialId, coated, glass, lambert, metal, tinted};

/// Materials that several objects share.
pub struct Palette {
    /// Clear glass.
    pub glass: MaterialId,
    /// Green glass of full bottles.
    pub green: MaterialId,
    /// Brown glass.
    pub amber: MaterialId,
    /// Nearly clear glass.
    pub clear: MaterialId,
    /// Blue glass.
    pub blue: MaterialId,
    /// Red glass.
    pub red: MaterialId,
    /// Whiskey.
    pub whiskey: MaterialId,
    /// Water.
    pub water: MaterialId,
    /// Red wine.
    pub red_wine: MaterialId,
    /// Sparkling wine.
    pub sparkling: MaterialId,
    /// A perfect mirror.
    pub mirror: MaterialId,
    /// Polished brass.
    pub brass: MaterialId,
    /// Polished steel.
    pub steel: MaterialId,
    /// Foil around a cork: too rough to cast caustics.
    pub foil: MaterialId,
    /// Lacquered wood.
    pub wood: MaterialId,
    /// Dark wood of counter and back bar.
    pub panelling: MaterialId,
    /// Polished tiles.
    pub tiles: MaterialId,
    /// Enamel of the lamps' shades.
    pub enamel: MaterialId,
    /// White insides of the shades.
    pub white: MaterialId,
    /// Black iron.
    pub iron: MaterialId,
    /// Seats.
    pub leather: MaterialId,
    /// Labels.
    pub paper: MaterialId,
    /// Corks.
    pub cork: MaterialId,
}

impl Palette {
    /// Adds the materials.
    pub fn new(document: &mut Document) -> Self {
        let mut add = |name: &str, material| document.material(name, material);
        Palette {
            glass: add("glass", glass(1.5, 0.002)),
            green: add("green glass", tinted(1.5, [0.30, 0.62, 0.26], 0.05)),
            amber: add("amber glass", tinted(1.5, [0.86, 0.48, 0.12], 0.05)),
            clear: add("clear bottle", tinted(1.5, [0.93, 0.96, 0.94], 0.05)),
            blue: add("blue glass", tinted(1.5, [0.36, 0.62, 0.90], 0.05)),
            red: add("red glass", tinted(1.5, [0.88, 0.22, 0.12], 0.05)),
            whiskey: add("whiskey", tinted(1.36, [0.90, 0.55, 0.16], 0.05)),
            water: add("water", tinted(1.33, [0.97, 0.99, 0.99], 0.1)),
            red_wine: add("red wine", tinted(1.34, [0.55, 0.06, 0.08], 0.03)),
            sparkling: add("sparkling wine", tinted(1.34, [0.96, 0.86, 0.52], 0.05)),
            mirror: add("mirror", metal([0.94, 0.94, 0.94], 0.0)),
            brass: add("brass", metal([0.90, 0.72, 0.40], 0.05)),
            steel: add("steel", metal([0.88, 0.88, 0.87], 0.03)),
            foil: add("foil", metal([0.70, 0.58, 0.34], 0.4)),
            wood: add("wood", coated([0.46, 0.33, 0.22], 0.05)),
            panelling: add("panelling", coated([0.16, 0.09, 0.06], 0.3)),
            tiles: add("tiles", coated([0.22, 0.21, 0.20], 0.1)),
            enamel: add("enamel", coated([0.04, 0.12, 0.09], 0.15)),
            white: add("white", lambert([0.75, 0.73, 0.68])),
            iron: add("iron", lambert([0.05, 0.05, 0.05])),
            leather: add("leather", coated([0.20, 0.07, 0.05], 0.4)),
            paper: add("paper", lambert([0.68, 0.64, 0.54])),
            cork: add("cork", lambert([0.52, 0.38, 0.24])),
        }
    }
}
