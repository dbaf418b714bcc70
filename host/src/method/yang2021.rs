//! Adaptive anisotropic photon scattering: light paths start where a density map asks for them, carry differentials, and
//! each deposit is spread over the pixels around it as an ellipse; what they see is fed back into the map of the next frame
//! [Yang and Ouyang 2021, Ray Tracing Gems II, chapter 48].
//!
//! Cost: OurBasic's light paths and the pixels of their ellipses; no index, no stored deposit. Where it is wrong: only
//! primary surfaces receive, so that no mirror shows a caustic; an ellipse blurs, and at borders and thin walls part of it
//! is lost or leaks, over up to 16 pixels (2 % of the light in a small picture of a room full of things); differentials say
//! nothing of the extent of a lamp, of normal maps, and of what lies behind diffuse bounces. What the chapter accumulates
//! over time by reprojection is left out.

use caustics_kernels::interface::density::DensityTexel;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::light::density_map::{FEEDBACK_WORDS, MAPS, NODES, SIDE_LOG2, TEXELS, map_count};
use caustics_kernels::pass::density::node_count;

use super::basic::{frame_buffers, frame_steps};
use super::settings::TextureFilter;
use super::{BufferSpec, Method, Parts, Step};

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
    buffers,
};

fn steps(parts: Parts, params: FrameParams) -> Vec<Step> {
    frame_steps(parts, params, prepare, |batch| {
        vec![Step::Dispatch { pass: "shoot.yang2021", count: batch.light_path_batch, params: batch }]
    })
}

/// The density map of this frame.
fn prepare(params: FrameParams) -> Vec<Step> {
    let maps = map_count(params.light_count);
    let mut steps = vec![Step::Dispatch { pass: "density.update", count: maps * TEXELS, params }];
    steps.extend((0..=SIDE_LOG2).map(|level| Step::Dispatch {
        pass: "density.sum",
        count: node_count(level, maps),
        params: FrameParams { part: level, ..params },
    }));
    steps.push(Step::Clear { buffer: "density_feedback" });
    steps
}

fn buffers(parts: Parts, params: &FrameParams) -> Vec<BufferSpec> {
    let mut buffers = frame_buffers(parts, params);
    if params.light_path_count > 0 {
        let maps = MAPS as usize;
        let texels = maps * TEXELS as usize;
        buffers.extend([
            BufferSpec { name: "density", bytes: size_of::<DensityTexel>() * texels },
            BufferSpec { name: "density_tree", bytes: 4 * NODES as usize * maps },
            BufferSpec { name: "density_feedback", bytes: 4 * FEEDBACK_WORDS as usize * texels },
        ]);
    }
    buffers
}
