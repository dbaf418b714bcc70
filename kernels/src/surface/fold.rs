//! Directions on whose side the face and the shading normal disagree.
//!
//! Such a direction is turned round: x stands for -x. That exchanges the wedge above the face and below the shading
//! normal's horizon with the wedge below the face and above that horizon, and keeps solid angles and the size of cosines.
//! So f(a, b) = f(b, a) stays what it is, whichever end light comes from, and all that a lobe sends below the face leaves
//! above it: seen under even light a surface is as bright as its material says, whatever its normals.

use spirv_std::glam::Vec3;

/// `local` (z is the shading normal), turned round if it is on the other side than the face says.
#[inline(always)]
pub fn folded(local: Vec3, above: bool) -> Vec3 {
    if (local.z > 0.0) == above { local } else { -local }
}
