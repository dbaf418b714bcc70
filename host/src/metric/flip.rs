//! FLIP of two display-linear images: the perceived difference of each pixel when an observer alternates between them, from
//! 0 to 1.
//!
//! Implementation of P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. Fairchild, "FLIP: A
//! Difference Evaluator for Alternating Images", HPG 2020.
//! Its constants are those of NVIDIA's implementation (BSD-3-Clause, github.com/NVlabs/flip), against which it is tested.
//! Filters are separable, as in NVIDIA's since version 1.2.

pub mod color;
mod filter;

use glam::DVec3;
use rayon::prelude::*;

use super::error_map::ErrorMap;
use super::pixels::Pixels;

/// Pixels per degree of visual angle: 3840 pixels over 0.7 m, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Exponent that compresses colour distances.
const COLOR_EXPONENT: f64 = 0.7;
/// Part of the largest colour distance below which distances are stretched.
const STRETCHED: f64 = 0.4;
/// Part of the scale that the stretched distances take.
const STRETCHED_TO: f64 = 0.95;

/// Returns the difference of every pixel. Both images are display-linear in [0, 1] and of one size.
pub fn flip(image: &Pixels, reference: &Pixels, pixels_per_degree: f64) -> ErrorMap {
    let (seen_image, seen_reference) = (Seen::new(image), Seen::new(reference));
    let filters = filter::contrast_sensitivity(pixels_per_degree);
    let colors = [&seen_image, &seen_reference].map(|seen| seen.colors(&filters));
    let filters = filter::features(pixels_per_degree);
    let features = [&seen_image, &seen_reference].map(|seen| seen.features(&filters));

    // The distance between green and blue is the largest.
    let compressed = |a, b| color::distance(a, b).powf(COLOR_EXPONENT);
    let largest = compressed(color::to_hunt_lab(DVec3::Y), color::to_hunt_lab(DVec3::Z));
    let knee = STRETCHED * largest;
    let at = |pixel: usize| {
        let distance = compressed(colors[0][pixel], colors[1][pixel]);
        let color = if distance < knee {
            distance * STRETCHED_TO / knee
        } else {
            STRETCHED_TO + (distance - knee) / (largest - knee) * (1.0 - STRETCHED_TO)
        };
        let [(edge, point), (edge_reference, point_reference)] = [features[0][pixel], features[1][pixel]];
        let difference = (edge - edge_reference).abs().max((point - point_reference).abs());
        let feature = (difference / std::f64::consts::SQRT_2).sqrt();
        color.powf(1.0 - feature)
    };
    let values = (0..image.values.len()).into_par_iter().map(at).collect();
    ErrorMap { width: image.width, height: image.height, values }
}

/// An image in planes of opponent colours.
struct Seen {
    width: usize,
    planes: [Vec<f64>; 3],
}

impl Seen {
    fn new(image: &Pixels) -> Seen {
        let opponent: Vec<_> = image.values.par_iter().map(|&value| color::to_opponent(value)).collect();
        let plane = |channel: usize| opponent.par_iter().map(|value| value[channel]).collect();
        Seen { width: image.width, planes: [plane(0), plane(1), plane(2)] }
    }

    fn filtered(&self, plane: &[f64], across: &[f64], down: &[f64]) -> Vec<f64> {
        filter::along_columns(&filter::along_rows(plane, self.width, across), self.width, down)
    }

    /// Filters by the contrast sensitivity of the eye and converts to uniform colours.
    fn colors(&self, [achromatic, red_green, first, second]: &[filter::Weights; 4]) -> Vec<DVec3> {
        let [y, x, z] = &self.planes;
        let blurred = |plane, weights: &[f64]| self.filtered(plane, weights, weights);
        let (y, x) = (blurred(y, achromatic), blurred(x, red_green));
        let (first, second) = (blurred(z, first), blurred(z, second));
        let at = |pixel: usize| {
            let opponent = DVec3::new(y[pixel], x[pixel], first[pixel] + second[pixel]);
            color::to_hunt_lab(color::from_opponent(opponent).clamp(DVec3::ZERO, DVec3::ONE))
        };
        (0..y.len()).into_par_iter().map(at).collect()
    }

    /// Returns the strength of edges and points in the achromatic plane.
    fn features(&self, [gauss, slope, curvature]: &[filter::Weights; 3]) -> Vec<(f64, f64)> {
        let grey: Vec<f64> = self.planes[0].par_iter().map(|y| (y + 16.0) / 116.0).collect();
        let length = |weights: &[f64]| -> Vec<f64> {
            let (across, down) = (self.filtered(&grey, weights, gauss), self.filtered(&grey, gauss, weights));
            across
                .into_par_iter()
                .zip(down)
                .map(|(across, down)| (across * across + down * down).sqrt())
                .collect()
        };
        length(slope).into_par_iter().zip(length(curvature)).collect()
    }
}
