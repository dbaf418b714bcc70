//! Brute force: every point looks at every deposit. O(points x deposits): the oracle of every gather, nothing else.

use crate::gather::{Near, Neighbours, Visit};

/// All ids below a count.
#[derive(Clone, Copy)]
pub struct Brute {
    /// Elements.
    pub count: u32,
}

impl Neighbours for Brute {
    #[inline(always)]
    fn for_each_near<V: Visit>(&mut self, _near: Near, visit: &mut V) {
        let mut id = 0;
        while id < self.count {
            visit.visit(id);
            id += 1;
        }
    }
}
