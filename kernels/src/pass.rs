//! The passes of a frame, a pass a file: each declares what it binds, and is a function of an index, generic over the seams.
//! Imports everything but `gather`'s variants.

pub mod collect;
pub mod density;
pub mod display;
pub mod filter;
pub mod reference;
pub mod resolve;
pub mod resolve_history;
pub mod reuse_paper;
pub mod reuse_validated;
pub mod shoot;
pub mod shoot_yang2021;
pub mod splat_kim2019;
pub mod step;
pub mod validate;
