//! Steps that the frames of methods share: collect, denoise, reuse, shoot and gather batch by batch, resolve, display.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::LazyLock;

use crate::declare::{BufferSpec, Emission, FrameStage, INDEX, Pilot, Step, Work, buffers};
use crate::gather::variant::{self, Over, Side, Stage, Variant};
use crate::interface::frame::{Dispatch, FIRST_FRAME, FrameParams, PILOT};
use crate::method::{Method, Parts, Stages};
use crate::pass::collect::COLLECT;
use crate::pass::display::DISPLAY;
use crate::{denoiser, emission, history};

/// Steps of a frame of any method that brings photons to collection points. `prepare` comes once before the light paths, `shoot`
/// for each batch of them.
pub fn frame_steps(
    parts: Parts,
    params: &FrameParams,
    prepare: Vec<Step>,
    shoot: impl Fn(Batch) -> Vec<Step>,
) -> Vec<Step> {
    let Parts { history, denoiser, .. } = parts;
    let shoots = params.light_path_count > 0;
    // Trace the camera paths
    let mut steps = vec![Step::Clear { buffer: "counters" }, Step::Clear { buffer: "accumulator" }];
    steps.extend(parts.steps(|stage| stage.before_collect, params));
    steps.push(Step::new(&COLLECT, params));
    steps.extend(parts.steps(|stage| stage.after_collect, params));

    // Denoise the path layer
    steps.extend(parts.steps(|stage| stage.before_denoise, params));
    steps.extend((denoiser.steps)(params));

    // Prepare the history; without light paths, clear one that follows them.
    let forgets = !shoots && !history.forget.is_empty();
    if forgets {
        steps.extend(history.forget.iter().map(|&buffer| Step::Clear { buffer }));
    } else {
        steps.extend((history.before)(params));
    }
    if shoots {
        // Learn from earlier frames, and index the collection points
        steps.extend(parts.steps(|stage| stage.before_light, params));
        steps.extend(prepare.clone());
    }

    // Learn from training paths before the first frame, and from a pilot after something moved
    let pilot_count = params.light_path_count / PILOT;
    let learns = parts.all_stages().any(|stage| stage.after_pilot.is_some());
    let has_pilot = params.moved != 0 && pilot_count > 0 && learns;
    let learn = |pilot: Pilot| {
        let learn_of = |stage: &FrameStage| Some(stage.after_pilot?(params, pilot));
        parts.all_stages().filter_map(learn_of).flatten().collect()
    };
    let mut first = 0;
    if has_pilot && params.moved == FIRST_FRAME {
        steps.extend(train(params, &shoot, learn));
    } else if has_pilot {
        first = pilot_count;
        steps.extend(batches(params, 0..first).flat_map(&shoot));
        steps.extend(learn(Pilot { gathered: 1, has_weights: true }));
    }

    // Shoot and gather the other light paths
    steps.extend(batches(params, first..params.light_path_count).flat_map(&shoot));
    if shoots {
        steps.extend(parts.steps(|stage| stage.after_gather, params));
    }

    // Resolve and display
    steps.push(Step::new(if forgets { history::none::NONE.resolve } else { history.resolve }, params));
    if shoots {
        steps.extend(parts.steps(|stage| stage.after_resolve, params));
        if !has_pilot && params.light_path_count <= params.light_path_batch {
            let gather = [prepare, exchange(parts.gather, params)].concat();
            steps.extend(parts.all_stages().flat_map(|stage| (stage.gather_again)(params, &gather)));
        }
    }
    steps.extend(parts.steps(|stage| stage.before_display, params));
    steps.push(Step::new(&DISPLAY, params));
    steps
}

/// Training paths, in three parts (eighths of the first frame's number of light paths). The first part shows where
/// caustics are, so that scores of the second count. The third starts where the second found them.
const TRAINING: [u32; 3] = [1, 4, 4];

/// Number of training paths of a first frame with this number of light paths.
pub fn training_paths(light_path_count: u32) -> u64 {
    u64::from(TRAINING.iter().sum::<u32>()) * u64::from(light_path_count / PILOT)
}

