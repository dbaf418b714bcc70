//! Accessors: numbers in buffers, of every type that glTF and KHR_mesh_quantization have.

use gltf::json::Index;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;

use self::bytes::{elements, substitutes, unsigned, wrong};
use super::document::Document;
use crate::SceneError;

mod bytes;

/// N numbers an element, for whom `owner` names: floats, or integers of 8 or 16 bits, which are shares of their largest
/// where the accessor is `normalized`. What is neither in a buffer nor replaced is zero.
pub fn numbers<const N: usize>(
    document: &Document,
    index: Index<Accessor>,
    owner: &str,
) -> Result<Vec<[f32; N]>, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    let has_shape = matches!(accessor.type_, Checked::Valid(shape) if shape.multiplicity() == N);
    let Some((size, read)) = component(accessor).filter(|_| has_shape).and_then(reader) else {
        let what = format!("should hold {N} an element: floats, or integers of 8 or 16 bits");
        return Err(wrong(document, index, owner, what));
    };
    let largest = largest(accessor);
    let element = |bytes: &[u8]| std::array::from_fn(|number| share(read(&bytes[number * size..]), largest));
    let mut all: Vec<[f32; N]> = match elements(document, index, accessor, owner, N * size)? {
        Some(elements) => elements.map(element).collect(),
        None => vec![[0.0; N]; accessor.count.0 as usize],
    };
    for (at, bytes) in substitutes(document, index, accessor, owner, N * size)? {
        all[at] = element(bytes);
    }
    Ok(all)
}

/// The number that bytes stand for.
type Read = fn(&[u8]) -> f32;

/// Bytes of a component, and how they are read.
fn reader(component: ComponentType) -> Option<(usize, Read)> {
    Some(match component {
        ComponentType::F32 => (4, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        ComponentType::I8 => (1, |b| f32::from(b[0] as i8)),
        ComponentType::U8 => (1, |b| f32::from(b[0])),
        ComponentType::I16 => (2, |b| f32::from(i16::from_le_bytes([b[0], b[1]]))),
        ComponentType::U16 => (2, |b| f32::from(u16::from_le_bytes([b[0], b[1]]))),
        ComponentType::U32 => return None,
    })
}

/// What the numbers of an accessor are shares of: its integers' largest where it is `normalized`, else 1.
pub fn largest(accessor: &Accessor) -> f32 {
    match component(accessor).filter(|_| accessor.normalized) {
        Some(ComponentType::I8) => 127.0,
        Some(ComponentType::U8) => 255.0,
        Some(ComponentType::I16) => 32767.0,
        Some(ComponentType::U16) => 65535.0,
        _ => 1.0,
    }
}

/// What a number stands for as a share of `largest`; the least of signed integers is -1 too.
pub fn share(number: f32, largest: f32) -> f32 {
    if largest == 1.0 { number } else { (number / largest).max(-1.0) }
}

/// One unsigned integer an element.
pub fn integers(document: &Document, index: Index<Accessor>, owner: &str) -> Result<Vec<u32>, SceneError> {
    let (accessor, size) = integer(document, index, owner)?;
    let mut all: Vec<u32> = match elements(document, index, accessor, owner, size)? {
        Some(elements) => elements.map(unsigned).collect(),
        None => vec![0; accessor.count.0 as usize],
    };
    for (at, bytes) in substitutes(document, index, accessor, owner, size)? {
        all[at] = unsigned(bytes);
    }
    Ok(all)
}

/// Elements of an accessor of any type, once those of its buffer view are known to be there; nothing is read.
pub fn count(document: &Document, index: Index<Accessor>, owner: &str) -> Result<u64, SceneError> {
    let accessor = document.get(&document.root.accessors, index, "accessor", owner)?;
    let (Some(component), Checked::Valid(shape)) = (component(accessor), accessor.type_) else {
        return Ok(0);
    };
    let size = component.size() * shape.multiplicity();
    elements(document, index, accessor, owner, size).map(|_| accessor.count.0)
}

/// How many unsigned integers there are, once they are known to be there; none is read.
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
