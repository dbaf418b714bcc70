//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views whose bytes are compressed.
//!
//! Each such view becomes a plain one of a new buffer, before anybody reads it. What is decoded never exceeds the counts that
//! the document says, and memory is taken for it first.

use gltf::json::Index;
use gltf::json::validation::USize64;
use serde_json::Value;

use super::document::Document;
use super::extension::compression;
use crate::SceneError;

mod attributes;
mod filter;
mod indices;
#[cfg(test)]
mod tests;

/// Decompresses every view that is compressed.
pub fn decompress(document: &mut Document) -> Result<(), SceneError> {
    for id in 0..document.root.buffer_views.len() {
        let Some(extension) = document.sections.buffer_views.get(id).and_then(compression).cloned() else {
            continue;
        };
        let number = |key: &str| extension[key].as_u64().unwrap_or(0);
        let bytes = number("count").saturating_mul(number("byteStride"));
        document.take(bytes, format_args!("its compressed buffer view {id}"))?;
        let decoded = decode(document, &extension).map_err(|what| SceneError::Compressed {
            file: document.file.clone(),
            what: format!("buffer view {id} {what}"),
        })?;
        // The view as the rest of the loader knows it.
        let buffer = document.buffers.len();
        let view = &mut document.root.buffer_views[id];
        view.buffer = Index::new(buffer as u32);
        (view.byte_offset, view.byte_length) = (None, USize64::from(decoded.len()));
        let view = &mut document.sections.buffer_views[id];
        view["buffer"] = buffer.into();
        (view["byteOffset"], view["byteLength"]) = (0.into(), decoded.len().into());
        document.buffers.push(decoded);
    }
    Ok(())
}

/// The bytes of a view. An error says what is wrong with it.
fn decode(document: &Document, extension: &Value) -> Result<Vec<u8>, String> {
    let number = |key: &str| extension[key].as_u64().unwrap_or(0);
    let buffer = document.buffers.get(number("buffer") as usize).ok_or_else(|| {
        format!("refers to buffer {}, but there are {}", number("buffer"), document.buffers.len())
    })?;
    let start = number("byteOffset");
    let end = start.saturating_add(number("byteLength"));
    if end > buffer.len() as u64 {
        return Err(format!("needs {end} bytes of a buffer of {}", buffer.len()));
    }
    let bytes = &buffer[start as usize..end as usize];
    let (count, stride) = (number("count") as usize, number("byteStride") as usize);
    let mode = extension["mode"].as_str().unwrap_or_default();
    let is_sized = match mode {
        "ATTRIBUTES" => stride % 4 == 0 && (4..=256).contains(&stride),
        "TRIANGLES" | "INDICES" => matches!(stride, 2 | 4),
        _ => false,
    };
    if !is_sized || (mode == "TRIANGLES" && !count.is_multiple_of(3)) {
        return Err(format!("has {count} elements of {stride} bytes, which mode {mode:?} cannot have"));
    }
    let filter = extension["filter"].as_str().unwrap_or("NONE");
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
