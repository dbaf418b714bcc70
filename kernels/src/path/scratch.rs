//! Scratch memory of a camera path, and all that exists for the registers of a GPU.
//!
//! Values that are live while a ray is traced or a BSDF is evaluated take registers of each invocation. The number of registers
//! decides how many waves run at once. The camera path therefore follows five rules (docs/decisions/registers.md has the
//! measurements):
//!
//! 1. **Path scratch.** Values that a path uses at few vertices lie in an array of the invocation instead of variables. They are
//!    the sums of light, the cone and the pencil of the prefix, and the shadow rays of a vertex. Each use reads them anew.
//! 2. **Light samples before the BSDF, shadow rays after it.** A vertex samples positions on lights first and stores them in an
//!    array ([`light_samples`]). Then it makes its BSDF and weighs them. The shadow rays are traced once the next segment is
//!    known, when nothing else of the vertex is needed.
//! 3. **One exit.** The loop over segments has one exit, with [nothing left of a segment](super::camera_path). With several exits
//!    a GPU keeps the values that any of them returns, for the invocations that have ended while others go on.
//! 4. **Values only.** A loop carries no slices and no references that change: drivers fail on pointers that a loop carries.
//!    Therefore an observer returns a value that it keeps, and functions here have `if`s instead of early returns.
//! 5. **Rare counts at once.** A count that is nearly always 0 is added to its counter where it occurs. A sum would be live along
//!    the whole path.

pub mod light_samples;

use super::PathContext;
use super::camera_path::CameraPathLight;
use super::camera_ray::CameraPathStart;
use super::prefix::needs_virtual_image;
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::packed::{to_bfloats, to_rgbe};
use crate::interface::point::{IndirectSample, PointDirect, SHARED_DEPTHS};
use crate::interface::radiance_cache::{CacheKey, CacheSample};
use crate::interface::ray::Ray;
use crate::light::light_sampling::FEW_LIGHTS;
use crate::math::cone::RayCone;
use crate::math::pencil::{Pencil, RayDerivative};
use crate::platform::Record;
use crate::surface::media::MediaStack;
use spirv_std::glam::{UVec2, Vec2, Vec3};

/// Shadow ray, and the light that it brings where nothing blocks it.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay {
    /// The ray.
    pub ray: Ray,
    /// Media around its start.
    pub media: MediaStack,
    /// Radiance (W m^-2 sr^-1).
    pub radiance: Vec3,
    /// With [`Features::PARTS`]: the part of the radiance that the specular class of its vertex scatters.
    pub specular: Vec3,
    /// The part of the radiance that the non-specular class scatters.
    pub non_specular: Vec3,
}

/// A sum of light along a path: `radiance`, `prefix`, `direct.radiance` and `delta_prefix` of [`CameraPathLight`].
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sum {
    /// All light.
    Radiance,
    /// Light that the non-specular class of the point does not reflect.
    Prefix,
    /// Direct light that this class reflects.
    Direct,
    /// Light found before the first non-delta bounce.
    DeltaPrefix,
}

/// Largest light of a sample (W m^-2 sr^-1).
const MAX_LIGHT: f32 = 1.0e30;

/// Number of words of a record: a shadow ray, or the path's own.
const WORDS: usize = 19;

/// Number of words of all shadow rays of a vertex, and of five more records.
pub const ROOM: usize = WORDS * (FEW_LIGHTS as usize + 5);

type PathRecord = Record<WORDS, ROOM>;

// Indices of words in the records of indirect light and of the cache, behind the light itself.
const DEMODULATION: usize = 3 * SHARED_DEPTHS;
const PROXIMITY: usize = DEMODULATION + 3;
const SHARE_RADIUS: usize = PROXIMITY + 1;
const CACHE_KEY: usize = DEMODULATION + 3;

// Indices of the words of the path's own record, beside its sums.
const CLASS_PROBABILITY: usize = 12;
const DISTANCE: usize = 13;
const CONE: usize = 14;

/// Features with which rays need the media around them.
const MEDIA: Features = Features(Features::ABSORPTION.0 | Features::NESTED.0);

