//! Types that host and kernels share: `repr(C)` plain-old-data with a unit on every field. Imports nothing of the crate.

pub mod auxiliary;
pub mod balance;
pub mod bvh;
pub mod caster;
pub mod choice;
pub mod counters;
pub mod denoiser;
pub mod density;
pub mod environment;
pub mod features;
pub mod frame;
pub mod guide;
pub mod history;
pub mod instance;
pub mod ledger;
pub mod light;
pub mod light_bvh;
pub mod material;
#[cfg(not(target_arch = "spirv"))]
pub mod named;
pub mod packed;
pub mod point;
pub mod radiance_cache;
pub mod ray;
pub mod scene;
pub mod seen;
pub mod sequence;
pub mod step;
pub mod texture;
pub mod triangle;

/// Marks "no such element" in every id field.
pub const NONE: u32 = u32::MAX;
