//! The seam of `shoot`: what becomes of a deposit.
//!
//! `Neighbours` over points stay beside the receiver, not in it: rust-gpu keeps no acceleration structure in a struct
//! with other fields.

use crate::gather::accumulator::Sum;
use crate::gather::contribution::{contribution, takes};
use crate::gather::{Near, Neighbours, Visit};
use crate::interface::counters::{Counter, DepositState};
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use crate::seam::{Atomics, Scatter};
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Receives the deposits of a light path.
pub trait Receive {
    /// Takes one deposit; `points` finds the points near it.
    fn receive<N: Neighbours>(&mut self, points: &mut N, geometry: DepositGeometry, light: DepositLight);
}

/// Stores deposits for a gather from the points' side.
pub struct Store<G, L, A> {
    /// Slots of `deposit_geometry`.
    pub geometry: G,
    /// Slots of `deposit_light`.
    pub light: L,
    /// `deposit_state`.
    pub state: A,
    /// Slots there are.
    pub capacity: u32,
    /// Deposits of this path that found no room.
    pub dropped: u32,
}

impl<G: Scatter<DepositGeometry>, L: Scatter<DepositLight>, A: Atomics> Receive for Store<G, L, A> {
    #[inline(always)]
    fn receive<N: Neighbours>(&mut self, _points: &mut N, geometry: DepositGeometry, light: DepositLight) {
        let slot = self.state.add(DepositState::Stored as u32, 1);
        if slot < self.capacity {
            self.geometry.write(slot, geometry);
            self.light.write(slot, light);
        } else {
            self.dropped += 1;
        }
    }
}

/// Hands each deposit at once to the points that take it.
pub struct Give<'a, A> {
    /// Pixel of each point that `Neighbours` finds.
    pub pixel_order: &'a [u32],
    /// All points, by pixel.
    pub point_geometry: &'a [PointGeometry],
    /// Their shading.
    pub point_shading: &'a [PointShading],
    /// All materials.
    pub materials: &'a [Material],
    /// Words of all points' sums.
    pub accumulator: A,
    /// Settings.
    pub params: &'a FrameParams,
    /// What the scene needs.
    pub needs: Needs,
    /// What was given so far.
    pub total: Sum,
}

impl<A: Atomics> Receive for Give<'_, A> {
    #[inline(always)]
    fn receive<N: Neighbours>(&mut self, points: &mut N, geometry: DepositGeometry, light: DepositLight) {
        let mut visit = GiveOne {
            pixel_order: self.pixel_order,
            point_geometry: self.point_geometry,
            point_shading: self.point_shading,
            materials: self.materials,
            accumulator: &mut self.accumulator,
            params: self.params,
            needs: self.needs,
            geometry,
            light,
            total: self.total,
        };
        let near = Near { position: geometry.position, half_extent: Vec3::ZERO };
        points.for_each_near(near, &mut visit);
        self.total = visit.total;
    }
}

struct GiveOne<'a, A> {
    pixel_order: &'a [u32],
    point_geometry: &'a [PointGeometry],
    point_shading: &'a [PointShading],
    materials: &'a [Material],
    accumulator: &'a mut A,
    params: &'a FrameParams,
    needs: Needs,
    geometry: DepositGeometry,
    light: DepositLight,
    total: Sum,
}

impl<A: Atomics> Visit for GiveOne<'_, A> {
    #[inline(always)]
    fn visit(&mut self, id: u32) {
        let pixel = self.pixel_order[id as usize];
        let point = self.point_geometry[pixel as usize];
        if takes(&point, &self.geometry, self.params.max_bounces) {
            let shading = self.point_shading[pixel as usize];
            let material = material_of(&shading, self.materials, self.needs);
            let value =
                contribution(&shading, material, &self.light, self.params.specular_roughness, self.needs);
            let sum = Sum::of(value, self.params.inverse_quantum());
            sum.add_to(self.accumulator, pixel);
            self.total = self.total.plus(sum);
        }
    }
}

/// Sums the deposits that one point takes.
pub struct Take<'a> {
    /// All deposits.
    pub deposit_geometry: &'a [DepositGeometry],
    /// Their light.
    pub deposit_light: &'a [DepositLight],
    /// The point.
    pub point: PointGeometry,
    /// Its shading.
    pub shading: PointShading,
    /// Its material.
    pub material: Material,
    /// Settings.
    pub params: &'a FrameParams,
    /// What the scene needs.
    pub needs: Needs,
    /// The sum so far.
    pub sum: Sum,
}

impl Visit for Take<'_> {
    #[inline(always)]
    fn visit(&mut self, id: u32) {
        if takes(&self.point, &self.deposit_geometry[id as usize], self.params.max_bounces) {
            let light = self.deposit_light[id as usize];
            let value = contribution(
                &self.shading,
                self.material,
                &light,
                self.params.specular_roughness,
                self.needs,
            );
            self.sum = self.sum.plus(Sum::of(value, self.params.inverse_quantum()));
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
