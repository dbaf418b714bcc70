//! Photons in a hash grid: photons are sorted by cell, and each point visits the cells that its box meets.
//!
//! Source: the grid of progressive photon mapping [Hachisuka and Jensen 2009], with counting instead of sorting.
//!
//! Cost: one pass over the points and two over the photons to build; a point reads the photons of a few cells.
//!
//! Limitations: slow for a point whose radius is far above the median, since it visits many cells. Where these are more than
//! there are photons, the point visits all photons. Slow on a GPU where one disc takes many photons in its one invocation. A
//! caustic seen through the rim of a glass is such a case: it holds most photons of guided light paths. The result is exact for
//! every radius.

use crate::gather::hash::{RADIUS_BINS, Runs, common_cell_size, radius_bin, reserve, slot};
use crate::gather::tables::{Build, Tables};
use crate::gather::variant::{Over, Stage, Variant, WordCount};
use crate::gather::{Gather, Index, Near, Visit};
use crate::math::grid::cell;
use crate::platform::{Atomics, Words as _};

/// Gather with a hash grid over the photons.
pub struct PhotonsGrid;

/// Index of the word of `index_0`, behind the histogram of radii, that holds the bits of the cell size (m).
const CELL_SIZE: u32 = RADIUS_BINS;

impl Index for PhotonsGrid {
    const VARIANT: Variant = Variant {
        name: "photons-grid",
        description: "photons in a hash grid, gathered from each point",
        cost: "a pass over the points and two over the photons; a point reads a few cells",
        limitations: "slow where radii are far above the median",
        frame: &[
            Stage::Clear(0),
            Stage::Run(0, "survey", Over::Pixels),
            Stage::Run(1, "size", Over::Count(1)),
        ],
        batch: &[
            Stage::Clear(1),
            Stage::Run(2, "count", Over::Photons),
            Stage::Run(3, "reserve", Over::Cells),
            Stage::Run(4, "fill", Over::Photons),
        ],
        words: [
            WordCount(1, Over::Count(RADIUS_BINS + 1)),
            WordCount(2, Over::Cells),
            WordCount(2, Over::Cells),
            WordCount::NONE,
        ],
        sorts: true,
        ..Variant::NEW
    };

    #[inline(always)]
    fn build(stage: u32, index: u32, build: &mut Build<'_>) {
        let mask = build.params.cell_mask;
        if stage == 0 {
            let point = build.point(index);
            if point.exists() {
                build.index_0.add(radius_bin(point.radius), 1);
            }
        } else if stage == 1 {
            let size = common_cell_size(&build.index_0);
            build.index_0.set(CELL_SIZE, size);
        } else if stage == 3 {
            reserve(index, build);
        } else {
            let photon = build.photon_geometry[index as usize];
            let size = f32::from_bits(build.index_0.get(CELL_SIZE));
            let slot = slot(cell(photon.position, size), 0, mask);
            if stage == 2 {
                build.index_1.add(slot, 1);
            } else {
                // Take the next entry of the slot. The order in a cell is free, because sums are integers.
                let to = build.index_2.add(2 * slot + 1, 1);
                build.sorted_geometry.write(to, photon);
                build.sorted_light.write(to, build.photon_light[index as usize]);
            }
        }
    }
}

impl Gather for PhotonsGrid {
    #[inline(always)]
    fn for_each_near<V: Visit>(tables: &mut Tables<'_>, near: Near, visit: &mut V) {
        let cell_size = f32::from_bits(tables.index_0[CELL_SIZE as usize]);
        let low = cell(near.position - near.half_extent, cell_size);
        let high = cell(near.position + near.half_extent, cell_size);
        let mut runs = Runs::new(low, high, 0, tables.params.cell_mask);
        // Visit all photons where the box meets more cells than there are photons
        if runs.cell_count() > tables.photon_count as f32 {
            let mut id = 0;
            while id < tables.photon_count {
                visit.visit(tables, id);
                id += 1;
            }
            return;
        }
        // Visit the photons of each run of cells that are in the box
        while runs.is_left() {
            let run = runs.next(tables.index_2);
            let mut id = run.start;
            while id < run.end {
                let position = tables.photon_geometry[id as usize].position;
                let along = (position - near.position).abs();
                let half = near.half_extent;
                // Skip the test of the cell outside of the box.
                let is_near = (along.x <= half.x) & (along.y <= half.y) & (along.z <= half.z);
                if is_near && run.holds(position, cell_size) {
                    visit.visit(tables, id);
                }
                id += 1;
            }
        }
    }
}
