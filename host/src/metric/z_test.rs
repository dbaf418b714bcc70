//! z-test: whether a noisy image and a noisy reference can have the same expectation.
//!
//! The test compares means of 8x8 blocks, channel by channel. If only noise differs, z = (a - b) / sqrt(var a + var b) is a
//! standard normal number.
//! The variance of the image's block comes from the differences between runs, which include noise that neighbouring pixels
//! share. With a single run it comes from the variance layer, as for the reference; pixels then count as independent.
//! With few runs the variance itself is uncertain. Their t with Welch's degrees of freedom is converted to the z of the
//! same probability.
//! The whole image is tested in the same way. With fewer than [`ENOUGH`] runs, its variance is computed from its blocks as
//! if they were independent, because so few images determine it poorly.
//!
//! Block means must be roughly normal. A block that is black in most runs and bright in few is not: such images need longer
//! runs.

use glam::DVec3;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

use super::comparison::{Better, Comparison, Metric, MetricValue, NoValue};
use super::pixels::{Estimate, Pixels};

/// Side of a block (px). Blocks at the right and lower border may be smaller.
pub const BLOCK: usize = 8;

/// Number of runs from which the variance of the whole image is estimated from whole images.
pub const ENOUGH: usize = 8;

/// Relative rounding error of images: sums of thousands of frames in f32.
const ROUNDING: f64 = 1e-6;

/// Mean square over blocks of the difference, in units of its noise; 1 where only noise differs.
pub static Z_MEAN_SQUARE: Metric = Metric {
    name: "z_mean_square",
    description: "Mean square over blocks of the difference, in units of its noise; 1 where only noise differs",
    unit: "1",
    better: Better::NearOne,
    limitations: "blocks that most runs leave dark are not normal; give them longer runs",
    compute: |comparison| value(comparison, |test| test.mean_square),
};

/// Largest difference of a block, in units of its noise.
pub static Z_LARGEST: Metric = Metric {
    name: "z_largest",
    description: "Largest difference of a block, in units of its noise",
    unit: "1",
    better: Better::Lower,
    limitations: "it grows with the number of blocks",
    compute: |comparison| value(comparison, |test| test.largest),
};

/// Difference of the whole image, in units of its noise.
pub static Z_IMAGE: Metric = Metric {
    name: "z_image",
    description: "Difference of the whole image, in units of its noise",
    unit: "1",
    better: Better::NearZero,
    limitations: "errors of opposite sign cancel",
    compute: |comparison| value(comparison, |test| test.z_image),
};

/// -log10 of the probability that noise alone differs as much.
pub static Z_SURPRISE: Metric = Metric {
    name: "z_surprise",
    description: "-log10 of the probability that noise alone differs as much",
    unit: "1",
    better: Better::Lower,
    limitations: "the less noise there is, the smaller the bias that surprises",
    compute: |comparison| value(comparison, ZTest::surprise),
};

/// Result of the test, computed once per comparison.
struct Test(Result<ZTest, NoValue>);

fn test(comparison: &Comparison<'_>) -> Result<ZTest, NoValue> {
    comparison.shared(|Comparison { runs, reference, .. }| Test(z_test(runs, reference))).0.clone()
}

fn value(comparison: &Comparison<'_>, pick: fn(&ZTest) -> f64) -> MetricValue {
    test(comparison).map(|test| pick(&test))
}

/// Returns the number of compared blocks; `None` if there is no test.
pub fn blocks(comparison: &Comparison<'_>) -> Option<usize> {
    test(comparison).ok().map(|test| test.blocks)
}

/// Result of the z-test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZTest {
    /// Number of compared blocks: those with noise or a difference in some channel.
    pub blocks: usize,
    /// Mean of z^2 over blocks and channels. Its expectation is 1, its deviation at most sqrt(2 / blocks).
    pub mean_square: f64,
    /// Largest |z| of a block.
    pub largest: f64,
    /// z of the whole image in the channel with the largest |z|.
    pub z_image: f64,
    /// Probability that noise alone gives one of the three values or a larger one. It is small if the expectations differ.
    pub probability: f64,
}

impl ZTest {
    /// Returns -log10 of the probability, at most 300. Noise alone exceeds 3 in one of a thousand tests.
    pub fn surprise(&self) -> f64 {
        -self.probability.max(1e-300).log10()
    }
}

