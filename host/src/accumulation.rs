//! The mean of independent frames and the variance of that mean, from sums and sums of squares in f64.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::picture::Picture;

/// Sums of pictures: [`Accumulation::add`] frames, then take [`Accumulation::mean`] and [`Accumulation::variance`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accumulation {
    /// Size of the pictures, and how many were added.
    pub shape: Shape,
    /// Sums of layers: three channels of `path`, three of `caustics`, then `radius`, `depth`, `deposits`; the last four
    /// may be empty.
    sums: [Vec<f64>; 5],
    /// Sums of the squares of all radiance, three channels.
    squares: Vec<f64>,
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
}

impl Accumulation {
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
        let squares = self.squares.par_iter_mut().zip(beauty);
        squares.for_each(|(sum, &value)| *sum += f64::from(value) * f64::from(value));
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
        let count = self.squares.len() as f64;
        let whole = self.beauty().sum::<f64>() / count;
        let floor = (0.1 * whole).powi(2).max(f64::MIN_POSITIVE);
        self.moments().map(|(mean, variance)| variance / (mean * mean + floor)).sum::<f64>() / count
    }

    /// Mean of all radiance and variance of that mean, channel by channel, of two frames or more.
    fn moments(&self) -> impl Iterator<Item = (f64, f64)> {
        let n = f64::from(self.shape.frames);
        self.squares.iter().zip(self.beauty()).map(move |(squares, mean)| {
            // Rounding may leave a constant pixel a little below zero.
            (mean, (squares / n - mean * mean).max(0.0) / (n - 1.0))
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
        self.sums.iter().chain([&self.squares]).map(Vec::as_slice)
    }

    /// Sums of this shape from numbers in the order of [`Accumulation::parts`]; `None` if there are more or fewer than it has.
    pub fn of(shape: Shape, mut values: impl ExactSizeIterator<Item = f64>) -> Option<Accumulation> {
        let per_pixel = if shape.gathers { 12 } else { 6 };
        // Compared before memory is asked for.
        let count = shape.width.checked_mul(shape.height)?.checked_mul(per_pixel)?;
        if values.len() != count {
            return None;
        }
        let mut sums = Accumulation::zero(shape);
        for part in sums.sums.iter_mut().chain([&mut sums.squares]) {
            part.iter_mut().zip(&mut values).for_each(|(sum, value)| *sum = value);
        }
        Some(sums)
    }

    /// Sums of this shape, at zero.
    fn zero(shape: Shape) -> Accumulation {
        let pixels = shape.width * shape.height;
        let split = if shape.gathers { pixels } else { 0 };
        let sums = [3 * pixels, 3 * split, split, split, split].map(|count| vec![0.0; count]);
        Accumulation { shape, sums, squares: vec![0.0; 3 * pixels] }
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
