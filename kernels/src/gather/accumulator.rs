//! The accumulator: 64-bit fixed point in two words, so that sums commute and no order of threads shows.
//!
//! A point has seven words: (low, high) of red, green, blue, and the number of deposits. The quantum is 2^-24 of the
//! largest flux of a light path; an addend is clamped to 2^24 of it, so 2^16 addends of that size still fit.

use crate::math::is_finite;
use crate::seam::Atomics;
use spirv_std::glam::Vec3;

/// Words of one point.
pub const WORDS: u32 = 7;
/// Largest addend in quanta: 2^48.
const LARGEST: f32 = 281_474_976_710_656.0;
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
    /// `value / quantum`, to the nearest integer; zero for what is not finite or negative, clamped above.
    #[inline]
    pub fn from_f32(value: f32, inverse_quantum: f32) -> Self {
        if !is_finite(value) {
            return Quanta::default();
        }
        let quanta = (value * inverse_quantum + 0.5).clamp(0.0, LARGEST);
        let high = (quanta * (1.0 / WORD)) as u32;
        // Exact: both are multiples of an ulp of `quanta`.
        let low = (quanta - high as f32 * WORD) as u32;
        Quanta { low, high }
    }

    /// The same with a sign, as two's complement.
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

    /// The value [unit of `quantum`].
    #[inline]
    pub fn to_f32(self, quantum: f32) -> f32 {
        (self.high as f32 * WORD + self.low as f32) * quantum
    }

    /// Sum with carry.
    #[inline]
    pub fn plus(self, other: Quanta) -> Self {
        let low = self.low.wrapping_add(other.low);
        let carry = if low < self.low { 1 } else { 0 };
        Quanta { low, high: self.high.wrapping_add(other.high).wrapping_add(carry) }
    }
}

/// The sum of one point's deposits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sum {
    /// Red.
    pub red: Quanta,
    /// Green.
    pub green: Quanta,
    /// Blue.
    pub blue: Quanta,
    /// Deposits taken.
    pub count: u32,
    /// Deposits of which a channel was clamped.
    pub clamped: u32,
    /// Deposits of which a channel was not finite.
    pub non_finite: u32,
}

impl Sum {
    /// One deposit.
    #[inline]
    pub fn of(value: Vec3, inverse_quantum: f32) -> Self {
        let finite = is_finite(value.x) && is_finite(value.y) && is_finite(value.z);
        let most = value.x.max(value.y).max(value.z) * inverse_quantum;
        Sum {
            red: Quanta::from_f32(value.x, inverse_quantum),
            green: Quanta::from_f32(value.y, inverse_quantum),
            blue: Quanta::from_f32(value.z, inverse_quantum),
            count: 1,
            clamped: if finite && most > LARGEST { 1 } else { 0 },
            non_finite: if finite { 0 } else { 1 },
        }
    }

    /// Sum of two.
    #[inline]
    pub fn plus(self, other: Sum) -> Self {
        Sum {
            red: self.red.plus(other.red),
            green: self.green.plus(other.green),
            blue: self.blue.plus(other.blue),
            count: self.count + other.count,
            clamped: self.clamped + other.clamped,
            non_finite: self.non_finite + other.non_finite,
        }
    }

    /// Adds to a point's words; any number of invocations may do so at once.
    #[inline]
    pub fn add_to<A: Atomics>(self, words: &mut A, point: u32) {
        let first = point * WORDS;
        self.red.add_to(words, first);
        self.green.add_to(words, first + 2);
        self.blue.add_to(words, first + 4);
        words.add(first + 6, self.count);
    }

    /// The sum in a point's words [unit of `quantum`] and its number of deposits.
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
    use crate::seam::AtomicWords;
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
        }

        #[test]
        fn words_hold_the_exact_sum(values in prop::collection::vec(0.0f32..1.0e9, 1..200)) {
            let mut words = vec![0u32; 14];
            let mut atomics = AtomicWords::new(&mut words);
            let mut local = Sum::default();
            let mut exact = 0u64;
            for &v in &values {
                let sum = Sum::of(Vec3::new(v, 2.0 * v, 0.5), 65_536.0);
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
    fn what_does_not_fit_is_clamped_and_counted() {
        let sum = Sum::of(Vec3::new(1.0e30, -1.0, f32::NAN), 1.0);
        assert_eq!(
            (sum.red, sum.green, sum.blue),
            (Quanta { low: 0, high: 65_536 }, Quanta::default(), Quanta::default())
        );
        assert_eq!((sum.clamped, sum.non_finite), (0, 1));
        assert_eq!(Sum::of(Vec3::new(1.0e30, 0.0, 0.0), 1.0).clamped, 1);
        assert_eq!(Sum::of(Vec3::new(f32::INFINITY, 0.0, 0.0), 1.0).red, Quanta::default());
    }
}
