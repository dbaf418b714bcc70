//! Accessors: numbers in buffers, of every type of glTF and KHR_mesh_quantization.

use gltf::json::Index;
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;

use self::bytes::unsigned;
use crate::SceneError;

pub use self::reader::AccessorReader;

mod bytes;
mod reader;

impl<'a> AccessorReader<'a> {
    /// Reads N numbers an element: floats, or integers of 8 or 16 bits. Integers of a `normalized` accessor are divided by their
    /// largest value. Elements without bytes are zero.
    pub fn numbers<const N: usize>(&self, index: Index<Accessor>) -> Result<Vec<[f32; N]>, SceneError> {
        let accessor = self.get(index)?;
        let has_shape = matches!(accessor.type_, Checked::Valid(shape) if shape.multiplicity() == N);
        let Some((size, read)) = component(accessor).filter(|_| has_shape).and_then(reader) else {
            let what = format!("should hold {N} an element: floats, or integers of 8 or 16 bits");
            return Err(self.error(index, what));
        };
        let largest = largest(accessor);
        let element =
            |bytes: &[u8]| std::array::from_fn(|number| share(read(&bytes[number * size..]), largest));
        let mut all: Vec<[f32; N]> = match self.elements(index, accessor, N * size)? {
            Some(elements) => elements.map(element).collect(),
            None => vec![[0.0; N]; accessor.count.0 as usize],
        };
        for (at, bytes) in self.substitutes(index, accessor, N * size)? {
            all[at] = element(bytes);
        }
        Ok(all)
    }

    /// Reads one unsigned integer an element.
    pub fn integers(&self, index: Index<Accessor>) -> Result<Vec<u32>, SceneError> {
        let (accessor, size) = self.integer(index)?;
        let mut all: Vec<u32> = match self.elements(index, accessor, size)? {
            Some(elements) => elements.map(unsigned).collect(),
            None => vec![0; accessor.count.0 as usize],
        };
        for (at, bytes) in self.substitutes(index, accessor, size)? {
            all[at] = unsigned(bytes);
        }
        Ok(all)
    }

    /// Reads a vertex attribute. An accessor with another number of elements than vertices is refused before it is read.
    pub fn vertex_attribute<const N: usize>(
        &self,
        index: Index<Accessor>,
        vertices: usize,
        name: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let count = self.count(index)?;
        if count != vertices as u64 {
            let what = format!("has {count} {name}, but {vertices} positions");
            return Err(SceneError::Mesh { file: self.file.into(), mesh: self.owner.into(), what });
        }
        self.numbers(index)
    }

    /// Number of elements of an accessor of any type. Checks that their bytes exist, and reads none.
    pub fn count(&self, index: Index<Accessor>) -> Result<u64, SceneError> {
        let accessor = self.get(index)?;
        let (Some(component), Checked::Valid(shape)) = (component(accessor), accessor.type_) else {
            return Ok(0);
        };
        let size = component.size() * shape.multiplicity();
        self.elements(index, accessor, size).map(|_| accessor.count.0)
    }

    /// Number of unsigned integers. Checks that their bytes exist, and reads none.
    pub fn integer_count(&self, index: Index<Accessor>) -> Result<u64, SceneError> {
        let (accessor, size) = self.integer(index)?;
        self.elements(index, accessor, size).map(|_| accessor.count.0)
    }

    /// Accessor of unsigned integers, and the size of one (bytes).
    fn integer(&self, index: Index<Accessor>) -> Result<(&'a Accessor, usize), SceneError> {
        let accessor = self.get(index)?;
        let is_scalar = matches!(accessor.type_, Checked::Valid(Type::Scalar));
        match component(accessor).filter(|_| is_scalar) {
            Some(ComponentType::U8) => Ok((accessor, 1)),
            Some(ComponentType::U16) => Ok((accessor, 2)),
            Some(ComponentType::U32) => Ok((accessor, 4)),
            _ => Err(self.error(index, "should hold one unsigned integer an element")),
        }
    }
}

/// Reads the number at the start of a slice.
type Read = fn(&[u8]) -> f32;

/// Size of a component (bytes), and its reader.
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

/// Divisor of the numbers of an accessor: the largest integer of its type if it is `normalized`, else 1.
pub fn largest(accessor: &Accessor) -> f32 {
    match component(accessor).filter(|_| accessor.normalized) {
        Some(ComponentType::I8) => 127.0,
        Some(ComponentType::U8) => 255.0,
        Some(ComponentType::I16) => 32767.0,
        Some(ComponentType::U16) => 65535.0,
        _ => 1.0,
    }
}

/// Divides a number by `largest`. The smallest signed integer gives -1 too.
pub fn share(number: f32, largest: f32) -> f32 {
    if largest == 1.0 { number } else { (number / largest).max(-1.0) }
}

fn component(accessor: &Accessor) -> Option<ComponentType> {
    match accessor.component_type {
        Checked::Valid(generic) => Some(generic.0),
        Checked::Invalid => None,
    }
}
