//! The mean of frames and the variance of that mean, in f64: from the squares of independent frames, or from the sums of batches
//! that frames take turns in, which are independent of each other.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::picture::Picture;

/// Batches that the frames of a mean usually take turns in: the fewer, the less noise the mean has, and the more its variance.
pub const BATCHES: u32 = 4;

/// Sums of pictures: [`Accumulation::add`] frames, then take [`Accumulation::mean`] and [`Accumulation::variance`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accumulation {
    /// Size of the pictures, and how many were added.
    pub shape: Shape,
    /// Sums of layers: three channels of `path`, three of `caustics`, then `radius`, `depth`, `deposits`; the last four
    /// may be empty.
    sums: [Vec<f64>; 5],
    /// Of all radiance, three channels: the sums of squares, or the sums of each batch.
    spread: Vec<Vec<f64>>,
}

/// Size of the pictures, and how many were added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// Number of frames added.
    pub frames: u32,
    /// Whether the pictures have caustics and the other layers of a gather.
    pub gathers: bool,
    /// Batches that frames take turns in, independent of each other; 0: every frame is independent.
    #[serde(default)]
    pub batches: u32,
}

impl Shape {
    /// Frames of a batch.
    fn frames_of(&self, batch: usize) -> u32 {
        (self.frames + self.batches - 1 - batch as u32) / self.batches
    }
}

impl Accumulation {
    /// None yet, of frames that take turns in so many batches; 0: of independent frames.
    pub fn in_batches(batches: u32) -> Accumulation {
        Accumulation { shape: Shape { batches, ..Shape::default() }, ..Accumulation::default() }
    }

    /// Adds a picture.
    ///
    /// # Panics
    ///
    /// If it has another size or other layers than those before.
    pub fn add(&mut self, picture: &Picture) {
        let gathers = !picture.caustics.is_empty();
        let shape = Shape { width: picture.width, height: picture.height, gathers, ..self.shape };
        if self.shape.frames == 0 {
            *self = Accumulation::zero(shape);
        }
        assert_eq!(self.shape, shape, "pictures of one kind are added");
        let batch = self.shape.frames.checked_rem(self.shape.batches);
        self.shape.frames += 1;
        let beauty = picture.beauty();
        let layers: [&[f32]; 5] = [
            bytemuck::cast_slice(&picture.path),
            bytemuck::cast_slice(&picture.caustics),
            &picture.radius,
            &picture.depth,
            &picture.deposits,
        ];
        for (sum, layer) in self.sums.iter_mut().zip(layers) {
            sum.par_iter_mut().zip(layer).for_each(|(sum, &value)| *sum += f64::from(value));
        }
        let beauty: &[f32] = bytemuck::cast_slice(&beauty);
        let spread = self.spread[batch.unwrap_or(0) as usize].par_iter_mut().zip(beauty);
        match batch {
            Some(_) => spread.for_each(|(sum, &value)| *sum += f64::from(value)),
            None => spread.for_each(|(sum, &value)| *sum += f64::from(value) * f64::from(value)),
        }
    }

    /// Number of frames added so far.
    pub fn frames(&self) -> u32 {
        self.shape.frames
    }

    /// The mean of all pictures added, layer by layer.
    pub fn mean(&self) -> Picture {
        let scale = 1.0 / f64::from(self.shape.frames.max(1));
        let numbers = |sum: &[f64]| sum.iter().map(|sum| (sum * scale) as f32).collect::<Vec<f32>>();
        let colors = |sum: &[f64]| bytemuck::pod_collect_to_vec::<f32, Vec3>(&numbers(sum));
        let [path, caustics, radius, depth, deposits] = &self.sums;
        Picture {
            width: self.shape.width,
            height: self.shape.height,
            path: colors(path),
            caustics: colors(caustics),
            radius: numbers(radius),
            depth: numbers(depth),
            deposits: numbers(deposits),
        }
    }

    /// Estimated variance of the mean of all radiance in each pixel; `None` for fewer than two frames.
    pub fn variance(&self) -> Option<Vec<Vec3>> {
        if self.shape.frames < 2 {
            return None;
        }
        let variance: Vec<f32> = self.moments().map(|(_, variance)| variance as f32).collect();
        Some(bytemuck::pod_collect_to_vec(&variance))
    }

    /// Estimated relative mean square error of the mean, as `metric::relmse` defines it, with the mean in place of the
    /// truth and its variance in place of its squared error. Infinite for fewer than two frames.
    pub fn relative_error(&self) -> f64 {
        if self.shape.frames < 2 {
            return f64::INFINITY;
        }
        let count = 3.0 * (self.shape.width * self.shape.height) as f64;
        let whole = self.beauty().sum::<f64>() / count;
        let floor = (0.1 * whole).powi(2).max(f64::MIN_POSITIVE);
        self.moments().map(|(mean, variance)| variance / (mean * mean + floor)).sum::<f64>() / count
    }

