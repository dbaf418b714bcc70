//! Points in hash grids: a level for each power of two of radius, whose cells hold a disc; each deposit visits the cells
//! about it in every level that has points.
//!
//! Source: hierarchical hash grids [Eitz and Lixu 2007, Hierarchical spatial hashing for real-time collision detection].
//! Cost: two passes over the points to build, once a frame, whatever the number of light paths; a deposit looks into
//! eight cells a level. Scenes that are seen directly and in mirrors have four to eight levels.
//! Where it is slow: many levels, and points that crowd a cell: those of one surface that is seen from afar at a grazing
//! angle. It is exact for every radius.

use crate::gather::hash::{RADIUS_BINS, cell, cell_size_of, radius_bin, slot};
use crate::gather::tables::{Build, Tables};
use crate::gather::variant::{Over, Side, Stage, Variant, Words};
use crate::gather::{Gather, Index, Near, Visit};
use crate::interface::point::PointGeometry;
use crate::math::max_abs;
use crate::seam::{Atomics, Words as _};
use spirv_std::glam::{IVec3, Vec3};

/// See the head of the file.
pub struct PointsGrid;

/// Words of `index_0` behind the histogram of radii: levels that have points, then their bins.
const LEVEL_COUNT: u32 = RADIUS_BINS;
/// The last word of `index_1`, behind the counts of the cells: points in cells reserved so far.
const fn reserved(cell_mask: u32) -> u32 {
    cell_mask + 1
}

impl Index for PointsGrid {
    const VARIANT: Variant = Variant {
        name: "points-grid",
        about: "points in hash grids by radius, searched from each deposit",
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
            Words(1, Over::Count(2 * RADIUS_BINS + 1)),
            Words(2, Over::Cells),
            Words(2, Over::Cells),
            Words(1, Over::Pixels),
        ],
        ..Variant::of::<PointsGrid>()
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
            let count = build.index_1.get(index);
            let start = if count == 0 { 0 } else { build.index_1.add(reserved(mask), count) };
            build.index_2.set(2 * index, start);
            build.index_2.set(2 * index + 1, start);
        } else {
            let point = build.point(index);
            if point.depth != 0 {
                let bin = radius_bin(point.radius);
                let slot = level_slot(cell(point.position, cell_size_of(bin)), bin, mask);
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

/// Slot of a cell of a level.
#[inline(always)]
fn level_slot(cell: IVec3, bin: u32, cell_mask: u32) -> u32 {
    slot(cell, cell_mask).wrapping_add(bin.wrapping_mul(0x27d4_eb2f)) & cell_mask
}

/// The point at a place of `pixel_order`.
#[inline(always)]
fn point(tables: &Tables<'_>, place: u32) -> PointGeometry {
    tables.point_geometry[tables.pixel_order[place as usize] as usize]
}

impl Gather for PointsGrid {
    #[inline(always)]
    fn for_each_near<V: Visit>(tables: &Tables<'_>, near: Near, visit: &mut V) {
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
fn visit_level<V: Visit>(tables: &Tables<'_>, bin: u32, near: Near, visit: &mut V) {
    let size = cell_size_of(bin);
    // A disc's centre is at most a radius away, but for what rounding takes.
    let reach = 0.5 * size * (1.0 + 1.0e-6) + max_abs(near.position) * (4.0 * f32::EPSILON);
    let half_extent = near.half_extent + Vec3::splat(reach);
    let low = cell(near.position - half_extent, size);
    let high = cell(near.position + half_extent, size);
    let span = (high - low).as_vec3() + Vec3::ONE;
    let everything = span.x * span.y * span.z > tables.params.pixel_count() as f32;
    if everything {
        let mut place = 0;
        while place < tables.params.pixel_count() {
            let point = point(tables, place);
            if point.depth != 0 && radius_bin(point.radius) == bin {
                visit.visit(place);
            }
            place += 1;
        }
        return;
    }
    let mut z = low.z;
    while z <= high.z {
        let mut y = low.y;
        while y <= high.y {
            let mut x = low.x;
            while x <= high.x {
                let here = IVec3::new(x, y, z);
                let slot = level_slot(here, bin, tables.params.cell_mask) as usize;
                let mut entry = tables.index_2[2 * slot];
                let end = tables.index_2[2 * slot + 1];
                while entry < end {
                    let place = tables.index_3[entry as usize];
                    let point = point(tables, place);
                    // Another cell, or one of another level, may share the slot: it has its own visit.
                    if radius_bin(point.radius) == bin && cell(point.position, size) == here {
                        visit.visit(place);
                    }
                    entry += 1;
                }
                x += 1;
            }
            y += 1;
        }
        z += 1;
    }
}