/// Steps of the training before the first frame: stages learn from light paths whose light is not shown. Their indices, and so their
/// random numbers, follow those of the frame's own paths.
fn train(
    params: &FrameParams,
    shoot: impl Fn(Batch) -> Vec<Step>,
    learn: impl Fn(Pilot) -> Vec<Step>,
) -> Vec<Step> {
    let mut steps = Vec::new();
    let (mut end, mut gathered) = (params.light_path_count, 0);
    for eighths in TRAINING {
        let (start, has_weights) = (end, gathered > 0);
        end += eighths * (params.light_path_count / PILOT);
        gathered += eighths;
        steps.extend(batches(params, start..end).flat_map(&shoot));
        steps.extend(learn(Pilot { gathered, has_weights }));
    }
    steps.push(Step::Clear { buffer: "accumulator" });
    steps
}

/// Steps that precede a frame after something moved. They run with the settings of the last frame, in the scene of this one.
pub fn look_back(parts: Parts, params: &FrameParams) -> Vec<Step> {
    parts.steps(|stage| stage.look_back, params)
}

/// Light paths whose photons fit the photon buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batch {
    /// Index of the first light path.
    pub first: u32,
    /// Number of light paths.
    pub count: u32,
}

impl Batch {
    /// The dispatch of a pass over them.
    pub fn dispatch(self) -> Dispatch {
        Dispatch { first: self.first, count: self.count, ..Dispatch::default() }
    }
}

/// Steps of a gather that run once a frame, after `collect`.
pub fn prepare(gather: &'static Variant, params: &FrameParams) -> Vec<Step> {
    gather.frame.iter().map(|&stage| step(gather, stage, params)).collect()
}

/// Steps for each batch of light paths: shoot, build the index over photons, gather.
pub fn batch(parts: Parts, params: &FrameParams, batch: Batch) -> Vec<Step> {
    let mut steps = shoot(parts.emission, batch);
    steps.extend(exchange(parts.gather, params));
    steps
}

/// Steps that build the index over the stored photons, and gather them.
pub fn exchange(gather: &'static Variant, params: &FrameParams) -> Vec<Step> {
    let mut steps: Vec<Step> = gather.batch.iter().map(|&stage| step(gather, stage, params)).collect();
    steps.push(Step::dispatch(gather.gather, over(Over::searchers(gather.side), params)));
    steps
}

/// Steps that shoot a batch of light paths and store their photons.
pub fn shoot(emission: &Emission, batch: Batch) -> Vec<Step> {
    vec![Step::Clear { buffer: "photon_state" }, Step::dispatch(emission.shoot, batch.dispatch())]
}

/// The batches of these light paths.
fn batches(params: &FrameParams, paths: Range<u32>) -> impl Iterator<Item = Batch> + use<> {
    let (end, max_count) = (paths.end, params.light_path_batch.max(1));
    paths.step_by(max_count as usize).map(move |first| Batch { first, count: max_count.min(end - first) })
}

/// Dispatch over a range. One over photons is limited to the stored photons.
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

