//! `resolve.history`: turns flux into radiance with reused light of the previous frame, and stores light for the next one.

use crate::declare::pass;
use crate::gather::accumulator::{self, GatheredSum};
use crate::history::demodulate::{MIN_REFLECTANCE, demodulated, head_on};
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistoryPoint, HistorySettings, Reprojected};
use crate::interface::material::Material;
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::{PI, octahedral};
use crate::pass::resolve;
use crate::platform::Slots;
use spirv_std::glam::Vec3;

/// Caustic of a pixel, and its part of the history.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blended {
    /// Radiance of the caustic (W m^-2 sr^-1).
    pub radiance: Vec3,
    /// Point, as the next frame finds it.
    pub point: HistoryPoint,
    /// Light that the next frame may reuse (see `Reprojected::mean`).
    pub mean: Vec3,
}

/// Computes the radiance of the caustic at each pixel, blended with reused light.
#[pass(name = "resolve.history", over = params.pixel_count(), work = Resolve)]
pub fn resolve_history(
    pixel: u32,
    params: &FrameParams,
    features: Features,
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    materials: &[Material],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: &[u32],
    reprojected: &[Reprojected],
    mut caustic_radiance: Slots<'_, Vec3>,
    mut history_points: Slots<'_, HistoryPoint>,
    mut history_mean: Slots<'_, Vec3>,
) {
    let i = pixel as usize;
    let (point, shading) = (&point_geometry[i], &point_shading[i]);
    let settings = &params.history;
    let blended =
        blend(pixel, point, shading, materials, accumulator, &reprojected[i], settings, params, features);
    caustic_radiance.write(pixel, blended.radiance);
    history_points.write(pixel, blended.point);
    history_mean.write(pixel, blended.mean);
}

