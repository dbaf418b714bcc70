//! Passes on the CPU: buffers by name, and a pass mapped over chunks of its indices.

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use atomic_refcell::{AtomicRef, AtomicRefCell, AtomicRefMut};
use bytemuck::Pod;
use rayon::prelude::*;

use super::OnCpu;
use crate::interface::bvh::BvhNode;
use crate::interface::counters::COUNTER_COUNT;
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::instance::Instance;
use crate::interface::ledger::LEDGER_FIRST;
use crate::math::quanta::Quanta;
use crate::memory::{HUGE_PAGE, Memory};
use crate::platform::{AtomicWords, Atomics};
use crate::trace::on_cpu::{Bvh8, has_avx2};

/// Invocations that a worker takes at a time.
const CHUNK: u32 = 512;

/// A dispatch on the CPU.
#[derive(Clone, Copy)]
pub struct Call<'a> {
    /// Buffers, by name.
    pub buffers: &'a Buffers,
    /// Settings of the frame.
    pub params: &'a FrameParams,
    /// Position of the dispatch in its pass.
    pub dispatch: Dispatch,
    /// Features that the scene needs.
    pub features: Features,
    /// Set by a caller that cancels the call: chunks that have not begun are skipped.
    pub stop: &'a AtomicBool,
}

impl Call<'_> {
    /// Calls `work` with consecutive ranges of the indices below `count`, in parallel on rayon's pool.
    pub fn for_chunks(&self, count: u32, work: impl Fn(Range<u32>) + Sync) {
        let chunks = (0..count.div_ceil(CHUNK)).into_par_iter();
        chunks.filter(|_| !self.stop.load(Ordering::Relaxed)).for_each(|i| {
            work(i * CHUNK..(i * CHUNK).saturating_add(CHUNK).min(count));
        });
    }
}

impl OnCpu {
    /// Runs the code that suits this CPU.
    pub fn run(&self, call: &Call<'_>) -> Result<(), BufferError> {
        #[cfg(target_arch = "x86_64")]
        if has_avx2() {
            // SAFETY: `has_avx2` checked the instructions that `avx2` is compiled with.
            #[allow(unsafe_code)]
            return unsafe { (self.avx2)(call) };
        }
        (self.any)(call)
    }
}

/// Reason why a buffer is not available.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BufferError {
    /// No buffer has this name.
    Unknown(String),
    /// The system has no memory for it.
    NoMemory {
        /// Name of the buffer.
        buffer: String,
        /// Its size (bytes).
        bytes: usize,
    },
    /// The bytes do not fit.
    TooSmall {
        /// Name of the buffer.
        buffer: String,
        /// Its size (bytes).
        size: usize,
        /// Offset of the first byte (bytes).
        offset: usize,
        /// Number of bytes.
        bytes: usize,
    },
}

impl fmt::Display for BufferError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BufferError::Unknown(name) => write!(f, "there is no buffer {name:?}"),
            BufferError::NoMemory { buffer, bytes } => {
                write!(
                    f,
                    "the system has no {bytes} bytes of memory for buffer {buffer:?}; make the frame or the scene smaller"
                )
            }
            BufferError::TooSmall { buffer, size, offset, bytes } => {
                write!(f, "{bytes} bytes from {offset} on do not fit buffer {buffer:?} of {size}")
            }
        }
    }
}

impl std::error::Error for BufferError {}

/// Buffers by name, each borrowed on its own while a pass runs.
#[derive(Default)]
pub struct Buffers {
    buffers: HashMap<String, AtomicRefCell<Memory>>,
    /// BVH for AVX2, made of the buffers of the BVH when a pass first needs it.
    bvh8: OnceLock<Option<Bvh8>>,
}

impl Buffers {
    /// Adds a buffer of zeros.
    ///
    /// # Errors
    ///
    /// If the system has no memory for it.
    pub fn add(&mut self, name: &str, bytes: usize) -> Result<(), BufferError> {
        let buffer = name.to_string();
        let Ok(memory) = Memory::zeros(bytes) else {
            return Err(BufferError::NoMemory { buffer, bytes });
        };
        self.buffers.insert(buffer, AtomicRefCell::new(memory));
        Ok(())
    }

    fn find(&self, name: &str) -> Result<&AtomicRefCell<Memory>, BufferError> {
        self.buffers.get(name).ok_or_else(|| BufferError::Unknown(name.to_string()))
    }

    /// Elements of a buffer.
    pub fn read<T: Pod>(&self, name: &str) -> Result<AtomicRef<'_, [T]>, BufferError> {
        Ok(AtomicRef::map(self.find(name)?.borrow(), Memory::read))
    }

    /// Elements of a buffer, to write.
    pub fn edit<T: Pod>(&self, name: &str) -> Result<AtomicRefMut<'_, [T]>, BufferError> {
        Ok(AtomicRefMut::map(self.find(name)?.borrow_mut(), Memory::edit))
    }

    /// BVH for AVX2; `None` if this CPU cannot use it.
    pub fn bvh8(&self, nodes: &[BvhNode], instances: &[Instance]) -> Option<&Bvh8> {
        self.bvh8.get_or_init(|| Bvh8::new(nodes, instances)).as_ref()
    }

    /// Overwrites a buffer from an offset (bytes) on.
    pub fn write(&mut self, name: &str, offset: usize, bytes: &[u8]) -> Result<(), BufferError> {
        // A large write is a table, which passes read at random.
        if bytes.len() >= HUGE_PAGE {
            self.find(name)?.borrow().in_huge_pages();
        }
        let mut buffer = self.edit::<u8>(name)?;
        let (end, size) = (offset.saturating_add(bytes.len()), buffer.len());
        if end > size {
            let buffer = name.to_string();
            return Err(BufferError::TooSmall { buffer, size, offset, bytes: bytes.len() });
        }
        buffer[offset..end].copy_from_slice(bytes);
        drop(buffer);
        if ["nodes", "instances"].contains(&name) {
            self.bvh8.take();
        }
        Ok(())
    }

    /// Fills a buffer with zeros.
    pub fn clear(&self, name: &str) -> Result<(), BufferError> {
        self.edit::<u8>(name)?.fill(0);
        Ok(())
    }
}

/// Counters of one worker, added to the shared ones at its end, so that no cache line travels for each ray.
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
