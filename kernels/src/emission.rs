//! Emissions: how light paths start, for every gather and every history. An emission is a file and a line here: the pass that
//! shoots (`shoot_pass`), and its description as data. Imports `interface`, `math`, `light`, `pass`.

#[cfg(not(target_arch = "spirv"))]
pub use crate::declare::Emission;

crate::declare::variants! {
    Emission {
        power: POWER;
        aimed: AIMED;
        guided: GUIDED;
    }
}
