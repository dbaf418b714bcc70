//! The seam of `shoot`: what becomes of a deposit, and what is followed on the way to it.

use crate::interface::counters::DepositState;
use crate::interface::point::{DepositGeometry, DepositLight};
use crate::light::emit::Leaving;
use crate::math::ray::{Hit, Ray};
use crate::seam::{Atomics, Scatter};
use crate::surface::scatter::Departure;
use crate::surface::vertex::Vertex;

/// Receives the deposits of a light path. What else it may ask to see of the way costs nothing where it does not.
pub trait Receive {
    /// A path starts.
    #[inline(always)]
    fn start(&mut self, _leaving: &Leaving) {}
    /// The path meets a surface, before it deposits there.
    #[inline(always)]
    fn arrive(&mut self, _ray: &Ray, _hit: &Hit, _here: &Vertex) {}
    /// The path leaves a surface.
    #[inline(always)]
    fn scatter(&mut self, _departure: &Departure) {}
    /// Takes one deposit.
    fn receive(&mut self, geometry: DepositGeometry, light: DepositLight);
}

/// Stores deposits for a gather.
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
    fn receive(&mut self, geometry: DepositGeometry, light: DepositLight) {
        let slot = self.state.add(DepositState::Stored as u32, 1);
        if slot < self.capacity {
            self.geometry.write(slot, geometry);
            self.light.write(slot, light);
        } else {
            self.dropped += 1;
        }
    }
}
