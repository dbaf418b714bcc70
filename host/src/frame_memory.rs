//! What a session takes of the host's memory, estimated before any of it is asked for.

use thiserror::Error;

use crate::render_config::RenderConfig;
use caustics_files::memory::{self, shown};
use caustics_kernels::declare::BufferSpec;
use caustics_kernels::history::auxiliary::AUXILIARY_LAYERS;
use caustics_kernels::interface::frame::{FrameParams, Window};
use caustics_kernels::method::Method;
use caustics_kernels::method::Parts;
use caustics_kernels::method::frame::frame_buffers;

/// Memory of a pixel beside the buffers (bytes): sums in f64 (72) and those of four batches (96), an image (44) as it is read,
/// as a mean, with its variance (12) and as an EXR (60): what is there at once, with room to spare.
const IMAGE_BYTES: u64 = 300;
/// The same of what other tools ask: sums in f64 (112), and layers (52) as they are read, as means, and as an EXR.
const AUXILIARY_BYTES: u64 = 300;

/// More than is there.
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
    /// What takes most.
    flag: &'static str,
}

/// Memory of a session by what decides it (bytes).
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
    /// What frames of these settings need. A GPU has its buffers in memory of its own.
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
        // Images are of the film, buffers of a tile of it.
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

    /// Refuses what is more than `available`; the message names the flag that lowers most of it.
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

    /// Refuses what takes more memory than there is; where the system does not say, all is let through.
    ///
    /// # Errors
    ///
    /// If it is too much; the error names the flag that lowers it most.
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
    fn needs_grow_with_what_decides_them() {
        let (one, wide, many) = (need(100, 100, 1000), need(200, 100, 1000), need(100, 100, 2000));
        // Counters and cells aside.
        let ratio = wide.pixels as f64 / one.pixels as f64;
        assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
        assert_eq!(wide.light_paths, one.light_paths);
        // A geometry and a light of 32 bytes for each photon, at least.
        assert!(many.light_paths - one.light_paths >= 4 * 1000 * 64, "{many:?}");
        assert_eq!((many.pixels, one.scene), (one.pixels, 1000));
        // A frame that shoots nothing needs nothing to shoot with.
        assert_eq!(need(100, 100, 0).light_paths, 0);
    }

    #[test]
    fn the_flag_that_lowers_most_is_named() {
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
