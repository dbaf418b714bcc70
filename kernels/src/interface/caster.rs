//! Casters: spheres around the surfaces that cast caustics, at which light paths can be aimed.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// A sphere that holds surfaces which cast caustics.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Caster {
    /// Centre (m).
    pub centre: Vec3,
    /// Radius (m); 0 where nothing is there.
    pub radius: f32,
}

/// Spheres there are at most.
pub const MAX_CASTERS: usize = 16;

/// The casters of a scene at a time.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Casters {
    /// The first `count` are theirs.
    pub spheres: [Caster; MAX_CASTERS],
    /// How many.
    pub count: u32,
}

const _: () = assert!(size_of::<Caster>() == 16);
