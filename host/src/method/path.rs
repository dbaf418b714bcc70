//! Path tracing of everything, one path a pixel and frame: the estimator of the reference at a frame's budget.
//!
//! Cost: a camera path a pixel. Unbiased, but caustics of small lights are noise for a long time, and those of point
//! lights are missing: no path finds a point.

use caustics_kernels::interface::counters::COUNTER_COUNT;
use caustics_kernels::interface::frame::FrameParams;

use super::settings::TextureFilter;
use super::{BufferSpec, Method, Parts, Step};

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
    buffers,
};

fn steps(_: Parts, params: FrameParams) -> Vec<Step> {
    let pixels = |pass| Step::Dispatch { pass, count: params.pixel_count(), params };
    vec![Step::Clear { buffer: "counters" }, pixels("reference"), pixels("display")]
}

fn buffers(_: Parts, params: &FrameParams) -> Vec<BufferSpec> {
    let pixels = params.pixel_count() as usize;
    let spec = |name, bytes| BufferSpec { name, bytes };
    vec![
        spec("pixel_order", 4 * pixels),
        spec("path_radiance", 12 * pixels),
        spec("caustic_radiance", 12 * pixels),
        spec("display_color", 12 * pixels),
        spec("counters", 4 * COUNTER_COUNT),
    ]
}
