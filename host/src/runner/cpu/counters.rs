//! Counters of one worker, added to the shared ones when it is done: no cache line travels for each ray.

use caustics_kernels::gather::accumulator::Quanta;
use caustics_kernels::interface::counters::COUNTER_COUNT;
use caustics_kernels::interface::ledger::LEDGER_FIRST;
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
        let (counters, ledger) = self.words.split_at(LEDGER_FIRST as usize);
        for (index, &value) in counters.iter().enumerate().filter(|(_, value)| **value != 0) {
            self.shared.add(index as u32, value);
        }
        // The ledger's entries have two words each, with a carry between them.
        for (pair, words) in ledger.chunks(2).enumerate().filter(|(_, words)| words != &[0, 0]) {
            let quanta = Quanta { low: words[0], high: words[1] };
            quanta.add_to(&mut self.shared, LEDGER_FIRST + 2 * pair as u32);
        }
    }
}
