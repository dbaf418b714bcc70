//! Options of loading.

use std::collections::BTreeSet;

use crate::bvh::BvhOptions;

/// Options of [`Scene::load_with`](crate::Scene::load_with).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Refuses files with elements that are missing or out of range. Else they are replaced, with a warning that names them.
    pub strict: bool,
    /// Variant of the materials, by its name (KHR_materials_variants); `None` for what the file shows without one.
    pub variant: Option<String>,
    /// The animation that plays, by its name; `None` for all together, of which the last counts where several set the same.
    pub animation: Option<String>,
    /// Puts the scene on a floor: a wide Lambertian square right under its bounds.
    pub floor: bool,
    /// Number of triangles that copies of meshes that stand still may take: paths are faster without instances. Beyond, the
    /// meshes that would take most are stored once.
    pub copies: u64,
    /// Nodes, by their index in the file, that [`Scene::edit`](crate::Scene::edit) may place: they and what is below them are
    /// loaded as if an animation moved them.
    pub grabbed: BTreeSet<usize>,
    /// Options of the BVHs that rays are traced by. None is kept on disk unless the caller names a folder.
    pub bvh: BvhOptions,
}

impl Default for LoadOptions {
    fn default() -> LoadOptions {
        LoadOptions {
            strict: false,
            variant: None,
            animation: None,
            floor: false,
            copies: 1 << 20,
            grabbed: BTreeSet::new(),
            bvh: BvhOptions::default(),
        }
    }
}
