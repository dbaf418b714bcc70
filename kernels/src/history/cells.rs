//! Changes of light: marks of validation photons in cells of the world, coarse and fine.
//!
//! A cell is about 16 pixels wide where the eye sees it directly, independent of mirrors that show it. Each mark also counts in
//! the coarser cells around it, so that the smallest cell with enough marks judges a position. The largest cell is the whole
//! world. So a few marks judge positions without marks near by, across all faces of the grid. A mesh that moves has cells of its
//! own, as its light may rest while all around it changes. Edges are powers of two; all cells share one hash table.

use crate::gather::accumulator::QUANTA_PER_PATH;
use crate::gather::hash;
use crate::history::significance::{significant_change, variance_of_sum};
use crate::interface::frame::FrameParams;
use crate::interface::history::VALIDATION_CELLS;
use crate::math::grid::cell;
use crate::math::quanta::Quanta;
use crate::math::{PI, clamp};
use crate::platform::Atomics;
use spirv_std::glam::{IVec3, Vec3};

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Words of a cell: marks, distance moved, changes, and three `Quanta` of two words. The `Quanta` are the light of the previous
/// frame, the sum of changes, and the sum of their squares.
pub const WORDS: u32 = 9;
/// Word of the distance moved.
const MOVED: u32 = 1;
/// Word of the number of changes: one for a photon in both frames, or for one that came or went.
const CHANGES: u32 = 2;
/// First word of the light of the previous frame.
const BEFORE: u32 = 3;
/// First word of the sum of changes, with signs.
const CHANGE: u32 = 5;
/// First word of the sum of squared changes.
const SQUARES: u32 = 7;
/// Edge of the finest cell over the radius of a point seen directly: about 16 pixels of sqrt(pi) radii each.
const RADII_PER_EDGE: f32 = 32.0;
/// Number of sizes of cells, each twice the size before; the last is the whole world.
const SIZES: u32 = 9;
/// Minimum number of marks with which a cell judges.
const MIN_MARKS: u32 = 12;
/// Quanta per radius of distance moved.
const QUANTA_PER_RADIUS: f32 = 256.0;
/// Quanta per maximum flux of a light path in the sums of cells. Rounding of a flux is below half a quantum.
const QUANTA_PER_LIGHT: f32 = 262_144.0;
/// Distance moved from which on light is other light (radii of a point seen directly). Longer distances count as this one.
pub const MAX_STEP: f32 = 8.0;
/// Number of sizes of cells, from the first with enough marks on, that may find light lost.
const SIZES_THAT_JUDGE: u32 = 4;
/// Maximum light of a mark, relative to that of a light path.
const MAX_MARK_LIGHT: f32 = 4.0;

/// Change of light from one frame to the next, over the photons of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Share of light that is gone or new, beyond noise, in [0, 1].
    pub lost: f32,
    /// Mean distance that photons moved (radii of a point seen directly): the largest of the cells that judge.
    pub moved: f32,
}

/// Frame of reference of light: an instance that carries its light along, or the world below the instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightFrame(u32);

impl LightFrame {
    /// Light that moves with an instance; instance 0 is the world.
    #[inline(always)]
    pub fn instance(instance: u32) -> LightFrame {
        LightFrame(2 * instance)
    }

    /// Number of frames of reference of light on an instance: the instance, and the world below it.
    #[inline(always)]
    pub fn count(instance: u32) -> u32 {
        if instance == 0 { 1 } else { 2 }
    }

    /// Frame of reference of an instance, by an index below `count`.
    #[inline(always)]
    pub fn new(instance: u32, index: u32) -> LightFrame {
        LightFrame(2 * instance + index)
    }

    /// Light that stays in the world while the instance moves below it.
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

/// First word of the cell of a size at a position; `finest` is the exponent of the finest edge there.
#[inline(always)]
fn slot(position: Vec3, carrier: LightFrame, finest: u32, size: u32) -> u32 {
    let (mut exponent, mut here) = (0, IVec3::ZERO);
    if size + 1 < SIZES {
        exponent = finest + size;
        here = cell(position, f32::from_bits(exponent << 23));
    }
    let key = exponent.wrapping_mul(0x9e37_79b1) ^ carrier.0.wrapping_mul(0xc2b2_ae35);
    WORDS * (hash::slot(here, 0, u32::MAX).wrapping_add(key ^ (key >> 16)) & (VALIDATION_CELLS - 1))
}

/// A photon of a validation path in one of two frames.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    /// Position (m).
    pub position: Vec3,
    /// Frame of reference of its light.
    pub carrier: LightFrame,
    /// Flux per cosine (W); 0 if the frame has no such photon.
    pub flux: f32,
}

