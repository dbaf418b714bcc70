//! Where light changed: marks of validation photons in cells of the world, coarse and fine.
//!
//! A cell is about 16 pixels wide where the eye sees it directly, whatever mirrors show it. Each mark also counts in the
//! coarser cells around it, so that a position is judged by the smallest cell that knows enough. The largest is all of the world: a few
//! marks judge what has none near by, whatever faces of the grid lie between. A mesh that moves has cells of its own: what lies on it
//! may rest while all around it changes. Edges are powers of two; all cells share one hash table.

use crate::gather::hash::{self, cell};
use crate::history::significance::{significant_change, variance_of_sum};
use crate::interface::frame::FrameParams;
use crate::interface::history::VALIDATION_CELLS;
use crate::math::quanta::Quanta;
use crate::math::{PI, clamp};
use crate::platform::Atomics;
use spirv_std::glam::{IVec3, Vec3};

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Words of a cell: marks, way moved, changes, and two words each of `Quanta`: light of the frame before, sum of changes, sum of
/// their squares.
pub const WORDS: u32 = 9;
/// Word of the way moved.
const MOVED: u32 = 1;
/// Word of the number of changes: one for a photon in both frames, or for one that came or went.
const CHANGES: u32 = 2;
/// First word of the light of the frame before.
const BEFORE: u32 = 3;
/// First word of the sum of changes, with their signs.
const CHANGE: u32 = 5;
/// First word of the sum of their squares.
const SQUARES: u32 = 7;
/// Edge of the finest cell over the radius of a point seen directly: 16 pixels of sqrt(pi) radii each, about.
const RADII_PER_EDGE: f32 = 32.0;
/// Sizes of cells, each twice the one before; the last is all of the world.
const SIZES: u32 = 9;
/// Marks that a cell must have to judge.
const MIN_MARKS: u32 = 12;
/// Quanta of a radius that a mark moved.
const QUANTA_PER_RADIUS: f32 = 256.0;
/// Quanta of the flux of a light path. Rounding of a flux is below a half.
const QUANTA_PER_PATH: f32 = 262_144.0;
/// Longest way that is told from longer ones (radii of a point seen directly); so far moved what came from elsewhere.
pub const MAX_STEP: f32 = 8.0;
/// Sizes of cells, from the first with enough marks on, that may find light lost.
const SIZES_THAT_JUDGE: u32 = 4;
/// Most light of a mark, in that of a light path.
const MAX_MARK_LIGHT: f32 = 4.0;

/// How light changed from one frame to the next, over the photons of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Share of the light that is gone or came anew, beyond noise, in [0, 1].
    pub lost: f32,
    /// Mean way of photons (radii of a point seen directly), the longest of the cells that judge.
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
    pub fn new(instance: u32, index: u32) -> LightFrame {
        LightFrame(2 * instance + index)
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

/// First word of the cell of a size at a position, by the exponent of the finest edge there.
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
    /// What moves with it.
    pub carrier: LightFrame,
    /// Flux per cosine (W); 0 where the frame has no such photon.
    pub flux: f32,
}

impl Mark {
    /// Number of photons: one or none.
    #[inline(always)]
    fn count(&self) -> u32 {
        if self.flux > 0.0 { 1 } else { 0 }
    }

    /// Light relative to the largest of a light path.
    #[inline(always)]
    fn light(&self, params: &FrameParams) -> f32 {
        // The largest flux of a light path is 2^24 quanta; three channels.
        let light = self.flux * params.inverse_quantum() * (1.0 / (3.0 * 16_777_216.0));
        light.min(MAX_MARK_LIGHT)
    }
}

/// Marks the same photon of one path in both frames, or the one that came or went. `moved` is its way (radii of a point seen
/// directly); below [`MAX_STEP`] both are the same light.
///
/// Light that moves across a face of its cell is no light lost: it shortens histories by its way. What counts is how its flux
/// changed, in both cells. Light that went further is lost where it was and new where it is.
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

