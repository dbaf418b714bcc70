//! Memory as a CPU reads it at random: a table may stand in huge pages, so that where a page is need not be looked up for every node
//! of a large BVH. Imports memmap2.

use std::io;

use bytemuck::{AnyBitPattern, NoUninit, Pod, Zeroable, cast_slice, cast_slice_mut};
use memmap2::MmapMut;

/// Size of a huge page (bytes).
pub const HUGE_PAGE: usize = 1 << 21;

/// A line of a cache.
#[repr(C, align(64))]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Line([u64; 8]);

/// Bytes that start as zeros, at the start of a cache line.
pub struct Memory {
    storage: Storage,
    bytes: usize,
}

/// Where they are.
enum Storage {
    /// Among others: what is small is read and cleared faster there than in pages of its own.
    Heap(Vec<Line>),
    /// In pages of their own, of which those that nothing is written to take no memory.
    Pages(MmapMut),
}

impl Memory {
    /// This many bytes.
    ///
    /// # Errors
    ///
    /// If the system does not give them.
    pub fn zeros(bytes: usize) -> io::Result<Memory> {
        let storage = if bytes < HUGE_PAGE {
            let count = bytes.div_ceil(size_of::<Line>());
            let mut lines = Vec::new();
            lines.try_reserve_exact(count).map_err(|_| io::ErrorKind::OutOfMemory)?;
            lines.resize(count, Line::zeroed());
            Storage::Heap(lines)
        } else {
            Storage::Pages(MmapMut::map_anon(bytes)?)
        };
        Ok(Memory { storage, bytes })
    }

    /// Asks for huge pages, where there are, for what is written from now on: good for what will be read at random, and a waste where
    /// little of it is ever used.
    pub fn in_huge_pages(&self) {
        // A hint: a system that cannot follow it gives small pages.
        #[cfg(target_os = "linux")]
        if let Storage::Pages(pages) = &self.storage {
            let _ = pages.advise(memmap2::Advice::HugePage);
        }
    }

    /// All of it as elements.
    pub fn read<T: AnyBitPattern>(&self) -> &[T] {
        let bytes = match &self.storage {
            Storage::Heap(lines) => cast_slice(lines),
            Storage::Pages(pages) => pages,
        };
        cast_slice(&bytes[..self.bytes])
    }

    /// All of it as elements, to write.
    pub fn edit<T: AnyBitPattern + NoUninit>(&mut self) -> &mut [T] {
        let bytes = match &mut self.storage {
            Storage::Heap(lines) => cast_slice_mut(lines),
            Storage::Pages(pages) => pages,
        };
        cast_slice_mut(&mut bytes[..self.bytes])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_zeros_that_keep_what_is_written() {
        for bytes in [0, 24, (1 << 21) - 8, (1 << 21) + 24] {
            let mut memory = Memory::zeros(bytes).unwrap();
            let words = memory.edit::<u64>();
            assert_eq!(words.len(), bytes / 8);
            assert!(words.iter().all(|&word| word == 0));
            if let Some(last) = words.last_mut() {
                *last = 7;
                assert_eq!(memory.read::<u64>().last(), Some(&7));
                assert_eq!(memory.read::<u8>()[bytes - 8], 7);
            }
        }
    }

    #[test]
    fn more_than_an_address_space_is_an_error() {
        assert!(Memory::zeros(1 << 62).is_err());
    }
}
