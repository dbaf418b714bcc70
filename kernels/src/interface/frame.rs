//! What every pass gets: the settings of the frame, and where a dispatch stands in its pass.

use crate::interface::caster::Casters;
use crate::interface::choice::{PixelFilter, TextureFilter};
use crate::interface::counters::PhotonState;
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

/// The part of a film that an image shows; all of it, where images are not rendered tile by tile.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Window {
    /// Column of the film that is the image's first.
    pub first_column: u32,
    /// Row of the film that is the image's first.
    pub first_row: u32,
    /// Width of the film (px).
    pub film_width: u32,
    /// Height of the film (px).
    pub film_height: u32,
}

impl Window {
    /// All of a film.
    pub fn all(film_width: u32, film_height: u32) -> Window {
        Window { film_width, film_height, ..Window::default() }
    }
}

/// Settings of a frame: a uniform buffer that is written once a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameParams {
    /// The eye.
    pub camera: Camera,
    /// The eye of the frame before.
    pub previous_camera: Camera,
    /// Image width (px).
    pub width: u32,
    /// Image height (px).
    pub height: u32,
    /// What it shows of the film: cameras see the film, and random numbers are those of its pixels.
    pub window: Window,
    /// Seed of every random number of the run.
    pub seed: u32,
    /// Index of the frame; another frame samples other random numbers.
    pub frame: u32,
    /// Light paths of the whole frame.
    pub light_path_count: u32,
    /// Light paths whose photons the photon buffers hold: those of a batch, at most.
    pub light_path_batch: u32,
    /// Validation paths: 0 of a history that has none, else the same in every frame that shoots.
    pub validation_path_count: u32,
    /// Scattering vertices between eye and light, at most.
    pub max_bounces: u32,
    /// Pixel filter and texture filter, a bit each ([`FrameParams::filters`]).
    pub filters: u32,
    /// Reflection lobes of at most this roughness are specular.
    pub specular_roughness: f32,
    /// Radius of a collection point relative to the disc of its pixel's footprint area.
    pub radius_px: f32,
    /// Spread of a pixel's ray cone at the eye (rad).
    pub pixel_spread: f32,
    /// Quantum of the accumulator (W sr^-1 in the unit of f phi), a power of two.
    pub quantum: f32,
    /// Lights in the light table.
    pub light_count: u32,
    /// Photons that fit the photon buffers.
    pub photon_capacity: u32,
    /// Cells of the photon grid's hash table minus one (a power of two minus one).
    pub cell_mask: u32,
    /// Linear exposure factor of `display`.
    pub exposure: f32,
    /// Radiance that camera prefixes see where they leave the scene (W m^-2 sr^-1); it lights nothing.
    pub background: Vec3,
    /// Settings of the history.
    pub history: HistorySettings,
    /// Which light is the light paths': `Caustics`.
    pub caustics: u32,
    /// How camera paths find lights: `LightSampler`.
    pub light_sampler: u32,
    /// 1: something moved since the frame before, or there was none.
    pub moved: u32,
    /// Spheres around what casts caustics, where the emission aims at them.
    pub casters: Casters,
    /// Where the numbers of camera paths stand in their sequences.
    pub sequence: Sequence,
}

/// Where a dispatch stands in its pass: the push constants of every pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Dispatch {
    /// The first light path of a batch.
    pub first: u32,
    /// Invocations.
    pub count: u32,
    /// The stage of an index, the level of a filter or of a pyramid, the variant of a splat.
    pub level: u32,
    /// 1: at most as many invocations as photons are stored, which only the device knows.
    pub stored: u32,
}

const _: () = assert!(size_of::<Camera>() == 48);
const _: () = assert!(size_of::<FrameParams>() == 752);

impl Dispatch {
    /// Invocations there are.
    #[inline(always)]
    pub fn limit(&self, photon_state: &[u32], params: &FrameParams) -> u32 {
        if self.stored == 0 { self.count } else { self.count.min(params.photon_count(photon_state)) }
    }
}

impl FrameParams {
    /// 0, which no compiler knows: of an array whose indices it knows a GPU's compiler makes registers.
    #[inline(always)]
    pub fn zero(&self) -> u32 {
        self.width >> 31
    }

    /// Pixels of the image.
    pub fn pixel_count(&self) -> u32 {
        self.width * self.height
    }

    /// Column and row of a pixel on the film.
    #[inline(always)]
    pub fn on_film(&self, pixel: u32) -> (u32, u32) {
        let Window { first_column, first_row, .. } = self.window;
        (first_column + pixel % self.width, first_row + pixel / self.width)
    }

    /// The pixel of the film that a pixel is.
    #[inline(always)]
    pub fn film_pixel(&self, pixel: u32) -> u32 {
        let (column, row) = self.on_film(pixel);
        row * self.window.film_width + column
    }

    /// Photons there are: those stored, as far as they fit.
    #[inline(always)]
    pub fn photon_count(&self, photon_state: &[u32]) -> u32 {
        photon_state[PhotonState::Stored as usize].min(self.photon_capacity)
    }

    /// Sums over the pixels so many to each side of a pixel, as far as there are.
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

    /// Word of `filters` that has both filters.
    #[inline]
    pub fn filters(pixel: PixelFilter, texture: TextureFilter) -> u32 {
        pixel as u32 | (texture as u32) << 1
    }

    /// Whether camera rays are uniform over a pixel, else they pass through its centre.
    #[inline]
    pub fn has_box_filter(&self) -> bool {
        self.filters & Self::filters(PixelFilter::Box, TextureFilter::Cone) != 0
    }

    /// Whether camera prefixes see the finest level of textures, else that of their ray cone.
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

/// One light path in so many is of the pilot of a frame, where it has one.
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
