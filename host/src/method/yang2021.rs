//! Adaptive anisotropic photon scattering: light paths start where a density map asks for them, carry differentials, and
//! each deposit is spread over the pixels around it as an ellipse; what they see is fed back into the map of the next frame
//! [Yang and Ouyang 2021, Ray Tracing Gems II, chapter 48].
//!
//! Cost: OurBasic's light paths and the pixels of their ellipses; no index, no stored deposit. Where it is wrong: only
//! primary surfaces receive, so that no mirror shows a caustic; an ellipse blurs, and at borders and thin walls part of it
//! is lost or leaks, over up to 16 pixels (2 % of the light in a small picture of a room full of things); differentials say
//! nothing of the extent of a lamp, of normal maps, and of what lies behind diffuse bounces. What the chapter accumulates
//! over time by reprojection is left out.

use caustics_kernels::interface::frame::{Dispatch, FrameParams};
use caustics_kernels::light::density_map::{SIDE_LOG2, map_count};
use caustics_kernels::pass::density::{DENSITY_SUM, DENSITY_UPDATE, node_count};
use caustics_kernels::pass::shoot_yang2021::SHOOT_YANG2021;

use super::basic::frame_steps;
use super::settings::TextureFilter;
use super::{Method, Parts, Step};

/// See the head of the file.
pub const YANG2021: Method = Method {
    name: "yang2021",
    about: "adaptive anisotropic photon scattering: ellipses on primary surfaces, guided by feedback",
    gathers: true,
    chooses_gather: false,
    texture_filter: TextureFilter::Cone,
    keeps: &["density", "density_tree", "density_feedback"],
    frame: |params, index| FrameParams { frame: index, ..params },
    steps,
};

fn steps(parts: Parts, params: &FrameParams) -> Vec<Step> {
    frame_steps(parts, params, prepare(params), |batch| {
        vec![Step::dispatch(&SHOOT_YANG2021, batch.dispatch())]
    })
}

/// The density map of this frame.
fn prepare(params: &FrameParams) -> Vec<Step> {
    let sum = |level| {
        let count = node_count(level, map_count(params.light_count));
        Step::dispatch(&DENSITY_SUM, Dispatch { count, level, ..Dispatch::default() })
    };
    let mut steps = vec![Step::of(&DENSITY_UPDATE, params)];
    steps.extend((0..=SIDE_LOG2).map(sum));
    steps.push(Step::Clear { buffer: "density_feedback" });
    steps
}
