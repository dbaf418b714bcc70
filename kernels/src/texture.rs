//! Textures: filtered texels from chunks of memory, and their effect on materials. Imports `interface` and `math`.

pub mod coordinates;
pub mod cut_out;
pub mod emission;
pub mod fetch;
pub mod sample;
pub mod srgb;