impl Mark {
    /// Number of photons: one or none.
    #[inline(always)]
    fn count(&self) -> u32 {
        if self.flux > 0.0 { 1 } else { 0 }
    }

    /// Light relative to the maximum of a light path.
    #[inline(always)]
    fn light(&self, params: &FrameParams) -> f32 {
        let light = self.flux * params.inverse_quantum() * (1.0 / (3.0 * QUANTA_PER_PATH));
        light.min(MAX_MARK_LIGHT)
    }
}

/// Marks the same photon of one path in both frames, or one that came or went. `moved` is its distance between the frames (radii
/// of a point seen directly). Below [`MAX_STEP`] both are the same light.
///
/// Light that moves across a face of its cell is not lost: it shortens histories by its distance. Both cells count the change of
/// its flux. Light that moved further is lost at its old position and new at its new one.
#[inline(always)]
pub fn mark<A: Atomics>(cells: &mut A, before: Mark, now: Mark, moved: f32, params: &FrameParams) {
    let exponents = (finest(before.position, params), finest(now.position, params));
    let (light_before, light_now) = (before.light(params), now.light(params));
    let is_same_light = moved < MAX_STEP;
    let mut size = 0;
    while size < SIZES {
        let from = slot(before.position, before.carrier, exponents.0, size);
        let to = slot(now.position, now.carrier, exponents.1, size);
        if from == to {
            let marks = before.count() + now.count();
            add(cells, from, marks, light_before, light_now, moved);
        } else {
            let (stays, came) = if is_same_light { (light_now, light_before) } else { (0.0, 0.0) };
            add(cells, from, before.count(), light_before, stays, moved);
            add(cells, to, now.count(), came, light_now, moved);
        }
        size += 1;
    }
}

/// Adds marks to a cell, with their light in both frames.
#[inline(always)]
fn add<A: Atomics>(cells: &mut A, first: u32, marks: u32, before: f32, now: f32, moved: f32) {
    if marks == 0 {
        return;
    }
    cells.add(first, marks);
    cells.add(first + CHANGES, 1);
    let moved = (moved.min(MAX_STEP) * QUANTA_PER_RADIUS + 0.5) as u32;
    if moved != 0 {
        cells.add(first + MOVED, marks * moved);
    }
    Quanta::from_f32(before, QUANTA_PER_LIGHT).add_to(cells, first + BEFORE);
    let change = now - before;
    let quanta = (change.abs() * QUANTA_PER_LIGHT + 0.5) as u32 as f32;
    if quanta > 0.0 {
        let signed = if change < 0.0 { -quanta } else { quanta };
        Quanta::from_signed(signed, 1.0).add_to(cells, first + CHANGE);
        Quanta::from_f32(quanta * quanta, 1.0).add_to(cells, first + SQUARES);
    }
}

/// Reads a sum of a cell.
#[inline(always)]
fn sum(cells: &[u32], first: usize, word: u32) -> Quanta {
    let low = first + word as usize;
    Quanta { low: cells[low], high: cells[low + 1] }
}

/// Share of the light of a cell that is gone or new, beyond noise.
#[inline(always)]
fn lost(cells: &[u32], first: usize) -> f32 {
    let before = sum(cells, first, BEFORE).to_f32(1.0);
    let change = sum(cells, first, CHANGE).to_signed(1.0);
    let squares = sum(cells, first, SQUARES).to_f32(1.0);
    let variance = variance_of_sum(change, squares, cells[first + CHANGES as usize]);
    (significant_change(change, variance) / before.max(before + change).max(1.0)).min(1.0)
}

