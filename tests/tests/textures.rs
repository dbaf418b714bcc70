//! Textures: sampling against an oracle in double precision, levels, normal maps, emission, holes.

#[path = "textures/emission.rs"]
mod emission;
#[path = "textures/filter.rs"]
mod filter;
#[path = "textures/holes.rs"]
mod holes;
#[path = "textures/light.rs"]
mod light;
#[path = "textures/sampling.rs"]
mod sampling;
