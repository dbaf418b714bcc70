//! Single parts of the kernels, each against its known result: lobes, textures, media, tracers, gathers.

mod aimed;
mod gathers;
mod instances;
mod lobes;
mod media;
mod overlaps;
mod primitives;
mod textures;
mod tracer;
