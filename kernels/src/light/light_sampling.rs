//! Next-event estimation: samples a point on a light for a vertex, with the density of that choice.
//!
//! A vertex samples one light by its power. Up to the collection point it samples all lights where they are few. Where they are
//! many, it takes several candidates and samples one by the light that each would give unshadowed. This is resampled importance
//! sampling [Talbot et al. 2005, Importance resampling for global illumination].
//!
//! The balance heuristic against scattering stands inside that target. It takes the density of all candidates together, whether
//! they are chosen or not. A path that finds a light by scattering can therefore compute the same weight without knowing the
//! candidates.

use crate::interface::NONE;
use crate::interface::choice::LightSampler;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::light::Light;
use crate::interface::scene::SceneTables;
use crate::light::light_bvh::LightBvh;
use crate::light::{choose, sample_light};
use crate::math::{BELOW_ONE, mean};
use spirv_std::glam::{Vec3, Vec4};

/// A point on a light as a vertex sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSample {
    /// End of the shadow ray, just before the light (m).
    pub target: Vec3,
    /// Unit direction to the light.
    pub to_light: Vec3,
    /// Radiance over `pdf_solid_angle`. For a punctual light, its irradiance at normal incidence over the probability of its
    /// choice (W m^-2).
    pub radiance_over_pdf: Vec3,
    /// Density of this direction (1/sr); 0 for a punctual light, which scattering cannot find.
    pub pdf_solid_angle: f32,
    /// Whether the light is infinitely far away: the shadow ray has no end, and `target` is meaningless.
    pub endless: bool,
}

impl LightSample {
    /// Sample without light.
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

/// Largest number of lights at which a vertex samples all of them.
pub const FEW_LIGHTS: u32 = 4;
/// Number of candidates of a light sample where there are more lights.
pub const CANDIDATE_COUNT: u32 = 8;
/// Shift between the random numbers of a vertex's candidates, which share them [Roberts 2018, The unreasonable effectiveness of
/// quasirandom sequences]. The second number, of the choice, is shifted by the golden ratio.
const SHIFT: Vec4 = Vec4::new(1.0 / CANDIDATE_COUNT as f32, 0.618_034, 0.754_877_7, 0.569_840_3);

/// Light samples of a vertex, and their candidates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCandidates {
    /// Number of light samples, a shadow ray each.
    pub sample_count: u32,
    /// Number of candidates of a light sample.
    pub candidate_count: u32,
    /// Whether the candidates are all lights, in order.
    pub is_all: bool,
    /// Probability of each light to be a given candidate, where it is the same for all; 0 where lights are sampled by power.
    pub probability: f32,
    /// Share of the candidates that the light BVH samples; the others are sampled by power.
    pub bvh_share: f32,
}

impl LightCandidates {
    /// One light, by power.
    pub const ONE: LightCandidates = LightCandidates {
        sample_count: 1,
        candidate_count: 1,
        is_all: false,
        probability: 0.0,
        bvh_share: 0.0,
    };

    /// Light sample of a vertex behind the collection point, by the settings.
    #[inline(always)]
    pub fn one(params: &FrameParams) -> LightCandidates {
        LightCandidates { bvh_share: params.light_bvh_share, ..LightCandidates::ONE }
    }

