//! Inputs of every pass: the settings of the frame, and the position of a dispatch in its pass.

use crate::interface::caster::Casters;
use crate::interface::choice::{PixelFilter, TextureFilter};
use crate::interface::counters::PhotonState;
use crate::interface::guide::LightGroups;
use crate::interface::history::HistorySettings;
use crate::interface::sequence::Sequence;
use bytemuck::{Pod, Zeroable};
use spirv_std::glam::{Vec2, Vec3};

/// Pinhole camera. A pixel's direction is `forward + x right + y up` with x, y in [-1, 1], y upwards.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// Eye (m).
    pub position: Vec3,
    /// Unit right times tan(fov_x / 2).
    pub right: Vec3,
    /// Unit up times tan(fov_y / 2).
    pub up: Vec3,
    /// Unit viewing direction.
    pub forward: Vec3,
}

/// Part of a film that an image shows; the whole film unless images are rendered tile by tile.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Window {
    /// Column of the film at the image's first column.
    pub first_column: u32,
    /// Row of the film at the image's first row.
    pub first_row: u32,
    /// Width of the film (px).
    pub film_width: u32,
    /// Height of the film (px).
    pub film_height: u32,
}

impl Window {
    /// A window of a whole film.
    pub fn all(film_width: u32, film_height: u32) -> Window {
        Window { film_width, film_height, ..Window::default() }
    }
}

/// Settings of a frame, in a uniform buffer that the host writes once a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameParams {
    /// Camera.
    pub camera: Camera,
    /// Camera of the previous frame.
    pub previous_camera: Camera,
    /// Image width (px).
    pub width: u32,
    /// Image height (px).
    pub height: u32,
    /// Part of the film that the image shows: cameras see the film, and random numbers are those of its pixels.
    pub window: Window,
    /// Seed of every random number of the run.
    pub seed: u32,
    /// Index of the frame; each frame samples other random numbers.
    pub frame: u32,
    /// Number of light paths of the whole frame.
    pub light_path_count: u32,
    /// Maximum number of light paths of a batch, whose photons fit the photon buffers.
    pub light_path_batch: u32,
    /// Number of validation paths: 0 for a history without them, else equal in every frame that shoots.
    pub validation_path_count: u32,
    /// Maximum number of scattering vertices between eye and light.
    pub max_bounces: u32,
    /// Pixel filter and texture filter, a bit each ([`FrameParams::filters`]).
    pub filters: u32,
    /// Maximum roughness of a specular reflection lobe.
    pub specular_roughness: f32,
    /// Radius of a collection point relative to the disc of its pixel's footprint area.
    pub radius_px: f32,
    /// Spread of a pixel's ray cone at the eye (rad).
    pub pixel_spread: f32,
    /// Quantum of the accumulator (W sr^-1 in the unit of f phi), a power of two.
    pub quantum: f32,
    /// Number of lights in the light table.
    pub light_count: u32,
    /// Number of photons that fit the photon buffers.
    pub photon_capacity: u32,
    /// Number of cells of the photon grid's hash table minus one (a power of two minus one).
    pub cell_mask: u32,
    /// Linear exposure factor of `display`.
    pub exposure: f32,
    /// Radiance that camera prefixes see where they leave the scene (W m^-2 sr^-1); it illuminates nothing.
    pub background: Vec3,
    /// Settings of the history.
    pub history: HistorySettings,
    /// Light that counts as a caustic: `Caustics`.
    pub caustics: u32,
    /// Choice of lights at camera vertices: `LightSampler`.
    pub light_sampler: u32,
    /// 1: something moved since the previous frame; `FIRST_FRAME`: there was none; else 0.
    pub moved: u32,
    /// Spheres around casters, for an emission into their cones.
    pub casters: Casters,
    /// Groups of lights, for guided emission.
    pub light_groups: LightGroups,
    /// Positions of the random numbers of camera paths in their sequences.
    pub sequence: Sequence,
    /// Treatment of thin walls: `ThinWalls`.
    pub thin_walls: u32,
    /// Share of the candidates of light samples that the light BVH samples; 0 without one.
    pub light_bvh_share: f32,
    /// Maximum number of collection points of a pixel.
    pub collection_points: u32,
    /// Radius within which collection points share indirect light, relative to the disc of a pixel's footprint area.
    pub share_radius_px: f32,
    /// Share of the camera paths that end in known cells of the radiance cache; 0 without one.
    pub cache_share: f32,
}

