//! Memory that a CPU reads at random. A table may lie in huge pages, so that the CPU need not look up a page for every node of a
//! large BVH. Imports memmap2.

use std::io;

use bytemuck::{AnyBitPattern, NoUninit, Pod, Zeroable, cast_slice, cast_slice_mut};
use memmap2::MmapMut;

/// Size of a huge page (bytes).
pub const HUGE_PAGE: usize = 1 << 21;

/// A cache line.
#[repr(C, align(64))]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Line([u64; 8]);

/// Bytes that start as zeros, aligned to a cache line.
pub struct Memory {
    storage: Storage,
    bytes: usize,
}

/// Location of the bytes.
enum Storage {
    /// On the heap, where few bytes are read and cleared faster than in pages of their own.
    Heap(Vec<Line>),
    /// In pages of their own; a page takes no memory until something is written to it.
    Pages(MmapMut),
}

impl Memory {
    /// Allocates bytes.
    ///
    /// # Errors
    ///
    /// If the system does not provide them.
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

    /// Requests huge pages for all that is written from now on. They suit memory that is read at random, and are a waste where
    /// little of it is used.
    pub fn in_huge_pages(&self) {
        // A hint: a system that cannot follow it provides small pages.
        #[cfg(target_os = "linux")]
        if let Storage::Pages(pages) = &self.storage {
            let _ = pages.advise(memmap2::Advice::HugePage);
        }
    }

    /// All bytes as elements.
    pub fn read<T: AnyBitPattern>(&self) -> &[T] {
        let bytes = match &self.storage {
            Storage::Heap(lines) => cast_slice(lines),
            Storage::Pages(pages) => pages,
        };
        cast_slice(&bytes[..self.bytes])
    }

    /// All bytes as elements, to write.
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
    fn memory_starts_as_zeros_and_keeps_what_is_written() {
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
