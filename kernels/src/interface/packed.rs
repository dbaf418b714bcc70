//! Numbers in few bits, by integer arithmetic alone, so that every runner rounds alike. Materials of textured surfaces are
//! rounded to the precision of a collection point, so that camera paths and light paths see one material.

use caustics_kernel_macros::shared;
use spirv_std::glam::{UVec3, Vec2, Vec3};

/// Converts a value in [0, 1] to the nearest half float, without its sign.
#[shared]
pub fn to_half(value: f32) -> u32 {
    if value < 1.0 / 16_384.0 {
        // Below 2^-14 halves are multiples of 2^-24.
        return (value * 16_777_216.0 + 0.5) as u32;
    }
    let bits = value.to_bits();
    let rounded = bits + 0x0fff + ((bits >> 13) & 1);
    (rounded >> 13) - (112 << 10)
}

/// Converts a half float without a sign to its value.
#[shared]
pub fn from_half(half: u32) -> f32 {
    if half < 1 << 10 {
        return half as f32 * (1.0 / 16_777_216.0);
    }
    f32::from_bits((half << 13) + (112 << 23))
}

/// Converts a color without negative channels to three bytes and a common exponent [Ward 1991, Real pixels]. Rounds down after adding
/// `offsets`, which are in [0, 1): uniform ones keep the mean of colors, also that of dark channels. Below 2^-119 all is zero. Colors
/// must be below 2^126. No color gives a word of ones.
#[shared]
pub fn to_rgbe(color: Vec3, offsets: Vec3) -> u32 {
    let max = color.max_element();
    // The exponent of the power of two above the largest channel, biased by 126
    let mut exponent = max.to_bits() >> 23;
    if exponent < 8 {
        return 0;
    }
    let mut scale = f32::from_bits((261 - exponent) << 23);
    if max * scale + 1.0 >= 256.0 {
        exponent += 1;
        scale *= 0.5;
    }
    let steps = color * scale + offsets;
    steps.x as u32 | (steps.y as u32) << 8 | (steps.z as u32) << 16 | exponent << 24
}

/// Converts a word of [`to_rgbe`] to its color.
#[shared]
pub fn from_rgbe(word: u32) -> Vec3 {
    let exponent = word >> 24;
    if exponent < 8 {
        return Vec3::ZERO;
    }
    let scale = f32::from_bits((exponent - 7) << 23);
    Vec3::new((word & 255) as f32, (word >> 8 & 255) as f32, (word >> 16 & 255) as f32) * scale
}

/// Exponent of a word of [`to_rgbe`].
#[inline(always)]
pub fn exponent(word: u32) -> u32 {
    word >> 24
}

/// Shift of a mantissa of the largest exponent in [`rgbe_quanta`].
const LARGEST_SHIFT: u32 = 23;

/// Converts a word of [`to_rgbe`] to integers, whose sums do not depend on an order. Their unit is [`rgbe_quantum`] of the largest
/// exponent of all words.
#[inline(always)]
pub fn rgbe_quanta(word: u32, largest: u32) -> UVec3 {
    let mantissas = UVec3::new(word & 255, word >> 8 & 255, word >> 16 & 255);
    let below = largest - exponent(word);
    if below <= LARGEST_SHIFT {
        mantissas << (LARGEST_SHIFT - below)
    } else {
        mantissas >> (below - LARGEST_SHIFT).min(31)
    }
}

/// Smallest largest exponent with which [`rgbe_quanta`] are summed: that of 1e-25. Words below it are of no light.
pub const MIN_EXPONENT: u32 = 43;

/// Unit of [`rgbe_quanta`] for a largest exponent from 31 on.
#[inline(always)]
pub fn rgbe_quantum(largest: u32) -> f32 {
    f32::from_bits((largest - 7 - LARGEST_SHIFT) << 23)
}

/// Converts two values to floats of 16 bits with the exponents of `f32` (bfloat16), rounded towards zero.
#[inline(always)]
pub fn to_bfloats(first: f32, second: f32) -> u32 {
    first.to_bits() >> 16 | second.to_bits() & 0xffff_0000
}

/// Converts a word of [`to_bfloats`] to its values.
#[inline(always)]
pub fn from_bfloats(word: u32) -> (f32, f32) {
    (f32::from_bits(word << 16), f32::from_bits(word & 0xffff_0000))
}

/// Converts a value in [0, 1] to the nearest share of 255.
#[inline]
pub fn to_byte(value: f32) -> u32 {
    (value * 255.0 + 0.5) as u32
}

/// Converts a share of 255 to its value.
#[inline]
pub fn from_byte(byte: u32) -> f32 {
    byte as f32 * (1.0 / 255.0)
}