/// Scratch memory of one camera path.
pub struct PathScratch<'a> {
    /// The words.
    words: &'a mut [u32; ROOM],
    /// Code that is compiled in.
    features: Features,
    /// Whether it keeps indirect light: with [`Features::INDIRECT`], in frames in which points share it.
    keeps_indirect: bool,
    /// Whether it keeps light for the radiance cache: with [`Features::INDIRECT`], in frames that use one.
    keeps_cached: bool,
    /// The path's own record.
    own: PathRecord,
    /// The pencil: its axes and its derivatives by the origin at the eye, and those by the direction there.
    pencil: [PathRecord; 2],
    /// Indirect light behind the collection point by the number of scatterings that it leaves, and the factor that makes a sample of
    /// it.
    indirect: PathRecord,
    /// Light and factor behind the vertex that gives a sample to the radiance cache, with its key.
    cached: PathRecord,
}

impl<'a> PathScratch<'a> {
    /// The scratch of a path that has found no light yet.
    #[inline(always)]
    pub fn new(words: &'a mut [u32; ROOM], start: &CameraPathStart, context: PathContext<'_>) -> Self {
        let PathContext { params, features, .. } = context;
        let first = FEW_LIGHTS + params.zero();
        let [own, by_origin, by_direction] =
            [PathRecord::at(first), PathRecord::at(first + 1), PathRecord::at(first + 2)];
        let pencil = [by_origin, by_direction];
        let (indirect, cached) = (PathRecord::at(first + 3), PathRecord::at(first + 4));
        let keeps_indirect = features.has(Features::INDIRECT) && params.shares_indirect();
        let keeps_cached = features.has(Features::INDIRECT) && params.uses_cache();
        let mut scratch =
            PathScratch { words, features, keeps_indirect, keeps_cached, own, pencil, indirect, cached };
        scratch.set(Sum::Radiance, Vec3::ZERO);
        if features.has(Features::PARTS) {
            scratch.set(Sum::Prefix, Vec3::ZERO);
            scratch.set(Sum::Direct, Vec3::ZERO);
            scratch.set(Sum::DeltaPrefix, Vec3::ZERO);
            scratch.set_class_probability(0.0);
        }
        if keeps_indirect {
            scratch.clear_light(indirect);
            scratch.set_demodulation(Vec3::ZERO, 0.0);
            scratch.set_proximity(0.0);
        }
        if keeps_cached {
            scratch.start_cache_sample(&CacheKey::default(), Vec3::ZERO);
        }
        scratch.set_cone(start.cone, 0.0);
        if needs_virtual_image(features) {
            scratch.set_pencil(&Pencil::at_eye(start.ray.direction, params.camera.right));
        }
        scratch
    }

    /// Returns a sum so far.
    #[inline(always)]
    pub fn sum(&self, sum: Sum) -> Vec3 {
        self.own.take3(self.words, 3 * sum as usize)
    }

    /// Sets a sum.
    #[inline(always)]
    pub fn set(&mut self, sum: Sum, light: Vec3) {
        self.own.put3(self.words, 3 * sum as usize, light);
    }

    /// Adds to a sum.
    #[inline(always)]
    pub fn add(&mut self, sum: Sum, light: Vec3) {
        self.set(sum, self.sum(sum) + light);
    }

    /// Sets the probability of the point's non-specular class.
    #[inline(always)]
    pub fn set_class_probability(&mut self, class_probability: f32) {
        self.own.put(self.words, CLASS_PROBABILITY, class_probability.to_bits());
    }

    /// Whether the path keeps indirect light.
    #[inline(always)]
    pub fn keeps_indirect(&self) -> bool {
        self.keeps_indirect
    }

    /// Whether the path keeps light for the radiance cache.
    #[inline(always)]
    pub fn keeps_cached(&self) -> bool {
        self.keeps_cached
    }

    /// Adds indirect light that leaves a path room for this number of further scatterings.
    #[inline(always)]
    pub fn add_indirect(&mut self, left: u32, light: Vec3) {
        if self.keeps_indirect {
            self.add_light(self.indirect, left, light);
        }
        if self.keeps_cached {
            self.add_light(self.cached, left, light);
        }
    }

    #[inline(always)]
    fn add_light(&mut self, record: PathRecord, left: u32, light: Vec3) {
        let word = 3 * (left as usize).min(SHARED_DEPTHS - 1);
        let sum = record.take3(self.words, word) + light;
        record.put3(self.words, word, sum);
    }

