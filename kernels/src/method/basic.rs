//! OurBasic [Moreau and Doggett 2022]: collect, shoot and gather, resolve, display. No light outlives its frame.
//!
//! Cost: a camera path a pixel, light paths, an index and its search. Limitations: discs blur by their radius, and lose
//! light beyond an edge.
#![cfg(not(target_arch = "spirv"))]

use crate::declare::Step;
use crate::interface::choice::TextureFilter;
use crate::interface::frame::FrameParams;
use crate::method::frame::{self, frame_steps};
use crate::method::{Method, Parts};

/// OurBasic: photons gathered at collection points, without reuse.
pub const BASIC: Method = Method {
    name: "basic",
    description: "OurBasic: photons gathered at collection points, without reuse",
    cost: "a camera path a pixel, light paths, an index and its search",
    limitations: "discs blur by their radius, and lose light at edges",
    gathers: true,
    supports_history: true,
    chooses_gather: true,
    chooses_emission: true,
    converges: false,
    texture_filter: TextureFilter::Cone,
    shares_indirect: false,
    uses_cache: false,
    passes_thin_walls: true,
    keeps: &[],
    frame: |params, index| FrameParams { frame: index, ..params },
    steps: |parts, params| steps(parts, params),
};

/// Steps of a frame. Light paths come in batches whose photons fit the photon buffers.
pub fn steps(parts: impl Into<Parts>, params: &FrameParams) -> Vec<Step> {
    let parts = parts.into();
    let prepare = frame::prepare(parts.gather, params);
    frame_steps(parts, params, prepare, |batch| frame::batch(parts, params, batch))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::declare::{Work, buffers};
    use crate::gather::variant;

    fn params() -> FrameParams {
        FrameParams {
            width: 7,
            height: 3,
            light_path_count: 1000,
            light_path_batch: 300,
            photon_capacity: 1200,
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
    fn cleared_and_used_buffers_have_a_size() {
        for variant in variant::ALL {
            let steps = steps(variant, &params());
            let buffers = buffers(&steps, &params());
            let bytes = |name| buffers.iter().find(|spec| spec.name == name).map(|spec| spec.bytes);
            for step in steps {
                if let Step::Clear { buffer } = step {
                    assert!(bytes(buffer) > Some(0), "{}: {buffer}", variant.name);
                }
            }
            // Records of 32 bytes.
            let sorted = if variant.sorts { 32 * 1200 } else { 0 };
            assert_eq!(bytes("sorted_light"), Some(sorted), "{}", variant.name);
            assert_eq!(bytes("point_geometry"), Some(32 * 21));
        }
    }
}
