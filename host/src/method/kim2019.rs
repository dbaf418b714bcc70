//! Screen-space photon mapping [Kim 2019, Ray Tracing Gems, ch. 30]: each deposit gives to the one pixel that sees it; see
//! the pass `splat`. The baseline of the talk.
//!
//! Cost: no index, no search. Wrong: caustics are seen on primary surfaces only, never in a mirror.

use caustics_kernels::gather::variant::Over;
use caustics_kernels::interface::frame::{Dispatch, FrameParams};
use caustics_kernels::pass::splat_kim2019::{AREA_FACING, AREA_FOOTPRINT, SPLAT_KIM2019};

use super::settings::TextureFilter;
use super::{Method, Parts, Step, basic, gather};

/// With the area of a pixel's footprint on the surface: conserves energy.
pub const KIM2019: Method = Method {
    name: "kim2019",
    about: "Kim 2019: photons splatted to the pixels that see them directly",
    gathers: true,
    chooses_gather: false,
    texture_filter: TextureFilter::Cone,
    keeps: &[],
    frame: |params, index| FrameParams { frame: index, ..params },
    steps: |parts, params| steps(parts, params, AREA_FOOTPRINT),
};

/// With Kim's own area of a pixel, which faces the eye: too bright where the surface does not, by 1 / cos.
pub const KIM2019_FACING: Method = Method {
    name: "kim2019-facing",
    about: "the same with Kim's area of a pixel, which ignores the surface's slant",
    steps: |parts, params| steps(parts, params, AREA_FACING),
    ..KIM2019
};

fn steps(parts: Parts, params: &FrameParams, area: u32) -> Vec<Step> {
    basic::frame_steps(parts, params, Vec::new(), |batch| {
        let mut steps = gather::shoot(batch);
        let deposits = gather::over(Over::Deposits, params);
        steps.push(Step::dispatch(&SPLAT_KIM2019, Dispatch { level: area, ..deposits }));
        steps
    })
}