/// Adds marks to a cell, with the light that they stand for in both frames.
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
    Quanta::from_f32(before, QUANTA_PER_PATH).add_to(cells, first + BEFORE);
    let change = now - before;
    let quanta = (change.abs() * QUANTA_PER_PATH + 0.5) as u32 as f32;
    if quanta > 0.0 {
        let signed = if change < 0.0 { -quanta } else { quanta };
        Quanta::from_signed(signed, 1.0).add_to(cells, first + CHANGE);
        Quanta::from_f32(quanta * quanta, 1.0).add_to(cells, first + SQUARES);
    }
}

/// A sum of a cell.
#[inline(always)]
fn sum(cells: &[u32], first: usize, word: u32) -> Quanta {
    let low = first + word as usize;
    Quanta { low: cells[low], high: cells[low + 1] }
}

/// Share of the light of a cell that is gone or came anew, beyond noise.
#[inline(always)]
fn lost(cells: &[u32], first: usize) -> f32 {
    let before = sum(cells, first, BEFORE).to_f32(1.0);
    let change = sum(cells, first, CHANGE).to_signed(1.0);
    let squares = sum(cells, first, SQUARES).to_f32(1.0);
    let variance = variance_of_sum(change, squares, cells[first + CHANGES as usize]);
    (significant_change(change, variance) / before.max(before + change).max(1.0)).min(1.0)
}

/// How light changed at a position: by the smallest cell with enough marks, else by the largest; not at all without a mark.
/// What is lost may be beyond noise only in some of the larger cells, and a mark that moved is no noise at all, however
/// few there are: the largest share and the longest way count.
#[inline(always)]
pub fn change(cells: &[u32], position: Vec3, carrier: LightFrame, params: &FrameParams) -> Change {
    let exponent = finest(position, params);
    let mut change = Change::default();
    let (mut size, mut judges) = (0, 0);
    let largest = slot(position, carrier, exponent, SIZES - 1) as usize;
    if cells[largest + MOVED as usize] == 0 && sum(cells, largest, SQUARES) == Quanta::default() {
        // All around rests, to the bit.
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
    use crate::platform::AtomicWords;

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
    fn middle() -> Vec3 {
        Vec3::splat(0.5 * edge())
    }

    fn at(position: Vec3, carrier: LightFrame, flux: f32) -> Mark {
        Mark { position, carrier, flux }
    }

    /// Adds photons of `count` light paths that had a flux of three channels; so large a share of it is left now.
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
    fn nothing_marked_and_light_at_rest_are_no_change() {
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
        // Means of sums in 1/256, which these numbers are.
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
        // Few that moved are not hidden by many that rest around them.
        assert_eq!(change(&cells, beside, WORLD, &params()).moved, 4.0);
    }

    #[test]
    fn a_few_marks_judge_all_that_has_none_near_by() {
        let mut cells = empty();
        add(&mut cells, 2, middle(), WORLD, 0.93, 4.0);
        // Also behind the planes of the axes, which are faces of all finer cells.
        for far in [Vec3::X, Vec3::NEG_X, Vec3::NEG_ONE] {
            let found = change(&cells, 1000.0 * edge() * far, WORLD, &params());
            // Half a quantum of each path.
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
    fn a_fade_shows_from_one_light_path_though_it_moves() {
        for (left, share) in [(0.93, 0.07), (1.0 / 0.93, 0.07), (0.99, 0.01), (0.8, 0.2)] {
            for count in [1u32, 2, 6, 100] {
                let mut cells = empty();
                add(&mut cells, count, middle(), WORLD, left, 0.5);
                let found = change(&cells, middle(), WORLD, &params());
                // Half a quantum of each path.
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
        // Further than that it is other light.
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
    fn what_some_paths_lose_and_others_gain_is_chance() {
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
    fn the_longest_ways_are_not_told_apart() {
        let mut cells = empty();
        add(&mut cells, 10, middle(), WORLD, 1.0, 1.0e9);
        assert_eq!(change(&cells, middle(), WORLD, &params()).moved, MAX_STEP);
    }
}
