//! Every `#[spirv]` entry point: bounds check, bind, call the pass; no logic.
//!
//! Parameters are named after the buffers, and the host binds by these names. Entry points that trace come in two
//! versions of one name (`tracing`): `software` in `base.spv`, `hardware` (ray queries) in `rayquery.spv`.

#[cfg(not(feature = "ray-query"))]
pub mod density;
#[cfg(not(feature = "ray-query"))]
pub mod filter;
pub mod gathers;
#[cfg(feature = "ray-query")]
pub mod hardware;
#[cfg(not(feature = "ray-query"))]
pub mod history;
#[cfg(not(feature = "ray-query"))]
pub mod points;
#[cfg(not(feature = "ray-query"))]
pub mod software;
#[cfg(not(feature = "ray-query"))]
pub mod steps;

mod tracing;

use crate::interface::frame::INVOCATIONS_PER_ROW;
use spirv_std::glam::UVec3;

/// Index of an invocation.
#[inline(always)]
fn index(id: UVec3) -> u32 {
    id.x + id.y * INVOCATIONS_PER_ROW
}
