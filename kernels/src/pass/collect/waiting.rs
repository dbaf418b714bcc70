//! Shadow rays that wait until their path has left the vertex that they start at: what is alive while a ray is traced takes a
//! GPU's registers, and a vertex with its lobes is more than half of it.

use crate::interface::features::Features;
use crate::interface::ray::Ray;
use crate::light::connect::FEW_LIGHTS;
use crate::seam::{put3, take3};
use crate::surface::media::MediaStack;
use spirv_std::glam::{UVec4, Vec3};

/// A shadow ray, and what it brings where nothing is in its way.
#[derive(Clone, Copy, Debug)]
pub struct Shadow {
    /// The ray.
    pub ray: Ray,
    /// Media around its start.
    pub media: MediaStack,
    /// Radiance (W m^-2 sr^-1).
    pub radiance: Vec3,
    /// With [`Features::PARTS`]: what the specular class of its vertex makes of it.
    pub specular: Vec3,
    /// What the other makes of it.
    pub non_specular: Vec3,
}

/// Words of one.
const WORDS: usize = 21;

/// Words of as many as a vertex has.
pub const ROOM: usize = WORDS * FEW_LIGHTS as usize;

/// Where rays ask for the media around them.
const MEDIA: Features = Features(Features::ABSORPTION.0 | Features::NESTED.0);

/// Leaves one at a place.
#[inline(always)]
pub fn put(words: &mut [u32; ROOM], place: u32, shadow: &Shadow, features: Features) {
    let first = first_of(place);
    put3(words, first, shadow.ray.origin);
    put3(words, first + 3, shadow.ray.direction);
    words[first + 6] = shadow.ray.length.to_bits();
    words[first + 7] = shadow.ray.key;
    put3(words, first + 8, shadow.radiance);
    if features.has(MEDIA) {
        let media = shadow.media.words();
        (words[first + 11], words[first + 12]) = (media.x, media.y);
        (words[first + 13], words[first + 14]) = (media.z, media.w);
    }
    if features.has(Features::PARTS) {
        put3(words, first + 15, shadow.specular);
        put3(words, first + 18, shadow.non_specular);
    }
}

/// The one at a place.
#[inline(always)]
pub fn take(words: &[u32; ROOM], place: u32, features: Features) -> Shadow {
    let first = first_of(place);
    let mut shadow = Shadow {
        ray: Ray {
            origin: take3(words, first),
            direction: take3(words, first + 3),
            length: f32::from_bits(words[first + 6]),
            key: words[first + 7],
        },
        media: MediaStack::VACUUM,
        radiance: take3(words, first + 8),
        specular: Vec3::ZERO,
        non_specular: Vec3::ZERO,
    };
    if features.has(MEDIA) {
        let media = UVec4::new(words[first + 11], words[first + 12], words[first + 13], words[first + 14]);
        shadow.media = MediaStack::of_words(media);
    }
    if features.has(Features::PARTS) {
        (shadow.specular, shadow.non_specular) = (take3(words, first + 15), take3(words, first + 18));
    }
    shadow
}

/// The first word of a place. That it has an end lets a CPU's compiler leave out all other checks.
#[inline(always)]
fn first_of(place: u32) -> usize {
    WORDS * place.min(FEW_LIGHTS - 1) as usize
}
