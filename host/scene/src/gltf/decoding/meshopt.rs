//! EXT_meshopt_compression and KHR_meshopt_compression: compressed buffer views.
//!
//! Each compressed view becomes a plain view of a new buffer, before other passes read it. The document's counts limit the number
//! of decoded bytes, and memory is reserved for them first.

use gltf::json::Index;
use gltf::json::validation::USize64;

use super::model::Model;
use crate::SceneError;
use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;
use crate::gltf::document::extension::Compression;

mod attributes;
mod filter;
mod indices;
#[cfg(test)]
mod tests;

/// Decompresses every compressed view.
pub fn decompress(model: &mut Model, context: &mut ImportContext<'_>) -> Result<(), SceneError> {
    let document = &mut model.document;
    let compressions = std::mem::take(&mut document.sections.compressions);
    for (id, compression) in compressions.iter().enumerate() {
        let Some(compression) = compression else { continue };
        let bytes = compression.count.unwrap_or(0).saturating_mul(compression.byte_stride.unwrap_or(0));
        context.take(bytes, format_args!("its compressed buffer view {id}"))?;
        let decoded = decode(document, compression)
            .map_err(|what| context.compressed_error(format_args!("buffer view {id} {what}")))?;

        // Replace the view by a plain view
        let view = &mut document.root.buffer_views[id];
        view.buffer = Index::new(document.buffers.len() as u32);
        (view.byte_offset, view.byte_length) = (None, USize64::from(decoded.len()));
        document.buffers.push(decoded);
    }
    Ok(())
}

/// Decodes the bytes of a view. An error describes the fault.
fn decode(document: &Document, compression: &Compression) -> Result<Vec<u8>, String> {
    let Compression { buffer, byte_offset, byte_length, byte_stride, count, mode, filter } = compression;
    let (start, length) = (byte_offset.unwrap_or(0), byte_length.unwrap_or(0));
    let bytes = document.buffer_bytes(buffer.unwrap_or(0), start, length)?;
    let (count, stride) = (count.unwrap_or(0) as usize, byte_stride.unwrap_or(0) as usize);
    let mode = mode.as_deref().unwrap_or_default();
    let is_sized = match mode {
        "ATTRIBUTES" => stride % 4 == 0 && (4..=256).contains(&stride),
        "TRIANGLES" | "INDICES" => matches!(stride, 2 | 4),
        _ => false,
    };
    if !is_sized || (mode == "TRIANGLES" && !count.is_multiple_of(3)) {
        return Err(format!("has {count} elements of {stride} bytes, which mode {mode:?} cannot have"));
    }
    let filter = filter.as_deref().unwrap_or("NONE");
    let decoded = match mode {
        "ATTRIBUTES" => attributes::decode(bytes, count, stride).and_then(|mut decoded| {
            filter::apply(filter, &mut decoded, stride)?;
            Some(decoded)
        }),
        "TRIANGLES" => indices::triangles(bytes, count, stride),
        _ => indices::sequence(bytes, count, stride),
    };
    decoded.ok_or_else(|| format!("({mode}, filter {filter}) is damaged or of a newer version"))
}
