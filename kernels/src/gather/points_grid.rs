//! Points in hash grids: a grid (a level) for each power of two of radius, whose cells hold a disc. Each photon visits the cells
//! around it in every level that has points.
//!
//! Source: hierarchical hash grids [Eitz and Lixu 2007, Hierarchical spatial hashing for real-time collision detection].
//!
//! Cost: two passes over the points to build, once a frame, whatever the number of light paths. A photon visits eight cells a
//! level. Scenes that are seen directly and in mirrors have four to eight levels.
//!
//! Limitations: slow with many levels, and where points crowd a cell, as on a surface seen from afar at a grazing angle. The
//! result is exact for every radius.

use crate::gather::hash::{RADIUS_BINS, Runs, cell_size_of, radius_bin, reserve, salt, slot};
use crate::gather::tables::{Build, Tables};
use crate::gather::variant::{Over, Side, Stage, Variant, WordCount};
use crate::gather::{Gather, Index, Near, Visit};
use crate::interface::point::PointGeometry;
use crate::math::grid::cell;
use crate::math::max_abs;
use crate::platform::{Atomics, Words as _};
use spirv_std::glam::Vec3;

/// Gather with hash grids over the points.
pub struct PointsGrid;

/// Index of the word of `index_0`, behind the histogram of radii, that holds the number of levels with points. Their bins follow.
const LEVEL_COUNT: u32 = RADIUS_BINS;

impl Index for PointsGrid {
    const VARIANT: Variant = Variant {
        name: "points-grid",
        description: "points in hash grids by radius, searched from each photon",
        cost: "two passes over the points, once a frame; eight cells a level a photon",
        limitations: "slow where radii span many levels, and where points crowd a cell",
        side: Side::Points,
        frame: &[
            Stage::Clear(0),
            Stage::Clear(1),
            Stage::Run(0, "count", Over::Pixels),
            Stage::Run(1, "levels", Over::Count(1)),
            Stage::Run(2, "reserve", Over::Cells),
            Stage::Run(3, "fill", Over::Pixels),
        ],
        words: [
            WordCount(1, Over::Count(2 * RADIUS_BINS + 1)),
            WordCount(2, Over::Cells),
            WordCount(2, Over::Cells),
            WordCount(1, Over::Pixels),
        ],
        ..Variant::NEW
    };

    #[inline(always)]
    fn build(stage: u32, index: u32, build: &mut Build<'_>) {
        let mask = build.params.cell_mask;
        if stage == 1 {
            let mut levels = 0;
            let mut bin = 0;
            while bin < RADIUS_BINS {
                if build.index_0.get(bin) != 0 {
                    levels += 1;
                    build.index_0.set(LEVEL_COUNT + levels, bin);
                }
                bin += 1;
            }
            build.index_0.set(LEVEL_COUNT, levels);
        } else if stage == 2 {
            reserve(index, build);
        } else {
            let point = build.point(index);
            if point.exists() {
                let bin = radius_bin(point.radius);
                let slot = slot(cell(point.position, cell_size_of(bin)), salt(bin), mask);
                if stage == 0 {
                    build.index_0.add(bin, 1);
                    build.index_1.add(slot, 1);
                } else {
                    let to = build.index_2.add(2 * slot + 1, 1);
                    build.index_3.set(to, index);
                }
            }
        }
    }
}

/// The point at an index of `pixel_order`.
#[inline(always)]
fn point(tables: &Tables<'_>, index: u32) -> PointGeometry {
    tables.point_geometry[tables.pixel_order[index as usize] as usize]
}

impl Gather for PointsGrid {
    #[inline(always)]
    fn for_each_near<V: Visit>(tables: &mut Tables<'_>, near: Near, visit: &mut V) {
        let levels = tables.index_0[LEVEL_COUNT as usize];
        let mut level = 1;
        while level <= levels {
            let bin = tables.index_0[(LEVEL_COUNT + level) as usize];
            visit_level(tables, bin, near, visit);
            level += 1;
        }
    }
}

/// Visits the points of a level near a position.
#[inline(always)]
fn visit_level<V: Visit>(tables: &mut Tables<'_>, bin: u32, near: Near, visit: &mut V) {
    let size = cell_size_of(bin);
    // A disc's centre is at most a radius away, and a rounding.
    let reach = 0.5 * size * (1.0 + 1.0e-6) + max_abs(near.position) * (4.0 * f32::EPSILON);
    let half_extent = near.half_extent + Vec3::splat(reach);
    let low = cell(near.position - half_extent, size);
    let high = cell(near.position + half_extent, size);
    let mut runs = Runs::new(low, high, salt(bin), tables.params.cell_mask);
    // Visit all points of the level where the box meets more cells than there are points
    if runs.cell_count() > tables.params.pixel_count() as f32 {
        let mut index = 0;
        while index < tables.params.pixel_count() {
            let point = point(tables, index);
            if point.exists() && radius_bin(point.radius) == bin {
                visit.visit(tables, index);
            }
            index += 1;
        }
        return;
    }
    // Visit the points of each run of cells
    while runs.is_left() {
        let run = runs.next(tables.index_2);
        let mut entry = run.start;
        while entry < run.end {
            let index = tables.index_3[entry as usize];
            let point = point(tables, index);
            // Skip points of other levels and cells that share the slot.
            if radius_bin(point.radius) == bin && run.holds(point.position, size) {
                visit.visit(tables, index);
            }
            entry += 1;
        }
    }
}
