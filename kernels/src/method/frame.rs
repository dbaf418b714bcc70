//! What the frames of methods have in common: collect, denoise, reuse, shoot and gather batch by batch, resolve, display.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::LazyLock;

use crate::declare::{BufferSpec, Emission, INDEX, Step, Work, buffers};
use crate::gather::variant::{self, Over, Side, Stage, Variant};
use crate::history::path;
use crate::interface::frame::{Dispatch, FrameParams, PILOT};
use crate::method::{Method, Parts};
use crate::pass::balance::balance;
use crate::pass::bound::bound;
use crate::pass::collect::COLLECT;
use crate::pass::display::DISPLAY;
use crate::pass::{weigh, widen};
use crate::{denoiser, emission, history};

/// The steps of a frame of any method that brings photons to collection points: `prepare` comes once before the light
/// paths, `shoot` for each batch of them.
pub fn frame_steps(
    parts: Parts,
    params: &FrameParams,
    prepare: Vec<Step>,
    shoot: impl Fn(Batch) -> Vec<Step>,
) -> Vec<Step> {
    let Parts { history, denoiser, emission, balances, bounds, keeps_path, widens, .. } = parts;
    let shoots = params.light_path_count > 0;
    let mut steps = vec![
        Step::Clear { buffer: "counters" },
        Step::Clear { buffer: "accumulator" },
        Step::new(&COLLECT, params),
    ];
    if keeps_path {
        steps.extend(path::reproject_steps(params));
    }
    if bounds {
        steps.extend(bound(params));
    }
    if keeps_path {
        steps.extend(path::blend_steps(params));
    }
    steps.extend((denoiser.steps)(params));
    // A history that follows the light has nothing to follow in the dark.
    let forgets = !shoots && !history.forget.is_empty();
    if forgets {
        steps.extend(history.forget.iter().map(|&buffer| Step::Clear { buffer }));
    } else {
        steps.extend((history.before)(params));
    }
    if shoots && widens {
        steps.extend(widen::widen(params));
    }
    if shoots {
        if parts.weighs() {
            steps.extend(weigh::weigh(params));
        }
        steps.extend((emission.prepare)(params));
        steps.extend(prepare);
    } else {
        steps.extend(emission.forget.iter().map(|&buffer| Step::Clear { buffer }));
    }
    let pilot = emission.pilot.filter(|_| params.moved != 0);
    let pilot_count = if pilot.is_some() { params.light_path_count / PILOT } else { 0 };
    if let Some(learn) = pilot.filter(|_| pilot_count > 0) {
        steps.extend(batches(params, 0..pilot_count).flat_map(&shoot));
        steps.extend(learn(params));
    }
    steps.extend(batches(params, pilot_count..params.light_path_count).flat_map(&shoot));
    if shoots && widens {
        steps.extend(widen::learn(params));
    }
    steps.push(Step::new(if forgets { history::none::NONE.resolve } else { history.resolve }, params));
    if shoots && parts.weighs() {
        steps.extend(weigh::learn(params));
    }
    if shoots && balances {
        steps.extend(balance(params));
    }
    steps.push(Step::new(&DISPLAY, params));
    steps
}

/// The steps before a frame before which something moved. They run with the settings of the last frame, in the scene of this one.
pub fn look_back(parts: Parts, params: &FrameParams) -> Vec<Step> {
    if parts.keeps_path { path::retrace_steps(params) } else { Vec::new() }
}

/// Light paths whose photons the photon buffers hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batch {
    /// The first.
    pub first: u32,
    /// So many.
    pub count: u32,
}

impl Batch {
    /// The dispatch of a pass over them.
    pub fn dispatch(self) -> Dispatch {
        Dispatch { first: self.first, count: self.count, ..Dispatch::default() }
    }
}

/// Once a frame, after `collect`.
pub fn prepare(gather: &'static Variant, params: &FrameParams) -> Vec<Step> {
    gather.frame.iter().map(|&stage| step(gather, stage, params)).collect()
}

/// For each batch of light paths: shoots them, builds what is built over photons, gathers.
pub fn batch(parts: Parts, params: &FrameParams, batch: Batch) -> Vec<Step> {
    let mut steps = shoot(parts.emission, batch);
    steps.extend(exchange(parts.gather, params));
    steps
}

/// Builds what is built over the photons that are stored, and gathers them.
pub fn exchange(gather: &'static Variant, params: &FrameParams) -> Vec<Step> {
    let mut steps: Vec<Step> = gather.batch.iter().map(|&stage| step(gather, stage, params)).collect();
    steps.push(Step::dispatch(gather.gather, over(Over::searchers(gather.side), params)));
    steps
}

/// Shoots a batch of light paths and stores their photons.
pub fn shoot(emission: &Emission, batch: Batch) -> Vec<Step> {
    vec![Step::Clear { buffer: "photon_state" }, Step::dispatch(emission.shoot, batch.dispatch())]
}

/// The batches of these light paths.
fn batches(params: &FrameParams, paths: Range<u32>) -> impl Iterator<Item = Batch> + use<> {
    let (end, max_count) = (paths.end, params.light_path_batch.max(1));
    paths.step_by(max_count as usize).map(move |first| Batch { first, count: max_count.min(end - first) })
}

/// A dispatch over so much; over photons, over those that there are.
pub fn over(over: Over, params: &FrameParams) -> Dispatch {
    let stored = u32::from(over == Over::Photons);
    Dispatch { count: over.extent(params), stored, ..Dispatch::default() }
}

fn step(gather: &'static Variant, stage: Stage, params: &FrameParams) -> Step {
    match stage {
        Stage::Run(level, stage, threads) => Step::Dispatch {
            pass: gather.index,
            stage,
            dispatch: Dispatch { level, ..over(threads, params) },
        },
        Stage::Clear(words) => Step::Clear { buffer: INDEX[words as usize] },
        Stage::Structure(side) => {
            let over = if side == Side::Points { Over::Pixels } else { Over::Photons };
            Step::Structure { side, count: over.extent(params) }
        }
    }
}

/// What kind of work the step of a label does, of all that frames can consist of.
pub fn work(label: &str) -> Option<Work> {
    static WORK: LazyLock<BTreeMap<String, Work>> =
        LazyLock::new(|| all_steps().iter().filter_map(|step| Some((step.label(), step.work()?))).collect());
    WORK.get(label).copied()
}

/// The steps of frames of every method with every gather, history, denoiser and emission.
fn all_steps() -> Vec<Step> {
    let params = FrameParams {
        width: 1,
        height: 1,
        light_path_count: 1,
        light_path_batch: 1,
        photon_capacity: 1,
        light_count: 1,
        moved: 1,
        ..FrameParams::default()
    };
    let mut steps = Vec::new();
    for method in super::ALL {
        for gather in variant::ALL {
            for history in history::ALL {
                for denoiser in denoiser::ALL {
                    for emission in emission::ALL {
                        let parts = Parts {
                            balances: true,
                            bounds: true,
                            keeps_path: true,
                            widens: true,
                            auxiliary: true,
                            gather,
                            history,
                            denoiser,
                            emission,
                        };
                        let params = (method.frame)(params, 0);
                        steps.extend(look_back(parts, &params));
                        steps.extend(method.frame_steps(parts, &params));
                    }
                }
            }
        }
    }
    steps
}

/// The buffers of a frame of a method.
pub fn frame_buffers(method: &Method, parts: Parts, params: &FrameParams) -> Vec<BufferSpec> {
    let params = (method.frame)(*params, 0);
    let mut steps = look_back(parts, &params);
    steps.extend(method.frame_steps(parts, &params));
    buffers(&steps, &params)
}
