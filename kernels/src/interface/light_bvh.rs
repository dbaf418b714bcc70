//! Nodes of the light BVH.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec4;

/// Bounds of four children, one lane a child: where their lights stand, where they shine, and how bright they are. Source: [Conty
/// Estevez and Kulla 2018, Importance sampling of many lights; pbrt-v4 12.6.3, `LightBounds`].
///
/// The root is node 0, and the children of node n are 4n + 1 to 4n + 4. Behind the last node come the lights, in the order of
/// their ids. Where there are fewer, lanes are zero.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightBvhNode {
    /// x of the centres of the spheres around the lights (m).
    pub center_x: Vec4,
    /// y of the centres.
    pub center_y: Vec4,
    /// z of the centres.
    pub center_z: Vec4,
    /// Radii of the spheres (m).
    pub radius: Vec4,
    /// x of the unit axes of the cones around the axes of the lights.
    pub axis_x: Vec4,
    /// y of the axes.
    pub axis_y: Vec4,
    /// z of the axes.
    pub axis_z: Vec4,
    /// Cosines of half the angles of these cones.
    pub cos_spread: Vec4,
    /// Sines of half the angles of these cones.
    pub sin_spread: Vec4,
    /// Cosines of the largest angle between the axis of a light and a direction in which it shines.
    pub cos_emission: Vec4,
    /// Sums of the lights' largest intensities over the flux of all lights (sr^-1), as means of the channels.
    pub intensity: Vec4,
    /// Keeps nodes at three cache lines.
    pub padding: Vec4,
}

const _: () = assert!(size_of::<LightBvhNode>() == 192);
