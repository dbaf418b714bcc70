//! Presets of `render`.

use caustics_bench::parameter::{AUTO, METHOD, Parameter, RADIUS_PX, SAMPLER};
use caustics_kernels::interface::choice::Sampler;
use caustics_kernels::method::progressive::PROGRESSIVE;
use clap::ValueEnum;

/// Values for options that are not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// One raw frame, as a real-time renderer would show it: one path a pixel
    Frame,
    /// A clean image in seconds: the mean of a few frames of progressive photon mapping
    Preview,
    /// A converged image: until the estimated relative error falls below 1e-3, at most 1024 frames
    Final,
}

impl Preset {
    /// Values of parameters that it sets.
    pub fn values(self) -> Vec<(&'static Parameter, &'static str)> {
        match self {
            // Blue noise is the least visible in a single frame.
            Preset::Frame => vec![(&SAMPLER, Sampler::Blue.name())],
            Preset::Preview => vec![(&METHOD, PROGRESSIVE.name), (&RADIUS_PX, AUTO)],
            Preset::Final => vec![(&METHOD, PROGRESSIVE.name)],
        }
    }

    /// Maximum number of frames to average.
    pub fn frames(self) -> u32 {
        match self {
            Preset::Frame => 1,
            Preset::Preview => 16,
            Preset::Final => 1024,
        }
    }

    /// Estimated relative mean square error at which the run stops.
    pub fn relative_error(self) -> Option<f64> {
        (self == Preset::Final).then_some(1e-3)
    }
}
