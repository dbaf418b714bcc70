//! Initial media stack: the media around a position where a path starts, the eye or a light.
//!
//! A position is inside of a solid as often as the solid's faces wind around it, which any ray out of the position counts. Around
//! an open surface that number is no integer, and eight rays decide [as winding numbers above one half, Jacobson et al. 2013].
//! The position is inside if more of them meet the surface's back first than meet its front or nothing.
//!
//! Opaque surfaces reflect the rays: below a pool's surface all rays come to its back. Around a flat open surface, at most half
//! of them do. A hanging surface has no inside. All rays have key 0: a blended surface is there for all of these rays, or for
//! none.

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::material::{FLAG_HANGING, FLAG_OPEN_SURFACE, Material};
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::math::offset;
use crate::surface::media::MediaStack;
use crate::surface::vertex::vertex;
use crate::trace::Tracer;
use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// Unit vectors along the edges of a cube that is aligned with no axis; the rays go to its corners.
const RIGHT: Vec3 = Vec3::new(-0.279_759, 0.911_838_1, 0.300_476_5);
const UP: Vec3 = Vec3::new(-0.055_185_6, -0.327_728_9, 0.943_158_7);
const BACK: Vec3 = Vec3::new(0.958_482_9, 0.247_275_1, 0.142_005_5);
/// Maximum number of faces that a ray out of solids passes.
const MAX_FACES: u32 = 256;
/// Maximum number of faces that a ray to open surfaces meets.
const MAX_BOUNCES: u32 = 16;

/// Winding number of a solid around a position; for an open surface, backs that rays met less fronts.
#[derive(Clone, Copy)]
struct Winding {
    material: u32,
    sum: i32,
}

/// Windings of up to four media; a winding of zero frees its slot.
#[derive(Clone, Copy)]
struct Windings {
    first: Winding,
    second: Winding,
    third: Winding,
    fourth: Winding,
}

/// Finds the media around `position`.
#[inline(always)]
pub fn initial_media_stack<T: Tracer>(
    position: Vec3,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
) -> MediaStack {
    // Vertices need only their sides and positions.
    let bare = Features(features.0 & Features::INSTANCES.0);
    let none = Winding { material: NONE, sum: 0 };
    let mut around = Windings { first: none, second: none, third: none, fourth: none };
    let rays = if features.has(Features::OPEN_SURFACES) { 9 } else { 1 };
    let (mut index, mut escaped) = (0, 0);
    while index < rays {
        // The first ray goes straight out and counts faces of solids; the others look for open surfaces.
        let straight = index == 0;
        let max_faces = if straight { MAX_FACES } else { MAX_BOUNCES };
        let mut ray = Ray::endless(position, to_corner(index));
        let mut faces = 0;
        while faces < max_faces {
            let hit = tracer.closest(&ray);
            if hit.is_miss() {
                escaped += i32::from(!straight);
                break;
            }
            let here = vertex(scene, bare, &ray, &hit, 0.0);
            let material = scene.materials[here.material as usize];
            let counts =
                (material.flags & FLAG_OPEN_SURFACE == 0) == straight && material.flags & FLAG_HANGING == 0;
            if material.is_medium() && counts {
                around = around.crossed(here.material, if here.front { -1 } else { 1 });
                if !straight {
                    break;
                }
            }
            let mut direction = ray.direction;
            if !straight && !material.transmits() {
                direction -= here.face_normal * (2.0 * direction.dot(here.face_normal));
            }
            let origin = offset::leave(here.position, here.face_normal, direction, here.clearance);
            ray = Ray::endless(origin, direction);
            faces += 1;
        }
        index += 1;
    }
    let mut media = MediaStack::VACUUM;
    let mut slot = 0;
    while slot < 4 {
        media = around.at(slot).inside(media, escaped, scene.materials);
        slot += 1;
    }
    media
}

/// Unit direction to a corner of the cube, 0 to 7; corner 7 - c is opposite to c. Corner 8 is corner 0.
#[inline(always)]
fn to_corner(corner: i32) -> Vec3 {
    let sign = |bit: i32| if corner & bit == 0 { 1.0 } else { -1.0 };
    (RIGHT * sign(1) + UP * sign(2) + BACK * sign(4)).normalize()
}

impl Winding {
    /// Enters the medium as often as it winds around the position; `escaped` rays met no open surface.
    #[inline(always)]
    fn inside(self, mut media: MediaStack, escaped: i32, materials: &[Material]) -> MediaStack {
        if self.sum > 0 {
            let mut times = self.sum;
            if materials[self.material as usize].flags & FLAG_OPEN_SURFACE != 0 {
                times = i32::from(self.sum > escaped);
            }
            while times > 0 {
                media = media.entered(self.material, materials).0;
                times -= 1;
            }
        }
        media
    }

    #[inline(always)]
    fn plus(self, by: i32) -> Winding {
        Winding { sum: self.sum + by, ..self }
    }
}

impl Windings {
    #[inline(always)]
    fn at(self, slot: u32) -> Winding {
        let Windings { first, second, third, fourth } = self;
        let (upper, lower) = if slot & 1 == 0 { (first, third) } else { (second, fourth) };
        if slot < 2 { upper } else { lower }
    }

    /// Windings after a ray out crossed a face. A back (1) ends a solid around the position, a front (-1) begins one that the ray
    /// passes.
    #[shared]
    fn crossed(mut self, material: u32, by: i32) -> Self {
        let fresh = Winding { material, sum: by };
        if self.first.material == material {
            self.first = self.first.plus(by);
        } else if self.second.material == material {
            self.second = self.second.plus(by);
        } else if self.third.material == material {
            self.third = self.third.plus(by);
        } else if self.fourth.material == material {
            self.fourth = self.fourth.plus(by);
        } else if self.first.sum == 0 {
            self.first = fresh;
        } else if self.second.sum == 0 {
            self.second = fresh;
        } else if self.third.sum == 0 {
            self.third = fresh;
        } else if self.fourth.sum == 0 {
            self.fourth = fresh;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_vectors_in_opposite_pairs() {
        for corner in 0..8 {
            let direction = to_corner(corner);
            assert!((direction.length() - 1.0).abs() < 1e-6);
            assert!((direction + to_corner(7 - corner)).length() < 1e-6);
            let components = direction.abs();
            assert!(components.min_element() > 0.1, "{direction}");
        }
    }

    #[test]
    fn open_surface_needs_more_than_half_of_the_rays() {
        for (flags, sum, escaped, times) in [
            (0, 0, 0, 0),
            (0, 1, 8, 1),
            (0, 2, 8, 2),
            (0, -1, 0, 0),
            (FLAG_OPEN_SURFACE, 4, 4, 0),
            (FLAG_OPEN_SURFACE, 4, 3, 1),
            (FLAG_OPEN_SURFACE, 8, 0, 1),
            (FLAG_OPEN_SURFACE, 0, 0, 0),
        ] {
            let materials = [Material { flags, ..Material::default() }];
            let inside = Winding { material: 0, sum }.inside(MediaStack::VACUUM, escaped, &materials);
            let mut expected = MediaStack::VACUUM;
            (0..times).for_each(|_| expected = expected.entered(0, &materials).0);
            assert_eq!(inside, expected, "{sum}, {escaped} escaped");
        }
    }
}
