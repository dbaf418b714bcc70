//! Vulkan through ash. May import `caustics_kernels::interface`, nothing else of ours.
//!
//! A [`context::Context`] is a device opened for compute; all other objects keep it alive. `memory` allocates the bytes of
//! each `buffer`. `structure` builds acceleration structures.
//! [`reflection`] reads the bindings of the entry points of a [`module`]. [`passes`] compiles them once a process
//! (`pipeline`) and binds buffers to them by name (`bound`).
//! `frame` records steps into one command buffer, runs it and measures its time. [`executable`] compiles an entry point to
//! inspect the result, and runs nothing.

pub(crate) mod bound;
pub(crate) mod buffer;
mod cache;
pub mod context;
pub(crate) mod debug;
pub mod device;
pub mod error;
pub mod executable;
mod extract;
pub(crate) mod frame;
mod instance;
pub(crate) mod memory;
pub mod module;
pub mod passes;
pub(crate) mod pipeline;
pub(crate) mod primitives;
pub(crate) mod recorder;
pub mod reflection;
pub(crate) mod structure;
#[cfg(test)]
pub(crate) mod test_module;
mod transfer;

pub use device::{DeviceInfo, DeviceKind, best, devices};
pub use error::VulkanError;