    #[inline(always)]
    fn clear_light(&mut self, record: PathRecord) {
        let mut left = 0;
        while left < SHARED_DEPTHS {
            record.put3(self.words, 3 * left, Vec3::ZERO);
            left += 1;
        }
    }

    /// Starts the sample for the radiance cache: of the light that is found from here on, times a factor. A factor of zero: the path
    /// gives no sample.
    #[inline(always)]
    pub fn start_cache_sample(&mut self, key: &CacheKey, factor: Vec3) {
        self.clear_light(self.cached);
        self.cached.put3(self.words, DEMODULATION, factor);
        self.cached.put(self.words, CACHE_KEY, key.xy);
        self.cached.put(self.words, CACHE_KEY + 1, key.z_edge_side_depth);
        self.cached.put(self.words, CACHE_KEY + 2, key.material);
    }

    /// Sample for the radiance cache, rounded by the bits of a random word.
    #[inline(always)]
    pub fn cache_sample(&self, bits: u32) -> CacheSample {
        let word = |index| self.cached.take(self.words, CACHE_KEY + index);
        let key = CacheKey { xy: word(0), z_edge_side_depth: word(1), material: word(2) };
        CacheSample { key, light: self.demodulated(self.cached, bits) }
    }

    /// Sets the factor that makes a sample of indirect light, and the radius of the point (m) without the width of rough lobes. A
    /// factor of zero: the point gives none.
    #[inline(always)]
    pub fn set_demodulation(&mut self, factor: Vec3, radius: f32) {
        self.indirect.put3(self.words, DEMODULATION, factor);
        self.indirect.put(self.words, SHARE_RADIUS, radius.to_bits());
    }

    /// Sets one over the distance from the collection point to the next surface of the path (1/m).
    #[inline(always)]
    pub fn set_proximity(&mut self, proximity: f32) {
        self.indirect.put(self.words, PROXIMITY, proximity.to_bits());
    }

    /// Sample of the indirect light, rounded by the bits of a random word.
    #[inline(always)]
    pub fn indirect_sample(&self, bits: u32) -> IndirectSample {
        let number = |word| f32::from_bits(self.indirect.take(self.words, word));
        let radius_and_proximity = to_bfloats(number(SHARE_RADIUS), number(PROXIMITY));
        IndirectSample { light: self.demodulated(self.indirect, bits), radius_and_proximity }
    }

    /// The light of a record times its factor. The first value is all of it. The next ones lack light of so many scatterings that
    /// vertices one and two deeper have no room for them.
    #[inline(always)]
    fn demodulated(&self, record: PathRecord, bits: u32) -> [u32; SHARED_DEPTHS] {
        let offset = |bits: u32| (bits & 1023) as f32 * (1.0 / 1024.0);
        let offsets = Vec3::new(offset(bits), offset(bits >> 10), offset(bits >> 20));
        let factor = record.take3(self.words, DEMODULATION);
        let mut light = [NONE; SHARED_DEPTHS];
        let mut sum = Vec3::ZERO;
        let mut deeper = SHARED_DEPTHS;
        while deeper > 0 && factor.x > 0.0 {
            deeper -= 1;
            sum += record.take3(self.words, 3 * deeper) * factor;
            light[deeper] = to_rgbe(sum.min(Vec3::splat(MAX_LIGHT)), offsets);
        }
        light
    }

    /// Returns all light so far.
    #[inline(always)]
    pub fn light(&self) -> CameraPathLight {
        let mut light = CameraPathLight { radiance: self.sum(Sum::Radiance), ..CameraPathLight::default() };
        if self.features.has(Features::PARTS) {
            light.prefix = self.sum(Sum::Prefix);
            let class_probability = f32::from_bits(self.own.take(self.words, CLASS_PROBABILITY));
            light.direct = PointDirect { radiance: self.sum(Sum::Direct), class_probability };
            light.delta_prefix = self.sum(Sum::DeltaPrefix);
        }
        light
    }

    /// Returns the cone of the prefix, and its length (m).
    #[inline(always)]
    pub fn cone(&self) -> (RayCone, f32) {
        let number = |word| f32::from_bits(self.own.take(self.words, word));
        let cone = RayCone {
            width: number(CONE),
            spread: number(CONE + 1),
            rough_width: number(CONE + 2),
            rough_spread: number(CONE + 3),
            is_distorted: self.own.take(self.words, CONE + 4) != 0,
        };
        (cone, number(DISTANCE))
    }

