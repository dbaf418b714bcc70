//! The media around a point where a path starts: the eye or a light.

use crate::interface::material::FLAG_THIN;
use crate::interface::needs::Needs;
use crate::interface::scene::SceneTables;
use crate::math::offset;
use crate::math::ray::Ray;
use crate::surface::media::MediaStack;
use crate::surface::vertex::vertex;
use crate::trace::Tracer;
use spirv_std::glam::Vec3;

/// A direction along no axis, of unit length.
const OUT: Vec3 = Vec3::new(0.36, 0.48, 0.8);
/// Faces on the way out, at most.
const MOST_FACES: u32 = 64;

/// Media whose faces a ray from `position` leaves without having entered them, the innermost first. Faces without a
/// back of their own count as closed.
#[inline(always)]
pub fn enclosing<T: Tracer>(position: Vec3, scene: SceneTables<'_>, tracer: &mut T) -> MediaStack {
    let mut around = MediaStack::VACUUM;
    let mut entered = MediaStack::VACUUM;
    let mut ray = Ray::endless(position, OUT);
    let mut faces = 0;
    while faces < MOST_FACES {
        let hit = tracer.closest(&ray);
        if hit.is_miss() {
            break;
        }
        let here = vertex(scene, Needs(0), &ray, &hit, 0.0);
        let material = scene.materials[here.material as usize];
        if material.transmission > 0.0 && material.flags & FLAG_THIN == 0 {
            if here.front {
                entered = entered.entered(here.material).0;
            } else if entered.holds(here.material) {
                entered = entered.left(here.material);
            } else {
                around = around.inside_of(here.material);
            }
        }
        ray = Ray::endless(offset::leave(here.position, here.face_normal, OUT, here.clearance), OUT);
        faces += 1;
    }
    around
}
