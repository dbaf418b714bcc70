//! `gather.*` of the photons' side: each point sums the deposits it takes.

use crate::gather::accumulator::Sum;
use crate::gather::contribution::disc_half_extent;
use crate::gather::receive::Take;
use crate::gather::{Near, Neighbours};
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use crate::seam::Atomics;
use crate::surface::textured::material_of;

/// Sums the deposits near the point of `pixel` into its words.
#[inline(always)]
pub fn gather_photons<N: Neighbours, A: Atomics, C: Atomics>(
    pixel: u32,
    params: &FrameParams,
    needs: Needs,
    materials: &[Material],
    point: PointGeometry,
    shading: PointShading,
    deposit_geometry: &[DepositGeometry],
    deposit_light: &[DepositLight],
    neighbours: &mut N,
    accumulator: &mut A,
    counters: &mut C,
) {
    if point.depth == 0 {
        return;
    }
    let mut take = Take {
        deposit_geometry,
        deposit_light,
        point,
        shading,
        material: material_of(&shading, materials, needs),
        params,
        needs,
        sum: Sum::default(),
    };
    let near = Near { position: point.position, half_extent: disc_half_extent(&point) };
    neighbours.for_each_near(near, &mut take);
    let sum = take.sum;
    if sum.count != 0 {
        sum.add_to(accumulator, pixel);
        sum.tally(counters);
    }
}
