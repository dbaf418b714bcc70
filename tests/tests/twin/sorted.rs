//! The grid's buffers, whose order is free: ranges of cells partition the slots, cells hold the same multisets.

use bytemuck::bytes_of;
use caustics_kernels::interface::point::{DepositGeometry, DepositLight};
use caustics_tests::compare::{Difference, Tolerance, words};
use caustics_tests::twin::Twin;

/// Whether each runner's ranges are disjoint and cover what was counted.
pub fn ranges(twin: &mut Twin) -> Vec<Difference> {
    let (counts, _) = twin.rows::<u32>("cell_counts");
    let (cpu_starts, gpu_starts) = twin.rows::<u32>("cell_starts");
    let (cpu_ends, gpu_ends) = twin.rows::<u32>("cell_ends");
    assert_eq!((&cpu_ends, &gpu_ends), (&cpu_starts, &gpu_starts));
    let partition = |starts: &[u32]| {
        let mut order: Vec<_> = (0..starts.len()).filter(|&cell| counts[cell] > 0).collect();
        order.sort_by_key(|&cell| starts[cell]);
        let mut next = 0;
        for cell in order {
            assert_eq!(starts[cell], next, "cell {cell} overlaps another or leaves a hole");
            next += counts[cell];
        }
        next
    };
    let totals = (partition(&cpu_starts), partition(&gpu_starts));
    vec![words("ranges' total", 1, &[totals.0], &[totals.1], Tolerance::EXACT)]
}

/// Whether each cell holds the same deposits.
pub fn cells(twin: &mut Twin) -> Vec<Difference> {
    let (starts, _) = twin.rows::<u32>("cell_starts");
    let (cpu_ends, gpu_ends) = twin.rows::<u32>("cell_ends");
    let (cpu_geometry, gpu_geometry) = twin.rows::<DepositGeometry>("sorted_geometry");
    let (cpu_light, gpu_light) = twin.rows::<DepositLight>("sorted_light");
    let sorted = |geometry: &[DepositGeometry], light: &[DepositLight]| {
        let mut all = vec![];
        for (&start, &end) in starts.iter().zip(&cpu_ends) {
            let slots = start as usize..end as usize;
            let mut cell: Vec<Vec<u8>> =
                slots.map(|slot| [bytes_of(&geometry[slot]), bytes_of(&light[slot])].concat()).collect();
            cell.sort();
            all.extend(cell.concat());
        }
        bytemuck::pod_collect_to_vec::<u8, u32>(&all)
    };
    let (cpu, gpu) = (sorted(&cpu_geometry, &cpu_light), sorted(&gpu_geometry, &gpu_light));
    vec![
        words("cell_ends", 1, &cpu_ends, &gpu_ends, Tolerance::EXACT),
        words("deposits by cell", 16, &cpu, &gpu, Tolerance::EXACT),
    ]
}
