//! Memory as a CPU reads it at random: a table may stand in huge pages, so that where a page is need not be looked up for every node
//! of a large tree. Imports memmap2.

use bytemuck::{AnyBitPattern, NoUninit, cast_slice, cast_slice_mut};
use memmap2::MmapMut;

/// Bytes that start as zeros, at the start of a page. A page that nothing is written to takes no memory.
pub struct Memory(MmapMut);

impl Memory {
    /// So many bytes; the system has them, or the program ends as where any memory is not to be had.
    pub fn zeros(bytes: usize) -> Memory {
        Memory(MmapMut::map_anon(bytes).unwrap_or_else(|error| panic!("{bytes} bytes of memory: {error}")))
    }

    /// Asks for huge pages, where there are, for what is written from now on: good for what will be read at random, and a waste where
    /// little of it is ever used.
    pub fn in_huge_pages(&self) {
        // A wish: a system that cannot fulfil it gives small pages.
        #[cfg(target_os = "linux")]
        let _ = self.0.advise(memmap2::Advice::HugePage);
    }

    /// All of it as elements.
    pub fn read<T: AnyBitPattern>(&self) -> &[T] {
        cast_slice(&self.0)
    }

    /// All of it as elements, to write.
    pub fn edit<T: AnyBitPattern + NoUninit>(&mut self) -> &mut [T] {
        cast_slice_mut(&mut self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_zeros_that_keep_what_is_written() {
        for bytes in [0, 24, (1 << 21) - 8, (1 << 21) + 24] {
            let mut memory = Memory::zeros(bytes);
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
}
