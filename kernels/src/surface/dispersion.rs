//! Dispersion: media that refract colours differently (KHR_materials_dispersion).
//!
//! A path that enters such a medium goes on with one channel alone. The channel is sampled in proportion to what each carries,
//! and divided by its probability: all channels together carry the same in expectation. From there on no other channel carries
//! anything. The light that a path carries therefore tells its channel, and the next such medium has nothing left to sample.
//!
//! A smooth face reflects all channels the same way. It reflects by the mean of their Fresnel reflectances, weighted by what the
//! path carries of each. The channel is sampled once the path is transmitted ([`sample`]). The other lobes of the surface, its
//! collection points and its photons thus keep all channels. The facets of a rough face refract each channel to directions of its
//! own, and no lobe there is free of the index. A path has its channel before it scatters there ([`needs_channel`], [`part`]).
//! Limitations: light that such a face reflects shows the noise of single channels.
//!
//! The renderer disperses channels, not wavelengths. A light path and a camera path that meet multiply what they carry channel by
//! channel; two paths of different wavelengths could not be joined. The formula is that of the extension's text, whose three
//! indices are those of the Fraunhofer lines C, d and F. Limitations: a point source shows three images and no continuum.

use crate::interface::features::Features;
use crate::interface::material::Material;
use crate::surface::class::Classes;
use crate::surface::media::MediaStack;
use crate::surface::vertex::Vertex;
use crate::surface::{Sampled, fresnel, ggx};
use spirv_std::glam::Vec3;
#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Channel that a path has, by its position among the indices of refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel(f32);

impl Channel {
    /// Red: 656.3 nm.
    pub const RED: Channel = Channel(-1.0);
    /// Green: 587.6 nm, `Material::ior` itself. A path that no medium has parted has this one, too.
    pub const GREEN: Channel = Channel(0.0);
    /// Blue: 486.1 nm.
    pub const BLUE: Channel = Channel(1.0);

    /// Index of refraction of a medium in this channel. Red and blue differ by (n_d - 1) / Abbe number.
    #[inline(always)]
    pub fn ior(self, material: &Material) -> f32 {
        let half_spread = (material.ior - 1.0) * (0.025 * material.dispersion);
        (material.ior + self.0 * half_spread).max(1.0)
    }

    /// 1 if it is this channel, else 0.
    #[inline(always)]
    fn is(self, other: Channel) -> f32 {
        if self.0 == other.0 { 1.0 } else { 0.0 }
    }
}

/// Ratios of the indices of refraction at a face: the path's side over the side behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// Ratio in the channel that the path has, or in green.
    pub eta: f32,
    /// Ratio in each channel; all `eta` unless `is_dispersive`.
    pub etas: Vec3,
    /// Share of each channel in what the path carries; they sum to 1. Read only where `is_dispersive`.
    pub carried: Vec3,
    /// Whether the path may still carry several channels, which the face refracts differently.
    pub is_dispersive: bool,
}

impl Indices {
    /// One ratio for all channels.
    #[inline(always)]
    pub fn new(eta: f32) -> Indices {
        Indices { eta, etas: Vec3::splat(eta), carried: Vec3::ZERO, is_dispersive: false }
    }

    /// Ratios at a smooth face between two media, for a path that carries `throughput`.
    #[inline(always)]
    pub fn dispersive(
        before: MediaStack,
        behind: MediaStack,
        throughput: Vec3,
        features: Features,
        materials: &[Material],
    ) -> Indices {
        let etas = before.iors(features, materials) / behind.iors(features, materials);
        let sum = throughput.element_sum();
        let carried = if sum > 0.0 { throughput / sum } else { Vec3::splat(1.0 / 3.0) };
        Indices { eta: etas.y, etas, carried, is_dispersive: true }
    }

    /// Mean over channels of a share, by what the path carries of each.
    #[inline(always)]
    pub fn mean(&self, shares: Vec3) -> f32 {
        self.carried.dot(shares)
    }
}

/// Fresnel reflectance of each channel, by its index of refraction.
#[inline(always)]
pub fn reflectances(cos: f32, etas: Vec3) -> Vec3 {
    let Vec3 { x: red, y: green, z: blue } = etas;
    Vec3::new(
        fresnel::dielectric_reflectance(cos, red),
        fresnel::dielectric_reflectance(cos, green),
        fresnel::dielectric_reflectance(cos, blue),
    )
}

/// Whether the face at `vertex`, met inside `media`, is rough and refracts channels differently. A path must have its channel
/// before it scatters there.
#[inline(always)]
pub fn needs_channel(
    vertex: &Vertex,
    material: &Material,
    materials: &[Material],
    media: MediaStack,
    features: Features,
) -> bool {
    if !features.has(Features::DISPERSION)
        || material.roughness < ggx::DELTA_ROUGHNESS
        || !materials[vertex.material as usize].is_medium()
    {
        return false;
    }
    let around = media.settled(features, materials);
    let sides = around.at_face(vertex.material, vertex.front, features, materials);
    sides.before.disperses(materials) || sides.behind.disperses(materials)
}

