//! Where light changed: marks of validation deposits in cells of the world, coarse and fine.
//!
//! A cell is about 16 pixels wide where the eye sees it directly, whatever mirrors show it. Each mark also counts in the
//! coarser cells around it, so that a place is judged by the smallest cell that knows enough. A mesh that moves has cells of
//! its own: what lies on it may rest while all around it changes. Edges are powers of two; all cells share one hash table.

use crate::gather::hash::{self, cell};
use crate::interface::frame::FrameParams;
use crate::interface::history::VALIDATION_CELLS;
use crate::math::{PI, clamp};
use crate::seam::Atomics;
use spirv_std::glam::Vec3;

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Words of a cell: marks, light of the frame before, light of this frame, way moved, marks that do not rest.
pub const WORDS: u32 = 5;
/// Edge of the finest cell over the radius of a point seen directly: 16 pixels of sqrt(pi) radii each, about.
const RADII_PER_EDGE: f32 = 32.0;
/// Sizes of cells, each twice the one before.
const SIZES: u32 = 9;
/// Marks that a cell must have to judge.
const MIN_MARKS: u32 = 12;
/// What counts as one.
const QUANTA_PER_MARK: f32 = 256.0;
/// Longest way that is told from longer ones (radii of a point seen directly); so far moved what came from elsewhere.
pub const MAX_STEP: f32 = 8.0;
/// Way of light that comes and goes by chance, rather than at rest (radii).
const REST_STEP: f32 = 0.1;
/// Sizes of cells, from the first with enough marks on, that may find light lost.
const SIZES_THAT_JUDGE: u32 = 4;
/// Standard deviations of light that came and went by chance, which say nothing.
const NOISE_SIGMAS: f32 = 1.2;
/// Most light of a mark, in that of a light path.
const MAX_MARK_LIGHT: f32 = 4.0;

/// How light changed from one frame to the next, over the deposits of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Share of the light that is gone or came anew, beyond chance, in [0, 1].
    pub lost: f32,
    /// Mean way of deposits (radii of a point seen directly), the longest of the cells that judge.
    pub moved: f32,
}

/// What moves with the light that is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightFrame(u32);

impl LightFrame {
    /// The instance, which carries its light along; for the world, the world.
    #[inline(always)]
    pub fn instance(instance: u32) -> LightFrame {
        LightFrame(2 * instance)
    }

    /// How many frames light has that falls on an instance: what carries it along is one, the world below it another.
    #[inline(always)]
    pub fn count(instance: u32) -> u32 {
        if instance == 0 { 1 } else { 2 }
    }

    /// One of these.
    #[inline(always)]
    pub fn of(instance: u32, place: u32) -> LightFrame {
        LightFrame(2 * instance + place)
    }

    /// Nothing: the instance moves below light that stays where it is in the world.
    #[inline(always)]
    pub fn world_below(instance: u32) -> LightFrame {
        LightFrame(2 * instance + 1)
    }
}

/// Radius (m) of a collection point at a position, seen directly and head on.
#[inline(always)]
pub fn direct_radius(position: Vec3, params: &FrameParams) -> f32 {
    let distance = (position - params.camera.position).length();
    params.radius_px * params.pixel_spread * distance * (1.0 / PI).sqrt()
}

/// Biased exponent of the edge of the finest cell at a position.
#[inline(always)]
fn finest(position: Vec3, params: &FrameParams) -> u32 {
    let exponent = (RADII_PER_EDGE * direct_radius(position, params)).to_bits() >> 23;
    clamp(exponent, 1, 253 - SIZES)
}

/// First word of the cell whose edge has this exponent.
#[inline(always)]
fn slot(position: Vec3, carrier: LightFrame, exponent: u32) -> u32 {
    let here = cell(position, f32::from_bits(exponent << 23));
    let key = exponent.wrapping_mul(0x9e37_79b1) ^ carrier.0.wrapping_mul(0xc2b2_ae35);
    WORDS * (hash::slot(here, 0, u32::MAX).wrapping_add(key ^ (key >> 16)) & (VALIDATION_CELLS - 1))
}