/// Tests several runs of an image, or one with a variance, against a reference with a variance.
pub fn z_test(runs: &[Estimate], reference: &Estimate) -> Result<ZTest, NoValue> {
    let variance_of_reference = reference.variance.as_ref().ok_or(NoValue::NoReferenceNoise)?;
    let variance_of_image = match runs {
        [run] => Some(run.variance.as_ref().ok_or(NoValue::NoImageNoise)?),
        _ => None,
    };
    for variance in variance_of_image.iter().copied().chain([variance_of_reference]) {
        if !variance.values.iter().all(|value| value.is_finite() && value.min_element() >= 0.0) {
            return Err(NoValue::BadVariance);
        }
    }
    let (width, height) = (reference.mean.width, reference.mean.height);
    let of_block = |block: Block| {
        let means: Vec<DVec3> = runs.iter().map(|run| block.sum(&run.mean) / block.count()).collect();
        let of_mean = |variance| block.sum(variance) / (block.count() * block.count());
        Compared {
            image: Moments::from_means(&means, variance_of_image.map(of_mean)),
            reference: block.sum(&reference.mean) / block.count(),
            reference_variance: of_mean(variance_of_reference),
        }
    };
    let all: Vec<_> = Block::all(width, height).map(|block| (block, of_block(block))).collect();
    // Average the image's part of the noise over all blocks, since the part of a single block is uncertain.
    let noise: DVec3 = all.iter().map(|(_, block)| block.image.variance + block.reference_variance).sum();
    let part = all.iter().map(|(_, block)| block.image.variance).sum::<DVec3>() / noise;
    let blocks: Vec<[Option<f64>; 3]> = all.iter().map(|(_, block)| block.z(part)).collect();

    let mut whole = of_block(Block { x: 0, y: 0, width, height });
    if (2..ENOUGH).contains(&runs.len()) {
        let weight = |block: &Block| (block.count() / (width * height) as f64).powi(2);
        let parts = || all.iter().map(|(block, compared)| weight(block) * compared.image.variance);
        whole.image.variance = parts().sum();
        let squares: DVec3 = parts().map(|part| part * part).sum();
        whole.image.freedom *= whole.image.variance * whole.image.variance / squares;
    }
    let whole = whole.z(whole.image.variance / (whole.image.variance + whole.reference_variance));

    let mut largest: f64 = 0.0;
    let mut squares = [0.0; 3];
    let mut counts = [0_usize; 3];
    for (channel, z) in blocks.iter().flat_map(|block| block.iter().enumerate()) {
        if let Some(z) = z {
            largest = largest.max(z.abs());
            squares[channel] += z * z;
            counts[channel] += 1;
        }
    }
    let tested: usize = counts.iter().sum();
    let whole = whole.into_iter().flatten();
    let z_image = whole.fold(0.0, |largest: f64, z| if z.abs() > largest.abs() { z } else { largest });

    // Combine the three by Bonferroni over channels and blocks, which needs no independence.
    let tail = |z: f64| 2.0 * normal().sf(z.abs());
    let chi = (0..3)
        .filter(|&channel| counts[channel] > 0)
        .map(|channel| ChiSquared::new(counts[channel] as f64).map_or(1.0, |chi| chi.sf(squares[channel])));
    let p_values = [3.0 * tail(z_image), tested as f64 * tail(largest), 3.0 * chi.fold(1.0, f64::min)];
    Ok(ZTest {
        blocks: blocks.iter().filter(|block| block.iter().any(Option::is_some)).count(),
        mean_square: if tested == 0 { 0.0 } else { squares.iter().sum::<f64>() / tested as f64 },
        largest,
        z_image,
        probability: if tested == 0 { 1.0 } else { p_values.into_iter().fold(1.0, |p, q| p.min(3.0 * q)) },
    })
}

/// Mean of a block over runs, variance of that mean, and degrees of freedom of the variance.
struct Moments {
    mean: DVec3,
    variance: DVec3,
    freedom: DVec3,
}

impl Moments {
    fn from_means(means: &[DVec3], known: Option<DVec3>) -> Moments {
        let count = means.len() as f64;
        let mean = means.iter().sum::<DVec3>() / count;
        if let Some(variance) = known {
            return Moments { mean, variance, freedom: DVec3::INFINITY };
        }
        let squares = means.iter().map(|value| (*value - mean) * (*value - mean)).sum::<DVec3>();
        let freedom = DVec3::splat(count - 1.0);
        Moments { mean, variance: squares / ((count - 1.0) * count), freedom }
    }
}

/// Block of the image and of the reference.
struct Compared {
    image: Moments,
    reference: DVec3,
    reference_variance: DVec3,
}

impl Compared {
    /// Returns z for each channel; `None` without noise or difference. `part` is the image's part of the noise's variance.
    fn z(&self, part: DVec3) -> [Option<f64>; 3] {
        [0, 1, 2].map(|channel| {
            let (image, reference) = (self.image.mean[channel], self.reference[channel]);
            let rounding = ROUNDING * image.abs().max(reference.abs());
            let noise = self.image.variance[channel] + self.reference_variance[channel];
            if noise == 0.0 && (image - reference).abs() <= rounding {
                return None;
            }
            let t = (image - reference) / (noise + rounding * rounding).sqrt();
            // Welch-Satterthwaite: only the image's variance is uncertain.
            Some(normal_of_t(t, self.image.freedom[channel] / part[channel].powi(2)))
        })
    }
}

/// Returns the standard normal number that has the same tail probability as `t`.
fn normal_of_t(t: f64, freedom: f64) -> f64 {
    if !freedom.is_finite() {
        return t;
    }
    let tail = StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |student| student.sf(t.abs()));
    // Above 37 deviations the probability is 0 in f64.
    let z = if tail > 1e-300 { -normal().inverse_cdf(tail) } else { 37.0 };
    z.copysign(t)
}

fn normal() -> Normal {
    Normal::standard()
}

/// A rectangle of pixels.
#[derive(Clone, Copy)]
struct Block {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

impl Block {
    fn all(width: usize, height: usize) -> impl Iterator<Item = Block> {
        let side = |start: usize, end: usize| BLOCK.min(end - start);
        (0..height).step_by(BLOCK).flat_map(move |y| {
            let row = (0..width).step_by(BLOCK);
            row.map(move |x| Block { x, y, width: side(x, width), height: side(y, height) })
        })
    }

    fn count(&self) -> f64 {
        (self.width * self.height) as f64
    }

    fn sum(&self, pixels: &Pixels) -> DVec3 {
        let row = |y: usize| &pixels.values[y * pixels.width + self.x..][..self.width];
        (self.y..self.y + self.height).flat_map(row).sum()
    }
}
