//! Filters of the path-traced part, before the caustics are added. A filter is a file and a line here: its passes, and its
//! description as data. Imports `interface`, `math`, `surface`.

#[cfg(not(target_arch = "spirv"))]
pub use crate::declare::Denoiser;

crate::declare::variants! {
    Denoiser {
        none: NONE;
        atrous: ATROUS;
    }
}
