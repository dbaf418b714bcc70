//! Memory that a session takes on the host, estimated before any allocation.

use thiserror::Error;

use crate::render_config::RenderConfig;
use caustics_files::memory::{self, shown};
use caustics_kernels::declare::BufferSpec;
use caustics_kernels::history::auxiliary::AUXILIARY_LAYERS;
use caustics_kernels::interface::frame::{FrameParams, Window};
use caustics_kernels::method::Method;
use caustics_kernels::method::Parts;
use caustics_kernels::method::frame::frame_buffers;

/// Memory of a pixel beside the buffers (bytes): the largest set that exists at one time, rounded up. Sums in f64 take 72,
/// and sums of four batches 96. An image takes 44 as read or as a mean, its variance 12, and an EXR file 60.
const IMAGE_BYTES: u64 = 300;
/// Memory of a pixel's auxiliary layers (bytes), rounded up: sums in f64 (112), and layers as read, as means and as an EXR
/// file (52).
const AUXILIARY_BYTES: u64 = 300;

/// Error: a frame takes more memory than is available.
#[derive(Debug, Error)]
#[error(
    "the frame would take {} of memory ({} for --width {width} and --height {height}, {} for --light-paths {light_paths}, \
     {} for the scene), but {} are available: lower {flag}",
    shown(.need.sum()), shown(.need.pixels), shown(.need.light_paths), shown(.need.scene), shown(*.available)
)]
pub struct FrameTooLarge {
    need: Need,
    available: u64,
    width: u32,
    height: u32,
    light_paths: u32,
    /// Flag that lowers the largest part.
    flag: &'static str,
}

/// Estimated memory of a session by the settings that determine it (bytes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Buffers and images.
    pub pixels: u64,
    /// Photons and their index.
    pub light_paths: u64,
    /// The runner's copy of the scene's tables.
    pub scene: u64,
}

impl Need {
    /// Estimates the memory of frames of these settings. On a GPU, the buffers are not in the host's memory.
    pub fn for_frame(method: &Method, parts: Parts, largest: FrameParams, tables: u64, on_gpu: bool) -> Need {
        let bytes = |params: FrameParams| -> u64 {
            let buffers = frame_buffers(method, parts, &params);
            buffers.iter().map(|BufferSpec { bytes, .. }| *bytes as u64).sum()
        };
        let all = bytes(largest);
        let dark =
            FrameParams { light_path_count: 0, light_path_batch: 0, validation_path_count: 0, ..largest };
        let dark = bytes(dark).min(all);
        let per_pixel = IMAGE_BYTES + if parts.stages.has(&AUXILIARY_LAYERS) { AUXILIARY_BYTES } else { 0 };
        // Images have the size of the film, buffers the size of a tile.
        let Window { film_width, film_height, .. } = largest.window;
        let images = per_pixel * u64::from(film_width) * u64::from(film_height);
        match on_gpu {
            true => Need { pixels: images, light_paths: 0, scene: tables },
            false => Need { pixels: dark + images, light_paths: all - dark, scene: tables },
        }
    }

    fn sum(&self) -> u64 {
        self.pixels.saturating_add(self.light_paths).saturating_add(self.scene)
    }

    /// Refuses a need above `available`. The message names the flag that lowers the largest part.
    fn check(self, available: u64, config: &RenderConfig) -> Result<(), FrameTooLarge> {
        if self.sum() <= available {
            return Ok(());
        }
        let flag = if self.light_paths > self.pixels {
            "--light-paths"
        } else {
            "--width and --height, or give more --tiles"
        };
        let RenderConfig { width, height, .. } = *config;
        let light_paths = config.max_light_paths();
        Err(FrameTooLarge { need: self, available, width, height, light_paths, flag })
    }

    /// Refuses a need above the available memory. All needs pass where the system does not report it.
    ///
    /// # Errors
    ///
    /// If the need exceeds the available memory. The error names the flag that lowers the largest part.
    pub fn check_available(self, config: &RenderConfig) -> Result<(), FrameTooLarge> {
        memory::available().map_or(Ok(()), |available| self.check(available, config))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render_config::Paths;
    use caustics_kernels::gather::variant::PHOTONS_GRID;
    use caustics_kernels::method::basic::BASIC;

    fn need(width: u32, height: u32, paths: u32) -> Need {
        let params = FrameParams {
            width,
            height,
            window: Window::all(width, height),
            light_path_count: paths,
            light_path_batch: paths,
            photon_capacity: 4 * paths,
            cell_mask: 1023,
            ..FrameParams::default()
        };
        Need::for_frame(&BASIC, Parts::from(&PHOTONS_GRID), params, 1000, false)
    }

    #[test]
    fn needs_grow_with_pixels_and_light_paths() {
        let (one, wide, many) = (need(100, 100, 1000), need(200, 100, 1000), need(100, 100, 2000));
        // The ratio is not exactly 2: counters and grid cells do not grow with the width.
        let ratio = wide.pixels as f64 / one.pixels as f64;
        assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
        assert_eq!(wide.light_paths, one.light_paths);
        // Each photon has at least a geometry and a light of 32 bytes each.
        assert!(many.light_paths - one.light_paths >= 4 * 1000 * 64, "{many:?}");
        assert_eq!((many.pixels, one.scene), (one.pixels, 1000));
        // A frame without light paths needs no memory for them.
        assert_eq!(need(100, 100, 0).light_paths, 0);
    }

    #[test]
    fn errors_name_the_flag_that_lowers_the_largest_part() {
        let config = RenderConfig {
            width: 8192,
            height: 4096,
            light_paths: Paths::Count(77),
            ..RenderConfig::default()
        };
        let need = Need { pixels: 6 << 30, light_paths: 1 << 30, scene: 0 };
        assert!(need.check(7 << 30, &config).is_ok());
        let message = need.check((7 << 30) - 1, &config).unwrap_err().to_string();
        for words in
            ["7.0 GiB", "--width 8192", "--height 4096", "--light-paths 77", "lower --width and --height"]
        {
            assert!(message.contains(words), "{message}");
        }
        let need = Need { pixels: 1, light_paths: 9, scene: 0 };
        assert!(need.check(8, &config).unwrap_err().to_string().ends_with("lower --light-paths"));
    }
}
