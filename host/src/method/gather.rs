//! The steps and buffers of a gather variant.

use caustics_kernels::gather::morton_sort;
use caustics_kernels::gather::variant::{Over, Side, Stage, Variant};
use caustics_kernels::interface::counters::DEPOSIT_STATE_COUNT;
use caustics_kernels::interface::frame::{EVERY_DEPOSIT, FrameParams};
use caustics_kernels::interface::point::{DepositGeometry, DepositLight};

use super::{BufferSpec, Step};

/// The words of an index.
const INDEX: [&str; 4] = ["index_0", "index_1", "index_2", "index_3"];

/// Once a frame, after `collect`.
pub fn prepare(gather: &'static Variant, params: FrameParams) -> Vec<Step> {
    gather.frame.iter().map(|&stage| step(gather, stage, params)).collect()
}

/// For each batch of light paths: shoots them, builds what is built over deposits, gathers.
pub fn batch(gather: &'static Variant, params: FrameParams) -> Vec<Step> {
    let count = match gather.side {
        Side::Points => params.deposit_capacity,
        Side::Photons => params.pixel_count(),
    };
    let mut steps = shoot(params);
    steps.extend(gather.batch.iter().map(|&stage| step(gather, stage, params)));
    steps.push(Step::Gather { gather, count, params });
    steps
}

/// Shoots a batch of light paths and stores their deposits.
pub fn shoot(params: FrameParams) -> Vec<Step> {
    let clear = Step::Clear { buffer: "deposit_state" };
    vec![clear, Step::Dispatch { pass: "shoot.store", count: params.light_path_batch, params }]
}

/// The settings of each batch of a frame's light paths.
pub fn batches(params: FrameParams) -> impl Iterator<Item = FrameParams> {
    let count = params.light_path_count;
    let offsets = (0..count).step_by(params.light_path_batch.max(1) as usize);
    offsets.map(move |part| {
        let light_path_batch = params.light_path_batch.min(count - part);
        FrameParams { part, light_path_batch, ..params }
    })
}

fn step(gather: &'static Variant, stage: Stage, params: FrameParams) -> Step {
    match stage {
        Stage::Run(part, name, over) => {
            let count = extent(over, &params);
            let light_path_batch = if over == Over::Deposits { EVERY_DEPOSIT } else { count };
            let params = FrameParams { part, light_path_batch, ..params };
            Step::Index { gather, stage: name, count, params }
        }
        Stage::Clear(words) => Step::Clear { buffer: INDEX[words as usize] },
        Stage::Structure(side) => {
            let over = if side == Side::Points { Over::Pixels } else { Over::Deposits };
            Step::Structure { side, count: extent(over, &params) }
        }
    }
}

/// The buffers of a gather; those that a variant does not use are empty.
pub fn buffers(gather: &Variant, params: &FrameParams) -> Vec<BufferSpec> {
    let mut buffers = deposit_buffers(params, gather.sorts).to_vec();
    buffers.extend(index_buffers(&gather.words.map(|words| words.0 * extent(words.1, params))));
    buffers
}

/// The buffers of deposits, as they are stored and as an index sorts them.
pub fn deposit_buffers(params: &FrameParams, sorts: bool) -> [BufferSpec; 5] {
    let deposits = params.deposit_capacity as usize;
    let sorted = if sorts { deposits } else { 0 };
    [
        BufferSpec { name: "deposit_state", bytes: 4 * DEPOSIT_STATE_COUNT },
        BufferSpec { name: "deposit_geometry", bytes: size_of::<DepositGeometry>() * deposits },
        BufferSpec { name: "deposit_light", bytes: size_of::<DepositLight>() * deposits },
        BufferSpec { name: "sorted_geometry", bytes: size_of::<DepositGeometry>() * sorted },
        BufferSpec { name: "sorted_light", bytes: size_of::<DepositLight>() * sorted },
    ]
}

/// The buffers of an index of so many words.
pub fn index_buffers(words: &[u32; 4]) -> Vec<BufferSpec> {
    let named = INDEX.iter().zip(words);
    named.map(|(name, &words)| BufferSpec { name, bytes: 4 * words as usize }).collect()
}

/// Elements of what a stage runs over.
fn extent(over: Over, params: &FrameParams) -> u32 {
    match over {
        Over::Pixels => params.pixel_count(),
        Over::PixelsIn(share) => params.pixel_count().div_ceil(share),
        Over::Deposits => params.deposit_capacity,
        Over::Cells => params.cell_mask + 1,
        Over::PixelSort(level) => morton_sort::level_count(params.pixel_count(), level),
        Over::DepositSort(level) => morton_sort::level_count(params.deposit_capacity, level),
        Over::Count(count) => count,
    }
}