/// Kind of work of the step with a label, among the steps of all frames.
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
        share_radius_px: 2.0,
        cache_share: 1.0,
        ..FrameParams::default()
    };
    let mut steps = Vec::new();
    for method in super::ALL {
        for gather in variant::ALL {
            for history in history::ALL {
                for denoiser in denoiser::ALL {
                    for emission in emission::ALL {
                        let parts = Parts { gather, history, denoiser, emission, stages: Stages::ALL };
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
    // Frames without a pilot and with a single batch have other steps.
    let light_path_count = params.light_path_count.min(params.light_path_batch);
    steps.extend(method.frame_steps(parts, &FrameParams { moved: 0, light_path_count, ..params }));
    buffers(&steps, &params)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::gather::variant::{BRUTE, PHOTONS_GRID, PHOTONS_RT, POINTS_BVH, POINTS_GRID, POINTS_RT};
    use crate::history::auxiliary::AUXILIARY_LAYERS;
    use crate::history::path::PATH_HISTORY;
    use crate::method::{BASIC, KIM2019, PATH, PROGRESSIVE, YANG2021};
    use crate::pass::balance::BALANCE;
    use crate::pass::bound::BOUND;
    use crate::pass::widen::WIDEN;

    /// FNV-1a hash of a text, continued.
    fn hash(state: u64, text: &str) -> u64 {
        text.bytes().fold(state, |state, byte| (state ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    /// Parts with the stages of a mask.
    fn with_stages(mask: u32, parts: Parts) -> Parts {
        let stages = [&PATH_HISTORY, &BOUND, &WIDEN, &BALANCE, &AUXILIARY_LAYERS];
        let with = |all: Stages, (bit, stage): (usize, &&FrameStage)| all.with(stage, mask & 1 << bit != 0);
        Parts { stages: stages.iter().enumerate().fold(Stages::NONE, with), ..parts }
    }

    /// Hash of the steps of frames with some stages, of every method, gather, history, denoiser and emission; dark and lit, still
    /// and after something moved.
    fn steps_hash(mask: u32) -> u64 {
        let mut state = 0xcbf2_9ce4_8422_2325;
        for (light_path_count, moved) in [(0, 0), (0, 1), (1000, 0), (1000, 1)] {
            let params = FrameParams {
                width: 7,
                height: 3,
                light_path_count,
                light_path_batch: 300,
                photon_capacity: 1200,
                light_count: 1,
                moved,
                ..FrameParams::default()
            };
            for method in [&BASIC, &PROGRESSIVE, &PATH, &KIM2019, &YANG2021] {
                for gather in [&BRUTE, &PHOTONS_GRID, &PHOTONS_RT, &POINTS_BVH, &POINTS_GRID, &POINTS_RT] {
                    for history in [&history::NONE, &history::PAPER, &history::VALIDATED] {
                        for denoiser in [&denoiser::NONE, &denoiser::ATROUS] {
                            for emission in [&emission::POWER, &emission::AIMED, &emission::GUIDED] {
                                let parts = Parts { history, denoiser, emission, ..Parts::from(gather) };
                                let parts = with_stages(mask, parts);
                                let params = (method.frame)(params, 0);
                                for step in look_back(parts, &params) {
                                    state = hash(state, &format!("{step:?}"));
                                }
                                for step in method.frame_steps(parts, &params) {
                                    state = hash(state, &format!("{step:?}"));
                                }
                                // A buffer had another name then
                                let name_then =
                                    |name| if name == "path_noise_kept" { "path_square" } else { name };
                                let kept: BTreeSet<_> = method.kept(parts).map(name_then).collect();
                                state = hash(state, &format!("{kept:?}"));
                            }
                        }
                    }
                }
            }
        }
        state
    }

    /// Expected hashes by a mask of stages: path history, bound, widen, balance, auxiliary layers. They are from the commit
    /// before `FrameStage`, when each stage was a boolean of `Parts` and an `if` of `frame_steps`.
    const HASHES: [u64; 32] = [
        0xeb65_8392_3ce3_cc5d,
        0x795b_0d2c_ccd4_3b85,
        0xe777_4878_eb3e_0465,
        0xabd9_6720_4536_7295,
        0x5b6f_7e92_6bc3_4bd5,
        0x0008_bb53_de45_9e5d,
        0xc6f2_b6cb_2df9_a36d,
        0x56ab_634c_a55f_6a05,
        0x5aeb_04aa_9739_2515,
        0x8bb3_2187_e96f_93dd,
        0x7aee_62a8_0825_0a35,
        0x652d_ac7a_5cca_b74d,
        0x9029_09c1_40c2_6bf5,
        0x7d6d_e268_6b51_5055,
        0xce95_9d2d_510a_9bcd,
        0x50a1_fa65_232a_ec5d,
        0x16cf_8d46_a809_40cd,
        0x8d2e_fca7_0f5b_ca8d,
        0xc997_14aa_59ab_4f0d,
        0x7006_f849_2359_9f95,
        0x5bd3_b7fc_f9e2_091d,
        0x7b12_8338_b052_510d,
        0x04de_a367_db07_9f1d,
        0x2cbd_cc18_48d3_8b5d,
        0x9a42_f822_4cf6_7215,
        0xd568_1850_4815_0405,
        0xa9fb_2b04_0177_3ced,
        0xe254_0c2d_276a_fe4d,
        0x6cfd_8603_2bbe_74ed,
        0xe917_c0c6_dc6c_f405,
        0xe024_06d2_8112_02dd,
        0xb8b4_2f14_27de_1175,
    ];

    #[test]
    fn stages_give_the_steps_of_the_booleans_that_they_replaced() {
        for (mask, expected) in (0..).zip(HASHES) {
            assert_eq!(steps_hash(mask), expected, "stages {mask:#07b}");
        }
    }
}
