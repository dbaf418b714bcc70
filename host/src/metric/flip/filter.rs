//! Separable filters of FLIP: the eye's blur, and the detection of edges and points [Andersson 2020, sections 4.1, 4.2].

use std::f64::consts::PI;

use rayon::prelude::*;

/// Weights around a pixel. Their number is odd; the middle one belongs to the pixel itself.
pub type Weights = Vec<f64>;

/// Returns the eye's contrast sensitivity as filters: achromatic, red-green, and two whose sum is blue-yellow.
pub fn contrast_sensitivity(pixels_per_degree: f64) -> [Weights; 4] {
    // Fits a sqrt(pi / b) exp(-pi^2 x^2 / b) over degrees of visual angle x. In two dimensions blue-yellow is the sum of
    // two such terms. Each separable factor of a term has the square root of the term's height.
    const ACHROMATIC: f64 = 0.0047;
    const RED_GREEN: f64 = 0.0053;
    const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
    let widest = BLUE_YELLOW[0].1;
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let gauss = |height: f64, b: f64| -> Weights {
        let at = |x: i32| height * (-(PI * f64::from(x) / pixels_per_degree).powi(2) / b).exp();
        (-radius..=radius).map(at).collect()
    };
    let normalised = |weights: Weights| {
        let sum: f64 = weights.iter().sum();
        weights.into_iter().map(|weight| weight / sum).collect::<Weights>()
    };
    let [first, second] = BLUE_YELLOW.map(|(a, b)| gauss((a * (PI / b).sqrt()).sqrt(), b));
    let sum = first.iter().sum::<f64>().hypot(second.iter().sum());
    let [first, second] = [first, second].map(|weights| weights.iter().map(|weight| weight / sum).collect());
    [normalised(gauss(1.0, ACHROMATIC)), normalised(gauss(1.0, RED_GREEN)), first, second]
}

/// Returns a Gaussian and its first and second derivative, as wide as features that the eye detects. The weights of the
/// Gaussian sum to 1, the positive and negative weights of a derivative to 1 and -1.
pub fn features(pixels_per_degree: f64) -> [Weights; 3] {
    const WIDTH_DEGREES: f64 = 0.082;
    let deviation = 0.5 * WIDTH_DEGREES * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i32;
    let gauss = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let sample_weights = |shape: &dyn Fn(f64) -> f64| -> Weights {
        let weights: Weights = (-radius..=radius).map(|x| shape(f64::from(x))).collect();
        let sum = |sign: f64| weights.iter().map(|weight| (sign * weight).max(0.0)).sum::<f64>();
        let (positive, negative) = (sum(1.0), sum(-1.0));
        weights
            .iter()
            .map(|&weight| weight / if weight > 0.0 { positive } else { negative.max(f64::MIN_POSITIVE) })
            .collect()
    };
    let curvature = |x: f64| (x * x / (deviation * deviation) - 1.0) * gauss(x);
    [sample_weights(&gauss), sample_weights(&|x| -x * gauss(x)), sample_weights(&curvature)]
}

/// Filters each row of a plane. Beyond the image its border is repeated.
pub fn along_rows(plane: &[f64], width: usize, weights: &[f64]) -> Vec<f64> {
    let radius = weights.len() / 2;
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each(|(out, row)| {
        let mut padded = vec![row[0]; radius];
        padded.extend_from_slice(row);
        padded.resize(width + 2 * radius, row[width - 1]);
        sum(out, weights, |tap| &padded[tap..]);
    });
    out
}

/// Filters each column of a plane, as [`along_rows`] filters each row.
pub fn along_columns(plane: &[f64], width: usize, weights: &[f64]) -> Vec<f64> {
    let (radius, last) = (weights.len() / 2, plane.len() / width - 1);
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
        sum(out, weights, |tap| &plane[(row + tap).saturating_sub(radius).min(last) * width..]);
    });
    out
}

/// Adds the weighted values of all taps, four at a time: `out` is then loaded and stored a quarter as often.
fn sum<'a>(out: &mut [f64], weights: &[f64], values: impl Fn(usize) -> &'a [f64]) {
    let count = out.len();
    let (quads, rest) = weights.as_chunks::<4>();
    for (index, quad) in quads.iter().enumerate() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|next| &values(4 * index + next)[..count]);
        for (x, out) in out.iter_mut().enumerate() {
            *out += quad[0] * a[x] + quad[1] * b[x] + quad[2] * c[x] + quad[3] * d[x];
        }
    }
    for (index, &weight) in rest.iter().enumerate() {
        let values = values(4 * quads.len() + index);
        out.iter_mut().zip(values).for_each(|(out, value)| *out += weight * value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Filters directly in two dimensions by a kernel that is a product.
    fn direct(plane: &[f64], width: usize, across: &[f64], down: &[f64]) -> Vec<f64> {
        let height = plane.len() / width;
        let clamp = |at: usize, offset: usize, taps: usize, end: usize| {
            (at as i64 + offset as i64 - taps as i64 / 2).clamp(0, end as i64 - 1) as usize
        };
        let at = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let mut sum = 0.0;
            for (i, a) in across.iter().enumerate() {
                for (j, d) in down.iter().enumerate() {
                    let source = clamp(y, j, down.len(), height) * width + clamp(x, i, across.len(), width);
                    sum += a * d * plane[source];
                }
            }
            sum
        };
        (0..plane.len()).map(at).collect()
    }

    #[test]
    fn separable_passes_equal_a_two_dimensional_filter() {
        for (width, height) in [(1, 1), (1, 9), (5, 1), (13, 7)] {
            let plane: Vec<f64> = (0..width * height).map(|i| ((i * 37) % 11) as f64).collect();
            let (across, down) = ([0.1, -0.3, 0.5, 0.2, 0.9], [1.0, -2.0, 0.25]);
            let two = along_columns(&along_rows(&plane, width, &across), width, &down);
            let one = direct(&plane, width, &across, &down);
            // The error bound is for sums of 15 products of at most 20.
            assert!(two.iter().zip(&one).all(|(two, one)| (two - one).abs() < 1e-12), "{width}x{height}");
        }
    }

    #[test]
    fn blurs_keep_constant_planes_and_feature_filters_cancel_them() {
        for pixels_per_degree in [10.0, 67.0, 120.0] {
            let [achromatic, red_green, first, second] = contrast_sensitivity(pixels_per_degree);
            let sum = |weights: &Weights| weights.iter().sum::<f64>();
            assert!((sum(&achromatic) - 1.0).abs() < 1e-12 && (sum(&red_green) - 1.0).abs() < 1e-12);
            assert!((sum(&first).powi(2) + sum(&second).powi(2) - 1.0).abs() < 1e-12);
            let [gauss, slope, curvature] = features(pixels_per_degree);
            assert!((sum(&gauss) - 1.0).abs() < 1e-12);
            assert!(sum(&slope).abs() < 1e-12 && sum(&curvature).abs() < 1e-12);
        }
    }
}
