//! The compiled kernels that the host carries.

use thiserror::Error;

/// Hash of the kernels' sources.
pub const SOURCES: &str = env!("CAUSTICS_KERNELS_HASH");

/// The SPIR-V modules.
#[derive(Clone, Debug)]
pub struct Modules {
    /// For any Vulkan 1.2 device.
    pub base: Vec<u32>,
    /// For devices with ray queries.
    pub rayquery: Vec<u32>,
}

/// The modules are not what the sources say.
#[derive(Clone, Copy, Debug, Error)]
#[error(
    "kernels/*.spv is older than kernels/src: run `cargo kernels`, then build again; --runner cpu works as it is"
)]
pub struct Stale;

/// The embedded modules, unless the sources have changed since `cargo kernels`. The folder in the environment
/// variable `CAUSTICS_KERNELS` takes their place (for modules built to report panics).
pub fn modules() -> Result<Modules, Stale> {
    if let Some(folder) = std::env::var_os("CAUSTICS_KERNELS") {
        let read = |name| std::fs::read(std::path::Path::new(&folder).join(name)).map_err(|_| Stale);
        return Ok(Modules { base: words(&read("base.spv")?), rayquery: words(&read("rayquery.spv")?) });
    }
    if env!("CAUSTICS_KERNELS_FRESH") != "1" {
        return Err(Stale);
    }
    Ok(Modules {
        base: words(include_bytes!("../../kernels/base.spv")),
        rayquery: words(include_bytes!("../../kernels/rayquery.spv")),
    })
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(bytes)
}