/// Which frame a mark belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum When {
    /// The frame before.
    Before = 1,
    /// This frame.
    Now = 2,
}

/// Marks a place where a deposit lies, whose like in the other frame lies so many radii away.
#[inline(always)]
pub fn mark<A: Atomics>(
    cells: &mut A,
    position: Vec3,
    carrier: LightFrame,
    when: When,
    flux: f32,
    moved: f32,
    params: &FrameParams,
) {
    let exponent = finest(position, params);
    // The largest flux of a light path is 2^24 quanta; three channels.
    let light = flux * params.inverse_quantum() * (1.0 / (3.0 * 16_777_216.0));
    let light = (light.min(MAX_MARK_LIGHT) * QUANTA_PER_MARK + 0.5) as u32;
    let restless = moved > REST_STEP;
    let moved = (moved.min(MAX_STEP) * QUANTA_PER_MARK + 0.5) as u32;
    let mut size = 0;
    while size < SIZES {
        let first = slot(position, carrier, exponent + size);
        cells.add(first, 1);
        cells.add(first + when as u32, light);
        if moved != 0 {
            cells.add(first + 3, moved);
        }
        if restless {
            cells.add(first + 4, 1);
        }
        size += 1;
    }
}

/// How light changed at a place: by the smallest cell with enough marks, else by the largest; not at all without a mark.
/// What is lost may be beyond chance only in some of the larger cells, and a mark that moved is no chance at all, however
/// few there are: the largest share and the longest way count.
#[inline(always)]
pub fn change(cells: &[u32], position: Vec3, carrier: LightFrame, params: &FrameParams) -> Change {
    let exponent = finest(position, params);
    let mut change = Change::default();
    let (mut size, mut judges) = (0, 0);
    let largest = slot(position, carrier, exponent + SIZES - 1) as usize;
    if cells[largest + 3] == 0 && cells[largest + 1] == cells[largest + 2] {
        // All around rests, to the bit.
        return change;
    }
    while size < SIZES && judges < SIZES_THAT_JUDGE {
        let first = slot(position, carrier, exponent + size) as usize;
        let marks = cells[first];
        let is_last = size + 1 == SIZES;
        if marks > 0 && judges == 0 {
            change.moved = change.moved.max(cells[first + 3] as f32 / (marks as f32 * QUANTA_PER_MARK));
        }
        if marks >= MIN_MARKS || (is_last && marks > 0 && judges == 0) {
            let (before, now) = (cells[first + 1] as f32, cells[first + 2] as f32);
            let chance = NOISE_SIGMAS * (cells[first + 4] as f32).sqrt() * (before + now) / marks as f32;
            let lost = ((now - before).abs() - chance).max(0.0) / before.max(now).max(1.0);
            change.lost = change.lost.max(lost);
            if change.moved <= 0.0 {
                // Nothing moved here: what larger cells saw happened elsewhere.
                judges = SIZES_THAT_JUDGE;
            }
            judges += 1;
        }
        size += 1;
    }
    change
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::frame::Camera;
    use crate::seam::AtomicWords;

    /// A view from far away: discs have about one radius all over the origin's surroundings.
    fn params() -> FrameParams {
        let camera = Camera { position: Vec3::new(0.0, 0.0, 1000.0), ..Default::default() };
        FrameParams {
            camera,
            radius_px: 1.0,
            pixel_spread: 1.0e-5,
            quantum: 2.0f32.powi(-24),
            ..Default::default()
        }
    }

    /// Edge of the finest cell there (m).
    fn edge() -> f32 {
        let radius = direct_radius(Vec3::ZERO, &params());
        let edge = f32::from_bits(finest(Vec3::ZERO, &params()) << 23);
        assert!((RADII_PER_EDGE / 2.0..=RADII_PER_EDGE).contains(&(edge / radius)));
        edge
    }

    /// The middle of a finest cell that shares every coarser cell with its neighbour to the right.
    fn place() -> Vec3 {
        Vec3::splat(0.5 * edge())
    }

    /// Adds `count` pairs of marks of a light path's flux: one before, one now if it still arrives.
    fn add(cells: &mut [u32], count: u32, position: Vec3, carrier: LightFrame, arrives: bool, moved: f32) {
        let mut cells = AtomicWords::new(cells);
        for _ in 0..count {
            mark(&mut cells, position, carrier, When::Before, 3.0, moved, &params());
            if arrives {
                mark(&mut cells, position, carrier, When::Now, 3.0, moved, &params());
            }
        }
    }

    fn empty() -> Vec<u32> {
        vec![0; (WORDS * VALIDATION_CELLS) as usize]
    }

    const WORLD: LightFrame = LightFrame(0);

    #[test]
    fn nothing_marked_and_light_at_rest_are_no_change() {
        let mut cells = empty();
        assert_eq!(change(&cells, place(), WORLD, &params()), Change::default());
        add(&mut cells, 100, place(), WORLD, true, 0.0);
        assert_eq!(change(&cells, place(), WORLD, &params()), Change::default());
    }

    #[test]
    fn enough_marks_judge_their_own_cell() {
        let mut cells = empty();
        let beside = place() + Vec3::X * edge();
        add(&mut cells, 6, place(), WORLD, true, 2.0);
        add(&mut cells, 6, beside, WORLD, true, 4.0);
        let found = change(&cells, place(), WORLD, &params());
        // Means of sums in 1/256, which these numbers are.
        assert_eq!((found.lost, found.moved), (0.0, 2.0));
        assert_eq!(change(&cells, beside, WORLD, &params()).moved, 4.0);
    }

    #[test]
    fn too_few_marks_are_judged_with_those_around() {
        let mut cells = empty();
        let beside = place() + Vec3::X * edge();
        add(&mut cells, 2, place(), WORLD, true, 0.0);
        add(&mut cells, 6, beside, WORLD, true, 4.0);
        // Twelve marks of sixteen, in a cell of twice the edge.
        assert_eq!(change(&cells, place(), WORLD, &params()).moved, 3.0);
        // Few that moved are not hidden by many that rest around them.
        assert_eq!(change(&cells, beside, WORLD, &params()).moved, 4.0);
        // Fewer than enough in all: the largest cell judges, also far from the marks. Beyond it there is nothing.
        let mut cells = empty();
        add(&mut cells, 2, place(), WORLD, true, 4.0);
        let largest = edge() * (1 << (SIZES - 1)) as f32;
        let far = |share: f32| place() + Vec3::X * (share * largest);
        assert_eq!(change(&cells, far(0.7), WORLD, &params()).moved, 4.0);
        assert_eq!(change(&cells, far(1.7), WORLD, &params()), Change::default());
    }

    #[test]
    fn light_that_goes_out_is_lost_beyond_chance() {
        let mut cells = empty();
        add(&mut cells, 100, place(), WORLD, false, MAX_STEP);
        let found = change(&cells, place(), WORLD, &params());
        // All is lost but 1.2 standard deviations of a hundred: 0.12.
        assert!((found.lost - 0.88).abs() < 1.0e-5, "{}", found.lost);
        assert_eq!(found.moved, MAX_STEP);
    }

    #[test]
    fn carriers_do_not_mix() {
        let carriers =
            [0, 1, 2, 77].map(|id| [LightFrame::instance(id), LightFrame::world_below(id)]).concat();
        for (index, &marks) in carriers.iter().enumerate() {
            let mut cells = empty();
            add(&mut cells, 10, place(), marks, true, 1.0);
            for (other, &carrier) in carriers.iter().enumerate() {
                let moved = if other == index { 1.0 } else { 0.0 };
                assert_eq!(change(&cells, place(), carrier, &params()).moved, moved);
            }
        }
    }

    #[test]
    fn the_longest_ways_are_not_told_apart() {
        let mut cells = empty();
        add(&mut cells, 10, place(), WORLD, true, 1.0e9);
        assert_eq!(change(&cells, place(), WORLD, &params()).moved, MAX_STEP);
    }
}
