//! The passes of a frame, a pass a file: each is a function of an index, generic over the seams.

pub mod collect;
pub mod density;
pub mod display;
pub mod enclosing;
pub mod filter;
pub mod gather;
pub mod ledger;
pub mod reach;
pub mod reference;
pub mod remember;
pub mod resolve;
pub mod reuse;
pub mod scatter_photons;
pub mod shoot;
pub mod splat;
pub mod step;
pub mod validate;
