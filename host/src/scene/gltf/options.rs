//! How a file is read where it can be read in several ways.

/// Options of [`Scene::load_with`](crate::Scene::load_with).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// What is missing or out of range is an error. Else it is replaced, with a warning that names it.
    pub strict: bool,
    /// Variant of the materials, by its name (KHR_materials_variants); `None` for what the file shows without one.
    pub variant: Option<String>,
    /// The scene stands on a floor: a wide Lambertian square right under its bounds.
    pub floor: bool,
}
