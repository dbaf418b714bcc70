//! Block means of images, frame by frame, and a test whether two configurations have the same mean in every block.

use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::gather::variant::Variant;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::method::Method;
use glam::Vec3;

use crate::failed_image;
use crate::statistics::Mean;

/// Side of a block (px).
const SIDE: usize = 8;

/// Mean radiance of each block of 8 x 8 pixels in each frame; pixels left over at the edges are ignored.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    /// All light: one row per frame, one column per block.
    pub frames: Vec<Vec<f64>>,
    /// Number of blocks in a row of the image.
    pub columns: usize,
    /// Share of the caustic layer in all light.
    pub caustic_share: f64,
}

impl Blocks {
    /// Renders `frames` frames of independent seeds through the first camera.
    pub fn render(
        choice: &RunnerChoice,
        scene: &Scene,
        config: &RenderConfig,
        method: &'static Method,
        variant: &'static Variant,
        frames: u32,
    ) -> Blocks {
        let features = scene.features(config.specular_roughness);
        let camera = &scene.cameras[0];
        let mut session = Session::new(
            choice,
            scene,
            camera,
            &RenderConfig { method, gather: Some(variant), ..config.clone() },
            features,
        )
        .expect("a session opens");
        let (mut rows, mut all, mut caustic) = (Vec::new(), 0.0, 0.0);
        for frame in 0..frames {
            session.frame(frame).expect("a frame runs");
            let counters = session.counters().expect("counters");
            assert_eq!(counters.get(Counter::NonFinite) + counters.get(Counter::Clamped), 0);
            let image = session.image().expect("an image");
            rows.push(means(&image.beauty(), image.width, image.height));
            let sum = |layer: &[Vec3]| layer.iter().map(|v| f64::from(v.element_sum())).sum::<f64>();
            all += sum(&image.path) + sum(&image.caustics);
            caustic += sum(&image.caustics);
        }
        let columns = config.width as usize / SIDE;
        Blocks { frames: rows, columns, caustic_share: caustic / all }
    }

    /// Returns means of `batches` batches in place of frames; consecutive frames belong to the batches in turn.
    pub fn batch_means(&self, batches: usize) -> Blocks {
        let mean = |batch: usize| {
            let rows: Vec<&Vec<f64>> = self.frames.iter().skip(batch).step_by(batches).collect();
            let mean_of = |block| rows.iter().map(|row| row[block]).sum::<f64>() / rows.len() as f64;
            (0..self.frames[0].len()).map(mean_of).collect()
        };
        Blocks { frames: (0..batches).map(mean).collect(), ..*self }
    }

    /// Mean of one block over the frames.
    pub fn block(&self, block: usize) -> Mean {
        Mean::from_samples(&self.frames.iter().map(|frame| frame[block]).collect::<Vec<_>>())
    }

    /// Mean of each block over the frames.
    fn means(&self) -> Vec<Mean> {
        (0..self.frames[0].len()).map(|block| self.block(block)).collect()
    }

    /// z-score of each block: this minus `reference`, over the standard error of the difference.
    fn z_scores(&self, reference: &Blocks) -> Vec<f64> {
        self.means()
            .iter()
            .zip(&reference.means())
            .map(|(image, reference)| image.z_score(reference))
            .collect()
    }

    /// Mean of all blocks.
    pub fn whole(&self) -> Mean {
        let mean = |frame: &Vec<f64>| frame.iter().sum::<f64>() / frame.len() as f64;
        Mean::from_samples(&self.frames.iter().map(mean).collect::<Vec<_>>())
    }

    /// Describes evidence that the means differ from those of `reference` ([`Scores::fault`]). Writes the blocks' image, reference, error and
    /// p-values into a folder, which the description names.
    pub fn failure(&self, reference: &Blocks) -> Option<String> {
        let fault = self.scores(reference).fault()?;
        let values = |means: Vec<Mean>| means.into_iter().map(|mean| mean.value).collect::<Vec<_>>();
        let folder = failed_image::write(
            "blocks",
            self.columns.max(1),
            &values(self.means()),
            &values(reference.means()),
            &self.z_scores(reference),
        );
        Some(format!("{fault}; maps are in {}", folder.display()))
    }

