//! Path tracing of everything, one path a pixel and frame: the estimator of the reference at a frame's budget.
//!
//! Cost: a camera path a pixel. Unbiased, but caustics of small lights are noise for a long time, and those of point
//! lights are missing: no path finds a point.

use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::pass::display::DISPLAY;
use caustics_kernels::pass::reference::REFERENCE;

use super::settings::TextureFilter;
use super::{Method, Parts, Step};

/// See the head of the file.
pub const PATH: Method = Method {
    name: "path",
    about: "path tracing of everything, one path a pixel: the reference's estimator",
    gathers: false,
    chooses_gather: false,
    texture_filter: TextureFilter::Finest,
    keeps: &[],
    frame: |params, index| FrameParams { frame: index, light_path_count: 0, ..params },
    steps,
};

fn steps(_: Parts, params: &FrameParams) -> Vec<Step> {
    vec![Step::Clear { buffer: "counters" }, Step::of(&REFERENCE, params), Step::of(&DISPLAY, params)]
}
