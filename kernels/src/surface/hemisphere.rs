//! Directions on whose side the face and the shading normal disagree.
//!
//! Such a direction is flipped: x stands for -x. That exchanges the wedge above the face and below the shading
//! normal's horizon with the wedge below the face and above that horizon, and keeps solid angles and the size of cosines.
//! So f(a, b) = f(b, a) stays what it is, whichever end light comes from, and all that a lobe sends below the face leaves
//! above it: seen under even light a surface is as bright as its material says, whatever its normals.

use spirv_std::glam::Vec3;

/// Flips a local direction (z is the shading normal) to the hemisphere of the geometric normal that `above` names.
#[inline(always)]
pub fn flip_to_geometric_hemisphere(local: Vec3, above: bool) -> Vec3 {
    if (local.z > 0.0) == above { local } else { -local }
}
