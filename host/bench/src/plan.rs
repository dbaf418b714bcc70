//! Plan of an experiment: settings and frames that its run configurations share.

use std::ops::Range;

use caustics::render_config::RenderConfig;
use caustics_kernels::interface::choice::PixelFilter;

/// Frames whose errors are measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Compared {
    /// Last one.
    Last,
    /// Every one.
    Every,
    /// Frames of these indices; the first frame is 0.
    These(Vec<u32>),
}

/// Settings and frames of a measurement.
#[derive(Clone, Debug)]
pub struct MeasurementPlan {
    /// Settings of the image, the same for all run configurations; a configuration has its own for everything else.
    pub config: RenderConfig,
    /// Name of the camera.
    pub camera: String,
    /// Indices of the frames.
    pub frames: Range<u32>,
    /// Frames a second; frame k shows the time k / fps.
    pub fps: f64,
    /// Time that all frames show instead (s).
    pub moment: Option<f64>,
    /// Frames rendered beforehand, at the first frame's pose, and not recorded.
    pub warm_up: u32,
    /// Whether times are recorded.
    pub time: bool,
    /// The frames whose errors are measured.
    pub compared: Compared,
    /// Position of the references' rays within a pixel; none: that of the images.
    pub reference_pixel_filter: Option<PixelFilter>,
    /// Number of independent seeds of each run configuration, from the settings' seed on.
    pub seeds: u32,
}

impl MeasurementPlan {
    /// Time that a frame shows (s).
    pub fn time_of(&self, frame: u32) -> f64 {
        self.moment.unwrap_or(f64::from(frame) / self.fps)
    }

    /// Whether errors of a frame are measured.
    pub fn compares(&self, frame: u32) -> bool {
        match &self.compared {
            Compared::Last => frame + 1 == self.frames.end,
            Compared::Every => true,
            Compared::These(frames) => frames.contains(&(frame - self.frames.start)),
        }
    }
}
