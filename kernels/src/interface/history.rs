//! State that outlives a frame: collection points with the light that they gathered, and photons that show whether it still
//! holds.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::{Vec2, Vec3};

/// A collection point of the previous frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct HistoryPoint {
    /// Mean of the positions whose light it holds (m).
    pub position: Vec3,
    /// Radius of its disc by the settings (m).
    pub radius: f32,
    /// Unit normal of the face, octahedral.
    pub normal: u32,
    /// Unit direction to the viewer, octahedral.
    pub to_viewer: u32,
    /// Index into the materials.
    pub material: u32,
    /// Number of frames of light that it holds; 0 marks "no point here".
    pub samples: f32,
}

/// Light of the previous frame that a collection point reuses.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Reprojected {
    /// Mean of the light gathered (W m^-2), or of the radiance (W m^-2 sr^-1) where the history does not demodulate.
    pub mean: Vec3,
    /// Number of frames that the light counts; 0: nothing is reused.
    pub samples: f32,
    /// Offset from the point to the mean position of that light (m).
    pub offset: Vec3,
    /// Radius of the point's disc by the settings, before it is widened (m).
    pub radius: f32,
}

/// Settings of a history.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct HistorySettings {
    /// Maximum distance at which the light of a point is reused, in radii of that point.
    pub search_radius: f32,
    /// Maximum temporal lag of reused light (radii of a point seen directly).
    pub lag: f32,
    /// Maximum number of frames that reused light counts.
    pub max_samples: f32,
    /// 1: light is stored without the point's reflectance; 0: as radiance.
    pub demodulates: u32,
}

/// A photon of a validation path in the previous frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ValidationPhoton {
    /// Position (m).
    pub position: Vec3,
    /// Flux per cosine if this were the only light path, summed over channels (W); 0 marks "no photon here".
    pub flux: f32,
    /// Index of the instance that it lies on.
    pub instance: u32,
}

/// Light that camera paths bring to a collection point, over the reflectance of the point head on (W m^-2).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PathHistoryLight {
    /// Mean of the light that comes straight from lights.
    pub direct: Vec3,
    /// Number of frames of direct light that it holds, or that reused light counts; 0: there is none.
    pub direct_samples: f32,
    /// Mean of the light that comes from surfaces.
    pub indirect: Vec3,
    /// Number of frames of indirect light, likewise.
    pub indirect_samples: f32,
}

impl PathHistoryLight {
    /// Whether there is any light.
    #[inline(always)]
    pub fn exists(&self) -> bool {
        self.direct_samples + self.indirect_samples > 0.0
    }
}

/// Path-traced light of the previous frame that a collection point reuses.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ReprojectedPathLight {
    /// The light; there is none if it counts no frames.
    pub light: PathHistoryLight,
    /// Offset from the point to the mean position of that light (m).
    pub offset: Vec3,
    /// Noise of that light. It is found where the light itself has changed, too.
    pub noise: PathHistoryNoise,
}

/// Noise of path-traced light at a collection point: direct and indirect light and all channels, summed.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PathHistoryNoise {
    /// Mean square of the light of a frame; negative where there is no light of earlier frames.
    pub square: f32,
    /// One plus the variance of the light of a frame over the square of its mean; 0 where it is unknown.
    pub relative_square: f32,
}

impl PathHistoryNoise {
    /// Noise where no light of earlier frames is known.
    pub const NONE: PathHistoryNoise = PathHistoryNoise { square: -1.0, relative_square: 0.0 };

    /// Whether light of earlier frames is known, though it may have changed.
    #[inline(always)]
    pub fn exists(&self) -> bool {
        self.square >= 0.0
    }
}

/// A path of the previous frame, traced again.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Retraced {
    /// Light found in the previous frame (W m^-2): direct and indirect, each summed over the channels of `PathHistoryLight`.
    pub before: Vec2,
    /// Light found now (W m^-2), likewise.
    pub now: Vec2,
}

/// Number of light paths of a frame for each validation path.
pub const PATHS_PER_VALIDATION: u32 = 8;
/// Number of photons that a validation path stores.
pub const VALIDATION_PHOTONS: u32 = 4;
/// Number of frames for which a validation path keeps its random numbers.
pub const VALIDATION_PERIOD: u32 = 8;
/// Number of cells of the hash table of validation (`history::cells`).
pub const VALIDATION_CELLS: u32 = 1 << 18;

/// Minimum number of validation paths, if the frame has as many light paths.
const MIN_VALIDATIONS: u32 = 4096;

/// Number of validation paths in frames with a number of light paths.
#[inline]
pub fn validation_paths(light_path_count: u32) -> u32 {
    light_path_count.div_ceil(PATHS_PER_VALIDATION).max(light_path_count.min(MIN_VALIDATIONS))
}

const _: () = assert!(size_of::<HistoryPoint>() == 32);
const _: () = assert!(size_of::<Reprojected>() == 32);
const _: () = assert!(size_of::<HistorySettings>() == 16);
const _: () = assert!(size_of::<PathHistoryLight>() == 32);
const _: () = assert!(size_of::<PathHistoryNoise>() == 8);
const _: () = assert!(size_of::<ValidationPhoton>() == 20);
