//! Bytes of an accessor's elements, checked against the ends of their buffers before they are read.

use gltf::json::accessor::Accessor;
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

use super::reader::AccessorReader;
use crate::SceneError;

/// Maximum number of elements without bytes, for a file of fewer bytes.
const MAX_ZEROS: u64 = 1 << 16;

/// Elements in a buffer view.
struct Span {
    view: Index<buffer::View>,
    /// Offset of the first element (bytes).
    offset: u64,
    count: u64,
    /// Size of each (bytes).
    size: usize,
}

impl<'a> AccessorReader<'a> {
    /// Bytes of each element; checks that all lie in the view and that the view lies in its buffer. `None` without a view: such
    /// elements cost the file nothing but take memory. Their number is therefore limited by the file's length.
    pub(super) fn elements(
        &self,
        index: Index<Accessor>,
        accessor: &Accessor,
        size: usize,
    ) -> Result<Option<impl Iterator<Item = &'a [u8]> + use<'a>>, SceneError> {
        let Some(view) = accessor.buffer_view else {
            let (count, max_count) = (accessor.count.0, self.document.bytes.max(MAX_ZEROS));
            let what =
                || format!("has {count} elements without a buffer view, and at most {max_count} are read");
            return if count <= max_count { Ok(None) } else { Err(self.error(index, what())) };
        };
        let (offset, count) = (accessor.byte_offset.unwrap_or_default().0, accessor.count.0);
        self.split(index, &Span { view, offset, count, size }).map(Some)
    }

    /// Replaced elements of a sparse accessor: their indices and their bytes.
    pub(super) fn substitutes(
        &self,
        index: Index<Accessor>,
        accessor: &Accessor,
        size: usize,
    ) -> Result<Vec<(usize, &'a [u8])>, SceneError> {
        let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
        let (at, values) = (&sparse.indices, &sparse.values);
        let Checked::Valid(component) = at.component_type else {
            return Err(self.error(index, "has sparse indices that are no unsigned integers"));
        };
        let count = sparse.count.0;
        let ids = Span { view: at.buffer_view, offset: at.byte_offset.0, count, size: component.0.size() };
        let values = Span { view: values.buffer_view, offset: values.byte_offset.0, count, size };
        let ids = self.split(index, &ids)?.map(unsigned);
        let values = self.split(index, &values)?;
        let pair = |(id, bytes): (u32, &'a [u8])| {
            let what = || format!("replaces element {id}, but there are {}", accessor.count.0);
            let is_there = u64::from(id) < accessor.count.0;
            if is_there { Ok((id as usize, bytes)) } else { Err(self.error(index, what())) }
        };
        ids.zip(values).map(pair).collect()
    }

    /// Bytes of each element of a span. Sums saturate, since a file's offsets have up to 64 bits.
    fn split(
        &self,
        index: Index<Accessor>,
        span: &Span,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, SceneError> {
        let Span { offset, count, size, .. } = *span;
        let wrong = |what: String| self.error(index, what);
        let (view, bytes) = self.view_and_buffer(index, span.view)?;

        // The view in its buffer
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(view.byte_length.0);
        if end > bytes.len() as u64 {
            return Err(wrong(format!("needs {end} bytes of a buffer of {}", bytes.len())));
        }
        let view_bytes = &bytes[start as usize..end as usize];

        // The elements in the view
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

    /// Buffer view of an accessor, and the bytes of its buffer.
    fn view_and_buffer(
        &self,
        index: Index<Accessor>,
        view: Index<buffer::View>,
    ) -> Result<(&'a buffer::View, &'a [u8]), SceneError> {
        let owner = format!("accessor {}", index.value());
        let missing = |kind, index, count| self.index_error(&owner, kind, index, count);
        let (views, buffers) = (&self.document.root.buffer_views, &self.document.buffers);
        let found = views.get(view.value());
        let view = found.ok_or_else(|| missing("buffer view", view.value(), views.len()))?;
        let buffer = view.buffer.value();
        let bytes = buffers.get(buffer).ok_or_else(|| missing("buffer", buffer, buffers.len()))?;
        Ok((view, bytes))
    }
}

/// Integer of one, two or four bytes.
pub fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| (number << 8) | u32::from(byte))
}
