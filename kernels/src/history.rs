//! Histories: from which of the last frame's collection points one of today's reuses light, and how much of it still holds. A
//! history is a file and a line here: its passes, and what it is as data. `auxiliary` says to other tools what pixels show and
//! where it was. Imports `interface`, `math`, `gather`, `pass`.

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
