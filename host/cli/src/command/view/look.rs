//! Display of an image: a layer of it in 8-bit colours.

use caustics::exposure::Exposure;
use caustics::rendered_image::RenderedImage;
use caustics_kernels::pass::display::tone_mapped;
use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Layer to show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layer {
    /// All radiance.
    #[default]
    Beauty,
    /// Radiance that is no caustic.
    Path,
    /// Radiance of the caustics.
    Caustics,
    /// Number of photons that each collection point gathered.
    Photons,
    /// Radius of the collection points.
    Radius,
    /// Index of the collection point among the vertices of the camera path.
    Depth,
    /// Standard error of the mean, relative to the mean.
    Variance,
}

impl Layer {
    /// All layers with names and descriptions.
    pub const ALL: [(Layer, &'static str, &'static str); 7] = [
        (Layer::Beauty, "beauty", "all light"),
        (Layer::Path, "path", "light without caustics"),
        (Layer::Caustics, "caustics", "caustics alone"),
        (Layer::Photons, "photons", "photons of the collection point"),
        (Layer::Radius, "radius", "radius of the collection point (m)"),
        (Layer::Depth, "depth", "path vertex of the collection point"),
        (Layer::Variance, "variance", "estimated relative error"),
    ];
}

/// Layer and exposure of the display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Layer to show.
    pub layer: Layer,
    /// Exposure.
    pub exposure: Exposure,
}

/// An image to show.
#[derive(Clone, Debug, Default)]
pub struct DisplayedImage {
    /// Its layers.
    pub image: RenderedImage,
    /// Variance of the mean of all radiance; empty where it is unknown.
    pub variance: Vec<Vec3>,
    /// Exposure that fits the image, or the image it is compared with (stops).
    pub suits: f64,
}

/// A displayed image: three bytes a pixel, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    /// Width (px).
    pub width: u32,
    /// Height (px).
    pub height: u32,
    /// Red, green and blue of each pixel.
    pub bytes: Vec<u8>,
    /// Exposure (stops).
    pub stops: f64,
    /// Value of the brightest false colour; none for colours of light.
    pub brightest: Option<f32>,
}

/// Stride of the pixels from which the exposure is computed.
const STRIDE: usize = 7;
/// Minimum change of the exposure (stops), so that images do not flicker.
const STEADY: f64 = 0.35;

/// Returns the exposure (stops) that fits an image, or the previous one if it is close.
pub fn suiting(image: &RenderedImage, before: Option<f64>) -> f64 {
    let stops = Exposure::Auto.stops(image.beauty().iter().step_by(STRIDE).map(|color| color.as_dvec3()));
    before.filter(|before| (before - stops).abs() < STEADY).unwrap_or(stops)
}

impl Look {
    /// Returns the exposure (stops); `suits` is the one that fits the image.
    pub fn stops(&self, suits: f64) -> f64 {
        match self.exposure {
            Exposure::Auto => suits,
            Exposure::Stops(stops) => stops,
        }
    }

    /// Returns the image as it is displayed.
    pub fn raster(&self, shown: &DisplayedImage) -> Raster {
        let image = &shown.image;
        let mut raster =
            Raster { width: image.width as u32, height: image.height as u32, ..Raster::default() };
        raster.stops = self.stops(shown.suits);
        let light =
            |raster: &mut Raster, colors: &[Vec3]| raster.bytes = ToneMap::new(raster.stops).bytes(colors);
        match self.layer {
            Layer::Beauty => light(&mut raster, &image.beauty()),
            Layer::Path => light(&mut raster, &image.path),
            Layer::Caustics => light(&mut raster, &or_black(&image.caustics, image)),
            Layer::Photons => raster.set(&image.photons),
            Layer::Radius => raster.set(&image.radius),
            Layer::Depth => raster.set(&image.depth),
            Layer::Variance => raster.set(&relative_errors(shown)),
        }
        raster
    }
}

fn or_black(layer: &[Vec3], image: &RenderedImage) -> Vec<Vec3> {
    if layer.is_empty() { vec![Vec3::ZERO; image.path.len()] } else { layer.to_vec() }
}

/// Standard error of the mean luminance over the mean.
fn relative_errors(shown: &DisplayedImage) -> Vec<f32> {
    let relative = |(mean, variance): (Vec3, &Vec3)| {
        let mean = mean.element_sum() / 3.0;
        if mean > 0.0 { (variance.element_sum() / 3.0).sqrt() / mean } else { 0.0 }
    };
    shown.image.beauty().into_iter().zip(&shown.variance).map(relative).collect()
}

