//! Counters of one worker, added to the shared ones when it is done: no cache line travels for each ray.

use caustics_kernels::interface::counters::COUNTER_COUNT;
use caustics_kernels::seam::{AtomicWords, Atomics};

/// Counts by itself and adds to `shared` when dropped.
pub struct LocalCounters<'a> {
    words: [u32; COUNTER_COUNT],
    shared: AtomicWords<'a>,
}

impl<'a> LocalCounters<'a> {
    /// Counters at zero.
    pub fn new(shared: AtomicWords<'a>) -> Self {
        LocalCounters { words: [0; COUNTER_COUNT], shared }
    }
}

impl Atomics for LocalCounters<'_> {
    #[inline]
    fn add(&mut self, index: u32, value: u32) -> u32 {
        let word = &mut self.words[index as usize];
        let before = *word;
        *word = before.wrapping_add(value);
        before
    }
}

impl Drop for LocalCounters<'_> {
    fn drop(&mut self) {
        for (index, &value) in self.words.iter().enumerate().filter(|(_, value)| **value != 0) {
            self.shared.add(index as u32, value);
        }
    }
}
