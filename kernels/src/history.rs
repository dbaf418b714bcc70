//! Histories: the reuse of light from collection points of the last frame, as far as that light still holds. A history is a file
//! and a line here: its passes, and its description as data. `auxiliary` gives other tools the surfaces that pixels show, and
//! their motion. Imports `interface`, `math`, `gather`, `pass`.

pub mod auxiliary;
pub mod cells;
pub mod demodulate;
pub mod nearest;
pub mod path;
pub mod reprojected;
pub mod resolve_history;
pub mod significance;
pub mod window;

#[cfg(not(target_arch = "spirv"))]
pub use crate::declare::History;

crate::declare::variants! {
    History {
        none: NONE;
        paper: PAPER;
        validated: VALIDATED;
    }
}