/// Converts two values in [-1, 1] to the nearest shares of 32767.
#[inline]
pub fn to_signed_shares(values: Vec2) -> u32 {
    let share = |value: f32| {
        // Truncation is towards zero, so half a step rounds to the nearest.
        let steps = value * 32_767.0;
        (steps + if steps < 0.0 { -0.5 } else { 0.5 }) as i32 as u32 & 0xffff
    };
    share(values.x) | share(values.y) << 16
}

/// Converts two signed shares of 32767 to their values.
#[inline]
pub fn from_signed_shares(word: u32) -> Vec2 {
    // A shift to the right repeats the sign.
    let share = |shares: u32| (shares as i32 >> 16) as f32 * (1.0 / 32_767.0);
    Vec2::new(share(word << 16), share(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signed_shares_round_trip_and_are_the_nearest() {
        assert_eq!(to_signed_shares(Vec2::ZERO), 0);
        for step in -32_767..=32_767 {
            let value = step as f32 / 32_767.0;
            for values in [Vec2::new(value, -value), Vec2::new(0.3, value), Vec2::new(value, -1.0)] {
                let off = |values: Vec2| from_signed_shares(to_signed_shares(values)) - values;
                // Half a step of rounding, and ulps.
                assert!(off(values).abs().max_element() < 1.0e-7 + 0.5 / 32_767.0);
                assert!(off(Vec2::splat(value)).abs().max_element() < 1.0e-7, "a share itself is exact");
            }
        }
    }

    #[test]
    fn colors_round_trip_within_a_step_of_their_largest_channel() {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(0x2c92_77b5).wrapping_add(0xac56_4b05);
            (state >> 8) as f32 / 16_777_216.0
        };
        let mut sum = (Vec3::ZERO, Vec3::ZERO);
        for _ in 0..100_000 {
            let unit = Vec3::new(next(), next(), 0.001 * next());
            let offsets = Vec3::new(next(), next(), next());
            for scale in [1.0e-30, 1.0, 1.0e30] {
                let color = unit * scale;
                let back = from_rgbe(to_rgbe(color, offsets));
                assert!((back - color).abs().max_element() <= color.max_element() / 127.0, "{color} {back}");
                if scale == 1.0 {
                    sum = (sum.0 + color, sum.1 + back);
                }
            }
        }
        let error = (sum.1 / sum.0 - Vec3::ONE).abs().max_element();
        assert!(error < 0.02, "offsets keep the sum: {error}");
        assert_eq!(to_rgbe(Vec3::ZERO, Vec3::ZERO), 0);
        let bright = Vec3::new(255.9, 1.0, 0.0);
        assert_eq!(from_rgbe(to_rgbe(bright, Vec3::splat(0.5))), Vec3::new(256.0, 2.0, 0.0));
        assert!(to_rgbe(Vec3::splat(8.0e37), Vec3::splat(0.99)) >> 24 < 255);
    }

    #[test]
    fn words_of_three_bytes_and_an_exponent_are_integers_of_a_common_quantum() {
        let color = Vec3::new(1.0, 0.3, 0.0001);
        let largest = exponent(to_rgbe(1.0e4 * color, Vec3::splat(0.5)));
        for scale in [1.0e4, 1.0, 1.0e-1] {
            let word = to_rgbe(scale * color, Vec3::splat(0.5));
            let value = rgbe_quanta(word, largest).as_vec3() * rgbe_quantum(largest);
            assert_eq!(value, from_rgbe(word));
        }
        let small = to_rgbe(1.0e-5 * color, Vec3::splat(0.5));
        let value = rgbe_quanta(small, largest).as_vec3() * rgbe_quantum(largest);
        assert!((value - from_rgbe(small)).abs().max_element() < rgbe_quantum(largest));
        assert_eq!(rgbe_quanta(0, largest), UVec3::ZERO);
    }

    #[test]
    fn halves_round_trip_and_are_the_nearest() {
        for half in 0..=0x3c00 {
            assert_eq!(to_half(from_half(half)), half);
        }
        assert_eq!((from_half(0x3c00), from_half(0x3800), from_half(1)), (1.0, 0.5, 2.0_f32.powi(-24)));
        for step in 0..=100_000 {
            let value = step as f32 / 100_000.0;
            let half = to_half(value);
            let error = |half: u32| (f64::from(from_half(half)) - f64::from(value)).abs();
            assert!(error(half) <= error(half + 1) && (half == 0 || error(half) <= error(half - 1)));
        }
    }

    #[test]
    fn bytes_round_trip() {
        for byte in 0..=255 {
            assert_eq!(to_byte(from_byte(byte)), byte);
        }
    }
}