    /// Sets the cone of the prefix, and its length (m).
    #[inline(always)]
    pub fn set_cone(&mut self, cone: RayCone, distance: f32) {
        self.own.put(self.words, DISTANCE, distance.to_bits());
        self.own.put(self.words, CONE, cone.width.to_bits());
        self.own.put(self.words, CONE + 1, cone.spread.to_bits());
        self.own.put(self.words, CONE + 2, cone.rough_width.to_bits());
        self.own.put(self.words, CONE + 3, cone.rough_spread.to_bits());
        self.own.put(self.words, CONE + 4, u32::from(cone.is_distorted));
    }

    /// Returns the pencil of the prefix.
    #[inline(always)]
    pub fn pencil(&self) -> Pencil {
        let words = &*self.words;
        let two = |record: PathRecord, word| {
            Vec2::new(f32::from_bits(record.take(words, word)), f32::from_bits(record.take(words, word + 1)))
        };
        let derivative =
            |record, word| RayDerivative { offset: two(record, word), slope: two(record, word + 2) };
        let [by_origin, by_direction] = self.pencil;
        Pencil {
            x: by_origin.take3(words, 8),
            y: by_origin.take3(words, 11),
            by_origin_x: derivative(by_origin, 0),
            by_origin_y: derivative(by_origin, 4),
            by_direction_x: derivative(by_direction, 0),
            by_direction_y: derivative(by_direction, 4),
            is_distorted: by_direction.take(words, 8) != 0,
        }
    }

    /// Sets the pencil of the prefix.
    #[inline(always)]
    pub fn set_pencil(&mut self, pencil: &Pencil) {
        let words = &mut *self.words;
        let mut set = |record: PathRecord, word, ray: &RayDerivative| {
            record.put(words, word, ray.offset.x.to_bits());
            record.put(words, word + 1, ray.offset.y.to_bits());
            record.put(words, word + 2, ray.slope.x.to_bits());
            record.put(words, word + 3, ray.slope.y.to_bits());
        };
        let [by_origin, by_direction] = self.pencil;
        set(by_origin, 0, &pencil.by_origin_x);
        set(by_origin, 4, &pencil.by_origin_y);
        set(by_direction, 0, &pencil.by_direction_x);
        set(by_direction, 4, &pencil.by_direction_y);
        by_origin.put3(words, 8, pencil.x);
        by_origin.put3(words, 11, pencil.y);
        by_direction.put(words, 8, u32::from(pencil.is_distorted));
    }

    /// Sets the shadow ray at an index below [`FEW_LIGHTS`].
    #[inline(always)]
    pub fn set_shadow_ray(&mut self, index: u32, shadow_ray: &ShadowRay) {
        let record = PathRecord::at(index);
        let words = &mut *self.words;
        record.put3(words, 0, shadow_ray.ray.origin);
        record.put3(words, 3, shadow_ray.ray.direction);
        record.put(words, 6, shadow_ray.ray.length.to_bits());
        record.put(words, 7, shadow_ray.ray.key);
        record.put3(words, 8, shadow_ray.radiance);
        if self.features.has(MEDIA) {
            let media = shadow_ray.media.words();
            record.put(words, 11, media.x);
            record.put(words, 12, media.y);
        }
        if self.features.has(Features::PARTS) {
            record.put3(words, 13, shadow_ray.specular);
            record.put3(words, 16, shadow_ray.non_specular);
        }
    }

    /// Returns the shadow ray at an index.
    #[inline(always)]
    pub fn shadow_ray(&self, index: u32) -> ShadowRay {
        let record = PathRecord::at(index);
        let words = &*self.words;
        let mut shadow_ray = ShadowRay {
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
            shadow_ray.media =
                MediaStack::from_words(UVec2::new(record.take(words, 11), record.take(words, 12)));
        }
        if self.features.has(Features::PARTS) {
            (shadow_ray.specular, shadow_ray.non_specular) =
                (record.take3(words, 13), record.take3(words, 16));
        }
        shadow_ray
    }
}