impl Raster {
    /// Shows numbers in the colours of Viridis, on a square-root scale from 0 to the value that one in 500 exceeds. Numbers
    /// that are missing are black.
    fn set(&mut self, values: &[f32]) {
        let mut seen: Vec<f32> = values.iter().copied().filter(|value| value.is_finite()).collect();
        let rank = seen.len() * 499 / 500;
        let brightest = match seen.len() {
            0 => 1.0,
            _ => *seen.select_nth_unstable_by(rank, f32::total_cmp).1,
        };
        let brightest = if brightest > 0.0 { brightest } else { 1.0 };
        self.brightest = Some(brightest);
        self.bytes = vec![0; 3 * (self.width * self.height) as usize];
        self.bytes.par_chunks_mut(3).zip(values).for_each(|(pixel, value)| {
            let share = (value / brightest).clamp(0.0, 1.0).sqrt();
            let color = colorous::VIRIDIS.eval_continuous(f64::from(share));
            pixel.copy_from_slice(&[color.r, color.g, color.b]);
        });
    }
}

/// Tone mapping of `display` as a table, indexed by the upper half of a radiance's bits. A step is less than one percent.
struct ToneMap(Vec<u8>);

impl ToneMap {
    fn new(stops: f64) -> ToneMap {
        let scale = stops.exp2() as f32;
        // Without the sign bit there are 2^15 entries.
        let byte = |bits: u32| {
            // Take the middle of all radiances with these bits.
            let radiance = f32::from_bits(bits << 16 | 0x8000);
            // Clamp to infinity.
            let radiance = if radiance.is_nan() { f32::INFINITY } else { radiance };
            (tone_mapped(Vec3::splat(radiance), scale).x * 255.0 + 0.5) as u8
        };
        ToneMap((0..1 << 15).into_par_iter().map(byte).collect())
    }

    fn bytes(&self, colors: &[Vec3]) -> Vec<u8> {
        let mut bytes = vec![0; 3 * colors.len()];
        let values: &[f32] = bytemuck::cast_slice(colors);
        bytes.par_chunks_mut(1 << 14).zip(values.par_chunks(1 << 14)).for_each(|(bytes, values)| {
            for (byte, value) in bytes.iter_mut().zip(values) {
                *byte = self.0[(value.max(0.0).to_bits() >> 16) as usize];
            }
        });
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(path: Vec<Vec3>) -> DisplayedImage {
        let photons = (0..path.len()).map(|pixel| pixel as f32).collect();
        let image = RenderedImage { width: path.len(), height: 1, path, photons, ..RenderedImage::default() };
        DisplayedImage { image, variance: Vec::new(), suits: 0.0 }
    }

    #[test]
    fn light_matches_display_within_two_steps() {
        let colors: Vec<Vec3> = (0..1000).map(|i| Vec3::new(1e-3, 0.011, 0.2) * 1.01_f32.powi(i)).collect();
        let look = Look { layer: Layer::Beauty, exposure: Exposure::Stops(0.7) };
        let raster = look.raster(&shown(colors.clone()));
        for (bytes, color) in raster.bytes.as_chunks::<3>().0.iter().zip(&colors) {
            let exact = tone_mapped(*color, 0.7_f32.exp2()) * 255.0;
            for (byte, exact) in bytes.iter().zip(exact.to_array()) {
                assert!((f32::from(*byte) - exact).abs() <= 2.0, "{byte} for {exact}");
            }
        }
        let odd = look.raster(&shown(vec![Vec3::new(f32::NAN, f32::INFINITY, -1.0)]));
        assert_eq!(odd.bytes[0], 0);
        assert!(odd.bytes[1] > 250 && odd.bytes[2] == 0);
    }

    #[test]
    fn small_changes_keep_the_exposure() {
        let grey = |value: f32| shown(vec![Vec3::splat(value); 100]).image;
        assert_eq!(suiting(&grey(0.18), None), 0.0);
        assert_eq!(suiting(&grey(0.2), Some(0.0)), 0.0);
        assert_eq!(suiting(&grey(0.36), Some(0.0)), -1.0);
    }

    #[test]
    fn false_colours_end_at_a_value_that_few_exceed() {
        let look = Look { layer: Layer::Photons, exposure: Exposure::Auto };
        let raster = look.raster(&shown(vec![Vec3::ZERO; 1000]));
        assert_eq!(raster.brightest, Some(998.0));
        let [first, last] = [colorous::VIRIDIS.eval_continuous(0.0), colorous::VIRIDIS.eval_continuous(1.0)];
        assert_eq!(raster.bytes[..3], [first.r, first.g, first.b]);
        assert_eq!(raster.bytes[2997..], [last.r, last.g, last.b]);
    }
}
