//! Light samples of a vertex, by their numbers. A GPU makes all of them before the vertex's lobes, and leaves them in an array:
//! with both at once it runs short of registers. A CPU makes each when it is asked for, and leaves none in memory.

use crate::light::light_sampling::{ByClass, LightSample};

#[cfg(target_arch = "spirv")]
pub use gpu::{Connected, ROOM};

#[cfg(not(target_arch = "spirv"))]
pub use cpu::{Connected, ROOM};

#[cfg(target_arch = "spirv")]
mod gpu {
    use super::{ByClass, LightSample};
    use crate::light::light_sampling::{CANDIDATE_COUNT, FEW_LIGHTS};
    use crate::platform::Record;

    /// Words of one, and of its light.
    const WORDS: usize = 17;

    /// Most that a vertex has: all lights where they are few, else the candidates of one light sample.
    const MAX_COUNT: u32 = if FEW_LIGHTS > CANDIDATE_COUNT { FEW_LIGHTS } else { CANDIDATE_COUNT };

    /// Words of as many.
    pub const ROOM: usize = WORDS * MAX_COUNT as usize;

    /// All of them, in an array.
    pub struct Connected<'a>(&'a mut [u32; ROOM]);

    impl<'a> Connected<'a> {
        /// Makes as many.
        #[inline(always)]
        pub fn new(count: u32, make: impl Fn(u32) -> LightSample, words: &'a mut [u32; ROOM]) -> Self {
            let mut number = 0;
            while number < count {
                put(words, number, &make(number));
                number += 1;
            }
            Connected(words)
        }

        /// The light sample of a number.
        #[inline(always)]
        pub fn get(&self, number: u32) -> LightSample {
            let record = Record::<WORDS, ROOM>::at(number);
            LightSample {
                target: record.take3(self.0, 0),
                to_light: record.take3(self.0, 3),
                radiance_over_pdf: record.take3(self.0, 6),
                pdf_solid_angle: f32::from_bits(record.take(self.0, 9)),
                endless: record.take(self.0, 10) != 0,
            }
        }

        /// What to keep of it and its light while others are looked at: its number.
        #[inline(always)]
        pub fn keep(&mut self, number: u32, _light_sample: LightSample, light: ByClass) -> u32 {
            let record = Record::<WORDS, ROOM>::at(number);
            record.put3(self.0, 11, light.non_specular);
            record.put3(self.0, 14, light.specular);
            number
        }

        /// The one that was kept, and its light.
        #[inline(always)]
        pub fn get_with_light(&self, kept: u32) -> (LightSample, ByClass) {
            let record = Record::<WORDS, ROOM>::at(kept);
            let light =
                ByClass { non_specular: record.take3(self.0, 11), specular: record.take3(self.0, 14) };
            (self.get(kept), light)
        }
    }

    #[inline(always)]
    fn put(words: &mut [u32; ROOM], number: u32, light_sample: &LightSample) {
        let record = Record::<WORDS, ROOM>::at(number);
        record.put3(words, 0, light_sample.target);
        record.put3(words, 3, light_sample.to_light);
        record.put3(words, 6, light_sample.radiance_over_pdf);
        record.put(words, 9, light_sample.pdf_solid_angle.to_bits());
        record.put(words, 10, u32::from(light_sample.endless));
    }
}

#[cfg(not(target_arch = "spirv"))]
mod cpu {
    use super::{ByClass, LightSample};

    /// Nothing is left in memory.
    pub const ROOM: usize = 0;

    /// What makes them.
    pub struct Connected<F>(F);

    impl<F: Fn(u32) -> LightSample> Connected<F> {
        /// Makes none yet.
        #[inline(always)]
        pub fn new(_count: u32, make: F, _words: &mut [u32; ROOM]) -> Self {
            Connected(make)
        }

        /// Makes the light sample of a number.
        #[inline(always)]
        pub fn get(&self, number: u32) -> LightSample {
            (self.0)(number)
        }

        /// What to keep of it and its light while others are looked at: all.
        #[inline(always)]
        pub fn keep(
            &mut self,
            _number: u32,
            light_sample: LightSample,
            light: ByClass,
        ) -> (LightSample, ByClass) {
            (light_sample, light)
        }

        /// The one that was kept, and its light.
        #[inline(always)]
        pub fn get_with_light(&self, kept: (LightSample, ByClass)) -> (LightSample, ByClass) {
            kept
        }
    }
}
