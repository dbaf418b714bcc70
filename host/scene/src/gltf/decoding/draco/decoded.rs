//! Decoded attributes and indices as accessors of new buffers.

use draco_core::Mesh;
use gltf::json::Index;
use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::validation::{Checked, USize64};

use crate::gltf::accessor;
use crate::gltf::document::Document;

/// Refuses an accessor whose number of elements differs. Memory was reserved for at most four numbers each.
pub fn check_size(accessor: &Accessor, points: usize) -> Result<(), String> {
    let is_short = matches!(accessor.type_, Checked::Valid(shape) if shape.multiplicity() <= 4);
    let declared = accessor.count.0;
    if declared == points as u64 && is_short {
        return Ok(());
    }
    Err(format!("cannot be decompressed (Draco: {points} points instead of {declared})"))
}

/// Appends an accessor of an attribute's floats, given its accessor in the document and its id in the stream.
pub fn append_attribute(
    document: &mut Document,
    accessor: Index<Accessor>,
    id: u64,
    decoded: &Mesh,
) -> Result<Index<Accessor>, String> {
    let stored = u32::try_from(id).ok().and_then(|id| decoded.attribute_by_unique_id(id));
    let Some(stored) = stored else {
        return Err(format!("cannot be decompressed (Draco: there is no attribute {id})"));
    };
    let source = document.root.accessors[accessor.value()].clone();
    let numbers = match source.type_ {
        Checked::Valid(shape) => shape.multiplicity(),
        Checked::Invalid => 1,
    };
    let (points, largest) = (decoded.num_points(), accessor::largest(&source));
    let numbers = stored.read_f32s(points, numbers);
    let bytes: Vec<u8> =
        numbers.iter().flat_map(|&number| accessor::share(number, largest).to_le_bytes()).collect();
    let are_floats =
        matches!(source.component_type, Checked::Valid(GenericComponentType(ComponentType::F32)));
    let accessor = Accessor {
        component_type: Checked::Valid(GenericComponentType(ComponentType::F32)),
        normalized: false,
        sparse: source.sparse.clone().filter(|_| are_floats),
        ..source
    };
    Ok(append(document, accessor, bytes, points))
}

/// Appends an accessor of the corners of the triangles.
pub fn append_indices(document: &mut Document, decoded: &Mesh) -> Index<Accessor> {
    let indices: Vec<u8> = decoded.faces().iter().flatten().flat_map(|point| point.0.to_le_bytes()).collect();
    let accessor = Accessor {
        buffer_view: None,
        byte_offset: None,
        count: USize64(0),
        component_type: Checked::Valid(GenericComponentType(ComponentType::U32)),
        extensions: None,
        extras: Default::default(),
        type_: Checked::Valid(Type::Scalar),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    };
    append(document, accessor, indices, 3 * decoded.num_faces())
}

/// Appends an accessor of `count` elements with their bytes.
fn append(document: &mut Document, accessor: Accessor, bytes: Vec<u8>, count: usize) -> Index<Accessor> {
    let view = View {
        buffer: Index::new(document.buffers.len() as u32),
        byte_length: USize64::from(bytes.len()),
        byte_offset: None,
        byte_stride: None,
        name: None,
        target: None,
        extensions: None,
        extras: Default::default(),
    };
    document.buffers.push(bytes);
    document.root.buffer_views.push(view);
    let view = Index::new(document.root.buffer_views.len() as u32 - 1);
    document.root.accessors.push(Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64::from(count),
        ..accessor
    });
    Index::new(document.root.accessors.len() as u32 - 1)
}
