//! Presets of `render`.

use caustics_bench::parameter::{AUTO, METHOD, Parameter, RADIUS_PX, SAMPLER};
use caustics_kernels::interface::choice::Sampler;
use caustics_kernels::method::progressive::PROGRESSIVE;
use clap::ValueEnum;

/// A choice of all that nobody gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// One raw frame, as a real-time renderer would show it: one path a pixel
    Frame,
    /// A clean image in seconds: the mean of a few frames of progressive photon mapping
    Preview,
    /// A converged image: until the estimated relative error falls below 1e-3, 1024 frames at most
    Final,
}

impl Preset {
    /// Values of parameters that it brings.
    pub fn values(self) -> Vec<(&'static Parameter, &'static str)> {
        match self {
            // The noise of one frame is for the eye to even out.
            Preset::Frame => vec![(&SAMPLER, Sampler::Blue.name())],
            Preset::Preview => vec![(&METHOD, PROGRESSIVE.name), (&RADIUS_PX, AUTO)],
            Preset::Final => vec![(&METHOD, PROGRESSIVE.name)],
        }
    }

    /// Frames that it averages, at most.
    pub fn frames(self) -> u32 {
        match self {
            Preset::Frame => 1,
            Preset::Preview => 16,
            Preset::Final => 1024,
        }
    }

    /// The estimated relative mean square error at which it stops.
    pub fn relative_error(self) -> Option<f64> {
        (self == Preset::Final).then_some(1e-3)
    }
}
