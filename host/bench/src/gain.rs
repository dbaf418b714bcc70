//! Effective sample gain: how many times the light paths a method without history would need for the same noise.
//!
//! Noise is the variance between runs with independent seeds, per pixel and channel, averaged over both. Averages of
//! unbiased variances are unbiased. Their ratio has a relative error of about sqrt(4 / ((S - 1) n)) for S seeds and n
//! independent pixels, so few seeds suffice. A history's blur lowers the variance too: read the gain beside the error.

use glam::{DVec3, Vec3};

/// Mean over pixels and channels of the variance between images of one size. None for fewer than two images, for images
/// without pixels, and for images that are not finite.
pub fn mean_variance(images: &[&[Vec3]]) -> Option<f64> {
    let (first, runs) = (images.first()?, images.len() as f64);
    if images.len() < 2 || first.is_empty() {
        return None;
    }
    let of_pixel = |pixel: usize| {
        let values = || images.iter().map(|image| image[pixel].as_dvec3());
        let mean = values().sum::<DVec3>() / runs;
        values().map(|value| (value - mean) * (value - mean)).sum::<DVec3>().element_sum() / (runs - 1.0)
    };
    let mean = (0..first.len()).map(of_pixel).sum::<f64>() / (3 * first.len()) as f64;
    mean.is_finite().then_some(mean)
}

/// Variance without a history over the variance with one; None where an image has no noise.
pub fn gain(of_none: f64, of_history: f64) -> Option<f64> {
    let gain = of_none / of_history;
    (gain.is_finite() && gain > 0.0).then_some(gain)
}

#[cfg(test)]
mod tests {
    use caustics_kernels::math::rng::{Rng, Stream};

    use super::*;

    /// Images whose pixels differ in mean and have uniform noise of the given variance.
    fn runs(seed: u32, variance: f32, pixels: u32) -> Vec<Vec3> {
        let width = (12.0 * variance).sqrt();
        let at = |pixel: u32| {
            let u = Rng::new(Stream::Light, seed, pixel, 0).next4();
            Vec3::splat(pixel as f32 * 0.01) + width * (Vec3::new(u.x, u.y, u.z) - 0.5)
        };
        (0..pixels).map(at).collect()
    }

    fn variance(seed: u32, of_one: f32) -> f64 {
        let images: Vec<_> = (0..4).map(|run| runs(seed + run, of_one, 4000)).collect();
        mean_variance(&images.iter().map(Vec::as_slice).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_known_ratio_of_variances_is_found() {
        let (of_none, of_history) = (variance(0, 0.9), variance(100, 0.1));
        // The variance of uniform noise from 3 * 12000 degrees of freedom has a relative standard error below 1 %.
        assert!((of_none / 0.9 - 1.0).abs() < 0.03, "{of_none}");
        let found = gain(of_none, of_history).unwrap();
        assert!((found / 9.0 - 1.0).abs() < 0.04, "{found}");
        assert!(
            (gain(of_none, variance(200, 0.2)).unwrap() / 9.0 - 1.0).abs() > 0.3,
            "another ratio is told apart"
        );
    }

    #[test]
    fn images_without_noise_have_no_gain() {
        let still = [Vec3::ONE; 3];
        assert_eq!(mean_variance(&[&still, &still]), Some(0.0));
        assert_eq!(mean_variance(&[&still]), None);
        assert_eq!(mean_variance(&[&[], &[]]), None);
        assert_eq!(mean_variance(&[&still, &[Vec3::NAN; 3]]), None);
        assert_eq!((gain(1.0, 0.0), gain(0.0, 1.0), gain(2.0, 2.0)), (None, None, Some(1.0)));
    }
}
