//! KHR_draco_mesh_compression: primitives whose vertices and indices are compressed together.
//!
//! Each becomes a plain primitive: what is decoded goes into a new buffer, with accessors of floats and of indices.

use std::collections::HashMap;

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use gltf::json::Index;
use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::{Checked, USize64};
use serde_json::Value;

use super::document::Document;
use super::extension::Compressed;
use super::{accessor, buffer, unsupported};
use crate::SceneError;
use caustics_files::caught::caught;

/// Memory that decoding a triangle takes for a while (bytes): corner tables and what is predicted from them.
const TRIANGLE_BYTES: u64 = 300;

/// What a stream became: accessors of attributes by their ids in it, and of the indices.
#[derive(Clone)]
struct Decoded {
    attributes: HashMap<u64, Index<Accessor>>,
    indices: Index<Accessor>,
}

/// Decompresses primitives. One that cannot be is left as it is where the file has it uncompressed too.
pub fn decompress(document: &mut Document) -> Result<(), SceneError> {
    let mut known: HashMap<String, Decoded> = HashMap::new();
    let mut largest = 0;
    for Compressed { mesh, primitive, extension } in std::mem::take(&mut document.compressed) {
        let name = document.root.meshes[mesh].name.as_deref();
        let owner = format!("{}, primitive {primitive}", unsupported::label("mesh", mesh, name));
        let ids: Vec<u64> =
            attributes(document, mesh, primitive, &extension).into_iter().map(|(.., id)| id).collect();
        let key = format!("{extension} {ids:?}");
        let decoded = match known.get(&key) {
            Some(decoded) => Ok(decoded.clone()),
            None => decode(document, mesh, primitive, &extension, &owner, &mut largest)?,
        };
        match decoded {
            Ok(decoded) => {
                link(document, mesh, primitive, &extension, &decoded);
                known.insert(key, decoded);
            }
            Err(what) => {
                let (file, what) = (document.file.clone(), format!("{owner} {what}"));
                let error = SceneError::Compressed { file, what: what.clone() };
                if !has_fallback(document, mesh, primitive) {
                    return Err(error);
                }
                document.replace(&owner, &what, "its uncompressed copy is rendered", error)?;
            }
        }
    }
    Ok(())
}

/// Whether a primitive's positions are there without compression.
fn has_fallback(document: &Document, mesh: usize, primitive: usize) -> bool {
    let primitive = &document.root.meshes[mesh].primitives[primitive];
    let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
    let accessor = positions.and_then(|index| document.root.accessors.get(index.value()));
    accessor.is_some_and(|accessor| accessor.buffer_view.is_some())
}

/// The attributes of a primitive that the loader reads and a stream holds, with their ids in it.
fn attributes(
    document: &Document,
    mesh: usize,
    primitive: usize,
    extension: &Value,
) -> Vec<(Semantic, Index<Accessor>, u64)> {
    let is_read = |semantic: &Semantic| {
        matches!(
            semantic,
            Semantic::Positions
                | Semantic::Normals
                | Semantic::Tangents
                | Semantic::TexCoords(_)
                | Semantic::Colors(0)
        )
    };
    let attributes = document.root.meshes[mesh].primitives[primitive].attributes.iter();
    let known = attributes.filter_map(|(semantic, &index)| match semantic {
        Checked::Valid(semantic) if is_read(semantic) => {
            let id = extension["attributes"][semantic.to_string()].as_u64()?;
            Some((semantic.clone(), index, id))
        }
        _ => None,
    });
    known.collect()
}

