//! Light samples of a vertex, by their ids. A GPU makes all of them before the BSDF of the vertex and stores them in an array.
//! Samples and BSDF at once take more registers than a GPU has. A CPU makes each sample when it is needed, and stores none.

use crate::light::light_sampling::{ByClass, LightSample};
use crate::path::PathContext;
use crate::path::light_numbers::LightNumbers;
use spirv_std::glam::Vec3;

#[cfg(target_arch = "spirv")]
pub use gpu::{LightSamples, ROOM};

#[cfg(not(target_arch = "spirv"))]
pub use cpu::{LightSamples, ROOM};

#[cfg(target_arch = "spirv")]
mod gpu {
    use super::{ByClass, LightNumbers, LightSample, PathContext, Vec3};
    use crate::light::light_sampling::{CANDIDATE_COUNT, FEW_LIGHTS};
    use crate::platform::Record;

    /// Number of words of a light sample, and of its light.
    const WORDS: usize = 17;

    /// Largest number of samples at a vertex: all lights where they are few, else the candidates of one light sample.
    const MAX_COUNT: u32 = if FEW_LIGHTS > CANDIDATE_COUNT { FEW_LIGHTS } else { CANDIDATE_COUNT };

    /// Number of words of all samples.
    pub const ROOM: usize = WORDS * MAX_COUNT as usize;

    /// Identifies a sample that is kept while others are made: its id.
    pub type Kept = u32;

    /// All light samples, in an array.
    pub struct LightSamples<'a>(&'a mut [u32; ROOM]);

    impl<'a> LightSamples<'a> {
        /// Makes all samples of a vertex.
        #[inline(always)]
        pub fn new(
            numbers: &LightNumbers,
            position: Vec3,
            context: PathContext<'_>,
            words: &'a mut [u32; ROOM],
        ) -> Self {
            let mut id = 0;
            while id < numbers.count {
                put(words, id, &numbers.sample(id, position, context));
                id += 1;
            }
            LightSamples(words)
        }

        /// Returns the light sample with an id.
        #[inline(always)]
        pub fn get(&self, id: u32) -> LightSample {
            let record = Record::<WORDS, ROOM>::at(id);
            LightSample {
                target: record.take3(self.0, 0),
                to_light: record.take3(self.0, 3),
                radiance_over_pdf: record.take3(self.0, 6),
                pdf_solid_angle: f32::from_bits(record.take(self.0, 9)),
                endless: record.take(self.0, 10) != 0,
            }
        }

        /// Keeps a sample and its light while others are made.
        #[inline(always)]
        pub fn keep(&mut self, id: u32, _light_sample: LightSample, light: ByClass) -> Kept {
            let record = Record::<WORDS, ROOM>::at(id);
            record.put3(self.0, 11, light.non_specular);
            record.put3(self.0, 14, light.specular);
            id
        }

        /// Returns a sample that was kept, and its light.
        #[inline(always)]
        pub fn kept(&self, kept: Kept) -> (LightSample, ByClass) {
            let record = Record::<WORDS, ROOM>::at(kept);
            let light =
                ByClass { non_specular: record.take3(self.0, 11), specular: record.take3(self.0, 14) };
            (self.get(kept), light)
        }
    }

    #[inline(always)]
    fn put(words: &mut [u32; ROOM], id: u32, light_sample: &LightSample) {
        let record = Record::<WORDS, ROOM>::at(id);
        record.put3(words, 0, light_sample.target);
        record.put3(words, 3, light_sample.to_light);
        record.put3(words, 6, light_sample.radiance_over_pdf);
        record.put(words, 9, light_sample.pdf_solid_angle.to_bits());
        record.put(words, 10, u32::from(light_sample.endless));
    }
}

#[cfg(not(target_arch = "spirv"))]
mod cpu {
    use super::{ByClass, LightNumbers, LightSample, PathContext, Vec3};

    /// No words: a CPU stores no sample.
    pub const ROOM: usize = 0;

    /// A sample that is kept while others are made, and its light.
    pub type Kept = (LightSample, ByClass);

    /// Makes light samples.
    pub struct LightSamples<'a> {
        numbers: LightNumbers,
        position: Vec3,
        context: PathContext<'a>,
    }

    impl<'a> LightSamples<'a> {
        /// Makes no sample yet. A closure in place of the fields would not be inlined, nor compiled for AVX2.
        #[inline(always)]
        pub fn new(
            numbers: &LightNumbers,
            position: Vec3,
            context: PathContext<'a>,
            _words: &mut [u32; ROOM],
        ) -> Self {
            LightSamples { numbers: *numbers, position, context }
        }

        /// Makes the light sample with an id.
        #[inline(always)]
        pub fn get(&self, id: u32) -> LightSample {
            self.numbers.sample(id, self.position, self.context)
        }

        /// Keeps a sample and its light while others are made.
        #[inline(always)]
        pub fn keep(&mut self, _id: u32, light_sample: LightSample, light: ByClass) -> Kept {
            (light_sample, light)
        }

        /// Returns a sample that was kept, and its light.
        #[inline(always)]
        pub fn kept(&self, kept: Kept) -> (LightSample, ByClass) {
            kept
        }
    }
}
