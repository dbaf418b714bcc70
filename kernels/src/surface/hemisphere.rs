//! Directions for which face normal and shading normal disagree on the side of the surface.
//!
//! Such a direction is flipped: x stands for -x. This exchanges two wedges: above the face and below the shading normal's
//! horizon, and below the face and above that horizon. It keeps solid angles and the size of cosines. So f(a, b) = f(b, a) holds,
//! whichever end light comes from. All light that a lobe sends below the face leaves above it. Under even light a surface is
//! therefore as bright as its material says, whatever its normals.

use spirv_std::glam::Vec3;

/// Flips a local direction (z is the shading normal) to the hemisphere of the geometric normal that `above` names.
#[inline(always)]
pub fn flip_to_geometric_hemisphere(local: Vec3, above: bool) -> Vec3 {
    if (local.z > 0.0) == above { local } else { -local }
}
