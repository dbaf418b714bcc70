//! KHR_draco_mesh_compression: primitives with jointly compressed vertices and indices.
//!
//! Each becomes a plain primitive: decoded numbers go into new buffers, with accessors of floats and of indices.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use self::decoded::{append_attribute, append_indices, check_size};
use super::model::Model;
use crate::SceneError;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::document::Document;
use crate::gltf::document::extension::{DracoPrimitive, DracoStream};
use crate::gltf::primitive::attribute;
use caustics_files::caught::caught;

mod decoded;

/// Temporary memory of the decoder for a triangle (bytes): corner tables and predictions.
const TRIANGLE_BYTES: u64 = 300;

/// An attribute in a stream that the import reads.
struct DracoAttribute {
    semantic: Semantic,
    accessor: Index<Accessor>,
    /// Id within the stream.
    id: u64,
}

/// Result of decoding a stream: accessors of attributes by their ids, and the accessor of indices.
#[derive(Clone)]
struct DecodedStream {
    attributes: HashMap<u64, Index<Accessor>>,
    indices: Index<Accessor>,
}

/// Decompresses all compressed primitives. If decoding fails, the primitive's uncompressed copy is kept, if the file has one.
pub fn decompress(model: &mut Model, context: &mut ImportContext<'_>) -> Result<(), SceneError> {
    let document = &mut model.document;
    let mut known: HashMap<(DracoStream, Vec<u64>), DecodedStream> = HashMap::new();
    let mut largest = 0;
    for DracoPrimitive { mesh, primitive, stream } in std::mem::take(&mut document.sections.draco) {
        let name = document.root.meshes[mesh].name.as_deref();
        let owner = format!("{}, primitive {primitive}", label("mesh", mesh, name));
        let plain = &document.root.meshes[mesh].primitives[primitive];
        let attributes = attributes(plain, &stream);

        // Decode each stream once
        let key = (stream, attributes.iter().map(|attribute| attribute.id).collect());
        let decoded = match known.get(&key) {
            Some(decoded) => Ok(decoded.clone()),
            None => {
                let declared = Declared::take(document, context, plain, &owner, &mut largest)?;
                decode(document, &attributes, &key.0, declared)
            }
        };
        match decoded {
            Ok(decoded) => {
                link(&mut document.root.meshes[mesh].primitives[primitive], &attributes, &decoded);
                known.insert(key, decoded);
            }
            Err(what) => {
                let what = format!("{owner} {what}");
                let error = context.compressed_error(&what);
                if !has_fallback(document, mesh, primitive) {
                    return Err(error);
                }
                context.replace(&owner, &what, "its uncompressed copy is rendered", error)?;
            }
        }
    }
    Ok(())
}

/// Whether a primitive's positions exist without compression.
fn has_fallback(document: &Document, mesh: usize, primitive: usize) -> bool {
    let positions = attribute(&document.root.meshes[mesh].primitives[primitive], Semantic::Positions);
    let accessor = positions.and_then(|index| document.root.accessors.get(index.value()));
    accessor.is_some_and(|accessor| accessor.buffer_view.is_some())
}

/// Attributes of a primitive that the import reads and the stream holds.
fn attributes(primitive: &Primitive, stream: &DracoStream) -> Vec<DracoAttribute> {
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
    let known = primitive.attributes.iter().filter_map(|(semantic, &accessor)| match semantic {
        Checked::Valid(semantic) if is_read(semantic) => {
            let id = (*stream.attributes.get(&semantic.to_string())?)?;
            Some(DracoAttribute { semantic: semantic.clone(), accessor, id })
        }
        _ => None,
    });
    known.collect()
}

/// Declared size of a primitive; the decoder stops beyond it.
#[derive(Clone, Copy)]
struct Declared {
    faces: u64,
    /// Size of the decoded numbers and indices (bytes).
    bytes: u64,
}

impl Declared {
    /// Reserves memory for the decoded data of a primitive.
    fn take(
        document: &Document,
        context: &mut ImportContext<'_>,
        primitive: &Primitive,
        owner: &str,
        largest: &mut u64,
    ) -> Result<Declared, SceneError> {
        let mut bytes = 0_u64;
        for &index in primitive.attributes.values() {
            let accessor = context.get(&document.root.accessors, index, "accessor", owner)?;
            bytes = bytes.saturating_add(accessor.count.0.saturating_mul(16));
        }
        let corners = match primitive.indices {
            Some(indices) => context.get(&document.root.accessors, indices, "accessor", owner)?.count.0,
            None => 0,
        };
        let faces = corners / 3;
        bytes = bytes.saturating_add(corners.saturating_mul(4));
        let transient = faces.saturating_mul(TRIANGLE_BYTES).saturating_add(bytes);
        context.take(bytes, format_args!("{owner}"))?;
        context.take_for_a_while(transient, largest, format_args!("{owner}"))?;
        Ok(Declared { faces, bytes })
    }
}

/// Decodes a stream into new accessors. An error describes the fault.
fn decode(
    document: &mut Document,
    attributes: &[DracoAttribute],
    stream: &DracoStream,
    declared: Declared,
) -> Result<DecodedStream, String> {
    let bytes = document.view_bytes(stream.buffer_view.unwrap_or(usize::MAX))?;
    let decoded = decode_stream(bytes, declared)?;
    let mut accessors = HashMap::new();
    for attribute in attributes {
        let accessor = &document.root.accessors[attribute.accessor.value()];
        check_size(accessor, decoded.num_points())?;
        if let Entry::Vacant(entry) = accessors.entry(attribute.id) {
            entry.insert(append_attribute(document, attribute.accessor, attribute.id, &decoded)?);
        }
    }
    Ok(DecodedStream { attributes: accessors, indices: append_indices(document, &decoded) })
}

/// Decodes the bytes of a stream.
fn decode_stream(bytes: &[u8], declared: Declared) -> Result<Mesh, String> {
    let limits = DecodeLimits::default()
        .with_max_faces(declared.faces)
        .with_max_decoded_bytes(declared.bytes.saturating_mul(2));
    // The decoder returns errors; should one of its checks be missing, damaged bytes must not end the program.
    let decoded = caught(|| {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
    });
    match decoded {
        Some(Ok(decoded)) => Ok(decoded),
        Some(Err(error)) => Err(format!("cannot be decompressed (Draco: {})", error.message())),
        None => Err("cannot be decompressed (Draco: its stream is damaged)".into()),
    }
}

/// Makes a primitive refer to decoded accessors.
fn link(primitive: &mut Primitive, attributes: &[DracoAttribute], decoded: &DecodedStream) {
    for DracoAttribute { semantic, id, .. } in attributes {
        if let Some(&accessor) = decoded.attributes.get(id) {
            primitive.attributes.insert(Checked::Valid(semantic.clone()), accessor);
        }
    }
    primitive.indices = Some(decoded.indices);
    // The decoder turns strips into triangles.
    primitive.mode = Checked::Valid(Mode::Triangles);
}
