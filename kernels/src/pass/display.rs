//! `display`: scene-linear radiance to display-referred colour.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
use crate::interface::frame::FrameParams;
use crate::platform::Slots;
use spirv_std::glam::Vec3;

/// Display colours of the whole image.
#[pass(name = "display", over = params.pixel_count(), work = Display)]
pub fn display(
    pixel: u32,
    params: &FrameParams,
    path_radiance: &[Vec3],
    #[len = params.pixel_count()] caustic_radiance: &[Vec3],
    mut display_color: Slots<'_, Vec3>,
) {
    let radiance = path_radiance[pixel as usize] + caustic_radiance[pixel as usize];
    display_color.write(pixel, tone_mapped(radiance, params.exposure));
}

/// Display colour in 0..=1: exposure, a filmic curve (rational fit to ACES [Narkowicz 2015]), sRGB encoding.
#[inline(always)]
pub fn tone_mapped(radiance: Vec3, exposure: f32) -> Vec3 {
    let x = radiance.max(Vec3::ZERO).min(Vec3::splat(1.0e6)) * exposure;
    let curve =
        (x * (x * 2.51 + Vec3::splat(0.03))) / (x * (x * 2.43 + Vec3::splat(0.59)) + Vec3::splat(0.14));
    let linear = curve.clamp(Vec3::ZERO, Vec3::ONE);
    Vec3::new(encode(linear.x), encode(linear.y), encode(linear.z))
}

/// sRGB transfer function.
#[inline(always)]
fn encode(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_stays_black_and_bright_stays_below_one() {
        assert_eq!(tone_mapped(Vec3::ZERO, 1.0), Vec3::ZERO);
        let white = tone_mapped(Vec3::splat(1.0e30), 1.0);
        assert!(white.max_element() <= 1.0 && white.min_element() > 0.99);
        assert!(tone_mapped(Vec3::splat(0.2), 1.0).x < tone_mapped(Vec3::splat(0.3), 1.0).x);
        assert!(tone_mapped(Vec3::splat(0.2), 1.0).x < tone_mapped(Vec3::splat(0.2), 2.0).x);
    }
}
