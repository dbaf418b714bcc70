//! Dispersion: media that bend colours differently (KHR_materials_dispersion).
//!
//! A path that meets one goes on with one channel alone, drawn in proportion to what each carries and divided by its
//! chance: all channels together still carry what they did. From there on no other channel carries anything, so that what
//! a path carries says which it has, and the next such medium finds nothing left to draw.
//!
//! Channels and no wavelengths: a light path and a camera path that meet multiply what they carry channel by channel, and would
//! have to be of one wavelength to give what a single path finds. The formula is that of the extension's text, whose three
//! indices are those of the Fraunhofer lines C, d and F. Wrong: a point source shows three images and no continuum.

use crate::interface::material::Material;
use spirv_std::glam::Vec3;

/// The channel that a path has, by its place among the indices of refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel(f32);

impl Channel {
    /// 656.3 nm.
    pub const RED: Channel = Channel(-1.0);
    /// 587.6 nm: `Material::ior` itself, also that of a path that no medium has parted.
    pub const GREEN: Channel = Channel(0.0);
    /// 486.1 nm.
    pub const BLUE: Channel = Channel(1.0);

    /// Index of refraction of a medium: (n_d - 1) / Abbe number between red and blue.
    #[inline(always)]
    pub fn ior(self, material: &Material) -> f32 {
        let half_spread = (material.ior - 1.0) * (0.025 * material.dispersion);
        (material.ior + self.0 * half_spread).max(1.0)
    }
}

/// Whether several channels carry something.
#[inline(always)]
pub fn is_mixed(carried: Vec3) -> bool {
    carried.max_element() < carried.element_sum()
}

/// The channel that `u`, uniform in [0, 1), draws, and what the path carries then.
#[inline(always)]
pub fn part(carried: Vec3, u: f32) -> (Channel, Vec3) {
    let Vec3 { x: red, y: green, z: blue } = carried;
    let sum = carried.element_sum();
    let at = u * sum;
    // A product may be rounded up to the sum: what carries nothing is never drawn.
    if at < red || green + blue <= 0.0 {
        (Channel::RED, Vec3::new(sum, 0.0, 0.0))
    } else if at < red + green || blue <= 0.0 {
        (Channel::GREEN, Vec3::new(0.0, sum, 0.0))
    } else {
        (Channel::BLUE, Vec3::new(0.0, 0.0, sum))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_those_of_the_extension() {
        // Crown glass: Abbe number 59.
        let crown = Material { ior: 1.52, dispersion: 20.0 / 59.0, ..Material::default() };
        let [red, green, blue] = [Channel::RED, Channel::GREEN, Channel::BLUE].map(|c| c.ior(&crown));
        assert!(((green - 1.0) / (blue - red) - 59.0).abs() < 0.01);
        assert!(green == 1.52 && (0.5 * (red + blue) - green).abs() < 1e-6 && red < blue);
        // As far as there is nothing denser than vacuum.
        let extreme = Material { dispersion: 100.0, ..crown };
        assert_eq!(Channel::RED.ior(&extreme), 1.0);
        assert_eq!(Channel::RED.ior(&Material { dispersion: 0.0, ..crown }), 1.52);
    }

    #[test]
    fn channels_are_drawn_as_often_as_they_carry_and_keep_the_sum() {
        let carried = Vec3::new(0.5, 0.125, 0.375);
        let draws = 1 << 12;
        let mut mean = Vec3::ZERO;
        for draw in 0..draws {
            let (_, single) = part(carried, draw as f32 / draws as f32);
            assert_eq!(single.element_sum(), 1.0);
            assert!(!is_mixed(single));
            mean += single / draws as f32;
        }
        assert_eq!(mean, carried);
    }

    #[test]
    fn a_path_keeps_its_channel_whatever_is_drawn() {
        let channels = [Channel::RED, Channel::GREEN, Channel::BLUE];
        for (channel, carried) in channels.into_iter().zip([Vec3::X, Vec3::Y, Vec3::Z]) {
            for carried in [carried, carried * 3.0e-20, carried * 0.3] {
                for u in [0.0, 0.5, 1.0 - 2.0f32.powi(-24)] {
                    assert_eq!(part(carried, u), (channel, carried));
                }
            }
        }
        // Nor is a channel drawn that carries nothing.
        let last = 1.0 - 2.0f32.powi(-24);
        assert_eq!(part(Vec3::new(0.3, 0.7, 0.0), last).0, Channel::GREEN);
        assert_eq!(part(Vec3::new(0.7, 0.0, 0.3), last).0, Channel::BLUE);
        assert_eq!(part(Vec3::new(0.7, 0.0, 0.3), 0.0).0, Channel::RED);
        assert!(is_mixed(Vec3::new(0.7, 0.0, 0.3)));
    }
}
