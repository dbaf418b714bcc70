//! OurBasic: collect, shoot and gather, resolve, display. No light outlives its frame [Moreau and Doggett 2022].

use caustics_kernels::gather::accumulator;
use caustics_kernels::interface::counters::COUNTER_COUNT;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::point::PointShading;

use super::settings::TextureFilter;
use super::{BufferSpec, Method, Parts, Step, gather as gathers, history};

/// See the head of the file.
pub const BASIC: Method = Method {
    name: "basic",
    about: "OurBasic: no light outlives its frame",
    gathers: true,
    chooses_gather: true,
    texture_filter: TextureFilter::Cone,
    keeps: &[],
    frame: |params, index| FrameParams { frame: index, ..params },
    steps: |parts, params| steps(parts, params),
    buffers: |parts, params| buffers(parts, params),
};

/// The steps of a frame. Light paths come in batches that the deposit buffers hold.
pub fn steps(parts: impl Into<Parts>, params: FrameParams) -> Vec<Step> {
    let parts = parts.into();
    let prepare = |params| gathers::prepare(parts.gather, params);
    frame_steps(parts, params, prepare, |batch| gathers::batch(parts.gather, batch))
}

/// The steps of a frame of any method that brings deposits to collection points: `prepare` comes once before the light
/// paths, `shoot` for each batch of them.
pub fn frame_steps(
    parts: Parts,
    params: FrameParams,
    prepare: impl Fn(FrameParams) -> Vec<Step>,
    shoot: impl Fn(FrameParams) -> Vec<Step>,
) -> Vec<Step> {
    let Parts { history, filter, .. } = parts;
    let pixels = |pass| Step::Dispatch { pass, count: params.pixel_count(), params };
    let mut steps =
        vec![Step::Clear { buffer: "counters" }, Step::Clear { buffer: "accumulator" }, pixels("collect")];
    steps.extend((filter.steps)(params));
    // A history that follows the light has nothing to follow in the dark.
    let forgets = params.light_path_count == 0 && !history.forget.is_empty();
    if forgets {
        steps.extend(history.forget.iter().map(|&buffer| Step::Clear { buffer }));
    } else {
        steps.extend((history.before)(params));
    }
    if params.light_path_count > 0 {
        steps.extend(prepare(params));
    }
    for batch in gathers::batches(params) {
        steps.extend(shoot(batch));
    }
    steps.push(pixels(if forgets { history::NONE.resolve } else { history.resolve }));
    steps.push(pixels("display"));
    steps
}

/// The buffers of a frame, scene tables aside.
pub fn buffers(parts: impl Into<Parts>, params: &FrameParams) -> Vec<BufferSpec> {
    let parts = parts.into();
    let mut buffers = frame_buffers(parts, params);
    // A frame that shoots nothing needs nothing to gather with.
    if params.light_path_count > 0 {
        buffers.extend(gathers::buffers(parts.gather, params));
    }
    buffers
}

/// The buffers of a frame of any method that brings deposits to collection points.
pub fn frame_buffers(parts: Parts, params: &FrameParams) -> Vec<BufferSpec> {
    let Parts { history, filter, .. } = parts;
    let pixels = params.pixel_count() as usize;
    let spec = |name, bytes| BufferSpec { name, bytes };
    let mut buffers = vec![
        spec("pixel_order", 4 * pixels),
        spec("path_radiance", 12 * pixels),
        spec("seen_radiance", 12 * pixels),
        spec("caustic_radiance", 12 * pixels),
        spec("display_color", 12 * pixels),
        spec("point_geometry", 32 * pixels),
        spec("point_shading", size_of::<PointShading>() * pixels),
        spec("accumulator", 4 * accumulator::WORDS as usize * pixels),
        spec("counters", 4 * COUNTER_COUNT),
    ];
    buffers.extend((history.buffers)(params));
    buffers.extend((filter.buffers)(params));
    buffers
}

/// Pixels in Morton order: neighbouring invocations and boxes stay close in the picture.
pub fn pixel_order(width: u32, height: u32) -> Vec<u32> {
    let spread = |x: u32| (0..16).fold(0u32, |code, bit| code | (x >> bit & 1) << (2 * bit));
    let mut order: Vec<u32> = (0..width * height).collect();
    order.sort_by_cached_key(|&pixel| spread(pixel % width) | spread(pixel / width) << 1);
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_kernels::gather::variant;

    fn params() -> FrameParams {
        FrameParams {
            width: 7,
            height: 3,
            light_path_count: 1000,
            light_path_batch: 300,
            deposit_capacity: 1200,
            cell_mask: 1023,
            ..Default::default()
        }
    }

    #[test]
    fn batches_cover_every_light_path_once() {
        for variant in variant::ALL {
            let mut next = 0;
            for step in steps(variant, params()) {
                if let Step::Dispatch { pass, count, params } = step
                    && pass.starts_with("shoot")
                {
                    assert_eq!((params.part, params.light_path_batch), (next, count));
                    next += count;
                }
            }
            assert_eq!(next, 1000);
        }
    }

    #[test]
    fn every_cleared_buffer_exists() {
        for variant in variant::ALL {
            let buffers = buffers(variant, &params());
            for step in steps(variant, params()) {
                if let Step::Clear { buffer } = step {
                    assert!(buffers.iter().any(|spec| spec.name == buffer), "{}: {buffer}", variant.name);
                }
            }
        }
    }

    #[test]
    fn the_order_of_pixels_is_a_permutation_of_tiles() {
        let order = pixel_order(17, 9);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..17 * 9).collect::<Vec<_>>());
        // The first 64 are the first tile of 8 by 8.
        assert!(order[..64].iter().all(|pixel| pixel % 17 < 8 && pixel / 17 < 8));
    }
}
