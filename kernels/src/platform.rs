//! Differences between GPU and CPU: buffers that many invocations write, and arrays of a single invocation. Imports nothing of
//! the crate.
//!
//! On the GPU the implementations hold slices of storage buffers, so they are always inlined. On the CPU they are `Copy` handles,
//! one for each worker.

use spirv_std::arch::IndexUnchecked;
use spirv_std::glam::Vec3;

/// Words that many invocations add to at once.
pub trait Atomics {
    /// Adds to a word and returns what it held before.
    fn add(&mut self, index: u32, value: u32) -> u32;
}

/// Words that many invocations read and write; an invocation reads only words that an earlier pass or stage wrote.
pub trait Words: Atomics {
    /// Reads a word.
    fn get(&self, index: u32) -> u32;
    /// Overwrites a word.
    fn set(&mut self, index: u32, value: u32);
    /// Raises a word to a value, if it is lower.
    fn fetch_max(&mut self, index: u32, value: u32);
}

/// Declares an array of words for a single invocation. AMD's compiler keeps an array of up to 64 words in registers.
#[cfg(not(target_arch = "spirv"))]
macro_rules! scratch {
    ($words:ident: $room:expr) => {
        let $words = &mut [0u32; $room];
    };
}

/// Declares an array without initial values, on a GPU: filling it with zeros would take as long as a few nodes of a BVH.
#[cfg(target_arch = "spirv")]
macro_rules! scratch {
    ($words:ident: $room:expr) => {
        let $words: *mut [u32; $room];
        // SAFETY: the variable is of this type, and every word is written before it is read.
        let $words = unsafe {
            core::arch::asm! {
                "{words} = OpVariable typeof{words} Function",
                words = out(reg) $words,
            }
            &mut *$words
        };
    };
}
pub(crate) use scratch;

/// A record of some words in such an array. The array is flat: AMD's compiler makes small arrays of nested ones.
#[derive(Clone, Copy)]
pub struct Record<const WORDS: usize, const ROOM: usize> {
    first: usize,
}

impl<const WORDS: usize, const ROOM: usize> Record<WORDS, ROOM> {
    /// Record at an index; higher indices give the last record.
    #[inline(always)]
    pub const fn at(index: u32) -> Self {
        let last = ROOM / WORDS - 1;
        Record { first: WORDS * if (index as usize) < last { index as usize } else { last } }
    }

    /// Writes a value to a word of the record.
    #[inline(always)]
    pub fn put(self, words: &mut [u32; ROOM], word: usize, value: u32) {
        // SAFETY: the record is in the array, and the word in the record. A check of each would be most of the code.
        unsafe { *words.index_unchecked_mut(self.first + word.min(WORDS - 1)) = value };
    }

    /// Reads a value from a word of the record.
    #[inline(always)]
    pub fn take(self, words: &[u32; ROOM], word: usize) -> u32 {
        // SAFETY: as above.
        unsafe { *words.index_unchecked(self.first + word.min(WORDS - 1)) }
    }

    /// Writes a vector to three words.
    #[inline(always)]
    pub fn put3(self, words: &mut [u32; ROOM], word: usize, value: Vec3) {
        self.put(words, word, value.x.to_bits());
        self.put(words, word + 1, value.y.to_bits());
        self.put(words, word + 2, value.z.to_bits());
    }

    /// Reads a vector from three words.
    #[inline(always)]
    pub fn take3(self, words: &[u32; ROOM], word: usize) -> Vec3 {
        let bits = (self.take(words, word), self.take(words, word + 1), self.take(words, word + 2));
        Vec3::new(f32::from_bits(bits.0), f32::from_bits(bits.1), f32::from_bits(bits.2))
    }
}

/// Counters that count nothing.
pub struct Uncounted;

impl Atomics for Uncounted {
    #[inline(always)]
    fn add(&mut self, _index: u32, _value: u32) -> u32 {
        0
    }
}

impl<A: Atomics + ?Sized> Atomics for &mut A {
    #[inline(always)]
    fn add(&mut self, index: u32, value: u32) -> u32 {
        (**self).add(index, value)
    }
}

#[cfg(target_arch = "spirv")]
pub use gpu::{AtomicWords, Counts, Slots};

#[cfg(not(target_arch = "spirv"))]
pub use cpu::{AtomicWords, Slots};

#[cfg(target_arch = "spirv")]
mod gpu {
    use super::{Atomics, Words};
    use spirv_std::arch::{IndexUnchecked, atomic_i_add, atomic_u_max};
    use spirv_std::memory::{Scope, Semantics};

