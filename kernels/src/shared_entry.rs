//! Entry points that several passes share on a GPU. Passes that trace paths are mostly the same code: a module that has it once for
//! all is half as large. Each pass stands in a file of its own, whole, as the CPU runs it; a file here brings those of an entry point
//! together where they differ. Which of them runs is known before a driver compiles it: what is the others' is dead.
//!
//! A pass of its own, without `shared_entry`, has an entry point of its own.

use crate::platform::Atomics;

pub mod camera;
pub mod light;

/// Counts for those passes whose paths are a frame's own.
struct Counted<'a, A> {
    counts: bool,
    counters: &'a mut A,
}

impl<A: Atomics> Atomics for Counted<'_, A> {
    #[inline(always)]
    fn add(&mut self, index: u32, value: u32) -> u32 {
        if self.counts { self.counters.add(index, value) } else { 0 }
    }
}
