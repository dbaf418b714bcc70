//! What a pass declares about itself (see the attribute [`pass`]), and how a CPU calls it. Imports `interface`, `seam` and `math`;
//! what the attribute makes stands in the pass's own file.

pub use caustics_kernel_macros::pass;

#[cfg(not(target_arch = "spirv"))]
pub use described::*;
#[cfg(not(target_arch = "spirv"))]
pub use on_cpu::{BufferError, Buffers, Call, LocalCounters};

#[cfg(not(target_arch = "spirv"))]
mod described;
#[cfg(not(target_arch = "spirv"))]
mod on_cpu;
