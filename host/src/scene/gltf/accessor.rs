//! Accessors: typed views of buffers, checked against their ends before anything is read.

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

use super::document::Document;
use crate::scene::SceneError;

/// Three floats an element, for the primitive that `owner` names.
pub fn vectors(
    document: &Document,
    index: Index<Accessor>,
    owner: &str,
) -> Result<Vec<[f32; 3]>, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    if component(accessor) != Some(ComponentType::F32)
        || !matches!(accessor.type_, Checked::Valid(Type::Vec3))
    {
        return Err(wrong(document, index, owner, "should hold three floats an element"));
    }
    let read = |e: &[u8]| [float(e), float(&e[4..]), float(&e[8..])];
    elements(document, index, accessor, owner, 12).map(|elements| elements.map(read).collect())
}

/// Two numbers an element: floats, or shares of 255 or 65535.
pub fn pairs(document: &Document, index: Index<Accessor>, owner: &str) -> Result<Vec<[f32; 2]>, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    let is_pair = matches!(accessor.type_, Checked::Valid(Type::Vec2));
    type Read = fn(&[u8]) -> f32;
    let (size, read): (usize, Read) = match component(accessor).filter(|_| is_pair) {
        Some(ComponentType::F32) => (4, float),
        Some(ComponentType::U8) => (1, |e| f32::from(e[0]) / 255.0),
        Some(ComponentType::U16) => (2, |e| f32::from(u16::from_le_bytes([e[0], e[1]])) / 65535.0),
        _ => return Err(wrong(document, index, owner, "should hold two floats or shares an element")),
    };
    elements(document, index, accessor, owner, 2 * size)
        .map(|elements| elements.map(|e| [read(e), read(&e[size..])]).collect())
}

/// Four floats an element.
pub fn quads(document: &Document, index: Index<Accessor>, owner: &str) -> Result<Vec<[f32; 4]>, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    if component(accessor) != Some(ComponentType::F32)
        || !matches!(accessor.type_, Checked::Valid(Type::Vec4))
    {
        return Err(wrong(document, index, owner, "should hold four floats an element"));
    }
    let read = |e: &[u8]| [float(e), float(&e[4..]), float(&e[8..]), float(&e[12..])];
    elements(document, index, accessor, owner, 16).map(|elements| elements.map(read).collect())
}

/// One float an element.
pub fn scalars(document: &Document, index: Index<Accessor>, owner: &str) -> Result<Vec<f32>, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    if component(accessor) != Some(ComponentType::F32)
        || !matches!(accessor.type_, Checked::Valid(Type::Scalar))
    {
        return Err(wrong(document, index, owner, "should hold one float an element"));
    }
    elements(document, index, accessor, owner, 4).map(|elements| elements.map(float).collect())
}

/// Four numbers an element: floats, or integers that are shares of their largest, as animated rotations have them.
pub fn rotations(
    document: &Document,
    index: Index<Accessor>,
    owner: &str,
) -> Result<Vec<[f32; 4]>, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    let is_quad = matches!(accessor.type_, Checked::Valid(Type::Vec4));
    type Read = fn(&[u8]) -> f32;
    let (size, read): (usize, Read) = match component(accessor).filter(|_| is_quad) {
        Some(ComponentType::F32) => (4, float),
        Some(ComponentType::I8) => (1, |e| (f32::from(e[0] as i8) / 127.0).max(-1.0)),
        Some(ComponentType::U8) => (1, |e| f32::from(e[0]) / 255.0),
        Some(ComponentType::I16) => {
            (2, |e| (f32::from(i16::from_le_bytes([e[0], e[1]])) / 32767.0).max(-1.0))
        }
        Some(ComponentType::U16) => (2, |e| f32::from(u16::from_le_bytes([e[0], e[1]])) / 65535.0),
        _ => return Err(wrong(document, index, owner, "should hold four floats or shares an element")),
    };
    let quad = |e: &[u8]| [0, 1, 2, 3].map(|i| read(&e[i * size..]));
    elements(document, index, accessor, owner, 4 * size).map(|elements| elements.map(quad).collect())
}

/// Elements of an accessor of any type, once they are known to be there; nothing is read.
pub fn count(document: &Document, index: Index<Accessor>, owner: &str) -> Result<u64, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    let (Some(component), Checked::Valid(shape)) = (component(accessor), accessor.type_) else {
        return Ok(0);
    };
    let size = component.size() * shape.multiplicity();
    elements(document, index, accessor, owner, size).map(|_| accessor.count.0)
}

fn float(bytes: &[u8]) -> f32 {
    f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// One unsigned integer an element.
pub fn integers(document: &Document, index: Index<Accessor>, owner: &str) -> Result<Vec<u32>, SceneError> {
    let (accessor, size) = integer(document, index, owner)?;
    let read = |e: &[u8]| e.iter().rev().fold(0, |number, &byte| (number << 8) | u32::from(byte));
    elements(document, index, accessor, owner, size).map(|elements| elements.map(read).collect())
}

/// How many there are, once they are known to be there; none is read.
pub fn integer_count(document: &Document, index: Index<Accessor>, owner: &str) -> Result<u64, SceneError> {
    let (accessor, size) = integer(document, index, owner)?;
    elements(document, index, accessor, owner, size).map(|_| accessor.count.0)
}

/// An accessor of unsigned integers, and the bytes of one.
fn integer<'a>(
    document: &'a Document,
    index: Index<Accessor>,
    owner: &str,
) -> Result<(&'a Accessor, usize), SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    let is_scalar = matches!(accessor.type_, Checked::Valid(Type::Scalar));
    match component(accessor).filter(|_| is_scalar) {
        Some(ComponentType::U8) => Ok((accessor, 1)),
        Some(ComponentType::U16) => Ok((accessor, 2)),
        Some(ComponentType::U32) => Ok((accessor, 4)),
        _ => Err(wrong(document, index, owner, "should hold one unsigned integer an element")),
    }
}

fn component(accessor: &Accessor) -> Option<ComponentType> {
    match accessor.component_type {
        Checked::Valid(generic) => Some(generic.0),
        Checked::Invalid => None,
    }
}

fn wrong(
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

/// Bytes of each element, once all are known to lie in the view and the view in its buffer.
fn elements<'a>(
    document: &'a Document,
    index: Index<Accessor>,
    accessor: &Accessor,
    owner: &str,
    size: usize,
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, SceneError> {
    let wrong = |what: String| wrong(document, index, owner, what);
    if accessor.sparse.is_some() {
        return Err(wrong("is sparse, which is not supported".into()));
    }
    let Some(view) = accessor.buffer_view else {
        return Err(wrong("has no buffer view".into()));
    };
    let owner = format!("accessor {}", index.value());
    let view: &buffer::View = document.get(&document.root.buffer_views, view, "buffer view", &owner)?;
    let bytes = document.buffers.get(view.buffer.value()).ok_or_else(|| SceneError::Index {
        file: document.file.clone(),
        owner,
        kind: "buffer",
        index: view.buffer.value(),
        count: document.buffers.len(),
    })?;

    // All sums saturate: a file's offsets may be as large as 64 bits hold.
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
    let count = accessor.count.0;
    let offset = accessor.byte_offset.unwrap_or_default().0;
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
