//! Reuse of the frame before: which of its collection points lend light to one of today's, and how much of it still holds.
//! Imports `interface`, `math`, `gather`.

pub mod cells;
pub mod reprojected;
pub mod window;
