//! `gather.*`: brings deposits and points together. An index over points is asked by each deposit, which gives to the
//! points that take it; an index over photons by each point, which takes from them.

use crate::gather::accumulator::Sum;
use crate::gather::contribution::{contribution, disc_half_extent, takes};
use crate::gather::tables::Tables;
use crate::gather::variant::Side;
use crate::gather::{Gather, Near, Visit};
use crate::interface::counters::{Counter, DepositState};
use crate::interface::frame::{EVERY_DEPOSIT, FrameParams};
use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry};
use crate::seam::Atomics;
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Deposits there are: those stored, as far as they fit.
#[inline(always)]
pub fn deposit_count(deposit_state: &[u32], params: &FrameParams) -> u32 {
    deposit_state[DepositState::Stored as usize].min(params.deposit_capacity)
}

/// Invocations of a stage of building.
#[inline(always)]
pub fn stage_count(params: &FrameParams, deposit_count: u32) -> u32 {
    if params.light_path_batch == EVERY_DEPOSIT { deposit_count } else { params.light_path_batch }
}

/// One invocation of a gather: of deposit `index`, or of the point at place `index` of `pixel_order`.
#[inline(always)]
pub fn gather<G: Gather, C: Atomics>(index: u32, tables: &mut Tables<'_>, counters: &mut C) {
    if const { matches!(G::VARIANT.side, Side::Points) } {
        if index < tables.deposit_count {
            let mut give = Give::new(index, tables);
            G::for_each_near(tables, give.near(), &mut give);
            give.close(counters);
        }
    } else if index < tables.params.pixel_count() {
        let mut take = Take::new(index, tables);
        if take.is_point() {
            G::for_each_near(tables, take.near(), &mut take);
            take.close(tables, counters);
        }
    }
}

/// A deposit that gives to points.
pub struct Give {
    geometry: DepositGeometry,
    light: DepositLight,
    total: Sum,
}

impl Give {
    /// Deposit `index`, which has given nothing yet.
    #[inline(always)]
    pub fn new(index: u32, tables: &Tables<'_>) -> Give {
        let geometry = tables.deposit_geometry[index as usize];
        let light = tables.deposit_light[index as usize];
        Give { geometry, light, total: Sum::default() }
    }

    /// Where its points are: their boxes hold it.
    #[inline(always)]
    pub fn near(&self) -> Near {
        Near { position: self.geometry.position, half_extent: Vec3::ZERO }
    }

    /// Counts what was given.
    #[inline(always)]
    pub fn close<C: Atomics>(self, counters: &mut C) {
        self.total.tally(counters);
    }
}

impl Visit for Give {
    #[inline(always)]
    fn visit(&mut self, tables: &mut Tables<'_>, id: u32) {
        let pixel = tables.pixel_order[id as usize];
        let point = tables.point_geometry[pixel as usize];
        if takes(&point, &self.geometry, tables.params.max_bounces) {
            let shading = tables.point_shading[pixel as usize];
            let material = material_of(&shading, tables.materials, tables.needs);
            let roughness = tables.params.specular_roughness;
            let value = contribution(&shading, material, &self.light, roughness, tables.needs);
            let sum = Sum::of(value, tables.params.inverse_quantum());
            sum.add_to(&mut tables.accumulator, pixel);
            self.total = self.total.plus(sum);
        }
    }
}

/// A point that takes from deposits.
pub struct Take {
    pixel: u32,
    point: PointGeometry,
    sum: Sum,
}

impl Take {
    /// The point at place `index` of `pixel_order`, which has taken nothing yet.
    #[inline(always)]
    pub fn new(index: u32, tables: &Tables<'_>) -> Take {
        let pixel = tables.pixel_order[index as usize];
        Take { pixel, point: tables.point_geometry[pixel as usize], sum: Sum::default() }
    }

    /// Whether there is a point.
    #[inline(always)]
    pub fn is_point(&self) -> bool {
        self.point.depth != 0
    }

    /// Where its deposits are.
    #[inline(always)]
    pub fn near(&self) -> Near {
        Near { position: self.point.position, half_extent: disc_half_extent(&self.point) }
    }

    /// Adds what was taken to the point's words.
    #[inline(always)]
    pub fn close<C: Atomics>(self, tables: &mut Tables<'_>, counters: &mut C) {
        if self.sum.count != 0 {
            self.sum.add_to(&mut tables.accumulator, self.pixel);
            self.sum.tally(counters);
        }
    }
}

impl Visit for Take {
    #[inline(always)]
    fn visit(&mut self, tables: &mut Tables<'_>, id: u32) {
        if takes(&self.point, &tables.deposit_geometry[id as usize], tables.params.max_bounces) {
            let shading = tables.point_shading[self.pixel as usize];
            let material = material_of(&shading, tables.materials, tables.needs);
            let light = tables.deposit_light[id as usize];
            let roughness = tables.params.specular_roughness;
            let value = contribution(&shading, material, &light, roughness, tables.needs);
            self.sum = self.sum.plus(Sum::of(value, tables.params.inverse_quantum()));
        }
    }
}

impl Sum {
    /// Adds its counts to the counters of the frame.
    #[inline(always)]
    pub fn tally<C: Atomics>(self, counters: &mut C) {
        if self.count != 0 {
            counters.add(Counter::Gathered as u32, self.count);
        }
        if self.clamped != 0 {
            counters.add(Counter::Clamped as u32, self.clamped);
        }
        if self.non_finite != 0 {
            counters.add(Counter::NonFinite as u32, self.non_finite);
        }
    }
}
