//! Textures: texels from chunks of memory, filtered; what they make of a material. Imports `interface` and `math`.

pub mod coordinates;
pub mod cut_out;
pub mod emission;
pub mod fetch;
pub mod sample;
pub mod srgb;
