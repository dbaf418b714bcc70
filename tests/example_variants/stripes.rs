//! Photons in stripes along x: an example that shows all that a gather consists of.
//!
//! Source: none. Cost: a pass over the photons to count, one to fill; a point reads every photon of its stripes.
//! Where it is slow: everywhere. It is exact for every radius.

use caustics_kernels::gather::tables::{Build, Tables};
use caustics_kernels::gather::variant::{Over, Stage, Variant, WordCount};
use caustics_kernels::gather::{Gather, Index, Near, Visit};
use caustics_kernels::platform::{Atomics, Words as _};

/// Photons in stripes along x.
pub struct Stripes;

/// Stripes; what lies farther along x starts over.
const COUNT: u32 = 1024;
/// Stripes a metre.
const PER_METRE: f32 = 16.0;

/// Number of the stripe of a coordinate.
fn stripe(x: f32) -> i32 {
    (x * PER_METRE + 1.0e6).clamp(0.0, 2.0e6) as i32
}

impl Index for Stripes {
    const VARIANT: Variant = Variant {
        name: "stripes",
        description: "photons in stripes along x: an example",
        cost: "a pass over the photons to count, one to fill; a point reads every photon of its stripes",
        limitations: "slow everywhere",
        batch: &[
            Stage::Clear(0),
            Stage::Run(0, "count", Over::Photons),
            Stage::Run(1, "scan", Over::Count(1)),
            Stage::Run(2, "fill", Over::Photons),
        ],
        // Ends of the stripes, behind a zero.
        words: [WordCount(1, Over::Count(COUNT + 1)), WordCount::NONE, WordCount::NONE, WordCount::NONE],
        sorts: true,
        ..Variant::NEW
    };

    fn build(stage: u32, index: u32, build: &mut Build<'_>) {
        if stage == 1 {
            // From counts to first slots, one slot on: filling turns them into ends.
            let (mut next, mut word) = (0, 1);
            while word <= COUNT {
                let count = build.index_0.get(word);
                build.index_0.set(word, next);
                next += count;
                word += 1;
            }
            return;
        }
        let photon = build.photon_geometry[index as usize];
        let word = 1 + (stripe(photon.position.x) as u32 & (COUNT - 1));
        let slot = build.index_0.add(word, 1);
        if stage == 2 {
            build.sorted_geometry.write(slot, photon);
            build.sorted_light.write(slot, build.photon_light[index as usize]);
        }
    }
}

impl Gather for Stripes {
    fn for_each_near<V: Visit>(tables: &mut Tables<'_>, near: Near, visit: &mut V) {
        let low = stripe(near.position.x - near.half_extent.x);
        let high = stripe(near.position.x + near.half_extent.x);
        let mut here = low;
        while here <= high && here < low + COUNT as i32 {
            let word = (here as u32 & (COUNT - 1)) as usize;
            let mut id = tables.index_0[word];
            while id < tables.index_0[word + 1] {
                visit.visit(tables, id);
                id += 1;
            }
            here += 1;
        }
    }
}
