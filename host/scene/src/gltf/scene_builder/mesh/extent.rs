//! Sizes of meshes, known before their data is read.

use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use crate::SceneError;
use crate::gltf::accessor::AccessorReader;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::document::Document;
use crate::gltf::primitive::attribute;
use crate::gltf::scene_builder::node::WorldMesh;

/// Numbers of elements of a mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extent {
    /// Number of triangles.
    pub triangles: u64,
    /// Number of triangles in emissive primitives.
    pub emitting: u64,
    /// Number of vertices in the largest primitive.
    pub vertices: u64,
}

/// Counts the elements of a mesh from its accessors.
pub fn extent(
    document: &Document,
    context: &ImportContext<'_>,
    instance: &WorldMesh,
) -> Result<Extent, SceneError> {
    let mesh = context.get(&document.root.meshes, instance.mesh, "mesh", &instance.node)?;
    let label = label("mesh", instance.mesh.value(), mesh.name.as_deref());
    let mut extent = Extent::default();
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        let owner = format!("{label}, primitive {index}");
        let accessors = AccessorReader::new(document, context, &owner);
        let positions = attribute(primitive, Semantic::Positions);
        let vertices = positions.map_or(Ok(0), |positions| accessors.count(positions))?;
        let corners = primitive.indices.map_or(Ok(vertices), |indices| accessors.integer_count(indices))?;
        let triangles = match primitive.mode {
            Checked::Valid(Mode::Triangles) => corners / 3,
            Checked::Valid(Mode::TriangleStrip | Mode::TriangleFan) => corners.saturating_sub(2),
            _ => 0,
        };
        extent.triangles = extent.triangles.saturating_add(triangles);
        if emits(document, primitive) {
            extent.emitting = extent.emitting.saturating_add(triangles);
        }
        extent.vertices = extent.vertices.max(vertices);
    }
    Ok(extent)
}

/// Whether a primitive's material emits.
pub fn emits(document: &Document, primitive: &Primitive) -> bool {
    let material = primitive.material.and_then(|material| document.root.materials.get(material.value()));
    material.is_some_and(|material| material.emissive_factor.0 != [0.0; 3])
}
