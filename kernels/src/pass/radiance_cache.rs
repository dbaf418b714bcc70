//! `cache.*`: a radiance cache, in which camera paths end.
//!
//! A cell is a cube of space, with one side of the surfaces of one material in it, and a depth of camera paths. It holds the mean of the
//! light that surfaces in it reflect to camera paths, divided by their albedo. A camera path looks up the first diffuse surface behind its
//! collection point. If the cell has four samples, half of the paths end there and take the light of the cell. With 128 samples, 31 of 32
//! do. All others go on, and give the cell a sample. So samples come from whole paths: no cell takes light of another.
//!
//! A frame reads the cells as the frame before left them. Its own samples are added behind the camera paths, as integers. If samples
//! of several keys hash to one free cell, the lowest pixel index claims it. Other keys try their second slot in the next frame. Keys are
//! compared in full.
//!
//! Paths neither end nor give samples where the surface is close to the last vertex, since the blur of a cell would be seen there.
//!
//! Bounces stay exact: a cell serves one depth of paths, so that all have as many bounces left (depths from 31 on are one). Like an
//! `IndirectSample`, it stores light by bounces left, for points at other depths that share it.
//!
//! Consistent in `progressive`: the share of paths that end falls as 1 / N, see `cache_share` there.
//!
//! Cost: a look-up a path, and passes over the samples and the cells, which take 2 to 4 % of a frame. In rooms, `collect` takes a fifth less
//! time. 60 to 90 bytes a pixel, of which a state keeps 13 to 26.
//! Limitations: light is blurred within a cell, and over the directions in which it leaves a surface. So surfaces with less than three
//! quarters of a diffuse base have no cells; a coat above the base is averaged. Cells are 24 to 48 pixels wide: in images below two
//! hundred pixels a side no surface is far enough from another. The cache is emptied when anything moves, the camera included. A tile of
//! an image has a cache of its own. The noise of a cell is common to all batches of frames, so that `variance` lacks it.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::interface::NONE;
#[cfg(not(target_arch = "spirv"))]
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::packed::{MIN_EXPONENT, exponent, rgbe_quanta, rgbe_quantum};
use crate::interface::point::SHARED_DEPTHS;
use crate::interface::radiance_cache::{CacheCell, CacheKey, CacheSample};
use crate::math::quanta::ColorQuanta;
use crate::path::radiance_cache::{cell_mask, find};
use crate::platform::{AtomicWords, Atomics, Slots, Words};

/// Stage that fills the radiance cache.
#[cfg(not(target_arch = "spirv"))]
pub const RADIANCE_CACHE: FrameStage = FrameStage {
    before_collect: |params| {
        if params.moved == 0 { Vec::new() } else { vec![Step::Clear { buffer: "cache_cells" }] }
    },
    after_collect: |params| {
        vec![
            Step::Clear { buffer: "cache_sums" },
            Step::level(&CACHE_ADD, CLAIM, params.pixel_count()),
            Step::level(&CACHE_ADD, ADD, params.pixel_count()),
            Step::new(&CACHE_MERGE, params),
        ]
    },
    keeps: &["cache_cells"],
    features: Features::INDIRECT,
    ..FrameStage::new("cache")
};

/// Stages of `cache.add`.
const CLAIM: u32 = 0;
#[cfg(not(target_arch = "spirv"))]
const ADD: u32 = 1;
/// Words of the sums of a cell: those of its light, and the two below.
const SUM_WORDS: u32 = ColorQuanta::WORDS * SHARED_DEPTHS as u32 + 2;
/// Index of the word with the number of samples.
const COUNT: u32 = SUM_WORDS - 2;
/// Index of the word with the claim of a free cell: the complement of a pixel's index, or 0.
const CLAIMED: u32 = SUM_WORDS - 1;

/// Index behind the sums of all cells of the word with the exponent of the frame's largest sample.
#[inline(always)]
fn largest_word(params: &FrameParams) -> u32 {
    SUM_WORDS * (cell_mask(params) + 1)
}

/// Adds the samples of a frame to sums of cells, one stage a dispatch. The first one claims free cells.
#[pass(name = "cache.add", over = params.pixel_count(), work = Reuse)]
pub fn cache_add(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    #[len = params.pixel_count()] cache_samples: &[CacheSample],
    #[len = cell_mask(params) + 1] cache_cells: &[CacheCell],
    #[len = largest_word(params) + 1] mut cache_sums: AtomicWords<'_>,
) {
    let sample = cache_samples[index as usize];
    if sample.light[0] == NONE {
        return;
    }
    let slot = find(&sample.key, cache_cells, cell_mask(params));
    let first = SUM_WORDS * slot;
    let cell = &cache_cells[slot as usize];
    let is_free = cell.count == 0.0;
    if dispatch.level == CLAIM {
        cache_sums.fetch_max(largest_word(params), exponent(sample.light[0]));
        if is_free {
            cache_sums.fetch_max(first + CLAIMED, !index);
        }
        return;
    }
    let largest = cache_sums.get(largest_word(params));
    let key = key_of(cell, cache_sums.get(first + CLAIMED), cache_samples);
    if key != sample.key {
        return;
    }
    cache_sums.add(first + COUNT, 1);
    // Samples of frames without light count, too.
    if largest < MIN_EXPONENT {
        return;
    }
    let mut depth = 0;
    while depth < SHARED_DEPTHS {
        let light = ColorQuanta::new(rgbe_quanta(sample.light[depth], largest));
        light.add_to(&mut cache_sums, first + ColorQuanta::WORDS * depth as u32);
        depth += 1;
    }
}

/// Key of a cell: its own, or that of the pixel that claimed it.
#[inline(always)]
fn key_of(cell: &CacheCell, claim: u32, samples: &[CacheSample]) -> CacheKey {
    if cell.count == 0.0 { samples[!claim as usize].key } else { cell.key }
}

/// Adds the sums of a frame to the cells.
#[pass(name = "cache.merge", over = cell_mask(params) + 1, work = Reuse)]
pub fn cache_merge(
    slot: u32,
    params: &FrameParams,
    cache_samples: &[CacheSample],
    cache_sums: AtomicWords<'_>,
    mut cache_cells: Slots<'_, CacheCell>,
) {
    let first = SUM_WORDS * slot;
    let count = cache_sums.get(first + COUNT);
    if count == 0 {
        return;
    }
    let mut cell = cache_cells.read(slot);
    cell.key = key_of(&cell, cache_sums.get(first + CLAIMED), cache_samples);
    cell.count += count as f32;
    let quantum = rgbe_quantum(cache_sums.get(largest_word(params)).max(MIN_EXPONENT));
    let mut depth = 0;
    while depth < SHARED_DEPTHS {
        let sum = ColorQuanta::read(&cache_sums, first + ColorQuanta::WORDS * depth as u32);
        cell.light[depth] += sum.to_vec3(quantum);
        depth += 1;
    }
    cache_cells.write(slot, cell);
}
