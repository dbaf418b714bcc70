//! Named buffers in memory, each borrowed on its own while a pass runs.

use std::collections::HashMap;

use anyhow::{Context, bail};
use atomic_refcell::{AtomicRef, AtomicRefCell, AtomicRefMut};
use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};

/// Sixteen aligned bytes: the alignment of every type of the interface.
#[repr(C, align(16))]
#[derive(Clone, Copy, Zeroable, Pod)]
struct Row([u32; 4]);

struct Buffer {
    rows: Vec<Row>,
    bytes: usize,
}

/// Buffers by name.
#[derive(Default)]
pub struct Memory {
    buffers: HashMap<String, AtomicRefCell<Buffer>>,
}

impl Memory {
    /// Adds a buffer of zeros.
    pub fn add(&mut self, name: &str, bytes: usize) {
        let rows = vec![Row::zeroed(); bytes.div_ceil(16)];
        self.buffers.insert(name.to_string(), AtomicRefCell::new(Buffer { rows, bytes }));
    }

    fn find(&self, name: &str) -> anyhow::Result<&AtomicRefCell<Buffer>> {
        self.buffers.get(name).with_context(|| format!("there is no buffer {name:?}"))
    }

    /// Elements of a buffer.
    pub fn read<T: Pod>(&self, name: &str) -> anyhow::Result<AtomicRef<'_, [T]>> {
        let buffer = self.find(name)?.borrow();
        Ok(AtomicRef::map(buffer, |b| cast_slice(&cast_slice::<Row, u8>(&b.rows)[..b.bytes])))
    }

    /// Elements of a buffer, to write.
    pub fn edit<T: Pod>(&self, name: &str) -> anyhow::Result<AtomicRefMut<'_, [T]>> {
        let buffer = self.find(name)?.borrow_mut();
        Ok(AtomicRefMut::map(buffer, |b| {
            let bytes = b.bytes;
            cast_slice_mut(&mut cast_slice_mut::<Row, u8>(&mut b.rows)[..bytes])
        }))
    }

    /// Overwrites a buffer from an offset on [bytes].
    pub fn write(&mut self, name: &str, offset: usize, bytes: &[u8]) -> anyhow::Result<()> {
        let mut buffer = self.edit::<u8>(name)?;
        let end = offset.saturating_add(bytes.len());
        if end > buffer.len() {
            bail!("{} bytes from {offset} on do not fit buffer {name:?} of {}", bytes.len(), buffer.len());
        }
        buffer[offset..end].copy_from_slice(bytes);
        Ok(())
    }

    /// A copy of a buffer.
    pub fn bytes(&self, name: &str) -> anyhow::Result<Vec<u8>> {
        Ok(self.read::<u8>(name)?.to_vec())
    }

    /// Fills a buffer with zeros.
    pub fn clear(&self, name: &str) -> anyhow::Result<()> {
        self.edit::<u8>(name)?.fill(0);
        Ok(())
    }
}