    /// Light samples of a vertex up to the collection point, by the settings.
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
            LightCandidates { candidate_count: CANDIDATE_COUNT, ..LightCandidates::one(params) }
        }
    }

    /// Expected number of candidates on this light, over the probability of the light by power. `by_bvh` is its probability by
    /// the light BVH for the vertex.
    #[inline(always)]
    fn gain_of(&self, light: &Light, features: Features, by_bvh: f32) -> f32 {
        let mut gain = self.candidate_count as f32;
        if self.probability > 0.0 {
            gain = self.probability / light.pdf_light_choice;
        } else if self.uses_bvh(features) {
            gain *= 1.0 - self.bvh_share + self.bvh_share * by_bvh / light.pdf_light_choice;
        }
        gain
    }

    /// Expected number of candidates on this light for a vertex, over the probability of the light by power.
    #[inline(always)]
    pub fn gain(
        &self,
        light_id: u32,
        scene: SceneTables<'_>,
        light_count: u32,
        features: Features,
        position: Vec3,
    ) -> f32 {
        let mut by_bvh = 0.0;
        if self.uses_bvh(features) {
            by_bvh = LightBvh { nodes: scene.light_bvh, light_count }.probability(position, light_id);
        }
        self.gain_of(&scene.lights[light_id as usize], features, by_bvh)
    }

    /// Whether the light BVH samples some candidates.
    #[inline(always)]
    fn uses_bvh(&self, features: Features) -> bool {
        features.has(Features::LIGHT_BVH) && self.bvh_share > 0.0
    }

    /// Samples the candidate of this number, by four uniform numbers that all candidates share. Its density is that of all
    /// candidates together.
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
        let (mut light_id, mut by_bvh) = (number, 0.0);
        if self.uses_bvh(features) {
            let bvh = LightBvh { nodes: scene.light_bvh, light_count };
            if u.x < self.bvh_share {
                let sampled = bvh.sample(position, u.x / self.bvh_share);
                if sampled.light_id == NONE {
                    return LightSample::none(position);
                }
                (light_id, by_bvh) = (sampled.light_id, sampled.probability);
            } else {
                let u_power = (u.x - self.bvh_share) / (1.0 - self.bvh_share);
                light_id = choose(scene.lights, light_count, u_power, u.y);
                by_bvh = bvh.probability(position, light_id);
            }
        } else if !self.is_all {
            light_id = if self.probability > 0.0 {
                ((u.x * light_count as f32) as u32).min(light_count - 1)
            } else {
                choose(scene.lights, light_count, u.x, u.y)
            };
        }
        let light = &scene.lights[light_id as usize];
        let gain = self.gain_of(light, features, by_bvh);
        let light_sample = sample_light(light, scene, features, position, u.z, u.w);
        LightSample {
            radiance_over_pdf: light_sample.radiance_over_pdf * (1.0 / gain),
            pdf_solid_angle: light_sample.pdf_solid_angle * gain,
            ..light_sample
        }
    }
}

/// Light that a vertex scatters, by the class of the lobe that does (W m^-2 sr^-1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByClass {
    /// By lobes that end a camera prefix.
    pub non_specular: Vec3,
    /// By specular lobes.
    pub specular: Vec3,
}

impl ByClass {
    /// Light of all lobes.
    #[inline(always)]
    pub fn sum(&self) -> Vec3 {
        self.non_specular + self.specular
    }

    /// Scales both by a factor.
    #[inline(always)]
    pub fn times(&self, factor: f32) -> ByClass {
        ByClass { non_specular: self.non_specular * factor, specular: self.specular * factor }
    }
}

/// Weighted reservoir of one candidate of a light sample [Chao 1982, A general purpose unequal probability sampling plan].
/// Candidates are sampled in proportion to the light that they would give unshadowed.
pub struct Reservoir<T> {
    /// Value kept of the sampled candidate.
    pub kept: T,
    /// Light that the sampled candidate would give, as the mean of its channels.
    weight: f32,
    /// Sum of this over all candidates.
    weights: f32,
    /// Uniform number in [0, 1), independent of the choices so far.
    choice: f32,
}

impl<T: Default> Reservoir<T> {
    /// Empty reservoir; `choice` is uniform in [0, 1).
    #[inline(always)]
    pub fn new(choice: f32) -> Self {
        Reservoir { kept: T::default(), weight: 0.0, weights: 0.0, choice }
    }

    /// Adds a candidate that would give this light. Keeps it with the probability weight / sum of weights.
    #[inline(always)]
    pub fn add(&mut self, kept: T, light: Vec3) {
        let weight = mean(light);
        if weight > 0.0 {
            self.weights += weight;
            // Always take the first candidate, and an infinite one, so that it is counted. Neither uses up the number.
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

    /// Whether any candidate gives light, so that one was sampled.
    #[inline(always)]
    pub fn has_sample(&self) -> bool {
        self.weights > 0.0
    }

    /// One over the probability of the sampled candidate.
    #[inline(always)]
    pub fn inverse_probability(&self) -> f32 {
        if self.weight == self.weights { 1.0 } else { self.weights / self.weight }
    }
}