/// Blends the light of this frame with reused light: (n old + new) / (n + 1).
#[inline(always)]
pub fn blend(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    materials: &[Material],
    accumulator: &[u32],
    reprojected: &Reprojected,
    settings: &HistorySettings,
    params: &FrameParams,
    features: Features,
) -> Blended {
    let mut out = Blended::default();
    out.point.position = point.position;
    if !point.exists() {
        return out;
    }
    let (sum, _) = GatheredSum::read(accumulator, pixel, params.quantum);
    // Without history the image is that of `resolve`, to the bit.
    out.radiance = resolve::estimate_radiance(point, shading, sum);
    let fresh = (sum / point.radius) / (PI * point.radius);

    let mut reflectance = Vec3::ONE;
    if settings.demodulates != 0 {
        reflectance = head_on(shading, materials, params, features);
    }
    if reflectance.max_element() < MIN_REFLECTANCE {
        return out;
    }
    let share = 1.0 / (reprojected.samples + 1.0);
    out.mean = demodulated(fresh, reflectance);
    if reprojected.samples > 0.0 {
        out.mean = reprojected.mean + (out.mean - reprojected.mean) * share;
        out.radiance = shading.throughput * reflectance * out.mean;
    }
    out.point = HistoryPoint {
        position: point.position + reprojected.offset * (1.0 - share),
        radius: reprojected.radius,
        normal: octahedral::encode(point.normal),
        to_viewer: octahedral::encode(shading.to_viewer),
        material: shading.material,
        samples: reprojected.samples + 1.0,
    };
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::material::FLAG_COLOR_TEXTURE;
    use crate::math::is_finite;
    use crate::math::rng::{Rng, Stream};
    use crate::math::warp::uniform_sphere;
    use crate::platform::AtomicWords;
    use crate::surface::textured::packed;

    const FEATURES: Features = Features(Features::TEXTURES.0 | Features::COAT.0);
    const DEMODULATES: HistorySettings =
        HistorySettings { search_radius: 1.3, lag: 4.0, max_samples: 1024.0, demodulates: 1 };

    fn params() -> FrameParams {
        FrameParams { quantum: 2.0f32.powi(-40), specular_roughness: 0.25, ..Default::default() }
    }

    /// A Lambertian material with a textured colour, bare and below a coat.
    fn materials() -> [Material; 2] {
        let lambert = Material {
            base_color: Vec3::ONE,
            roughness: 1.0,
            ior: 1.5,
            flags: FLAG_COLOR_TEXTURE,
            ..Material::default()
        };
        [lambert, Material { specular: 1.0, roughness: 0.5, ..lambert }]
    }

    fn point() -> PointGeometry {
        PointGeometry { position: Vec3::new(1.0, 2.0, 3.0), radius: 0.02, normal: Vec3::Y, depth: 1 }
    }

    /// Shading of a texel of a colour.
    fn shading(material: u32, base_color: Vec3) -> PointShading {
        let (red_green, blue) = packed(&Material { base_color, ..materials()[material as usize] });
        PointShading {
            to_viewer: Vec3::new(0.6, 0.8, 0.0),
            material,
            shading_normal: Vec3::Y,
            red_green,
            throughput: Vec3::new(0.9, 0.7, 0.8),
            blue_roughness_metallic: blue,
            eta: 1.0 / 1.5,
            ..PointShading::default()
        }
    }

    /// Accumulator of a point with a sum of f times flux (W/sr).
    fn accumulator(sum: Vec3) -> Vec<u32> {
        let mut words = vec![0; crate::gather::accumulator::WORDS as usize];
        for (channel, value) in sum.to_array().into_iter().enumerate() {
            let quanta = crate::math::quanta::Quanta::from_f32(value, params().inverse_quantum());
            quanta.add_to(&mut AtomicWords::new(&mut words), 2 * channel as u32);
        }
        words
    }

    fn blended(
        shading: &PointShading,
        sum: Vec3,
        reprojected: Reprojected,
        settings: &HistorySettings,
        depth: u32,
    ) -> Blended {
        let point = PointGeometry { depth, ..point() };
        blend(
            0,
            &point,
            shading,
            &materials(),
            &accumulator(sum),
            &reprojected,
            settings,
            &params(),
            FEATURES,
        )
    }

    fn colors() -> [Vec3; 4] {
        [Vec3::ONE, Vec3::new(0.5, 0.25, 0.125), Vec3::new(0.5, 0.0, 0.25), Vec3::ZERO]
    }

    #[test]
    fn without_history_radiance_equals_that_of_resolve_to_the_bit() {
        for index in 0..1000 {
            let u = Rng::new(Stream::Camera, 3, index, 0).next4();
            let sum = uniform_sphere(u.x, u.y).abs() * u.z * 1.0e-4;
            let shading = shading(index % 2, colors()[index as usize / 2 % 4]);
            for settings in [DEMODULATES, HistorySettings { demodulates: 0, ..DEMODULATES }] {
                for depth in 0..2 {
                    let found = blended(&shading, sum, Reprojected::default(), &settings, depth);
                    let geometry = [PointGeometry { depth, ..point() }];
                    let mut plain = [Vec3::ONE];
                    let (params, words) = (params(), accumulator(sum));
                    resolve::resolve(0, &params, &geometry, &[shading], &words, Slots::new(&mut plain));
                    let [plain] = plain;
                    assert_eq!(
                        found.radiance.to_array().map(f32::to_bits),
                        plain.to_array().map(f32::to_bits)
                    );
                    assert!(is_finite(found.mean.element_sum()));
                }
            }
        }
    }

    #[test]
    fn pixel_without_point_leaves_no_light_to_the_next_frame() {
        let reprojected = Reprojected { mean: Vec3::ONE, samples: 3.0, offset: Vec3::ONE, radius: 0.02 };
        let found = blended(&shading(0, Vec3::ONE), Vec3::splat(1.0e-4), reprojected, &DEMODULATES, 0);
        assert_eq!((found.radiance, found.point.samples), (Vec3::ZERO, 0.0));
        // Light of a point that reflects nothing cannot be demodulated.
        let found = blended(&shading(0, Vec3::ZERO), Vec3::ZERO, reprojected, &DEMODULATES, 1);
        assert_eq!((found.radiance, found.point.samples), (Vec3::ZERO, 0.0));
    }

    #[test]
    fn blend_weights_all_frames_equally() {
        let (sum, old) = (Vec3::new(1.0, 2.0, 3.0) * 1.0e-4, Vec3::new(0.7, 0.2, 0.4));
        let radiance = HistorySettings { demodulates: 0, ..DEMODULATES };
        for (material, settings) in [(0, &DEMODULATES), (1, &DEMODULATES), (0, &radiance), (1, &radiance)] {
            let shading = shading(material, colors()[1]);
            let fresh = blended(&shading, sum, Reprojected::default(), settings, 1);
            assert_eq!((fresh.point.samples, fresh.point.position), (1.0, point().position));
            for n in [1.0, 3.0, 4.0, 100.0] {
                let offset = Vec3::new(0.01, 0.0, -0.02);
                let found = blended(
                    &shading,
                    sum,
                    Reprojected { mean: old, samples: n, offset, radius: 0.02 },
                    settings,
                    1,
                );
                let expected = (n * old + fresh.mean) / (n + 1.0);
                // Tolerance: a few ulp.
                assert!((found.mean - expected).length() < 1.0e-6 * expected.length());
                // The eye sees blended light by the factor that it sees this frame's light by.
                let shown = fresh.radiance * found.mean / fresh.mean;
                assert!((found.radiance - shown).length() < 2.0e-6 * shown.length());
                assert_eq!(found.point.samples, n + 1.0);
                // The mean of the positions: n at the offset, one at the point.
                let position = point().position + offset * (n / (n + 1.0));
                assert!((found.point.position - position).length() < 1.0e-6);
            }
        }
    }

    #[test]
    fn lambert_reuses_irradiance_across_texels_of_other_colours() {
        let light = Vec3::new(1.0, 2.0, 3.0) * 1.0e-4;
        for white in [Vec3::ONE, Vec3::new(0.25, 1.0, 0.5)] {
            for color in [Vec3::ONE, Vec3::new(0.5, 0.25, 0.125), Vec3::new(0.5, 0.0, 0.25)] {
                // The same photons give both texels the same light times their colours.
                let source =
                    blended(&shading(0, white), white * light, Reprojected::default(), &DEMODULATES, 1);
                let own = blended(&shading(0, color), color * light, Reprojected::default(), &DEMODULATES, 1);
                // A history so long that this frame hardly counts.
                let reprojected = Reprojected { mean: source.mean, samples: 1.0e6, ..Reprojected::default() };
                let found = blended(&shading(0, color), color * light, reprojected, &DEMODULATES, 1);
                assert!((found.radiance - own.radiance).length() < 1.0e-6 * own.radiance.length());
                // Irradiance: pi times the light of the photons over the area of the disc.
                let expected = PI * light / (PI * 0.02 * 0.02);
                assert!((source.mean - expected).length() < 1.0e-5 * expected.length(), "{}", source.mean);
                // Reused radiance carries the colour of its source along.
                let radiance = HistorySettings { demodulates: 0, ..DEMODULATES };
                let source = blended(&shading(0, white), white * light, Reprojected::default(), &radiance, 1);
                let reprojected = Reprojected { mean: source.mean, samples: 1.0e6, ..Reprojected::default() };
                let smeared = blended(&shading(0, color), color * light, reprojected, &radiance, 1);
                let differs = (smeared.radiance - own.radiance).length() > 0.1 * own.radiance.length();
                assert_eq!(differs, white != color);
            }
        }
    }
}
