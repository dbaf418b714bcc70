//! Textures: sampling against an oracle in double precision, levels, normal maps, emission, holes, and blended
//! surfaces.

mod blends;
mod emission;
mod filter;
mod holes;
mod light;
mod sampling;
