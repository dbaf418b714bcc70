//! Faces of a primitive.

use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, accessor::Accessor};

use super::accessor::AccessorReader;
use super::context::ImportContext;
use super::document::Document;
use crate::SceneError;

/// Accessor of an attribute.
pub fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// Mode of a primitive; `None` if it has no triangles.
pub fn triangle_mode(primitive: &Primitive) -> Option<Mode> {
    match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => Some(mode),
        _ => None,
    }
}

/// Reads the indices of a primitive, and checks that each is below the number of vertices.
pub fn indices(
    document: &Document,
    context: &ImportContext<'_>,
    primitive: &Primitive,
    vertices: usize,
    owner: &str,
) -> Result<Vec<u32>, SceneError> {
    let indices = match primitive.indices {
        Some(indices) => AccessorReader::new(document, context, owner).integers(indices)?,
        None => (0..vertices as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
        let what = format!("index {index} is out of range, there are {vertices} vertices");
        return Err(context.mesh_error(owner, what));
    }
    Ok(indices)
}

/// Corners of each triangle, counter-clockwise.
pub fn faces(indices: &[u32], mode: Mode) -> Box<dyn Iterator<Item = [u32; 3]> + '_> {
    let windows = indices.windows(3).enumerate();
    match mode {
        Mode::TriangleStrip => Box::new(windows.map(|(index, ids)| {
            if index % 2 == 0 { [ids[0], ids[1], ids[2]] } else { [ids[0], ids[2], ids[1]] }
        })),
        Mode::TriangleFan => {
            Box::new(windows.map(|(index, _)| [indices[index + 1], indices[index + 2], indices[0]]))
        }
        _ => Box::new(indices.as_chunks().0.iter().copied()),
    }
}
