//! Options of loading.

use std::collections::BTreeSet;

use crate::bvh::BvhOptions;

/// Options of [`Scene::load_with`](crate::Scene::load_with).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Refuses files with elements that are missing or out of range. Otherwise they are replaced, with a warning that names them.
    pub strict: bool,
    /// Name of the material variant (KHR_materials_variants); `None`: the file's default materials.
    pub variant: Option<String>,
    /// Name of the animation that plays; `None`: all together, where the last one wins if several set the same property.
    pub animation: Option<String>,
    /// Puts the scene on a floor: a wide Lambertian square under its bounds.
    pub floor: bool,
    /// Maximum number of triangles in copies of resting meshes: paths are faster without instances. Above it, meshes are stored
    /// once, the largest first.
    pub copies: u64,
    /// Nodes, by their index in the file, that [`Scene::edit`](crate::Scene::edit) may set. They and their descendants are loaded
    /// as if an animation moved them.
    pub grabbed: BTreeSet<usize>,
    /// Options of the BVHs. BVHs are stored on disk only if the caller names a folder.
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
