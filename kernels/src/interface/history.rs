//! What outlives a frame: collection points with the light they gathered, and photons to judge by whether it still holds.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::{Vec2, Vec3};

/// A collection point of the frame before.
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
    /// Frames' worth of light that it holds; 0 marks "no point here".
    pub samples: f32,
}

/// Light of the previous frame that a collection point reuses.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Reprojected {
    /// Mean of the light gathered (W m^-2), or of the radiance (W m^-2 sr^-1) where the history does not demodulate.
    pub mean: Vec3,
    /// Frames' worth that it counts; 0 where nothing is reused.
    pub samples: f32,
    /// From the point to the mean position of that light (m).
    pub offset: Vec3,
    /// Radius of the point's disc by the settings, before it is widened (m).
    pub radius: f32,
}

/// Settings of a history.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct HistorySettings {
    /// Distance up to which the light of a point is reused, relative to its radius.
    pub search_radius: f32,
    /// Maximum temporal lag of reused light (radii of a point seen directly).
    pub lag: f32,
    /// Maximum frames' worth of light that is reused.
    pub max_samples: f32,
    /// 1: light is kept without the point's reflectance, 0: as radiance.
    pub demodulates: u32,
}

/// A photon of a validation path in the frame before.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ValidationPhoton {
    /// Position (m).
    pub position: Vec3,
    /// Flux per cosine that it had were it the only light path, summed over channels (W); 0 marks "no photon here".
    pub flux: f32,
    /// Index into the instances of what it lies on.
    pub instance: u32,
}

/// Light that reaches a collection point along camera paths, over what the point reflects head on (W m^-2).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PathHistoryLight {
    /// Mean of what comes straight from lights.
    pub direct: Vec3,
    /// Frames' worth that it holds, or counts where it is reused; 0: there is none.
    pub direct_samples: f32,
    /// Mean of what comes from surfaces.
    pub indirect: Vec3,
    /// The same of that.
    pub indirect_samples: f32,
}

impl PathHistoryLight {
    /// Whether there is any.
    #[inline(always)]
    pub fn exists(&self) -> bool {
        self.direct_samples + self.indirect_samples > 0.0
    }
}

/// Path-traced light of the previous frame that a collection point reuses.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ReprojectedPathLight {
    /// The light; none where it counts no frames.
    pub light: PathHistoryLight,
    /// From the point to the mean position of that light (m).
    pub offset: Vec3,
    /// Mean square of what a frame finds, direct and indirect light and all channels together.
    pub square: f32,
}

/// A path of the frame before, traced again.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Retraced {
    /// Light that it found in the frame before, all channels of `PathHistoryLight` together, direct and indirect (W m^-2).
    pub before: Vec2,
    /// Light that it finds now (W m^-2).
    pub now: Vec2,
}

/// Light paths of a frame for each validation path.
pub const PATHS_PER_VALIDATION: u32 = 8;
/// Photons that a validation path remembers.
pub const VALIDATION_PHOTONS: u32 = 4;
/// Frames for which a validation path keeps its random numbers.
pub const VALIDATION_PERIOD: u32 = 8;
/// Cells of the hash table of validation (`history::cells`).
pub const VALIDATION_CELLS: u32 = 1 << 18;

/// Validation paths of a small frame, if it has as many light paths.
const MIN_VALIDATIONS: u32 = 4096;

/// Validation paths of frames with this many light paths.
#[inline]
pub fn validation_paths(light_path_count: u32) -> u32 {
    light_path_count.div_ceil(PATHS_PER_VALIDATION).max(light_path_count.min(MIN_VALIDATIONS))
}

const _: () = assert!(size_of::<HistoryPoint>() == 32);
const _: () = assert!(size_of::<Reprojected>() == 32);
const _: () = assert!(size_of::<HistorySettings>() == 16);
const _: () = assert!(size_of::<PathHistoryLight>() == 32);
const _: () = assert!(size_of::<ValidationPhoton>() == 20);
