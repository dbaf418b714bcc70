//! Energy ledgers of light paths, frame by frame, without a runner.

use std::ops::Range;

use caustics::energy::EnergyLedger;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight};
use caustics_kernels::light::emit::Emit;
use caustics_kernels::pass::shoot::shoot;
use caustics_kernels::path::photon_sink::PhotonSink;

use crate::direct::{Tally, World};
use crate::statistics::Mean;

/// Receiver that discards photons.
struct NoReceiver;

impl PhotonSink for NoReceiver {
    type PathState = ();

    fn store_photon(&mut self, (): &mut (), _: PhotonGeometry, _: PhotonLight) {}
}

/// The ledger of one frame.
pub fn ledger<E: Emit>(world: &World<'_>, emit: &E, frame: u32) -> EnergyLedger {
    let mut params = world.params;
    params.frame = frame;
    let features = world.features | Features::LEDGER;
    let (mut tracer, mut tally) = (world.tracer(), Tally::default());
    for index in 0..params.light_path_count {
        shoot(index, &params, features, world.tables(), emit, &mut tracer, &mut NoReceiver, &mut tally);
    }
    EnergyLedger::from_words(&tally.0, params.quantum)
}

/// Ledgers of independent frames, on two threads.
pub fn ledgers<E: Emit + Sync>(world: &World<'_>, emit: &E, frames: Range<u32>) -> Vec<EnergyLedger> {
    let part = |frames: Range<u32>| frames.map(|frame| ledger(world, emit, frame)).collect::<Vec<_>>();
    let middle = frames.start.midpoint(frames.end);
    std::thread::scope(|scope| {
        let second = scope.spawn(|| part(middle..frames.end));
        let mut all = part(frames.start..middle);
        all.extend(second.join().expect("no panic"));
        all
    })
}

/// Mean over the frames of a part of the ledger, as a share of the emitted flux.
pub fn share(ledgers: &[EnergyLedger], part: impl Fn(&EnergyLedger) -> f64) -> Mean {
    Mean::from_samples(&ledgers.iter().map(|energy| part(energy) / energy.emitted).collect::<Vec<_>>())
}
