//! The media around a place where a path starts: the eye or a light.
//!
//! A place is inside of a medium where the medium's faces wind around it more than half a time. Around a solid that is
//! an integer, which any ray out counts. Around an open sheet it is the mean of all rays [Jacobson et al. 2013], here of
//! eight that come in opposite pairs, and of those only that no opaque thing stops before: below a pool's surface half
//! the rays end at its floor, and the other half tell. Nowhere does a flat sheet in the air wind around more than half,
//! and a hanging one has no inside.

use crate::interface::NONE;
use crate::interface::material::{FLAG_HANGING, FLAG_SHEET, Material};
use crate::interface::needs::Needs;
use crate::interface::scene::SceneTables;
use crate::math::offset;
use crate::math::ray::Ray;
use crate::surface::media::MediaStack;
use crate::surface::vertex::vertex;
use crate::trace::Tracer;
use spirv_std::glam::Vec3;

/// Unit vectors along the edges of a cube that stands along no axis; the rays go to its corners.
const RIGHT: Vec3 = Vec3::new(-0.279_759, 0.911_838_1, 0.300_476_5);
const UP: Vec3 = Vec3::new(-0.055_185_6, -0.327_728_9, 0.943_158_7);
const BACK: Vec3 = Vec3::new(0.958_482_9, 0.247_275_1, 0.142_005_5);
/// Faces on the way out of one ray, at most.
const MOST_FACES: u32 = 256;

/// How often a medium winds around a place, summed over rays.
#[derive(Clone, Copy)]
struct Winding {
    material: u32,
    sum: i32,
}

/// Windings of up to four media; one of zero says nothing and makes room.
#[derive(Clone, Copy)]
struct Windings {
    first: Winding,
    second: Winding,
    third: Winding,
    fourth: Winding,
}

/// The media around `position`.
#[inline(always)]
pub fn enclosing<T: Tracer>(
    position: Vec3,
    needs: Needs,
    scene: SceneTables<'_>,
    tracer: &mut T,
) -> MediaStack {
    let none = Winding { material: NONE, sum: 0 };
    let mut around = Windings { first: none, second: none, third: none, fourth: none };
    let rays: i32 = if needs.has(Needs::SHEETS) { 8 } else { 1 };
    // Rays that say where a sheet is: that meet one, or nothing opaque.
    let mut telling = 0;
    let mut corner = 0;
    while corner < rays {
        let direction = to_corner(corner);
        let mut ray = Ray::endless(position, direction);
        let (mut faces, mut free, mut tells) = (0, true, false);
        while faces < MOST_FACES {
            let hit = tracer.closest(&ray);
            if hit.is_miss() {
                break;
            }
            let here = vertex(scene, Needs(0), &ray, &hit, 0.0);
            let material = scene.materials[here.material as usize];
            if material.is_medium() {
                let is_sheet = material.flags & FLAG_SHEET != 0;
                tells |= is_sheet && free;
                if free || !is_sheet {
                    around = around.crossed(here.material, if here.front { -1 } else { 1 });
                }
            }
            free &= material.transmits();
            let origin = offset::leave(here.position, here.face_normal, direction, here.clearance);
            ray = Ray::endless(origin, direction);
            faces += 1;
        }
        telling += i32::from(free || tells);
        corner += 1;
    }
    let media = around.first.inside(MediaStack::VACUUM, rays, telling, scene.materials);
    let media = around.second.inside(media, rays, telling, scene.materials);
    let media = around.third.inside(media, rays, telling, scene.materials);
    around.fourth.inside(media, rays, telling, scene.materials)
}

/// Unit direction to a corner of the cube, 0 to 7; corner 7 - c is opposite to c.
#[inline(always)]
fn to_corner(corner: i32) -> Vec3 {
    let sign = |bit: i32| if corner & bit == 0 { 1.0 } else { -1.0 };
    (RIGHT * sign(1) + UP * sign(2) + BACK * sign(4)).normalize()
}

impl Winding {
    /// The media inside of this one too, as often as it winds around by more than half.
    #[inline(always)]
    fn inside(self, mut media: MediaStack, rays: i32, telling: i32, materials: &[Material]) -> MediaStack {
        if self.sum > 0 {
            let flags = materials[self.material as usize].flags;
            let mut times = (2 * self.sum + rays - 1) / (2 * rays);
            if flags & FLAG_HANGING != 0 {
                times = 0;
            } else if flags & FLAG_SHEET != 0 {
                times = i32::from(2 * self.sum > telling);
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
    /// After a ray out crossed a face: a back (1) ends what it came out of, a front (-1) begins what it passes.
    #[inline(always)]
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
    fn a_winding_of_half_is_outside() {
        let hanging = FLAG_SHEET | FLAG_HANGING;
        for (flags, sum, rays, telling, times) in [
            (0, 0, 1, 1, 0),
            (0, 1, 1, 1, 1),
            (0, 2, 1, 0, 2),
            (0, 4, 8, 8, 0),
            (0, 5, 8, 8, 1),
            (0, 12, 8, 8, 1),
            (0, 13, 8, 8, 2),
            (FLAG_SHEET, 4, 8, 8, 0),
            (FLAG_SHEET, 4, 8, 7, 1),
            (FLAG_SHEET, 8, 8, 8, 1),
            (FLAG_SHEET, 0, 8, 0, 0),
            (hanging, 8, 8, 8, 0),
        ] {
            let materials = [Material { flags, ..Material::default() }];
            let winding = Winding { material: 0, sum };
            let inside = winding.inside(MediaStack::VACUUM, rays, telling, &materials);
            let mut expected = MediaStack::VACUUM;
            (0..times).for_each(|_| expected = expected.entered(0, &materials).0);
            assert_eq!(inside, expected, "{sum} of {rays}, {telling} telling");
        }
    }
}
