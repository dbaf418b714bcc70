//! OurBasic with discs of half the radius: an example that shows all that a method consists of.
#![cfg(not(target_arch = "spirv"))]

use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;

/// OurBasic with discs of half the radius.
pub const HALVED: Method = Method {
    name: "halved",
    description: "OurBasic with discs of half the radius: an example",
    limitations: "twice the noise",
    frame: |params, index| FrameParams { frame: index, radius_px: 0.5 * params.radius_px, ..params },
    ..BASIC
};
