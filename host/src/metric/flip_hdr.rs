//! FLIP of scene-linear images: the maximum of each pixel's FLIP over the useful exposures of the reference.
//!
//! Implementation of P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Möller, "Visualizing Errors in Rendered High Dynamic
//! Range Images", Eurographics 2021. Tone curve, exposures and constants are those of NVIDIA's version 1.7.

use std::rc::Rc;

use glam::DVec3;

use super::comparison::{Better, Comparison, Metric, MetricValue, NoValue};
use super::error_map::ErrorMap;
use super::flip::{color, flip};
use super::pixels::Pixels;
use caustics_files::image_file::Encoding;

/// Perceived difference at the exposure that shows it most.
pub static FLIP_HDR: Metric = Metric {
    name: "flip_hdr",
    description: "Perceived difference at the exposure that shows it most",
    unit: "1",
    better: Better::Lower,
    limitations: "a firefly counts like a white pixel",
    compute: value,
};

/// Mean error map over runs.
pub struct HdrMap(pub Option<ErrorMap>);

/// Returns the error map of this metric, computed once per comparison.
pub fn map(comparison: &Comparison<'_>) -> Rc<HdrMap> {
    comparison.shared(|Comparison { runs, reference, viewing, .. }| {
        // A reference without exposures gives no map for any run.
        let maps =
            runs.iter().map_while(|run| flip_hdr(&run.mean, &reference.mean, viewing.pixels_per_degree));
        HdrMap(ErrorMap::mean_of(maps))
    })
}

fn value(comparison: &Comparison<'_>) -> MetricValue {
    match comparison.viewing.encoding {
        Encoding::Srgb => Err(NoValue::DisplayColours),
        Encoding::Linear => map(comparison).0.as_ref().map(ErrorMap::mean).ok_or(NoValue::BlackReference),
    }
}

/// Exposures, evenly spaced (stops).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// Darkest exposure: it shows the brightest pixel at 85 % of white.
    pub start: f64,
    /// Brightest exposure: it shows the median at 85 % of white.
    pub stop: f64,
    /// Number of exposures: about one per stop, at least 2.
    pub count: usize,
}

impl Exposures {
    /// Returns the useful exposures of a reference; `None` if all of it is black. If the median is black, the median of all
    /// other pixels takes its place.
    pub fn from_reference(reference: &Pixels) -> Option<Exposures> {
        let mut luminances: Vec<f64> =
            reference.values.iter().map(|&value| color::luminance(value)).collect();
        luminances.sort_by(f64::total_cmp);
        let brightest = *luminances.last()?;
        if !(brightest > 0.0 && brightest.is_finite()) {
            return None;
        }
        let mut median = luminances[luminances.len() / 2];
        if median <= 0.0 {
            let lit = &luminances[luminances.partition_point(|&luminance| luminance <= 0.0)..];
            median = lit[lit.len() / 2];
        }
        let (start, stop) = ((knee() / brightest).log2(), (knee() / median).log2());
        Some(Exposures { start, stop, count: ((stop - start).ceil() as usize).max(2) })
    }

    /// Returns all exposures (stops).
    pub fn all(self) -> impl Iterator<Item = f64> {
        let (start, step) = (self.start, (self.stop - self.start) / (self.count - 1) as f64);
        (0..self.count).map(move |index| start + index as f64 * step)
    }
}

/// ACES [Narkowicz 2015] with its built-in exposure of 0.6: (a x^2 + b x) / (c x^2 + d x + e).
const CURVE: [f64; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// Returns the display-linear colour of a radiance at an exposure. Negative radiance is black.
pub fn expose(value: DVec3, stops: f64) -> DVec3 {
    let [a, b, c, d, e] = CURVE;
    let x = value.max(DVec3::ZERO) * stops.exp2();
    ((x * x * a + x * b) / (x * x * c + x * d + e)).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Returns the radiance that the curve maps to 85 % of white.
fn knee() -> f64 {
    let [a, b, c, d, e] = CURVE;
    let (p, q) = ((b - 0.85 * d) / (a - 0.85 * c), -0.85 * e / (a - 0.85 * c));
    -0.5 * p + (0.25 * p * p - q).sqrt()
}

/// Returns the maximum of each pixel's FLIP over all exposures; `None` if the reference is black.
pub fn flip_hdr(image: &Pixels, reference: &Pixels, pixels_per_degree: f64) -> Option<ErrorMap> {
    let maps = Exposures::from_reference(reference)?.all().map(|stops| {
        let shown = |image: &Pixels| image.map(|value| expose(value, stops));
        flip(&shown(image), &shown(reference), pixels_per_degree)
    });
    maps.reduce(|mut largest, map| {
        largest.values.iter_mut().zip(map.values).for_each(|(largest, value)| *largest = largest.max(value));
        largest
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[f64]) -> Pixels {
        Pixels { width: values.len(), height: 1, values: values.iter().map(|&v| DVec3::splat(v)).collect() }
    }

    #[test]
    fn exposures_show_the_brightest_and_the_median_at_85_percent() {
        let exposures = Exposures::from_reference(&grey(&[8.0, 1.0, 0.25])).unwrap();
        for (value, stops) in [(8.0, exposures.start), (1.0, exposures.stop)] {
            assert!((expose(DVec3::splat(value), stops).x - 0.85).abs() < 1e-12);
        }
        assert_eq!(exposures.count, 3);
        assert_eq!(exposures.all().count(), 3);
        assert!((exposures.all().last().unwrap() - exposures.stop).abs() < 1e-12);
    }

    #[test]
    fn mostly_black_images_are_exposed_for_their_other_pixels() {
        let exposures = Exposures::from_reference(&grey(&[0.0, 0.0, 0.0, 4.0, 1.0])).unwrap();
        assert_eq!((exposures.stop - exposures.start).round(), 0.0);
        assert_eq!(exposures.count, 2);
        assert_eq!(Exposures::from_reference(&grey(&[0.0, -1.0])), None);
    }
}