/// Samples a smooth face that refracts channels differently: `u` chooses to reflect or to transmit, `v` the channel of
/// transmitted light. `reflectances` are those of the channels. `share` is that of the dielectric in the material,
/// `lobe_probability` that of the lobe among all.
#[inline(always)]
pub fn sample(
    tint: Vec3,
    to_previous: Vec3,
    indices: Indices,
    reflectances: Vec3,
    share: f32,
    lobe_probability: f32,
    u: f32,
    v: f32,
) -> Sampled {
    let passed = tint * (Vec3::ONE - reflectances);
    let (reflected_mean, passed_mean) = (indices.mean(reflectances), indices.mean(passed));
    let reflection_probability = reflected_mean / (reflected_mean + passed_mean);
    let cos = to_previous.z;
    let reflected = Sampled {
        direction: Vec3::new(-to_previous.x, -to_previous.y, cos),
        weight: reflectances * (share / (lobe_probability * reflection_probability)),
        pdf_solid_angle: 0.0,
        class: Classes::SPECULAR,
        transmitted: false,
        straight: false,
        eta: indices.eta,
        roughness: 0.0,
    };
    if u < reflection_probability {
        return reflected;
    }

    // Sample the channel, in proportion to what the path carries of each behind the face.
    let (channel, single) = part(indices.carried * passed, v);
    let one = Vec3::new(channel.is(Channel::RED), channel.is(Channel::GREEN), channel.is(Channel::BLUE));
    let scale = share / (lobe_probability * (1.0 - reflection_probability));
    let weight = one * (single.element_sum() * scale / indices.carried.dot(one));
    let eta = indices.etas.dot(one);
    // Refract by Snell's law: the tangential part scales with eta.
    let cos_behind = (1.0 - eta * eta * (1.0 - cos * cos)).max(0.0).sqrt();
    let direction = Vec3::new(-eta * to_previous.x, -eta * to_previous.y, -cos_behind);
    Sampled { direction: direction.normalize(), weight, transmitted: true, eta, ..reflected }
}

/// Whether several channels carry something.
#[inline(always)]
pub fn is_mixed(carried: Vec3) -> bool {
    carried.max_element() < carried.element_sum()
}

/// Samples the channel of a path by `u`, uniform in [0, 1). Returns it, and what the path carries then.
#[inline(always)]
pub fn part(carried: Vec3, u: f32) -> (Channel, Vec3) {
    let Vec3 { x: red, y: green, z: blue } = carried;
    let sum = carried.element_sum();
    let at = u * sum;
    // The product may be rounded up to the sum: never sample a channel that carries nothing.
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
    fn indices_match_the_extension_for_crown_glass() {
        // Crown glass: Abbe number 59.
        let crown = Material { ior: 1.52, dispersion: 20.0 / 59.0, ..Material::default() };
        let [red, green, blue] = [Channel::RED, Channel::GREEN, Channel::BLUE].map(|c| c.ior(&crown));
        assert!(((green - 1.0) / (blue - red) - 59.0).abs() < 0.01);
        assert!(green == 1.52 && (0.5 * (red + blue) - green).abs() < 1e-6 && red < blue);
        // Indices are at least that of vacuum.
        let extreme = Material { dispersion: 100.0, ..crown };
        assert_eq!(Channel::RED.ior(&extreme), 1.0);
        assert_eq!(Channel::RED.ior(&Material { dispersion: 0.0, ..crown }), 1.52);
    }

    #[test]
    fn channels_are_sampled_by_what_they_carry_and_keep_the_sum() {
        let carried = Vec3::new(0.5, 0.125, 0.375);
        let samples = 1 << 12;
        let mut mean = Vec3::ZERO;
        for sample in 0..samples {
            let (_, single) = part(carried, sample as f32 / samples as f32);
            assert_eq!(single.element_sum(), 1.0);
            assert!(!is_mixed(single));
            mean += single / samples as f32;
        }
        assert_eq!(mean, carried);
    }

    #[test]
    fn a_path_of_one_channel_keeps_it_for_every_u() {
        let channels = [Channel::RED, Channel::GREEN, Channel::BLUE];
        for (channel, carried) in channels.into_iter().zip([Vec3::X, Vec3::Y, Vec3::Z]) {
            for carried in [carried, carried * 3.0e-20, carried * 0.3] {
                for u in [0.0, 0.5, 1.0 - 2.0f32.powi(-24)] {
                    assert_eq!(part(carried, u), (channel, carried));
                }
            }
        }
        // A channel that carries nothing is not sampled.
        let last = 1.0 - 2.0f32.powi(-24);
        assert_eq!(part(Vec3::new(0.3, 0.7, 0.0), last).0, Channel::GREEN);
        assert_eq!(part(Vec3::new(0.7, 0.0, 0.3), last).0, Channel::BLUE);
        assert_eq!(part(Vec3::new(0.7, 0.0, 0.3), 0.0).0, Channel::RED);
        assert!(is_mixed(Vec3::new(0.7, 0.0, 0.3)));
    }
}