/// Position of a dispatch in its pass: the push constants of every pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Dispatch {
    /// First light path of the batch.
    pub first: u32,
    /// Number of invocations.
    pub count: u32,
    /// Stage of an index, level of a filter or of a pyramid, or variant of a splat.
    pub level: u32,
    /// 1: at most as many invocations as stored photons, a number that only the device knows.
    pub stored: u32,
}

const _: () = assert!(size_of::<Camera>() == 48);
const _: () = assert!(size_of::<FrameParams>() == 848);

impl Dispatch {
    /// Number of invocations that run.
    #[inline(always)]
    pub fn limit(&self, photon_state: &[u32], params: &FrameParams) -> u32 {
        if self.stored == 0 { self.count } else { self.count.min(params.photon_count(photon_state)) }
    }
}

impl FrameParams {
    /// 0, unknown to compilers: a GPU's compiler turns an array with known indices into registers.
    #[inline(always)]
    pub fn zero(&self) -> u32 {
        self.width >> 31
    }

    /// Whether the radius of shared indirect light is worth a search: below, few discs hold another point.
    #[inline(always)]
    pub fn shares_indirect(&self) -> bool {
        self.share_radius_px >= 1.2
    }

    /// Whether camera paths end in the radiance cache.
    #[inline(always)]
    pub fn uses_cache(&self) -> bool {
        self.cache_share > 0.0
    }

    /// Number of pixels of the image.
    pub fn pixel_count(&self) -> u32 {
        self.width * self.height
    }

    /// Column and row of a pixel on the film.
    #[inline(always)]
    pub fn on_film(&self, pixel: u32) -> (u32, u32) {
        let Window { first_column, first_row, .. } = self.window;
        (first_column + pixel % self.width, first_row + pixel / self.width)
    }

    /// Index on the film of a pixel of the image.
    #[inline(always)]
    pub fn film_pixel(&self, pixel: u32) -> u32 {
        let (column, row) = self.on_film(pixel);
        row * self.window.film_width + column
    }

    /// Number of photons that are stored and fit the buffers.
    #[inline(always)]
    pub fn photon_count(&self, photon_state: &[u32]) -> u32 {
        photon_state[PhotonState::Stored as usize].min(self.photon_capacity)
    }

    /// Sum over the pixels up to `side` columns and rows from a pixel, within the image.
    #[inline(always)]
    pub fn sum_around(&self, pixel: u32, side: u32, value: impl Fn(u32) -> Vec2) -> Vec2 {
        let (column, row) = (pixel % self.width, pixel / self.width);
        let mut sum = Vec2::ZERO;
        let mut y = row.max(side) - side;
        while y <= (row + side).min(self.height - 1) {
            let mut x = column.max(side) - side;
            while x <= (column + side).min(self.width - 1) {
                sum += value(y * self.width + x);
                x += 1;
            }
            y += 1;
        }
        sum
    }

    /// Word of `filters` for both filters.
    #[inline]
    pub fn filters(pixel: PixelFilter, texture: TextureFilter) -> u32 {
        pixel as u32 | (texture as u32) << 1
    }

    /// Whether camera rays are uniform over a pixel; else they pass through its centre.
    #[inline]
    pub fn has_box_filter(&self) -> bool {
        self.filters & Self::filters(PixelFilter::Box, TextureFilter::Cone) != 0
    }

    /// Whether camera prefixes see the finest level of textures; else they see the level of their ray cone.
    #[inline]
    pub fn sees_finest_textures(&self) -> bool {
        self.filters & Self::filters(PixelFilter::Centre, TextureFilter::Finest) != 0
    }

    /// 1 / quantum, exact: the exponent of a power of two changes its sign.
    #[inline]
    pub fn inverse_quantum(&self) -> f32 {
        f32::from_bits((254 << 23) - self.quantum.to_bits())
    }
}

/// Invocations of an entry point along x; further rows of them lie along y.
pub const INVOCATIONS_PER_ROW: u32 = 1 << 21;

/// Value of `FrameParams::moved` in a frame without a previous one.
pub const FIRST_FRAME: u32 = 2;

/// Number of light paths of a frame per path of its pilot.
pub const PILOT: u32 = 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_quantum_is_exact() {
        for exponent in -120..=120 {
            let params = FrameParams { quantum: 2.0_f32.powi(exponent), ..FrameParams::default() };
            assert_eq!(params.inverse_quantum(), 2.0_f32.powi(-exponent));
        }
    }
}