    /// Device-scope atomics on a storage buffer of `COUNT` words.
    pub struct Counts<'a, const COUNT: usize>(pub &'a mut [u32]);

    impl<const COUNT: usize> Atomics for Counts<'_, COUNT> {
        #[inline(always)]
        fn add(&mut self, index: u32, value: u32) -> u32 {
            // SAFETY: no buffer of counters is shorter. Nearly all counters have constant indices.
            let word = unsafe { self.0.index_unchecked_mut((index as usize).min(COUNT - 1)) };
            unsafe { atomic_i_add::<u32, { Scope::Device as u32 }, { Semantics::NONE.bits() }>(word, value) }
        }
    }

    /// Device-scope atomics on a storage buffer.
    pub struct AtomicWords<'a>(pub &'a mut [u32]);

    impl Atomics for AtomicWords<'_> {
        #[inline(always)]
        fn add(&mut self, index: u32, value: u32) -> u32 {
            let word = &mut self.0[index as usize];
            unsafe { atomic_i_add::<u32, { Scope::Device as u32 }, { Semantics::NONE.bits() }>(word, value) }
        }
    }

    impl Words for AtomicWords<'_> {
        #[inline(always)]
        fn get(&self, index: u32) -> u32 {
            self.0[index as usize]
        }

        #[inline(always)]
        fn set(&mut self, index: u32, value: u32) {
            self.0[index as usize] = value;
        }

        #[inline(always)]
        fn fetch_max(&mut self, index: u32, value: u32) {
            // Most values raise nothing: read before all invocations queue for the word. The value may be old, but is never too
            // high.
            if self.0[index as usize] < value {
                let word = &mut self.0[index as usize];
                unsafe {
                    atomic_u_max::<u32, { Scope::Device as u32 }, { Semantics::NONE.bits() }>(word, value)
                };
            }
        }
    }

    /// Elements of a storage buffer. If an invocation writes a slot, no other reads or writes it in that dispatch.
    pub struct Slots<'a, T>(pub &'a mut [T]);

    impl<T: Copy> Slots<'_, T> {
        /// Reads a slot.
        #[inline(always)]
        pub fn read(&self, slot: u32) -> T {
            self.0[slot as usize]
        }

        /// Writes a slot.
        #[inline(always)]
        pub fn write(&mut self, slot: u32, value: T) {
            self.0[slot as usize] = value;
        }
    }
}

#[cfg(not(target_arch = "spirv"))]
mod cpu {
    use super::{Atomics, Words};
    use std::marker::PhantomData;
    use std::sync::atomic::AtomicU32;
    use std::sync::atomic::Ordering::Relaxed;

    /// Atomic words in memory.
    #[derive(Clone, Copy)]
    pub struct AtomicWords<'a>(pub &'a [AtomicU32]);

    impl<'a> AtomicWords<'a> {
        /// A view of words with exclusive access.
        pub fn new(words: &'a mut [u32]) -> Self {
            // SAFETY: AtomicU32 has the layout of u32, and the exclusive borrow lasts as long as the view.
            Self(unsafe { &*(std::ptr::from_mut(words) as *const [AtomicU32]) })
        }
    }

    impl Atomics for AtomicWords<'_> {
        #[inline]
        fn add(&mut self, index: u32, value: u32) -> u32 {
            self.0[index as usize].fetch_add(value, Relaxed)
        }
    }

    impl Words for AtomicWords<'_> {
        #[inline]
        fn get(&self, index: u32) -> u32 {
            self.0[index as usize].load(Relaxed)
        }

        #[inline]
        fn set(&mut self, index: u32, value: u32) {
            self.0[index as usize].store(value, Relaxed);
        }

        #[inline]
        fn fetch_max(&mut self, index: u32, value: u32) {
            // Most values raise nothing: read before this thread takes the word from the others.
            let word = &self.0[index as usize];
            if word.load(Relaxed) < value {
                word.fetch_max(value, Relaxed);
            }
        }
    }

    /// Elements in memory, read and written through a shared handle. If an invocation writes a slot, no other reads or writes it
    /// in that dispatch.
    pub struct Slots<'a, T> {
        first: *mut T,
        count: usize,
        borrow: PhantomData<&'a mut [T]>,
    }

    impl<T> Clone for Slots<'_, T> {
        fn clone(&self) -> Self {
            *self
        }
    }

    impl<T> Copy for Slots<'_, T> {}

    // SAFETY: by contract, one worker reads and writes a slot, or all workers only read it.
    unsafe impl<T: Send> Send for Slots<'_, T> {}
    // SAFETY: as above.
    unsafe impl<T: Send> Sync for Slots<'_, T> {}

    impl<'a, T: Copy + Send> Slots<'a, T> {
        /// A handle on slots with exclusive access.
        pub fn new(slots: &'a mut [T]) -> Self {
            Self { first: slots.as_mut_ptr(), count: slots.len(), borrow: PhantomData }
        }

        /// Reads a slot.
        #[inline]
        pub fn read(&self, slot: u32) -> T {
            assert!((slot as usize) < self.count, "slot {slot} of {}", self.count);
            // SAFETY: in bounds, and written by no other worker.
            unsafe { self.first.add(slot as usize).read() }
        }

        /// Writes a slot.
        #[inline]
        pub fn write(&mut self, slot: u32, value: T) {
            assert!((slot as usize) < self.count, "slot {slot} of {}", self.count);
            // SAFETY: in bounds, and read or written by no other worker.
            unsafe { self.first.add(slot as usize).write(value) };
        }
    }
}
