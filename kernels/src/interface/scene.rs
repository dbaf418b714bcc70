//! The tables of a scene that paths read, as kernels pass them around.

use crate::interface::light::Light;
use crate::interface::material::Material;
use crate::interface::triangle::{Triangle, TriangleSurface};

/// The tables of a scene that paths read.
#[derive(Clone, Copy)]
pub struct SceneTables<'a> {
    /// Corners.
    pub triangles: &'a [Triangle],
    /// Normals and ids.
    pub surfaces: &'a [TriangleSurface],
    /// Materials.
    pub materials: &'a [Material],
    /// Lights.
    pub lights: &'a [Light],
}