    /// Compares block by block: this minus `reference`, over the standard error of the difference.
    pub fn scores(&self, reference: &Blocks) -> Scores {
        let blocks = self.z_scores(reference);
        let (a, b) = (self.whole(), reference.whole());
        Scores {
            whole: a.z_score(&b),
            ratio: a.value / b.value,
            ratio_error: (a.error / a.value).hypot(b.error / b.value) * a.value / b.value,
            mean_square: blocks.iter().map(|z| z * z).sum::<f64>() / blocks.len() as f64,
            worst: blocks.iter().fold(0.0, |worst: f64, z| worst.max(z.abs())),
            count: blocks.len(),
        }
    }
}

/// Outcome of a comparison of blocks.
#[derive(Clone, Copy, Debug)]
pub struct Scores {
    /// z-score of the whole image.
    pub whole: f64,
    /// Mean of this image over the mean of the reference.
    pub ratio: f64,
    /// Standard error of the ratio.
    pub ratio_error: f64,
    /// Mean square z-score of the blocks: 1 where the means are equal.
    pub mean_square: f64,
    /// Largest |z| of the blocks.
    pub worst: f64,
    /// Number of blocks.
    pub count: usize,
}

impl Scores {
    /// Describes evidence against equal means. Each criterion raises a false alarm with a probability of about 1 in
    /// 300.
    pub fn fault(&self) -> Option<String> {
        // The mean square of n normal numbers is 1 +- sqrt(2 / n).
        let spread = 3.0 * (2.0 / self.count as f64).sqrt();
        // The largest of n normal numbers exceeds this with a probability of 1 in 300 (n 2 exp(-z^2 / 2) / (z sqrt(2 pi))).
        let largest = (2.0 * (self.count as f64 * 300.0).ln()).sqrt();
        let ok = self.whole.abs() <= 3.0 && self.mean_square <= 1.0 + spread && self.worst <= largest;
        (!ok).then(|| format!("{self:?}: allowed |z| 3, mean square {:.2}, worst {largest:.2}", 1.0 + spread))
    }
}

fn means(image: &[Vec3], width: usize, height: usize) -> Vec<f64> {
    let (columns, rows) = (width / SIDE, height / SIDE);
    let mut sums = vec![0.0; columns * rows];
    for y in 0..rows * SIDE {
        for x in 0..columns * SIDE {
            let value = f64::from(image[y * width + x].element_sum()) / 3.0;
            sums[y / SIDE * columns + x / SIDE] += value / (SIDE * SIDE) as f64;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_kernels::math::rng::{Rng, Stream};

    /// 48 blocks of noise around `mean` in every frame; block `dark` is multiplied by `factor`.
    fn noise(seed: u32, mean: f64, dark: usize, factor: f64) -> Blocks {
        let frame = |frame: u32| {
            let value = |block: u32| {
                let u = Rng::new(Stream::Camera, seed, block, frame).next4();
                let value = mean * (0.7 + 0.3 * f64::from(u.element_sum()) / 2.0);
                if block as usize == dark { value * factor } else { value }
            };
            (0..48).map(value).collect()
        };
        Blocks { frames: (0..400).map(frame).collect(), columns: 1, caustic_share: 0.0 }
    }

    #[test]
    fn equal_means_pass_and_means_2_percent_apart_fail() {
        let reference = noise(1, 1.0, 0, 1.0);
        assert_eq!(noise(2, 1.0, 0, 1.0).scores(&reference).fault(), None);
        assert!(noise(2, 1.02, 0, 1.0).scores(&reference).fault().is_some());
    }

    #[test]
    fn detects_one_block_that_is_5_percent_darker() {
        let reference = noise(1, 1.0, 0, 1.0);
        let scores = noise(2, 1.0, 17, 0.95).scores(&reference);
        assert!(scores.fault().is_some() && scores.whole.abs() < 3.0, "{scores:?}");
    }

    #[test]
    fn blocks_are_means_of_their_pixels() {
        let image: Vec<Vec3> = (0..17 * 9).map(|pixel| Vec3::splat((pixel % 17 / 8) as f32)).collect();
        assert_eq!(means(&image, 17, 9), [0.0, 1.0]);
    }
}
