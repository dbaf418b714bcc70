//! Random numbers of the light samples of a vertex.

use super::PathContext;
use crate::light::light_sampling::{LightCandidates, LightSample};
use spirv_std::glam::{Vec3, Vec4};

/// Random numbers of the light samples of a vertex.
#[derive(Clone, Copy)]
pub struct LightNumbers {
    /// Light samples and their candidates.
    pub candidates: LightCandidates,
    /// Number of candidates of all light samples.
    pub count: u32,
    /// Numbers that all candidates share, shifted.
    pub u: Vec4,
    /// Number by which one of several candidates is chosen.
    pub choice: f32,
}

impl LightNumbers {
    /// Samples the candidate with this id.
    #[inline(always)]
    pub fn sample(&self, id: u32, position: Vec3, context: PathContext<'_>) -> LightSample {
        let PathContext { params, features, scene } = context;
        self.candidates.sample_light(id, scene, params.light_count, features, position, self.u)
    }
}