    /// Mean of all radiance and variance of that mean, channel by channel, of two frames or more.
    fn moments(&self) -> impl Iterator<Item = (f64, f64)> {
        let shape = self.shape;
        let n = f64::from(shape.frames);
        self.beauty().enumerate().map(move |(i, mean)| {
            if shape.batches == 0 {
                // Rounding may leave a constant pixel a little below zero.
                return (mean, (self.spread[0][i] / n - mean * mean).max(0.0) / (n - 1.0));
            }
            // Batches as long as each other; one that is a frame longer has that much more weight.
            let batches =
                self.spread.iter().enumerate().map(|(batch, sums)| (shape.frames_of(batch), sums[i]));
            let square =
                |(frames, sum): (u32, f64)| f64::from(frames) * (sum / f64::from(frames) - mean).powi(2);
            let squares: f64 = batches.filter(|(frames, _)| *frames > 0).map(square).sum();
            (mean, squares / f64::from(shape.batches.min(shape.frames) - 1) / n)
        })
    }

    /// Means of all radiance, channel by channel.
    fn beauty(&self) -> impl Iterator<Item = f64> {
        let [path, caustics, ..] = &self.sums;
        let scale = 1.0 / f64::from(self.shape.frames.max(1));
        let caustic = |i: usize| caustics.get(i).copied().unwrap_or(0.0);
        path.iter().enumerate().map(move |(i, path)| (path + caustic(i)) * scale)
    }

    /// All sums as slices of numbers, in the order that [`Accumulation::of`] takes them: for a checkpoint.
    pub fn parts(&self) -> impl Iterator<Item = &[f64]> {
        self.sums.iter().chain(&self.spread).map(Vec::as_slice)
    }

    /// Sums of this shape from numbers in the order of [`Accumulation::parts`]; `None` if there are more or fewer than it has.
    pub fn of(shape: Shape, mut values: impl ExactSizeIterator<Item = f64>) -> Option<Accumulation> {
        let of_spread = 3usize.checked_mul(shape.batches.max(1) as usize)?;
        let per_pixel = of_spread.checked_add(if shape.gathers { 9 } else { 3 })?;
        // Compared before memory is asked for.
        let count = shape.width.checked_mul(shape.height)?.checked_mul(per_pixel)?;
        if values.len() != count {
            return None;
        }
        let mut sums = Accumulation::zero(shape);
        for part in sums.sums.iter_mut().chain(&mut sums.spread) {
            part.iter_mut().zip(&mut values).for_each(|(sum, value)| *sum = value);
        }
        Some(sums)
    }

    /// Sums of this shape, at zero.
    fn zero(shape: Shape) -> Accumulation {
        let pixels = shape.width * shape.height;
        let split = if shape.gathers { pixels } else { 0 };
        let sums = [3 * pixels, 3 * split, split, split, split].map(|count| vec![0.0; count]);
        let spread = vec![vec![0.0; 3 * pixels]; shape.batches.max(1) as usize];
        Accumulation { shape, sums, spread }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(path: f32, caustics: f32) -> Picture {
        Picture {
            width: 1,
            height: 1,
            path: vec![Vec3::splat(path)],
            caustics: vec![Vec3::splat(caustics)],
            radius: vec![1.0],
            depth: vec![2.0],
            deposits: vec![path],
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_frames() {
        let mut sums = Accumulation::default();
        for (path, caustics) in [(1.0, 0.0), (2.0, 1.0), (3.0, 2.0)] {
            assert_eq!(sums.variance().is_some(), sums.frames() > 1);
            sums.add(&picture(path, caustics));
        }
        assert_eq!(sums.mean(), picture(2.0, 1.0));
        // 1, 3, 5: variance 4 of one, 4 / 3 of the mean.
        assert!((sums.variance().unwrap()[0].x - 4.0 / 3.0).abs() < 1e-6);
        assert!((sums.relative_error() - 4.0 / 3.0 / 9.09).abs() < 1e-6);
    }

    #[test]
    fn the_variance_of_batches_is_that_between_them() {
        let mut sums = Accumulation::in_batches(2);
        for path in [1.0, 4.0, 3.0, 6.0] {
            sums.add(&picture(path, 0.0));
        }
        // Batches of mean 2 and 5: variance 4.5 of one, half of that of their mean.
        assert!((sums.variance().unwrap()[0].x - 2.25).abs() < 1e-6);
        assert_eq!(sums.mean().path[0].x, 3.5);
        // As few frames as batches, or fewer, are independent.
        let (mut few, mut independent) = (Accumulation::in_batches(4), Accumulation::default());
        for path in [1.0, 2.0, 6.0] {
            few.add(&picture(path, 0.0));
            independent.add(&picture(path, 0.0));
        }
        assert!((few.variance().unwrap()[0].x - independent.variance().unwrap()[0].x).abs() < 1e-6);
        let values: Vec<f64> = sums.parts().flatten().copied().collect();
        assert_eq!(Accumulation::of(sums.shape, values.into_iter()), Some(sums));
    }

    #[test]
    #[should_panic(expected = "pictures of one kind")]
    fn pictures_of_two_methods_do_not_mix() {
        let mut sums = Accumulation::default();
        sums.add(&picture(1.0, 1.0));
        sums.add(&Picture {
            caustics: vec![],
            radius: vec![],
            depth: vec![],
            deposits: vec![],
            ..picture(1.0, 1.0)
        });
    }
}
