//! Segments of paths through media: they pass faces that a medium of higher priority covers.
//!
//! A covered face is no vertex: it takes no bounce and samples no number. Overlapping solids therefore give the light of one
//! surface between them. Camera paths, light paths and shadow rays all follow this rule.

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::ray::{Hit, Ray};
use crate::interface::scene::SceneTables;
use crate::math::offset;
use crate::surface::media::MediaStack;
use crate::surface::textured::material_at;
use crate::surface::thin_wall::{self, MAX_PASSED, is_passed};
use crate::surface::vertex::vertex;
use crate::trace::Tracer;
use spirv_std::glam::Vec3;

/// Maximum number of covered faces that one segment passes; the next one is a vertex that passes straight on. It only bounds
/// loops.
const MAX_COVERED: u32 = 256;

/// The end of a segment.
#[derive(Clone, Copy, Debug)]
pub struct TracedSegment {
    /// Hit, at its distance from the segment's start.
    pub hit: Hit,
    /// Media before the hit.
    pub media: MediaStack,
    /// Transmittance of the media along the segment.
    pub transmittance: Vec3,
    /// Number of faces on the way that contradict the media around the path.
    pub unexpected: u32,
    /// Number of media on the way that found no room in the stack.
    pub overflows: u32,
}

/// Follows `ray` through `media` to the first face that is not covered, or to its end.
#[inline(always)]
pub fn trace_through_media<T: Tracer>(
    ray: &Ray,
    media: MediaStack,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
) -> TracedSegment {
    // Vertices need only their sides and positions.
    let bare = Features(features.0 & Features::INSTANCES.0);
    let mut traced =
        TracedSegment { hit: Hit::MISS, media, transmittance: Vec3::ONE, unexpected: 0, overflows: 0 };
    let mut part = *ray;
    let (mut passed, mut covered) = (0.0, 0);
    let mut follows = true;
    while follows {
        follows = false;
        let hit = tracer.closest(&part);
        let mut length = part.length;
        let (mut along, mut behind) = (traced.media, traced.media);
        if !hit.is_miss() {
            length = hit.distance;
            let material = scene.surfaces[hit.triangle as usize].material;
            if features.has(Features::NESTED) && scene.materials[material as usize].is_medium() {
                let here = vertex(scene, bare, &part, &hit, 0.0);
                let sides = traced.media.at_face(material, here.front, features, scene.materials);
                traced.unexpected += u32::from(!sides.is_expected);
                along = sides.along;
                // Emitters are seen, covered or not.
                if sides.is_covered(scene.materials) && here.light == NONE && covered < MAX_COVERED {
                    follows = true;
                    covered += 1;
                    traced.overflows += u32::from(sides.overflow);
                    behind = sides.behind;
                    let origin =
                        offset::leave(here.position, here.face_normal, part.direction, here.clearance);
                    part = ray.rest_from(origin);
                }
            }
        }
        if features.has(Features::ABSORPTION) {
            traced.transmittance *= along.transmittance(scene.materials, length);
        }
        traced.media = behind;
        traced.hit = Hit { distance: passed + hit.distance, ..hit };
        passed += length;
    }
    traced
}

/// Transmittance of a shadow ray through `media` and thin walls up to its end; zero if any other face on its way is not covered.
#[inline(always)]
pub fn shadow_transmittance<T: Tracer>(
    ray: &Ray,
    media: MediaStack,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut T,
) -> Vec3 {
    // All rays of a scene take one branch, so that a device holds the code of one traversal.
    if !features.has(Features::NESTED | Features::THIN_WALLS) {
        if tracer.occluded(ray) {
            return Vec3::ZERO;
        }
        return if features.has(Features::ABSORPTION) {
            media.transmittance(scene.materials, ray.length)
        } else {
            Vec3::ONE
        };
    }
    let (mut part, mut around, mut transmittance) = (*ray, media, Vec3::ONE);
    let (mut passed, mut follows) = (0, true);
    while follows {
        follows = false;
        let traced = trace_through_media(&part, around, features, scene, tracer);
        transmittance *= traced.transmittance;
        let hit = traced.hit;
        if !hit.is_miss() {
            let material = scene.surfaces[hit.triangle as usize].material;
            if passed < MAX_PASSED && is_passed(&scene.materials[material as usize], params, features) {
                passed += 1;
                let here = vertex(scene, features, &part, &hit, 0.0);
                let wall = material_at(scene, &here, features);
                let cos = here.to_previous.dot(here.shading_normal).abs();
                transmittance *= thin_wall::transmittance(&wall, cos);
                around = traced.media.settled(features, scene.materials);
                let origin = offset::leave(here.position, here.face_normal, part.direction, here.clearance);
                part = ray.rest_from(origin);
                follows = transmittance.max_element() > 0.0;
            } else {
                transmittance = Vec3::ZERO;
            }
        }
    }
    transmittance
}
