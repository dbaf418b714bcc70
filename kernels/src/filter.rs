//! Filters of the path-traced part, before the caustics are added. A filter is a file and a line here: its passes, and what it
//! is as data. Imports `interface`, `math`, `surface`.

#[cfg(not(target_arch = "spirv"))]
pub use crate::declare::Filter;

crate::declare::variants! {
    Filter {
        none: NONE;
        atrous: ATROUS;
    }
}
