//! Next-event estimation: samples a point on a light for a vertex, with the density of that choice.
//!
//! A vertex samples one light sampled by its power; or, up to the collection point, all where they are few, and one of
//! several candidates where they are many, sampled by what they would give unshadowed: resampled importance sampling [Talbot et
//! al. 2005, Importance resampling for global illumination]. The balance heuristic against scattering stands inside that target,
//! and takes the density of all candidates together, whether they are chosen or not: so what finds a light by scattering
//! can say the same without knowing them.

use crate::interface::choice::LightSampler;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::light::Light;
use crate::interface::scene::SceneTables;
use crate::light::{choose, sample_light};
use crate::math::mean;
use spirv_std::glam::{Vec3, Vec4};

/// A point on a light as a vertex sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSample {
    /// Where a shadow ray ends, just before the light (m).
    pub target: Vec3,
    /// Unit direction to the light.
    pub to_light: Vec3,
    /// Radiance over pdf_solid_angle; for a punctual light its irradiance across over the probability of its choice
    /// (W m^-2).
    pub radiance_over_pdf: Vec3,
    /// Density of this direction (1/sr); 0 for a punctual light, which nothing else can find.
    pub pdf_solid_angle: f32,
    /// The light is infinitely far away: the shadow ray has no end, and `target` says nothing.
    pub endless: bool,
}

impl LightSample {
    /// No light comes to this position.
    #[inline(always)]
    pub fn none(position: Vec3) -> Self {
        LightSample {
            target: position,
            to_light: Vec3::Z,
            radiance_over_pdf: Vec3::ZERO,
            pdf_solid_angle: 0.0,
            endless: false,
        }
    }
}

/// Largest number of lights of which a vertex samples each.
pub const FEW_LIGHTS: u32 = 4;
/// Number of candidates of a light sample where there are more lights.
pub const CANDIDATE_COUNT: u32 = 8;
/// Candidates of a vertex share their random numbers, shifted by multiples of this [Roberts 2018, The unreasonable effectiveness
/// of quasirandom sequences]; that of a choice by the golden ratio.
const SHIFT: Vec4 = Vec4::new(1.0 / CANDIDATE_COUNT as f32, 0.618_034, 0.754_877_7, 0.569_840_3);

/// Light samples of a vertex, and their candidates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCandidates {
    /// Number of light samples, a shadow ray each.
    pub sample_count: u32,
    /// Number of candidates of a light sample.
    pub candidate_count: u32,
    /// Whether they are all lights, in turn.
    pub is_all: bool,
    /// Probability of each light to be one candidate, where that is the same for all; 0 where each is sampled by its power.
    pub probability: f32,
}

impl LightCandidates {
    /// One light, by power.
    pub const ONE: LightCandidates =
        LightCandidates { sample_count: 1, candidate_count: 1, is_all: false, probability: 0.0 };

    /// Those of a vertex up to the collection point.
    #[inline(always)]
    pub fn new(params: &FrameParams) -> LightCandidates {
        let count = params.light_count;
        if params.light_sampler == LightSampler::Power as u32 || count == 0 {
            LightCandidates::ONE
        } else if params.light_sampler == LightSampler::Uniform as u32 {
            LightCandidates { probability: 1.0 / count as f32, ..LightCandidates::ONE }
        } else if count <= FEW_LIGHTS {
            LightCandidates { sample_count: count, is_all: true, probability: 1.0, ..LightCandidates::ONE }
        } else {
            LightCandidates { candidate_count: CANDIDATE_COUNT, ..LightCandidates::ONE }
        }
    }

    /// How many are on this light, on average, over the probability that one sampled by power is.
    #[inline(always)]
    pub fn gain(&self, light: &Light) -> f32 {
        if self.probability > 0.0 {
            self.probability / light.pdf_light_choice
        } else {
            self.candidate_count as f32
        }
    }

    /// The candidate of this number, by four numbers that all share. Its density is that of all candidates together.
    #[inline(always)]
    pub fn sample_light(
        &self,
        number: u32,
        scene: SceneTables<'_>,
        light_count: u32,
        features: Features,
        position: Vec3,
        u: Vec4,
    ) -> LightSample {
        if light_count == 0 {
            return LightSample::none(position);
        }
        let mut u = u + SHIFT * number as f32;
        u -= u.floor();
        let mut light_id = number;
        if !self.is_all {
            light_id = if self.probability > 0.0 {
                ((u.x * light_count as f32) as u32).min(light_count - 1)
            } else {
                choose(scene.lights, light_count, u.x, u.y)
            };
        }
        let light = &scene.lights[light_id as usize];
        let gain = self.gain(light);
        let light_sample = sample_light(light, scene, features, position, u.z, u.w);
        LightSample {
            radiance_over_pdf: light_sample.radiance_over_pdf * (1.0 / gain),
            pdf_solid_angle: light_sample.pdf_solid_angle * gain,
            ..light_sample
        }
    }
}

/// The largest number below one.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Light that a vertex sends on, by the class of the lobe that does (W m^-2 sr^-1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByClass {
    /// By lobes that end a camera prefix.
    pub non_specular: Vec3,
    /// By others.
    pub specular: Vec3,
}

impl ByClass {
    /// By all lobes.
    #[inline(always)]
    pub fn sum(&self) -> Vec3 {
        self.non_specular + self.specular
    }

    /// As much of both.
    #[inline(always)]
    pub fn times(&self, factor: f32) -> ByClass {
        ByClass { non_specular: self.non_specular * factor, specular: self.specular * factor }
    }
}

/// One of the candidates of a light sample, sampled by the light that each would give unshadowed [Chao 1982, A general purpose unequal
/// probability sampling plan].
pub struct Reservoir<T> {
    /// What was kept of the one that was sampled.
    pub kept: T,
    /// The mean of the channels of the light that it would give, and that of all.
    weight: f32,
    weights: f32,
    /// Uniform in [0, 1), whatever was chosen.
    choice: f32,
}

impl<T: Default> Reservoir<T> {
    /// None yet; `choice` is uniform in [0, 1).
    #[inline(always)]
    pub fn new(choice: f32) -> Self {
        Reservoir { kept: T::default(), weight: 0.0, weights: 0.0, choice }
    }

    /// Takes a candidate that would give this light, or passes it by.
    #[inline(always)]
    pub fn add(&mut self, kept: T, light: Vec3) {
        let weight = mean(light);
        if weight > 0.0 {
            self.weights += weight;
            // The first is always taken, and what has no bounds, so that it is counted; neither takes of the number.
            let mut is_taken = weight == self.weights;
            if !is_taken {
                let probability = weight / self.weights;
                is_taken = self.choice < probability;
                let rest = if is_taken {
                    self.choice / probability
                } else {
                    (self.choice - probability) / (1.0 - probability)
                };
                self.choice = rest.min(BELOW_ONE);
            }
            if is_taken {
                (self.kept, self.weight) = (kept, weight);
            }
        }
    }

    /// Whether any gives light, so that one was sampled.
    #[inline(always)]
    pub fn has_sample(&self) -> bool {
        self.weights > 0.0
    }

    /// One over the probability that it was chosen.
    #[inline(always)]
    pub fn inverse_probability(&self) -> f32 {
        if self.weight == self.weights { 1.0 } else { self.weights / self.weight }
    }
}
