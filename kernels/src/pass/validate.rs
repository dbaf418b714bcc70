//! `validate`: traces a few light paths that keep their random numbers from frame to frame, and marks where their deposits
//! changed. In a scene where nothing moves nothing changes, to the bit.
//!
//! A path keeps its numbers for eight frames, and paths take turns in drawing new ones; in that frame a path only
//! remembers. All marks are made where things were in the frame before.

use crate::gather::Neighbours;
use crate::gather::brute::Brute;
use crate::gather::receive::Receive;
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistorySettings, VALIDATION_DEPOSITS, VALIDATION_PERIOD, ValidationDeposit};
use crate::interface::instance::Instance;
use crate::interface::needs::Needs;
use crate::interface::point::{DepositGeometry, DepositLight};
use crate::interface::scene::SceneTables;
use crate::light::emit::Emit;
use crate::math::rng::{Rng, Stream};
use crate::pass::shoot;
use crate::reuse::cells::{direct_radius, mark};
use crate::seam::{Atomics, Uncounted};
use crate::trace::Tracer;

/// Traces validation path `path`; its deposits of the frame before start at row `first` of `deposits`.
#[inline(always)]
pub fn validate<E: Emit, T: Tracer, A: Atomics>(
    path: u32,
    params: &FrameParams,
    needs: Needs,
    scene: SceneTables<'_>,
    instances: &[Instance],
    settings: &HistorySettings,
    emit: &E,
    tracer: &mut T,
    deposits: &mut [ValidationDeposit],
    first: u32,
    cells: &mut A,
) {
    let turn = params.frame.wrapping_add(path);
    let rng = Rng::new(Stream::Validation, params.seed, path, turn / VALIDATION_PERIOD);
    let compares = !turn.is_multiple_of(VALIDATION_PERIOD);
    let mut receive = Compare { deposits, first, count: 0, compares, instances, settings, params, cells };
    let needs = Needs(needs.0 & !Needs::LEDGER.0);
    let points = &mut Brute { count: 0 };
    shoot::follow(path, rng, params, needs, scene, emit, tracer, points, &mut receive, &mut Uncounted);
    receive.close();
}

/// Compares deposits with those of the frame before, and takes their place.
struct Compare<'a, A> {
    deposits: &'a mut [ValidationDeposit],
    first: u32,
    count: u32,
    compares: bool,
    instances: &'a [Instance],
    settings: &'a HistorySettings,
    params: &'a FrameParams,
    cells: &'a mut A,
}

impl<A: Atomics> Receive for Compare<'_, A> {
    #[inline(always)]
    fn receive<N: Neighbours>(&mut self, _points: &mut N, geometry: DepositGeometry, light: DepositLight) {
        if self.count >= VALIDATION_DEPOSITS {
            return;
        }
        let row = (self.first + self.count) as usize;
        let flux = light.flux.element_sum();
        let before = self.deposits[row];
        if self.compares {
            // Where this place of the surface was.
            let place = self.instances[geometry.instance as usize].to_previous.point(geometry.position);
            let mut change = 1.0;
            if before.flux > 0.0 {
                let lag = self.settings.lag * direct_radius(place, self.params);
                let moved = (place - before.position).length() / lag;
                let dimmed = (flux - before.flux).abs() / flux.max(before.flux);
                change = moved.max(dimmed).min(1.0);
                mark(self.cells, before.position, change, self.params);
            }
            mark(self.cells, place, change, self.params);
        }
        self.deposits[row] = ValidationDeposit { position: geometry.position, flux };
        self.count += 1;
    }
}

impl<A: Atomics> Compare<'_, A> {
    /// Marks and forgets the deposits that did not come again.
    #[inline(always)]
    fn close(&mut self) {
        while self.count < VALIDATION_DEPOSITS {
            let row = (self.first + self.count) as usize;
            let before = self.deposits[row];
            if self.compares && before.flux > 0.0 {
                mark(self.cells, before.position, 1.0, self.params);
            }
            self.deposits[row] = ValidationDeposit::default();
            self.count += 1;
        }
    }
}
