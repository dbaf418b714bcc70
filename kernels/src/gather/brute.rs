//! Brute force: every point visits every photon. It is the oracle that tests hold every gather against.
//!
//! Cost: points times photons. Limitations: slow, so it serves as the oracle alone.

use crate::gather::tables::{Build, Tables};
use crate::gather::variant::Variant;
use crate::gather::{Gather, Index, Near, Visit};

/// Gather without an index: every point visits every photon.
pub struct Brute;

impl Index for Brute {
    const VARIANT: Variant = Variant {
        name: "brute",
        description: "every point tests every photon: the reference of all gathers, O(points x photons)",
        cost: "points x photons",
        limitations: "slow",
        ..Variant::NEW
    };

    #[inline(always)]
    fn build(_stage: u32, _index: u32, _build: &mut Build<'_>) {}
}

impl Gather for Brute {
    #[inline(always)]
    fn for_each_near<V: Visit>(tables: &mut Tables<'_>, _near: Near, visit: &mut V) {
        let mut id = 0;
        while id < tables.photon_count {
            visit.visit(tables, id);
            id += 1;
        }
    }
}
