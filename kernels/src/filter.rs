//! Filters of the path-traced part, before the caustics are added. A filter is a file and a line here: its passes, and what it
//! is as data. Imports `interface`, `math`, `surface`.

crate::declare::variants! {
    Filter {
        none: NONE;
        atrous: ATROUS;
    }
}
