//! Collection points and photons, as structures of arrays.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Where a collection point is: all that a gather reads of points it does not take.
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

/// What light at a collection point is multiplied with.
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
    /// Camera throughput, divided by the probabilities of its choices.
    pub throughput: Vec3,
    /// The same: blue as a half float, roughness and metallic as shares of 255.
    pub blue_roughness_metallic: u32,
    /// Index of refraction on the viewer's side over index behind.
    pub eta: f32,
    /// Index into the instances; 0 is the world, which does not move.
    pub instance: u32,
    /// Distance at which the eye sees the point (m) (`math::pencil::VirtualImage`): the camera path's length, unless it is distorted
    /// and there is a history.
    pub distance: f32,
    /// Astigmatism of that image, as two signed shares of 32767.
    pub astigmatism: u32,
}

/// Direct light at a collection point.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PointDirect {
    /// Radiance at the eye of what the point's non-specular class reflects of light that comes straight from lights
    /// (W m^-2 sr^-1).
    pub radiance: Vec3,
    /// Probability of that class; the throughput of the camera suffix holds its inverse.
    pub class_probability: f32,
}

/// Where a photon lies: all that a gather reads of photons it does not take.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PhotonGeometry {
    /// Position (m).
    pub position: Vec3,
    /// Scatterings between the light and this hit.
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
    /// Texel that the path's start is of, if `score` is above 0.
    pub texel: u32,
    /// Flux per cosine at the face (W).
    pub flux: Vec3,
    /// What squares of relative light are multiplied with to be scores of that texel; 0: nobody learns from it.
    pub score: f32,
}

/// What an index is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Side {
    /// Over collection points: photons look for points.
    Points,
    /// Over photons: points look for photons.
    Photons,
}

const _: () = assert!(size_of::<PointGeometry>() == 32);
const _: () = assert!(size_of::<PointShading>() == 64);
const _: () = assert!(size_of::<PointDirect>() == 16);
const _: () = assert!(size_of::<PhotonGeometry>() == 32);
const _: () = assert!(size_of::<PhotonLight>() == 32);
