//! Numbers in few bits, by integer arithmetic alone: every runner rounds alike. Materials of textured surfaces are
//! rounded to what a collection point can store, so that camera paths and light paths see one material.

/// A value in [0, 1] as a half float, to the nearest, without its sign.
#[inline]
pub fn to_half(value: f32) -> u32 {
    if value < 1.0 / 16_384.0 {
        // Below 2^-14 halves are multiples of 2^-24.
        return (value * 16_777_216.0 + 0.5) as u32;
    }
    let bits = value.to_bits();
    let rounded = bits + 0x0fff + ((bits >> 13) & 1);
    (rounded >> 13) - (112 << 10)
}

/// The value of a half float without a sign.
#[inline]
pub fn from_half(half: u32) -> f32 {
    if half < 1 << 10 {
        return half as f32 * (1.0 / 16_777_216.0);
    }
    f32::from_bits((half << 13) + (112 << 23))
}

/// A value in [0, 1] as a share of 255, to the nearest.
#[inline]
pub fn to_byte(value: f32) -> u32 {
    (value * 255.0 + 0.5) as u32
}

/// The value of a share of 255.
#[inline]
pub fn from_byte(byte: u32) -> f32 {
    byte as f32 * (1.0 / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_come_back_and_are_the_nearest() {
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
    fn bytes_come_back() {
        for byte in 0..=255 {
            assert_eq!(to_byte(from_byte(byte)), byte);
        }
    }
}
