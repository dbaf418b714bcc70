//! Single parts of the kernels, each against what it must compute: lobes, textures, media, tracers, gathers.

mod aimed;
mod gathers;
mod instances;
mod lobes;
mod media;
mod overlaps;
mod primitives;
mod textures;
mod tracer;
