//! The seam of `shoot`: what becomes of a deposit.

use crate::interface::counters::DepositState;
use crate::interface::point::{DepositGeometry, DepositLight};
use crate::seam::{Atomics, Scatter};

/// Receives the deposits of a light path.
pub trait Receive {
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
