//! The passes that methods share, one a file. Each declares the buffers that it binds, and is a function of an index, generic
//! over the traits. Imports all but `history`, `filter` and `method`.

pub mod balance;
pub mod bound;
pub mod collect;
pub mod display;
pub mod more_points;
pub mod radiance_cache;
pub mod resolve;
pub mod share;
pub mod shoot;
pub mod step;
pub mod weigh;
pub mod widen;
