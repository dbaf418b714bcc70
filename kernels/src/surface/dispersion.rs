//! Dispersion: media that refract colours differently (KHR_materials_dispersion).
//!
//! A path that enters one goes on with one channel alone, sampled in proportion to what each carries and divided by its
//! probability: all channels together still carry what they did. From there on no other channel carries anything, so that
//! what a path carries says which it has, and the next such medium finds nothing left to sample.
//!
//! A smooth face reflects all channels the same way: it reflects by the mean of their Fresnel reflectances, weighted by what the
//! path carries of each, and the channel is sampled once the path is transmitted ([`sample`]). So the other lobes of the surface, its
//! collection points and its photons keep all channels too. The facets of a rough face refract each channel to directions of
//! its own, and no lobe there is free of the index: a path has its channel before it scatters ([`needs_channel`], [`part`]). Limitations: what
//! such a face reflects shows the noise of single channels.
//!
//! Channels and no wavelengths: a light path and a camera path that meet multiply what they carry channel by channel, and would
//! have to be of one wavelength to give what a single path finds. The formula is that of the extension's text, whose three
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

/// The channel that a path has, by its position among the indices of refraction.
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

    /// 1 where it is this one, else 0.
    #[inline(always)]
    fn is(self, other: Channel) -> f32 {
        if self.0 == other.0 { 1.0 } else { 0.0 }
    }
}

/// Indices of refraction at a face, of the path's side over the side behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// Of the channel that the path has, or of green.
    pub eta: f32,
    /// Of each channel; all `eta` unless `is_dispersive`.
    pub etas: Vec3,
    /// Share of each channel in what the path carries; they sum to 1. Read only where `is_dispersive`.
    pub carried: Vec3,
    /// Whether the path may still carry several channels, which the face refracts differently.
    pub is_dispersive: bool,
}

impl Indices {
    /// The same index for all channels.
    #[inline(always)]
    pub fn new(eta: f32) -> Indices {
        Indices { eta, etas: Vec3::splat(eta), carried: Vec3::ZERO, is_dispersive: false }
    }

    /// Of a smooth face between two media, for a path that carries `throughput`.
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

/// Whether the face at `vertex`, met inside `media`, refracts channels differently and is rough: a path has its channel before it
/// scatters there.
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

/// Samples a smooth face that refracts channels differently: `u` chooses to reflect or to transmit, `v` the channel of what is
/// transmitted. `reflectances` are those of the channels, `share` is the share of the dielectric and `lobe_probability` that of the
/// lobe among all.
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

    // The channel, in proportion to what the path carries of each behind the face.
    let (channel, single) = part(indices.carried * passed, v);
    let one = Vec3::new(channel.is(Channel::RED), channel.is(Channel::GREEN), channel.is(Channel::BLUE));
    let scale = share / (lobe_probability * (1.0 - reflection_probability));
    let weight = one * (single.element_sum() * scale / indices.carried.dot(one));
    let eta = indices.etas.dot(one);
    // Snell's law: the tangential part scales with eta.
    let cos_behind = (1.0 - eta * eta * (1.0 - cos * cos)).max(0.0).sqrt();
    let direction = Vec3::new(-eta * to_previous.x, -eta * to_previous.y, -cos_behind);
    Sampled { direction: direction.normalize(), weight, transmitted: true, eta, ..reflected }
}

/// Whether several channels carry something.
#[inline(always)]
pub fn is_mixed(carried: Vec3) -> bool {
    carried.max_element() < carried.element_sum()
}

/// The channel that `u`, uniform in [0, 1), samples, and what the path carries then.
#[inline(always)]
pub fn part(carried: Vec3, u: f32) -> (Channel, Vec3) {
    let Vec3 { x: red, y: green, z: blue } = carried;
    let sum = carried.element_sum();
    let at = u * sum;
    // A product may be rounded up to the sum: what carries nothing is never sampled.
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
    fn a_path_keeps_its_channel_whatever_is_drawn() {
        let channels = [Channel::RED, Channel::GREEN, Channel::BLUE];
        for (channel, carried) in channels.into_iter().zip([Vec3::X, Vec3::Y, Vec3::Z]) {
            for carried in [carried, carried * 3.0e-20, carried * 0.3] {
                for u in [0.0, 0.5, 1.0 - 2.0f32.powi(-24)] {
                    assert_eq!(part(carried, u), (channel, carried));
                }
            }
        }
        // Nor is a channel sampled that carries nothing.
        let last = 1.0 - 2.0f32.powi(-24);
        assert_eq!(part(Vec3::new(0.3, 0.7, 0.0), last).0, Channel::GREEN);
        assert_eq!(part(Vec3::new(0.7, 0.0, 0.3), last).0, Channel::BLUE);
        assert_eq!(part(Vec3::new(0.7, 0.0, 0.3), 0.0).0, Channel::RED);
        assert!(is_mixed(Vec3::new(0.7, 0.0, 0.3)));
    }
}
