//! Entry points that several passes share on a GPU. Passes that trace paths are mostly the same code, so a module with one copy
//! of it is half as large. Each pass is complete in a file of its own, as the CPU runs it. A file here combines the passes of an
//! entry point where they differ. Before a driver compiles, it is known which pass runs, so the code of the others is dead.
//!
//! A pass without `shared_entry` has an entry point of its own.

use crate::platform::Atomics;

pub mod camera;
pub mod light;

/// Counters that ignore passes whose paths are not a frame's own.
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
