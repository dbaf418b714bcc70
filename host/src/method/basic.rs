//! OurBasic: collect, shoot and gather, resolve, display. No light outlives its frame [Moreau and Doggett 2022].

use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::pass::collect::COLLECT;
use caustics_kernels::pass::display::DISPLAY;

use super::gather::Batch;
use super::settings::TextureFilter;
use super::{Method, Parts, Step, gather as gathers, history};

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
};

/// The steps of a frame. Light paths come in batches that the deposit buffers hold.
pub fn steps(parts: impl Into<Parts>, params: &FrameParams) -> Vec<Step> {
    let parts = parts.into();
    let prepare = gathers::prepare(parts.gather, params);
    frame_steps(parts, params, prepare, |batch| gathers::batch(parts.gather, params, batch))
}

/// The steps of a frame of any method that brings deposits to collection points: `prepare` comes once before the light
/// paths, `shoot` for each batch of them.
pub fn frame_steps(
    parts: Parts,
    params: &FrameParams,
    prepare: Vec<Step>,
    shoot: impl Fn(Batch) -> Vec<Step>,
) -> Vec<Step> {
    let Parts { history, filter, .. } = parts;
    let mut steps = vec![
        Step::Clear { buffer: "counters" },
        Step::Clear { buffer: "accumulator" },
        Step::of(&COLLECT, params),
    ];
    steps.extend((filter.steps)(params));
    // A history that follows the light has nothing to follow in the dark.
    let forgets = params.light_path_count == 0 && !history.forget.is_empty();
    if forgets {
        steps.extend(history.forget.iter().map(|&buffer| Step::Clear { buffer }));
    } else {
        steps.extend((history.before)(params));
    }
    if params.light_path_count > 0 {
        steps.extend(prepare);
    }
    for batch in gathers::batches(params) {
        steps.extend(shoot(batch));
    }
    steps.push(Step::of(if forgets { history::NONE.resolve } else { history.resolve }, params));
    steps.push(Step::of(&DISPLAY, params));
    steps
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
    use crate::method::buffers;
    use caustics_kernels::declare::Work;
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
            for step in steps(variant, &params()) {
                if let Step::Dispatch { pass, dispatch, .. } = step
                    && pass.work == Work::Light
                {
                    assert_eq!(dispatch.first, next);
                    next += dispatch.count;
                }
            }
            assert_eq!(next, 1000);
        }
    }

    #[test]
    fn what_is_bound_and_cleared_has_a_size_if_anything_uses_it() {
        for variant in variant::ALL {
            let steps = steps(variant, &params());
            let buffers = buffers(&steps, &params());
            let bytes = |name| buffers.iter().find(|spec| spec.name == name).map(|spec| spec.bytes);
            for step in steps {
                if let Step::Clear { buffer } = step {
                    assert!(bytes(buffer) > Some(0), "{}: {buffer}", variant.name);
                }
            }
            // Rows of 32 bytes.
            let sorted = if variant.sorts { 32 * 1200 } else { 0 };
            assert_eq!(bytes("sorted_light"), Some(sorted), "{}", variant.name);
            assert_eq!(bytes("point_geometry"), Some(32 * 21));
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
