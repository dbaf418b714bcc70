//! Passes of the path history: both runners hold equal inputs before each pass, and its outputs are compared.

use caustics_kernels::declare::Step;
use caustics_kernels::history::NONE;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::method::frame::look_back;
use caustics_tests::compare::{Difference, Tolerance, floats};
use caustics_tests::table::Table;

use super::{Animation, steps};

const PATHS: &str = "0.5 % of the paths may diverge, as in the parity test of camera paths; a judgement is of up to 225 of them";
const FLIPS: &str =
    "the nearest history point may be another one of two that are as near, or one on the bound";

/// Frames before the compared one: enough that unchanged light knows its variance.
const FRAMES_BEFORE: u32 = 6;

/// Compares a frame of an animation, pass by pass. No buffer is zero in most pixels.
pub fn steps_agree(animation: &mut Animation) {
    animation.keeps_path = true;
    animation.restart(&NONE);
    let mut table = Table::new("path-traced light that is kept, CPU against GPU");
    let mut before: Option<FrameParams> = None;
    for frame in 0..=FRAMES_BEFORE {
        let params = animation.pose(frame);
        let past = before.map(|before| FrameParams { light_count: params.light_count, ..before });
        let mut all: Vec<(FrameParams, Step)> = Vec::new();
        if let Some(past) = past {
            all.extend(look_back(animation.parts(), &past).into_iter().map(|step| (past, step)));
        }
        all.extend(animation.steps(&params).into_iter().map(|step| (params, step)));
        for (params, step) in all {
            if frame < FRAMES_BEFORE {
                animation.runners.cpu.run(&params, &[step]).expect("the CPU runs the step");
            } else {
                one(animation, &params, step, &mut table);
            }
        }
        before = Some(params);
    }
    table.finish();
}

/// Runs a step: on both runners if it belongs to this history, else on the CPU.
fn one(animation: &mut Animation, params: &FrameParams, step: Step, table: &mut Table) {
    let runners = &mut animation.runners;
    let pass = match step {
        Step::Dispatch { pass, .. } if pass.name.starts_with("path.") => pass,
        _ => {
            runners.cpu.run(params, &[step]).expect("the CPU runs the step");
            return;
        }
    };
    runners.copy_to_gpu(&[step]);
    runners.run(params, &[step]);
    for bound in pass.written() {
        if bound.name == "path_points" {
            table.add(pass.name, steps::points(runners, bound.name));
            continue;
        }
        let (cpu, gpu) = runners.records::<f32>(bound.name);
        let written = cpu.iter().filter(|value| **value != 0.0).count();
        assert!(written > cpu.len() / 8, "{}: {written} of {}", bound.name, cpu.len());
        let scale = cpu.iter().map(|value| value.abs()).sum::<f32>() / cpu.len() as f32;
        let (share, reason) = if pass.name == "path.retrace" { (5.0e-3, PATHS) } else { (2.0e-3, FLIPS) };
        let tolerance = Tolerance::relative(1.0e-3, scale, reason).except(share, reason);
        let found: Difference = floats(bound.name, 1, &cpu, &gpu, tolerance);
        table.add(pass.name, [found]);
    }
}
