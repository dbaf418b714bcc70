//! What a camera path puts aside, in memory, until it asks for it again: what is alive while a ray is traced, or a vertex scattered at,
//! takes a GPU's registers. These are the shadow rays of a vertex, which wait until the path has left it, the light that the path
//! has found, and the cone of its prefix.

use crate::interface::features::Features;
use crate::interface::point::PointDirect;
use crate::interface::ray::Ray;
use crate::light::connect::FEW_LIGHTS;
use crate::math::cone::RayCone;
use crate::pass::collect::PathLight;
use crate::seam::Record;
use crate::surface::media::MediaStack;
use spirv_std::glam::{UVec2, Vec3};

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

/// A sum of light that a path brings: `radiance`, `seen`, `direct.radiance` and `steady` of [`PathLight`].
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sum {
    /// All of it.
    Radiance,
    /// What the non-specular class of the point reflects nothing of.
    Seen,
    /// Direct light that this class reflects.
    Direct,
    /// What was found before the first draw from a lobe that has a width.
    Steady,
}

/// Words of a record: those of a shadow ray, or the path's own.
const WORDS: usize = 19;

/// Words of as many shadow rays as a vertex has, and of one record more.
pub const ROOM: usize = WORDS * (FEW_LIGHTS as usize + 1);

type Place = Record<WORDS, ROOM>;

/// The path's own record: sums, and these.
const OWN: Place = Place::at(FEW_LIGHTS);
const CHANCE: usize = 12;
const DISTANCE: usize = 13;
const CONE: usize = 14;

/// Where rays ask for the media around them.
const MEDIA: Features = Features(Features::ABSORPTION.0 | Features::NESTED.0);

/// What a path has put aside.
pub struct Aside<'a> {
    /// The words.
    pub words: &'a mut [u32; ROOM],
    /// What the scene needs.
    pub features: Features,
}

impl Aside<'_> {
    /// Has found no light yet.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.set(Sum::Radiance, Vec3::ZERO);
        if self.features.has(Features::PARTS) {
            self.set(Sum::Seen, Vec3::ZERO);
            self.set(Sum::Direct, Vec3::ZERO);
            self.set(Sum::Steady, Vec3::ZERO);
            self.set_chance(0.0);
        }
    }

    /// A sum so far.
    #[inline(always)]
    pub fn sum(&self, sum: Sum) -> Vec3 {
        OWN.take3(self.words, 3 * sum as usize)
    }

    /// Sets a sum.
    #[inline(always)]
    pub fn set(&mut self, sum: Sum, light: Vec3) {
        OWN.put3(self.words, 3 * sum as usize, light);
    }

    /// Adds to a sum.
    #[inline(always)]
    pub fn add(&mut self, sum: Sum, light: Vec3) {
        self.set(sum, self.sum(sum) + light);
    }

    /// Sets the chance of the point's non-specular class.
    #[inline(always)]
    pub fn set_chance(&mut self, chance: f32) {
        OWN.put(self.words, CHANCE, chance.to_bits());
    }

    /// All that was found.
    #[inline(always)]
    pub fn light(&self) -> PathLight {
        let mut light = PathLight { radiance: self.sum(Sum::Radiance), ..PathLight::default() };
        if self.features.has(Features::PARTS) {
            light.seen = self.sum(Sum::Seen);
            let chance = f32::from_bits(OWN.take(self.words, CHANCE));
            light.direct = PointDirect { radiance: self.sum(Sum::Direct), chance };
            light.steady = self.sum(Sum::Steady);
        }
        light
    }

    /// The cone of the prefix, and its length (m).
    #[inline(always)]
    pub fn cone(&self) -> (RayCone, f32) {
        let number = |word| f32::from_bits(OWN.take(self.words, word));
        let cone = RayCone {
            width: number(CONE),
            spread: number(CONE + 1),
            rough_width: number(CONE + 2),
            rough_spread: number(CONE + 3),
            is_bent: OWN.take(self.words, CONE + 4) != 0,
        };
        (cone, number(DISTANCE))
    }

    /// Leaves them.
    #[inline(always)]
    pub fn set_cone(&mut self, cone: RayCone, distance: f32) {
        OWN.put(self.words, DISTANCE, distance.to_bits());
        OWN.put(self.words, CONE, cone.width.to_bits());
        OWN.put(self.words, CONE + 1, cone.spread.to_bits());
        OWN.put(self.words, CONE + 2, cone.rough_width.to_bits());
        OWN.put(self.words, CONE + 3, cone.rough_spread.to_bits());
        OWN.put(self.words, CONE + 4, u32::from(cone.is_bent));
    }

    /// Leaves a shadow ray at a place below [`FEW_LIGHTS`].
    #[inline(always)]
    pub fn set_shadow(&mut self, place: u32, shadow: &Shadow) {
        let record = Place::at(place);
        let words = &mut *self.words;
        record.put3(words, 0, shadow.ray.origin);
        record.put3(words, 3, shadow.ray.direction);
        record.put(words, 6, shadow.ray.length.to_bits());
        record.put(words, 7, shadow.ray.key);
        record.put3(words, 8, shadow.radiance);
        if self.features.has(MEDIA) {
            let media = shadow.media.words();
            record.put(words, 11, media.x);
            record.put(words, 12, media.y);
        }
        if self.features.has(Features::PARTS) {
            record.put3(words, 13, shadow.specular);
            record.put3(words, 16, shadow.non_specular);
        }
    }

    /// The shadow ray at a place.
    #[inline(always)]
    pub fn shadow(&self, place: u32) -> Shadow {
        let record = Place::at(place);
        let words = &*self.words;
        let mut shadow = Shadow {
            ray: Ray {
                origin: record.take3(words, 0),
                direction: record.take3(words, 3),
                length: f32::from_bits(record.take(words, 6)),
                key: record.take(words, 7),
            },
            media: MediaStack::VACUUM,
            radiance: record.take3(words, 8),
            specular: Vec3::ZERO,
            non_specular: Vec3::ZERO,
        };
        if self.features.has(MEDIA) {
            shadow.media = MediaStack::of_words(UVec2::new(record.take(words, 11), record.take(words, 12)));
        }
        if self.features.has(Features::PARTS) {
            (shadow.specular, shadow.non_specular) = (record.take3(words, 13), record.take3(words, 16));
        }
        shadow
    }
}
