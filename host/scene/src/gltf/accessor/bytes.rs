//! Bytes of an accessor's elements, checked against the ends of their buffers before anything is read.

use gltf::json::accessor::Accessor;
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

use crate::SceneError;
use crate::gltf::document::Document;

/// Elements at most of an accessor that no bytes stand behind, where the file has fewer bytes.
const MAX_ZEROS: u64 = 1 << 16;

/// Bytes of each element, once all are known to lie in the view and the view in its buffer; `None` without a view. Elements without
/// one cost the file nothing and memory as much as others, so that there are at most as many as the file has bytes.
pub fn elements<'a>(
    document: &'a Document,
    index: Index<Accessor>,
    accessor: &Accessor,
    owner: &str,
    size: usize,
) -> Result<Option<impl Iterator<Item = &'a [u8]> + use<'a>>, SceneError> {
    let Some(view) = accessor.buffer_view else {
        let (count, max_count) = (accessor.count.0, document.bytes.max(MAX_ZEROS));
        let what = || format!("has {count} elements without a buffer view, and at most {max_count} are read");
        return if count <= max_count { Ok(None) } else { Err(wrong(document, index, owner, what())) };
    };
    let span =
        Span { view, offset: accessor.byte_offset.unwrap_or_default().0, count: accessor.count.0, size };
    span.split(document, index, owner).map(Some)
}

/// What a sparse accessor replaces: which element, and its bytes.
pub fn substitutes<'a>(
    document: &'a Document,
    index: Index<Accessor>,
    accessor: &Accessor,
    owner: &str,
    size: usize,
) -> Result<Vec<(usize, &'a [u8])>, SceneError> {
    let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
    let (at, values) = (&sparse.indices, &sparse.values);
    let Checked::Valid(component) = at.component_type else {
        return Err(wrong(document, index, owner, "has sparse indices that are no unsigned integers"));
    };
    let count = sparse.count.0;
    let ids = Span { view: at.buffer_view, offset: at.byte_offset.0, count, size: component.0.size() };
    let values = Span { view: values.buffer_view, offset: values.byte_offset.0, count, size };
    let ids = ids.split(document, index, owner)?.map(unsigned);
    let values = values.split(document, index, owner)?;
    let pair = |(id, bytes): (u32, &'a [u8])| {
        let what = || format!("replaces element {id}, but there are {}", accessor.count.0);
        let is_there = u64::from(id) < accessor.count.0;
        if is_there { Ok((id as usize, bytes)) } else { Err(wrong(document, index, owner, what())) }
    };
    ids.zip(values).map(pair).collect()
}

/// Elements in a buffer view.
struct Span {
    view: Index<buffer::View>,
    /// Where the first begins (bytes).
    offset: u64,
    count: u64,
    /// Size of each (bytes).
    size: usize,
}

impl Span {
    /// Bytes of each element. All sums saturate: a file's offsets may be as large as 64 bits hold.
    fn split<'a>(
        &self,
        document: &'a Document,
        index: Index<Accessor>,
        owner: &str,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, SceneError> {
        let wrong = |what: String| wrong(document, index, owner, what);
        let (size, count, offset) = (self.size, self.count, self.offset);
        let owner = format!("accessor {}", index.value());
        let view = document.get(&document.root.buffer_views, self.view, "buffer view", &owner)?;
        let bytes = document.buffers.get(view.buffer.value()).ok_or_else(|| SceneError::Index {
            file: document.file.clone(),
            owner,
            kind: "buffer",
            index: view.buffer.value(),
            count: document.buffers.len(),
        })?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(view.byte_length.0);
        if end > bytes.len() as u64 {
            return Err(wrong(format!("needs {end} bytes of a buffer of {}", bytes.len())));
        }
        let view_bytes = &bytes[start as usize..end as usize];
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(wrong(format!("has elements of {size} bytes, but the next begins after {stride}")));
        }
        let needed = match count.checked_sub(1) {
            Some(others) => {
                offset.saturating_add(others.saturating_mul(stride as u64)).saturating_add(size as u64)
            }
            None => 0,
        };
        if needed > view_bytes.len() as u64 {
            return Err(wrong(format!("needs {needed} bytes of a buffer view of {}", view_bytes.len())));
        }
        Ok((0..count as usize).map(move |element| {
            let at = offset as usize + element * stride;
            &view_bytes[at..at + size]
        }))
    }
}

/// An integer of one, two or four bytes.
pub fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| (number << 8) | u32::from(byte))
}

/// The error of an accessor that does not fit.
pub fn wrong(
    document: &Document,
    index: Index<Accessor>,
    owner: &str,
    what: impl std::fmt::Display,
) -> SceneError {
    SceneError::Accessor {
        file: document.file.clone(),
        accessor: index.value(),
        owner: owner.into(),
        what: what.to_string(),
    }
}
