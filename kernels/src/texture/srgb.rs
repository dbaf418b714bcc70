//! Transfer function of sRGB without a power: an approximation that every runner computes alike.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Linear value of an encoded value in [0, 1]; relative error below 3e-6.
#[inline]
pub fn to_linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 {
        return encoded * (1.0 / 12.92);
    }
    let x = (encoded + 0.055) * (1.0 / 1.055);
    // x^2.4 = x^2 s^0.8 with s = sqrt(x). The polynomial minimises the largest relative error over s in [0.3, 1].
    let s = x.sqrt();
    let power = 0.031_369_135
        + s * (1.386_490_6
            + s * (-1.032_55
                + s * (1.302_936_2 + s * (-1.132_436_5 + s * (0.565_830_05 - s * 0.121_641_6)))));
    x * x * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn to_linear_matches_the_standard() {
        for byte in 0..=255 {
            let encoded = f64::from(byte) / 255.0;
            let exact =
                if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
            let got = f64::from(to_linear(byte as f32 / 255.0));
            assert!((got - exact).abs() <= 3e-6 * exact, "{byte}: {got} {exact}");
        }
    }
}
