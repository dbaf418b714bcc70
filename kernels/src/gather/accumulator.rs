//! The accumulator of a gather. A point has seven words: (low, high) of red, green and blue in [`Quanta`], and the number of
//! photons. An addend is clamped to 2^14 times the flux of a light path by power, so 2^15 addends of that size still fit.

use crate::interface::counters::Counter;
use crate::math::is_finite;
use crate::math::quanta::{MAX_QUANTA, Quanta};
use crate::math::rng::{pcg4d, units};
use crate::platform::Atomics;
use spirv_std::glam::{UVec4, Vec3};

/// Number of words of one point.
pub const WORDS: u32 = 7;

/// Quanta of the largest flux of a light path by power, rounded up to a power of two: 2^34. Paths of aimed and guided emission may
/// have much less.
pub const QUANTA_PER_PATH: f32 = 17_179_869_184.0;

/// Offset by which the addend of a photon to a point is rounded, uniform in [0, 1). Photons that are aimed at a small caster may bring
/// less than half a quantum. Rounded to the nearest integer, all of them would be lost. The offset depends on positions alone, so that
/// all gathers round alike. Exponents are left out, so that a unit of length of another power of two changes no bit.
#[inline(always)]
pub fn rounding_offset(photon: Vec3, point: Vec3) -> f32 {
    let digits = |coordinate: f32| coordinate.to_bits() & 0x807f_ffff;
    let other = digits(point.x) ^ digits(point.y).rotate_left(11) ^ digits(point.z).rotate_left(22);
    units(pcg4d(UVec4::new(digits(photon.x), digits(photon.y), digits(photon.z), other))).x
}

/// The sum of one point's photons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GatheredSum {
    /// Red.
    pub red: Quanta,
    /// Green.
    pub green: Quanta,
    /// Blue.
    pub blue: Quanta,
    /// Photons taken.
    pub count: u32,
    /// Photons of which a channel was clamped.
    pub clamped: u32,
    /// Photons of which a channel was not finite.
    pub non_finite: u32,
}

impl GatheredSum {
    /// Sum of one photon at a position that contributes `value` to a point; `inverse_quantum` is one over the quantum.
    #[inline(always)]
    pub fn new(value: Vec3, inverse_quantum: f32, photon: Vec3, point: Vec3) -> Self {
        GatheredSum::rounded(value, inverse_quantum, rounding_offset(photon, point))
    }

    /// Sum of one photon that contributes `value`, rounded by this offset.
    #[inline]
    fn rounded(value: Vec3, inverse_quantum: f32, offset: f32) -> Self {
        let finite = is_finite(value.x) && is_finite(value.y) && is_finite(value.z);
        let max_quanta = value.x.max(value.y).max(value.z) * inverse_quantum;
        GatheredSum {
            red: Quanta::rounded(value.x, inverse_quantum, offset),
            green: Quanta::rounded(value.y, inverse_quantum, offset),
            blue: Quanta::rounded(value.z, inverse_quantum, offset),
            count: 1,
            clamped: if finite && max_quanta > MAX_QUANTA { 1 } else { 0 },
            non_finite: if finite { 0 } else { 1 },
        }
    }

    /// Adds two sums.
    #[inline]
    pub fn plus(self, other: GatheredSum) -> Self {
        GatheredSum {
            red: self.red.plus(other.red),
            green: self.green.plus(other.green),
            blue: self.blue.plus(other.blue),
            count: self.count + other.count,
            clamped: self.clamped + other.clamped,
            non_finite: self.non_finite + other.non_finite,
        }
    }

    /// Adds the sum to a point's words. Any number of invocations may add at once.
    #[inline]
    pub fn add_to<A: Atomics>(self, words: &mut A, point: u32) {
        let first = point * WORDS;
        self.red.add_to(words, first);
        self.green.add_to(words, first + 2);
        self.blue.add_to(words, first + 4);
        words.add(first + 6, self.count);
    }

    /// Adds its counts to the counters of the frame.
    #[inline(always)]
    pub fn tally<C: Atomics>(self, counters: &mut C) {
        if self.count != 0 {
            counters.add(Counter::Gathered as u32, self.count);
        }
        if self.clamped != 0 {
            counters.add(Counter::Clamped as u32, self.clamped);
        }
        if self.non_finite != 0 {
            counters.add(Counter::NonFinite as u32, self.non_finite);
        }
    }

    /// Reads the sum in a point's words (in the unit of `quantum`) and its number of photons.
    #[inline]
    pub fn read(words: &[u32], point: u32, quantum: f32) -> (Vec3, u32) {
        let first = (point * WORDS) as usize;
        let channel = |i: usize| Quanta { low: words[first + i], high: words[first + i + 1] }.to_f32(quantum);
        (Vec3::new(channel(0), channel(2), channel(4)), words[first + 6])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::platform::AtomicWords;
    use proptest::prelude::*;

    fn to_u64(q: Quanta) -> u64 {
        u64::from(q.high) << 32 | u64::from(q.low)
    }

    proptest! {
        #[test]
        fn words_hold_the_exact_sum(values in prop::collection::vec(0.0f32..1.0e9, 1..200)) {
            let mut words = vec![0u32; 14];
            let mut atomics = AtomicWords::new(&mut words);
            let mut local = GatheredSum::default();
            let mut exact = 0u64;
            for &v in &values {
                let sum = GatheredSum::rounded(Vec3::new(v, 2.0 * v, 0.5), 65_536.0, 0.5);
                sum.add_to(&mut atomics, 1);
                local = local.plus(sum);
                exact += to_u64(Quanta::from_f32(v, 65_536.0));
            }
            prop_assert_eq!(u64::from(words[8]) << 32 | u64::from(words[7]), exact);
            prop_assert_eq!(to_u64(local.red), exact);
            prop_assert_eq!(words[13] as usize, values.len());
            prop_assert_eq!(&words[..7], &[0; 7]);
        }
    }

    #[test]
    fn addend_that_does_not_fit_is_clamped_and_counted() {
        let sum = GatheredSum::rounded(Vec3::new(1.0e30, -1.0, f32::NAN), 1.0, 0.5);
        assert_eq!(
            (sum.red, sum.green, sum.blue),
            (Quanta { low: 0, high: 65_536 }, Quanta::default(), Quanta::default())
        );
        assert_eq!((sum.clamped, sum.non_finite), (0, 1));
        assert_eq!(GatheredSum::rounded(Vec3::new(1.0e30, 0.0, 0.0), 1.0, 0.5).clamped, 1);
        assert_eq!(GatheredSum::rounded(Vec3::new(f32::INFINITY, 0.0, 0.0), 1.0, 0.5).red, Quanta::default());
    }

    /// A twentieth of a quantum is one in twenty photons, not nothing.
    #[test]
    fn the_mean_of_addends_below_a_quantum_is_exact() {
        let count = 100_000;
        let add = |sum: GatheredSum, index: u32| {
            let photon = Vec3::new(index as f32 * 1.0e-4, 0.0, -1.0);
            let point = Vec3::new(0.3, 0.0, -1.1);
            sum.plus(GatheredSum::new(Vec3::new(0.05, 0.5, 1.25), 1.0, photon, point))
        };
        let sum = (0..count).fold(GatheredSum::default(), add);
        for (sum, mean) in [(sum.red, 0.05), (sum.green, 0.5), (sum.blue, 1.25)] {
            let found = sum.to_f32(1.0) / count as f32;
            assert!((found - mean).abs() < 0.005, "{found} {mean}");
        }
    }
}
