//! Rendering methods. A method is a file and a line here: passes of its own, if it has any, and the steps of a frame, as data.
//! Imports everything.

#[cfg(not(target_arch = "spirv"))]
pub mod frame;
#[cfg(not(target_arch = "spirv"))]
pub mod kind;

#[cfg(not(target_arch = "spirv"))]
pub use kind::{Method, Parts, STAGES, Stages};

crate::declare::variants! {
    Method {
        basic: BASIC;
        progressive: PROGRESSIVE;
        path: PATH;
        kim2019: KIM2019 KIM2019_FACING;
        yang2021: YANG2021;
    }
}
