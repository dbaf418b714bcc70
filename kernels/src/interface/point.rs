//! Collection points and photons, as structures of arrays.

use super::NONE;
use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Geometry of a collection point: all that a gather reads of points that it does not take.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PointGeometry {
    /// Position (m); without a point, the last finite vertex of the camera path.
    pub position: Vec3,
    /// Radius of the disc (m); 0 marks "no point here".
    pub radius: f32,
    /// Unit normal of the face, on the viewer's side.
    pub normal: Vec3,
    /// Camera vertex: 1 is the primary hit; 0 marks "no point here".
    pub depth: u32,
}

impl PointGeometry {
    /// Whether there is a point.
    #[inline(always)]
    pub fn exists(&self) -> bool {
        self.depth != 0
    }
}

/// Shading of a collection point: turns light at the point into radiance at the eye.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PointShading {
    /// Unit direction to the viewer.
    pub to_viewer: Vec3,
    /// Index into the materials.
    pub material: u32,
    /// Unit shading normal, on the viewer's side.
    pub shading_normal: Vec3,
    /// Base colour of a textured material, red and green as half floats.
    pub red_green: u32,
    /// Throughput of the camera prefix, divided by the probabilities of its choices.
    pub throughput: Vec3,
    /// Blue of that base colour as a half float; roughness and metallic as shares of 255.
    pub blue_roughness_metallic: u32,
    /// Index of refraction on the viewer's side over index behind.
    pub eta: f32,
    /// Index into the instances; 0 is the world, which does not move.
    pub instance: u32,
    /// Distance of the point's image from the eye (m), see `math::pencil::VirtualImage`. It is the length of the camera path,
    /// unless the image is distorted and there is a history.
    pub distance: f32,
    /// Astigmatism of that image, as two signed shares of 32767.
    pub astigmatism: u32,
}

/// Direct light at a collection point.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PointDirect {
    /// Radiance at the eye of light that comes straight from lights and that the point's non-specular class reflects (W m^-2
    /// sr^-1).
    pub radiance: Vec3,
    /// Probability of that class; the throughput of the camera suffix holds its inverse.
    pub class_probability: f32,
}

/// Sample of the indirect light at a collection point: the radiance that a white diffuse surface would show (W m^-2 sr^-1). It is the
/// incident radiance times the cosine, over pi and the density of the sampled direction. The words are those of
/// [`packed::to_rgbe`](super::packed::to_rgbe).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct IndirectSample {
    /// Light for points that are 0 to 2 camera vertices deeper than this one. Light of many scatterings is left out where the whole
    /// path would exceed `max_bounces`. `NONE`: the point gives nothing.
    pub light: [u32; SHARED_DEPTHS],
    /// Two numbers by [`packed::to_bfloats`](super::packed::to_bfloats). First, the radius of the point (m) without the width that rough
    /// lobes add. Then one over the distance to the surface that the path met next (1/m), or 0 if it met none.
    pub radius_and_proximity: u32,
}

impl Default for IndirectSample {
    fn default() -> IndirectSample {
        IndirectSample { light: [NONE; SHARED_DEPTHS], radius_and_proximity: 0 }
    }
}

/// Number of depths of points that an [`IndirectSample`] serves: its own, and those below.
pub const SHARED_DEPTHS: usize = 3;

/// A point that shares its indirect light, in the order of the index: all that a search reads of points that it does not take.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SharingPoint {
    /// Position (m).
    pub position: Vec3,
    /// Camera vertex in the lowest byte, level of the index in the next; then the bits of the cell (`gather::hash::cell_bits`).
    pub key: u32,
}

/// The light of such a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SharedLight {
    /// Unit shading normal, on the viewer's side.
    pub shading_normal: Vec3,
    /// Index into the materials.
    pub material: u32,
    /// Its light.
    pub sample: IndirectSample,
}

/// Geometry of a photon: all that a gather reads of photons that it does not take.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PhotonGeometry {
    /// Position (m).
    pub position: Vec3,
    /// Number of scatterings between the light and this hit.
    pub scatterings: u32,
    /// Unit normal of the face, on the side of arrival.
    pub normal: Vec3,
    /// Index into the instances; 0 is the world, which does not move.
    pub instance: u32,
}

/// The light of a photon.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PhotonLight {
    /// Unit direction back along the light path.
    pub to_light: Vec3,
    /// Start of the path as the emission counts it, if `score` is above 0: a texel, or the code of a `GuidedStart`.
    pub start_code: u32,
    /// Flux per cosine at the face (W).
    pub flux: Vec3,
    /// Factor from squares of relative light to scores of that start; 0: the emission does not learn.
    pub score: f32,
}

/// Elements of an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Side {
    /// Collection points: photons look for points.
    Points,
    /// Photons: points look for photons.
    Photons,
}

const _: () = assert!(size_of::<PointGeometry>() == 32);
const _: () = assert!(size_of::<PointShading>() == 64);
const _: () = assert!(size_of::<PointDirect>() == 16);
const _: () = assert!(size_of::<IndirectSample>() == 16);
const _: () = assert!(size_of::<SharingPoint>() == 16);
const _: () = assert!(size_of::<SharedLight>() == 32);
const _: () = assert!(size_of::<PhotonGeometry>() == 32);
const _: () = assert!(size_of::<PhotonLight>() == 32);