/// Decodes a primitive's stream into new accessors; the inner error says what is wrong with the stream.
fn decode(
    document: &mut Document,
    mesh: usize,
    primitive: usize,
    extension: &Value,
    owner: &str,
    largest: &mut u64,
) -> Result<Result<Decoded, String>, SceneError> {
    // Take memory for what the document says that there is; the decoder stops beyond it.
    let attributes = attributes(document, mesh, primitive, extension);
    let mut bytes = 0_u64;
    for &index in document.root.meshes[mesh].primitives[primitive].attributes.values() {
        let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
        bytes = bytes.saturating_add(accessor.count.0.saturating_mul(16));
    }
    let indices = document.root.meshes[mesh].primitives[primitive].indices;
    let corners = match indices {
        Some(indices) => document.get(&document.root.accessors, indices, "accessor", owner)?.count.0,
        None => 0,
    };
    let faces = corners / 3;
    bytes = bytes.saturating_add(corners.saturating_mul(4));
    let transient = faces.saturating_mul(TRIANGLE_BYTES).saturating_add(bytes);
    document.take(bytes, format_args!("{owner}"))?;
    document.take_for_a_while(transient, largest, format_args!("{owner}"))?;

    let view = extension["bufferView"].as_u64().unwrap_or(u64::MAX);
    let stream = match buffer::view_bytes(view, &document.sections.buffer_views, &document.buffers) {
        Ok(stream) => stream,
        Err(what) => return Ok(Err(what)),
    };
    let limits =
        DecodeLimits::default().with_max_faces(faces).with_max_decoded_bytes(bytes.saturating_mul(2));
    // The decoder is made to return errors; should one of its checks be missing, damaged bytes must not end the program.
    let decoded = caught(|| {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
    });
    let decoded = match decoded {
        Some(Ok(decoded)) => decoded,
        Some(Err(error)) => return Ok(Err(format!("cannot be decompressed (Draco: {})", error.message()))),
        None => return Ok(Err("cannot be decompressed (Draco: its stream is damaged)".into())),
    };
    let points = decoded.num_points();
    let mut read = HashMap::new();
    for (_, index, id) in attributes {
        // Memory was taken for what the accessors say, of at most four numbers each.
        let accessor = &document.root.accessors[index.value()];
        let is_short = matches!(accessor.type_, Checked::Valid(shape) if shape.multiplicity() <= 4);
        if accessor.count.0 != points as u64 || !is_short {
            let declared = accessor.count.0;
            return Ok(Err(format!("cannot be decompressed (Draco: {points} points instead of {declared})")));
        }
        if read.contains_key(&id) {
            continue;
        }
        let Some(attribute) = u32::try_from(id).ok().and_then(|id| decoded.attribute_by_unique_id(id)) else {
            return Ok(Err(format!("cannot be decompressed (Draco: there is no attribute {id})")));
        };
        let source = document.root.accessors[index.value()].clone();
        let numbers = match source.type_ {
            Checked::Valid(shape) => shape.multiplicity(),
            Checked::Invalid => 1,
        };
        let largest = accessor::largest(&source);
        let numbers = attribute.read_f32s(points, numbers);
        let bytes: Vec<u8> =
            numbers.iter().flat_map(|&number| accessor::share(number, largest).to_le_bytes()).collect();
        let kept = matches!(source.component_type, Checked::Valid(GenericComponentType(ComponentType::F32)));
        let accessor = Accessor {
            component_type: Checked::Valid(GenericComponentType(ComponentType::F32)),
            normalized: false,
            sparse: source.sparse.clone().filter(|_| kept),
            ..source
        };
        read.insert(id, append(document, accessor, bytes, points));
    }
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
    let indices = append(document, accessor, indices, 3 * decoded.num_faces());
    Ok(Ok(Decoded { attributes: read, indices }))
}

/// Appends an accessor of so many elements with its bytes.
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

/// Makes a primitive refer to what was decoded.
fn link(document: &mut Document, mesh: usize, primitive: usize, extension: &Value, decoded: &Decoded) {
    let attributes = attributes(document, mesh, primitive, extension);
    let primitive = &mut document.root.meshes[mesh].primitives[primitive];
    for (semantic, _, id) in attributes {
        if let Some(&accessor) = decoded.attributes.get(&id) {
            primitive.attributes.insert(Checked::Valid(semantic), accessor);
        }
    }
    primitive.indices = Some(decoded.indices);
    // Strips are decoded into triangles.
    primitive.mode = Checked::Valid(Mode::Triangles);
}
