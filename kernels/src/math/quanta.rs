//! 64-bit fixed point in two words: sums commute, and do not depend on the order of threads.

use crate::math::{clamp, is_finite};
use crate::platform::{Atomics, Words};
use caustics_kernel_macros::shared;
use spirv_std::glam::{UVec3, Vec3};

/// Largest addend in quanta: 2^48.
pub const MAX_QUANTA: f32 = 281_474_976_710_656.0;
/// 2^32.
const WORD: f32 = 4_294_967_296.0;

/// A 64-bit integer of quanta.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quanta {
    /// Low word.
    pub low: u32,
    /// High word.
    pub high: u32,
}

impl Quanta {
    /// Converts `value / quantum` to the nearest integer; zero if it is negative or not finite, clamped above.
    #[inline]
    pub fn from_f32(value: f32, inverse_quantum: f32) -> Self {
        Quanta::rounded(value, inverse_quantum, 0.5)
    }

    /// Converts `value / quantum` plus an offset below 1 to the integer below; zero if it is negative or not finite, clamped above. An
    /// offset that is uniform in [0, 1) makes it unbiased.
    #[shared]
    pub fn rounded(value: f32, inverse_quantum: f32, offset: f32) -> Self {
        if !is_finite(value) {
            return Quanta::default();
        }
        let quanta = clamp(value * inverse_quantum + offset, 0.0, MAX_QUANTA);
        Quanta::from_whole(quanta)
    }

    /// Converts a float below 2^63, without its fraction.
    #[cfg(not(target_arch = "spirv"))]
    #[inline]
    fn from_whole(quanta: f32) -> Self {
        let whole = quanta as i64;
        Quanta { low: whole as u32, high: (whole >> 32) as u32 }
    }

    /// Converts a float below 2^63, without its fraction, where integers have 32 bits.
    #[cfg(target_arch = "spirv")]
    fn from_whole(quanta: f32) -> Self {
        let high = (quanta * (1.0 / WORD)) as u32;
        // Exact: both are multiples of an ulp of `quanta`.
        let low = (quanta - high as f32 * WORD) as u32;
        Quanta { low, high }
    }

    /// Converts `value / quantum` with its sign, as two's complement.
    #[inline]
    pub fn from_signed(value: f32, inverse_quantum: f32) -> Self {
        let magnitude = Quanta::from_f32(value.abs(), inverse_quantum);
        if value >= 0.0 {
            return magnitude;
        }
        let carry = if magnitude.low == 0 { 1 } else { 0 };
        Quanta { low: (!magnitude.low).wrapping_add(1), high: (!magnitude.high).wrapping_add(carry) }
    }

    /// Adds to the two words at `first`; any number of invocations may do so at once.
    #[inline]
    pub fn add_to<A: Atomics>(self, words: &mut A, first: u32) {
        let before = words.add(first, self.low);
        let carry = if before.wrapping_add(self.low) < before { 1 } else { 0 };
        let high = self.high.wrapping_add(carry);
        if high != 0 {
            words.add(first + 1, high);
        }
    }

    /// Value [unit of `quantum`].
    #[inline]
    pub fn to_f32(self, quantum: f32) -> f32 {
        (self.high as f32 * WORD + self.low as f32) * quantum
    }

    /// Value of two's complement [unit of `quantum`].
    #[inline]
    pub fn to_signed(self, quantum: f32) -> f32 {
        if self.high < 0x8000_0000 {
            return self.to_f32(quantum);
        }
        let carry = if self.low == 0 { 1 } else { 0 };
        let magnitude = Quanta { low: (!self.low).wrapping_add(1), high: (!self.high).wrapping_add(carry) };
        -magnitude.to_f32(quantum)
    }

    /// Sum with carry.
    #[inline]
    pub fn plus(self, other: Quanta) -> Self {
        let low = self.low.wrapping_add(other.low);
        let carry = if low < self.low { 1 } else { 0 };
        Quanta { low, high: self.high.wrapping_add(other.high).wrapping_add(carry) }
    }
}

/// Quanta of a color.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ColorQuanta {
    /// Red.
    pub red: Quanta,
    /// Green.
    pub green: Quanta,
    /// Blue.
    pub blue: Quanta,
}

impl ColorQuanta {
    /// Number of words.
    pub const WORDS: u32 = 6;

    /// Makes a color of integers below 2^32.
    #[inline]
    pub fn new(color: UVec3) -> ColorQuanta {
        let quanta = |low| Quanta { low, high: 0 };
        ColorQuanta { red: quanta(color.x), green: quanta(color.y), blue: quanta(color.z) }
    }

    /// Reads the words at `first`.
    #[inline]
    pub fn read<W: Words>(words: &W, first: u32) -> ColorQuanta {
        let quanta = |word| Quanta { low: words.get(first + word), high: words.get(first + word + 1) };
        ColorQuanta { red: quanta(0), green: quanta(2), blue: quanta(4) }
    }

    /// Sum.
    #[inline]
    pub fn plus(self, other: ColorQuanta) -> ColorQuanta {
        ColorQuanta {
            red: self.red.plus(other.red),
            green: self.green.plus(other.green),
            blue: self.blue.plus(other.blue),
        }
    }

    /// Adds to the words at `first`; any number of invocations may do so at once.
    #[inline]
    pub fn add_to<A: Atomics>(self, words: &mut A, first: u32) {
        self.red.add_to(words, first);
        self.green.add_to(words, first + 2);
        self.blue.add_to(words, first + 4);
    }

    /// Value [unit of `quantum`].
    #[inline]
    pub fn to_vec3(self, quantum: f32) -> Vec3 {
        Vec3::new(self.red.to_f32(quantum), self.green.to_f32(quantum), self.blue.to_f32(quantum))
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
        fn conversion_is_the_nearest_integer(quanta in 0.0f32..2.0e14) {
            let exact = (f64::from(quanta) + 0.5).floor();
            let got = to_u64(Quanta::from_f32(quanta, 1.0)) as f64;
            // quanta + 0.5 is itself rounded to an f32.
            prop_assert!((got - exact).abs() <= f64::from(quanta) * 1.2e-7 + 1.0);
        }

        #[test]
        fn signed_words_hold_the_exact_sum(values in prop::collection::vec(-1.0e9f32..1.0e9, 1..200)) {
            let mut words = [0u32; 2];
            let mut atomics = AtomicWords::new(&mut words);
            let mut exact = 0i64;
            for &v in &values {
                Quanta::from_signed(v, 65_536.0).add_to(&mut atomics, 0);
                let magnitude = to_u64(Quanta::from_f32(v.abs(), 65_536.0)) as i64;
                exact += if v < 0.0 { -magnitude } else { magnitude };
            }
            prop_assert_eq!((u64::from(words[1]) << 32 | u64::from(words[0])) as i64, exact);
            let found = Quanta { low: words[0], high: words[1] }.to_signed(1.0);
            // Each word is rounded to an f32.
            prop_assert!((f64::from(found) - exact as f64).abs() <= 3e-7 * exact.abs() as f64);
        }
    }
}