/// Change of light at a position, by the smallest cell with enough marks, else by the largest; none without a mark.
///
/// Loss may exceed noise only in some of the larger cells, so the largest share counts. Motion of a mark is no noise, however few
/// marks there are, so the longest distance counts.
#[inline(always)]
pub fn change(cells: &[u32], position: Vec3, carrier: LightFrame, params: &FrameParams) -> Change {
    let exponent = finest(position, params);
    let mut change = Change::default();
    let (mut size, mut judges) = (0, 0);
    let largest = slot(position, carrier, exponent, SIZES - 1) as usize;
    if cells[largest + MOVED as usize] == 0 && sum(cells, largest, SQUARES) == Quanta::default() {
        // No light of this frame of reference changed, to the bit.
        return change;
    }
    while size < SIZES && judges < SIZES_THAT_JUDGE {
        let first = slot(position, carrier, exponent, size) as usize;
        let marks = cells[first];
        let is_last = size + 1 == SIZES;
        if marks > 0 && judges == 0 {
            change.moved =
                change.moved.max(cells[first + MOVED as usize] as f32 / (marks as f32 * QUANTA_PER_RADIUS));
        }
        if marks >= MIN_MARKS || (is_last && marks > 0 && judges == 0) {
            change.lost = change.lost.max(lost(cells, first));
            if change.moved <= 0.0 {
                // Nothing moved here: larger cells saw changes elsewhere.
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
    use crate::platform::AtomicWords;

    /// View from far away: discs have about one radius all around the origin.
    fn params() -> FrameParams {
        let camera = Camera { position: Vec3::new(0.0, 0.0, 1000.0), ..Default::default() };
        FrameParams {
            camera,
            radius_px: 1.0,
            pixel_spread: 1.0e-5,
            quantum: 1.0 / QUANTA_PER_PATH,
            ..Default::default()
        }
    }

    /// Edge of the finest cell at the origin (m).
    fn edge() -> f32 {
        let radius = direct_radius(Vec3::ZERO, &params());
        let edge = f32::from_bits(finest(Vec3::ZERO, &params()) << 23);
        assert!((RADII_PER_EDGE / 2.0..=RADII_PER_EDGE).contains(&(edge / radius)));
        edge
    }

    /// Middle of a finest cell that shares every coarser cell with its neighbour to the right.
    fn middle() -> Vec3 {
        Vec3::splat(0.5 * edge())
    }

    fn at(position: Vec3, carrier: LightFrame, flux: f32) -> Mark {
        Mark { position, carrier, flux }
    }

    /// Marks `count` light paths of flux 3, one for each channel, of which the share `left` remains.
    fn add(cells: &mut [u32], count: u32, position: Vec3, carrier: LightFrame, left: f32, moved: f32) {
        let mut cells = AtomicWords::new(cells);
        for _ in 0..count {
            let (before, now) = (at(position, carrier, 3.0), at(position, carrier, 3.0 * left));
            mark(&mut cells, before, now, moved, &params());
        }
    }

    fn empty() -> Vec<u32> {
        vec![0; (WORDS * VALIDATION_CELLS) as usize]
    }

    const WORLD: LightFrame = LightFrame(0);

    #[test]
    fn unmarked_and_resting_light_is_unchanged() {
        let mut cells = empty();
        assert_eq!(change(&cells, middle(), WORLD, &params()), Change::default());
        add(&mut cells, 100, middle(), WORLD, 1.0, 0.0);
        assert_eq!(change(&cells, middle(), WORLD, &params()), Change::default());
    }

    #[test]
    fn enough_marks_judge_their_own_cell() {
        let mut cells = empty();
        let beside = middle() + Vec3::X * edge();
        add(&mut cells, 6, middle(), WORLD, 1.0, 2.0);
        add(&mut cells, 6, beside, WORLD, 1.0, 4.0);
        let found = change(&cells, middle(), WORLD, &params());
        // Exact: the means are of sums in multiples of 1/256.
        assert_eq!((found.lost, found.moved), (0.0, 2.0));
        assert_eq!(change(&cells, beside, WORLD, &params()).moved, 4.0);
    }

    #[test]
    fn too_few_marks_are_judged_with_those_around() {
        let mut cells = empty();
        let beside = middle() + Vec3::X * edge();
        add(&mut cells, 2, middle(), WORLD, 1.0, 0.0);
        add(&mut cells, 6, beside, WORLD, 1.0, 4.0);
        // Twelve marks of sixteen, in a cell of twice the edge.
        assert_eq!(change(&cells, middle(), WORLD, &params()).moved, 3.0);
        // The few marks that moved are not hidden by many around them that rest.
        assert_eq!(change(&cells, beside, WORLD, &params()).moved, 4.0);
    }

    #[test]
    fn few_marks_judge_positions_without_marks_near_by() {
        let mut cells = empty();
        add(&mut cells, 2, middle(), WORLD, 0.93, 4.0);
        // Also across the planes of the axes, which are faces of all finer cells.
        for far in [Vec3::X, Vec3::NEG_X, Vec3::NEG_ONE] {
            let found = change(&cells, 1000.0 * edge() * far, WORLD, &params());
            // Tolerance: half a quantum of each path.
            assert!((found.lost - 0.07).abs() < 1.0e-4 && found.moved == 4.0, "{found:?}");
        }
    }

    #[test]
    fn light_that_goes_out_is_lost() {
        let mut cells = empty();
        add(&mut cells, 100, middle(), WORLD, 0.0, MAX_STEP);
        let found = change(&cells, middle(), WORLD, &params());
        assert_eq!((found.lost, found.moved), (1.0, MAX_STEP));
    }

    #[test]
    fn fade_shows_from_one_light_path_despite_motion() {
        for (left, share) in [(0.93, 0.07), (1.0 / 0.93, 0.07), (0.99, 0.01), (0.8, 0.2)] {
            for count in [1u32, 2, 6, 100] {
                let mut cells = empty();
                add(&mut cells, count, middle(), WORLD, left, 0.5);
                let found = change(&cells, middle(), WORLD, &params());
                // Tolerance: half a quantum of each path.
                assert!((found.lost - share).abs() < 1.0e-4, "{count}, {left}: {}", found.lost);
                assert_eq!(found.moved, 0.5);
            }
        }
    }

    #[test]
    fn light_that_moves_across_a_face_of_its_cell_is_not_lost() {
        let (mut cells, params) = (empty(), params());
        let beside = middle() + Vec3::X * edge();
        for count in 0..40 {
            let (from, to) = if count % 4 == 0 { (middle(), beside) } else { (middle(), middle()) };
            let mut cells = AtomicWords::new(&mut cells);
            mark(&mut cells, at(from, WORLD, 3.0), at(to, WORLD, 3.0), 1.0, &params);
        }
        assert_eq!(change(&cells, middle(), WORLD, &params), Change { lost: 0.0, moved: 1.0 });
        assert_eq!(change(&cells, beside, WORLD, &params).lost, 0.0);
        // Light that moves further is other light.
        let mut cells = empty();
        for _ in 0..40 {
            let mut cells = AtomicWords::new(&mut cells);
            mark(&mut cells, at(middle(), WORLD, 3.0), at(beside, WORLD, 3.0), MAX_STEP, &params);
        }
        for position in [middle(), beside] {
            assert_eq!(change(&cells, position, WORLD, &params).lost, 1.0);
        }
    }

    #[test]
    fn losses_of_some_paths_and_gains_of_others_are_noise() {
        let mut cells = empty();
        add(&mut cells, 50, middle(), WORLD, 0.0, MAX_STEP);
        let mut words = AtomicWords::new(&mut cells);
        for _ in 0..45 {
            mark(&mut words, at(middle(), WORLD, 0.0), at(middle(), WORLD, 3.0), MAX_STEP, &params());
        }
        assert_eq!(change(&cells, middle(), WORLD, &params()).lost, 0.0);
    }

    #[test]
    fn rounding_of_a_flux_is_no_change() {
        let mut cells = empty();
        add(&mut cells, 100, middle(), WORLD, 1.0 + 4.0 * f32::EPSILON, 0.0);
        assert_eq!(change(&cells, middle(), WORLD, &params()), Change::default());
    }

    #[test]
    fn carriers_do_not_mix() {
        let carriers =
            [0, 1, 2, 77].map(|id| [LightFrame::instance(id), LightFrame::world_below(id)]).concat();
        for (index, &marks) in carriers.iter().enumerate() {
            let mut cells = empty();
            add(&mut cells, 10, middle(), marks, 1.0, 1.0);
            for (other, &carrier) in carriers.iter().enumerate() {
                let moved = if other == index { 1.0 } else { 0.0 };
                assert_eq!(change(&cells, middle(), carrier, &params()).moved, moved);
            }
        }
    }

    #[test]
    fn distance_moved_is_at_most_max_step() {
        let mut cells = empty();
        add(&mut cells, 10, middle(), WORLD, 1.0, 1.0e9);
        assert_eq!(change(&cells, middle(), WORLD, &params()).moved, MAX_STEP);
    }
}
