//! Mean of frames and variance of that mean, in f64. The variance comes from the squares of independent frames, or from the
//! sums of independent batches that frames take turns in.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use caustics_files::rendered_image::auxiliary::NO_MATERIAL;
use caustics_files::rendered_image::{Auxiliary, RenderedImage};

/// Default number of batches. With fewer batches the mean has less noise, and the estimate of its variance has more.
pub const BATCHES: u32 = 4;

/// Sums of images. The caller adds frames by [`Accumulation::add`] and reads [`Accumulation::mean`] and
/// [`Accumulation::variance`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accumulation {
    /// Size and layers of the images, and the frames that were added.
    pub shape: Shape,
    /// Sums of layers: three channels of `path`, three of `caustics`, then `radius`, `depth`, `photons`. The last four may
    /// be empty.
    sums: [Vec<f64>; 5],
    /// Sums of squares of all radiance, or its sums over each batch; three channels.
    spread: Vec<Vec<f64>>,
    /// Sums of the auxiliary layers: a record of `SHOWN` numbers for each pixel.
    shown: Vec<f64>,
}

/// Size and layers of the images, and the frames that were added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// Index of the first frame.
    #[serde(default)]
    pub first: u32,
    /// Number of frames added.
    pub frames: u32,
    /// Whether the images have caustics and the other layers of a gather.
    pub gathers: bool,
    /// Number of independent batches that frames take turns in; 0 if every frame is independent.
    #[serde(default)]
    pub batches: u32,
    /// Whether the images have auxiliary layers.
    #[serde(default)]
    pub auxiliary: bool,
}

impl Shape {
    /// Returns the index of the frame behind the last added frame.
    pub fn end(&self) -> u32 {
        self.first.saturating_add(self.frames)
    }

    /// Returns the number of frames in a batch.
    fn frames_of(&self, batch: usize) -> u32 {
        let before = |frame: u32| (frame + self.batches - 1 - batch as u32) / self.batches;
        before(self.end()) - before(self.first)
    }
}

impl Accumulation {
    /// Empty accumulation of frames that take turns in `batches` batches; 0 if every frame is independent.
    pub fn in_batches(batches: u32) -> Accumulation {
        Accumulation::from_frame(0, batches)
    }

    /// Empty accumulation of frames from index `first` on. They take turns in `batches` batches; 0 if every frame is
    /// independent.
    pub fn from_frame(first: u32, batches: u32) -> Accumulation {
        Accumulation { shape: Shape { first, batches, ..Shape::default() }, ..Accumulation::default() }
    }

    /// Adds an image.
    ///
    /// # Panics
    ///
    /// If the image has another size or other layers than those before.
    pub fn add(&mut self, image: &RenderedImage) {
        let gathers = !image.caustics.is_empty();
        let auxiliary = !image.auxiliary.is_empty();
        let shape = Shape { width: image.width, height: image.height, gathers, auxiliary, ..self.shape };
        if self.shape.frames == 0 {
            *self = Accumulation::zero(shape);
        }
        assert_eq!(self.shape, shape, "images of one kind are added");
        let batch = self.shape.end().checked_rem(self.shape.batches);
        self.shape.frames += 1;
        let layers: [&[f32]; 5] = [
            bytemuck::cast_slice(&image.path),
            bytemuck::cast_slice(&image.caustics),
            &image.radius,
            &image.depth,
            &image.photons,
        ];
        for (sum, layer) in self.sums.iter_mut().zip(layers) {
            sum.par_iter_mut().zip(layer).for_each(|(sum, &value)| *sum += f64::from(value));
        }
        let [path, caustics, ..] = layers;
        let spread = self.spread[batch.unwrap_or(0) as usize].par_iter_mut().enumerate();
        spread.for_each(|(at, sum)| {
            let value = f64::from(if gathers { path[at] + caustics[at] } else { path[at] });
            *sum += if batch.is_some() { value } else { value * value };
        });
        self.shown
            .par_chunks_mut(SHOWN)
            .enumerate()
            .for_each(|(pixel, record)| show(record, &image.auxiliary, pixel));
    }

    /// Adds the sums of the frames that follow directly.
    ///
    /// # Panics
    ///
    /// If the sums have another size or other layers, or do not follow directly.
    pub fn append(&mut self, next: &Accumulation) {
        let shape = Shape { first: self.shape.end(), frames: next.shape.frames, ..self.shape };
        assert_eq!(next.shape, shape, "frames of one kind follow each other");
        self.shape.frames += next.shape.frames;
        let own = self.sums.iter_mut().chain(&mut self.spread);
        for (own, next) in own.zip(next.sums.iter().chain(&next.spread)) {
            own.par_iter_mut().zip(next).for_each(|(sum, value)| *sum += value);
        }
        for (own, next) in self.shown.chunks_mut(SHOWN).zip(next.shown.chunks(SHOWN)) {
            let first = if own[0] == 0.0 { next } else { &*own };
            let (material, cell) = (first[MATERIAL], first[CELL]);
            own.iter_mut().zip(next).for_each(|(sum, value)| *sum += value);
            (own[MATERIAL], own[CELL]) = (material, cell);
        }
    }

    /// Number of frames added so far.
    pub fn frames(&self) -> u32 {
        self.shape.frames
    }

    /// Returns the mean of all images, layer by layer.
    pub fn mean(&self) -> RenderedImage {
        let scale = 1.0 / f64::from(self.shape.frames.max(1));
        let number = |sum: f64| (sum * scale) as f32;
        let numbers = |sum: &[f64]| sum.iter().map(|&sum| number(sum)).collect();
        let colors = |sum: &[f64]| {
            let pixels = sum.chunks(3).map(|sum| Vec3::new(number(sum[0]), number(sum[1]), number(sum[2])));
            pixels.collect()
        };
        let [path, caustics, radius, depth, photons] = &self.sums;
        RenderedImage {
            width: self.shape.width,
            height: self.shape.height,
            path: colors(path),
            caustics: colors(caustics),
            radius: numbers(radius),
            depth: numbers(depth),
            photons: numbers(photons),
            auxiliary: self.shown(),
        }
    }

    /// Returns the means of the auxiliary layers over the frames in which a pixel has a collection point, and its first
    /// material and cell.
    fn shown(&self) -> Auxiliary {
        let mut auxiliary = Auxiliary::default();
        for record in self.shown.chunks(SHOWN) {
            let scale = 1.0 / record[0].max(1.0);
            let number = |at: usize| (record[at] * scale) as f32;
            let vector = |at: usize| Vec3::new(number(at), number(at + 1), number(at + 2));
            auxiliary.normal.push(vector(1));
            auxiliary.albedo.push(vector(4));
            auxiliary.position.push(vector(7));
            auxiliary.depth.push(number(10));
            auxiliary.motion.push(Vec2::new(number(11), number(12)));
            let first = |at: usize| if record[0] > 0.0 { record[at] as f32 } else { NO_MATERIAL };
            auxiliary.material.push(first(MATERIAL));
            auxiliary.cell.push(first(CELL));
        }
        auxiliary
    }

    /// Estimates the variance of the mean of all radiance in each pixel. `None` for fewer than two frames.
    pub fn variance(&self) -> Option<Vec<Vec3>> {
        if self.shape.frames < 2 {
            return None;
        }
        let channels: Vec<f32> = self.moments().map(|(_, variance)| variance as f32).collect();
        Some(bytemuck::cast_slice(&channels).to_vec())
    }

    /// Estimates the relative mean square error of the mean. See `metric::relmse`: the mean stands for the reference, its
    /// variance for the squared error. Infinite for fewer than two frames.
    pub fn relative_error(&self) -> f64 {
        if self.shape.frames < 2 {
            return f64::INFINITY;
        }
        let count = 3.0 * (self.shape.width * self.shape.height) as f64;
        let whole = self.beauty().sum::<f64>() / count;
        let floor = (0.1 * whole).powi(2).max(f64::MIN_POSITIVE);
        self.moments().map(|(mean, variance)| variance / (mean * mean + floor)).sum::<f64>() / count
    }

    /// Returns the mean of all radiance and the variance of that mean, channel by channel. Needs two frames or more.
    fn moments(&self) -> impl Iterator<Item = (f64, f64)> {
        let shape = self.shape;
        let n = f64::from(shape.frames);
        self.beauty().enumerate().map(move |(i, mean)| {
            if shape.batches == 0 {
                // Rounding may leave a constant pixel a little below zero.
                return (mean, (self.spread[0][i] / n - mean * mean).max(0.0) / (n - 1.0));
            }
            // Weight each batch by its number of frames, since some may have one frame more.
            let batches =
                self.spread.iter().enumerate().map(|(batch, sums)| (shape.frames_of(batch), sums[i]));
            let square =
                |(frames, sum): (u32, f64)| f64::from(frames) * (sum / f64::from(frames) - mean).powi(2);
            let squares: f64 = batches.filter(|(frames, _)| *frames > 0).map(square).sum();
            (mean, squares / f64::from(shape.batches.min(shape.frames) - 1) / n)
        })
    }

    /// Returns the means of all radiance, channel by channel.
    fn beauty(&self) -> impl Iterator<Item = f64> {
        let [path, caustics, ..] = &self.sums;
        let scale = 1.0 / f64::from(self.shape.frames.max(1));
        let caustic = |i: usize| caustics.get(i).copied().unwrap_or(0.0);
        path.iter().enumerate().map(move |(i, path)| (path + caustic(i)) * scale)
    }

    /// Returns all sums as slices of numbers for a checkpoint, in the order of [`Accumulation::from_values`].
    pub fn parts(&self) -> impl Iterator<Item = &[f64]> {
        self.sums.iter().chain(&self.spread).chain([&self.shown]).map(Vec::as_slice)
    }

    /// Restores sums of this shape from numbers in the order of [`Accumulation::parts`]. `None` if the number of values is
    /// wrong.
    pub fn from_values(shape: Shape, mut values: impl ExactSizeIterator<Item = f64>) -> Option<Accumulation> {
        let of_spread = 3usize.checked_mul(shape.batches.max(1) as usize)?;
        let of_layers = if shape.gathers { 9 } else { 3 } + if shape.auxiliary { SHOWN } else { 0 };
        let per_pixel = of_spread.checked_add(of_layers)?;
        // Compare the count before allocating.
        let count = shape.width.checked_mul(shape.height)?.checked_mul(per_pixel)?;
        if values.len() != count {
            return None;
        }
        let mut sums = Accumulation::zero(shape);
        for part in sums.sums.iter_mut().chain(&mut sums.spread).chain([&mut sums.shown]) {
            part.iter_mut().zip(&mut values).for_each(|(sum, value)| *sum = value);
        }
        Some(sums)
    }

    /// Sums of this shape, all zero.
    fn zero(shape: Shape) -> Accumulation {
        let pixels = shape.width * shape.height;
        let split = if shape.gathers { pixels } else { 0 };
        let sums = [3 * pixels, 3 * split, split, split, split].map(|count| vec![0.0; count]);
        // Allocate each batch by itself: cloning would write to the memory before the first frame does.
        let spread = (0..shape.batches.max(1)).map(|_| vec![0.0; 3 * pixels]).collect();
        let shown = vec![0.0; if shape.auxiliary { SHOWN * pixels } else { 0 }];
        Accumulation { shape, sums, spread, shown }
    }
}

/// Numbers of a pixel's auxiliary record. The first counts the frames with a collection point. Sums over these frames
/// follow: normal, albedo, position, depth, motion. The last are the first frame's material and cell.
const SHOWN: usize = 15;
/// Index of the material in the record.
const MATERIAL: usize = 13;
/// Index of the cell in the record.
const CELL: usize = 14;

/// Adds the auxiliary layers of a pixel to its record.
fn show(record: &mut [f64], auxiliary: &Auxiliary, pixel: usize) {
    if auxiliary.depth[pixel] <= 0.0 {
        return;
    }
    if record[0] == 0.0 {
        record[MATERIAL] = f64::from(auxiliary.material[pixel]);
        record[CELL] = f64::from(auxiliary.cell[pixel]);
    }
    record[0] += 1.0;
    let vectors = [&auxiliary.normal, &auxiliary.albedo, &auxiliary.position];
    let vectors = vectors.into_iter().flat_map(|layer| layer[pixel].to_array());
    let values = vectors.chain([auxiliary.depth[pixel]]).chain(auxiliary.motion[pixel].to_array());
    record[1..MATERIAL].iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(path: f32, caustics: f32) -> RenderedImage {
        RenderedImage {
            width: 1,
            height: 1,
            path: vec![Vec3::splat(path)],
            caustics: vec![Vec3::splat(caustics)],
            radius: vec![1.0],
            depth: vec![2.0],
            photons: vec![path],
            ..RenderedImage::default()
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_frames() {
        let mut sums = Accumulation::default();
        for (path, caustics) in [(1.0, 0.0), (2.0, 1.0), (3.0, 2.0)] {
            assert_eq!(sums.variance().is_some(), sums.frames() > 1);
            sums.add(&image(path, caustics));
        }
        assert_eq!(sums.mean(), image(2.0, 1.0));
        // Values 1, 3, 5: the variance of one is 4, the variance of the mean 4 / 3.
        assert!((sums.variance().unwrap()[0].x - 4.0 / 3.0).abs() < 1e-6);
        assert!((sums.relative_error() - 4.0 / 3.0 / 9.09).abs() < 1e-6);
    }

    #[test]
    fn variance_comes_from_the_differences_between_batches() {
        let mut sums = Accumulation::in_batches(2);
        for path in [1.0, 4.0, 3.0, 6.0] {
            sums.add(&image(path, 0.0));
        }
        // Batches of mean 2 and 5: the variance of one is 4.5, the variance of their mean half of that.
        assert!((sums.variance().unwrap()[0].x - 2.25).abs() < 1e-6);
        assert_eq!(sums.mean().path[0].x, 3.5);
        // With at most as many frames as batches, the estimate is that of independent frames.
        let (mut few, mut independent) = (Accumulation::in_batches(4), Accumulation::default());
        for path in [1.0, 2.0, 6.0] {
            few.add(&image(path, 0.0));
            independent.add(&image(path, 0.0));
        }
        assert!((few.variance().unwrap()[0].x - independent.variance().unwrap()[0].x).abs() < 1e-6);
        let values: Vec<f64> = sums.parts().flatten().copied().collect();
        assert_eq!(Accumulation::from_values(sums.shape, values.into_iter()), Some(sums));
        // Frames 1 to 3 in two batches: 3 in one, 4 and 6 in the other, with a mean of 13 / 3.
        let mut part = Accumulation::from_frame(1, 2);
        for path in [4.0, 3.0, 6.0] {
            part.add(&image(path, 0.0));
        }
        let square = |frames: f32, mean: f32| frames * (mean - 13.0 / 3.0).powi(2);
        let variance = (square(1.0, 3.0) + square(2.0, 5.0)) / 3.0;
        assert!((part.variance().unwrap()[0].x - variance).abs() < 1e-6);
    }

    #[test]
    fn auxiliary_layers_are_means_over_frames_with_a_point_and_the_first_material() {
        let mut sums = Accumulation::default();
        for (depth, material) in [(0.0, NO_MATERIAL), (2.0, 7.0), (4.0, 1.0)] {
            let is_there = if depth > 0.0 { 1.0 } else { 0.0 };
            let auxiliary = Auxiliary {
                normal: vec![Vec3::Y * is_there, Vec3::ZERO],
                albedo: vec![Vec3::splat(0.5) * is_there, Vec3::ZERO],
                depth: vec![depth, 0.0],
                position: vec![Vec3::X * depth, Vec3::ZERO],
                motion: vec![Vec2::new(depth, 1.0) * is_there, Vec2::ZERO],
                material: vec![material, NO_MATERIAL],
                cell: vec![material + 2.0 * is_there, NO_MATERIAL],
            };
            let path = vec![Vec3::ONE; 2];
            sums.add(&RenderedImage { width: 2, height: 1, path, auxiliary, ..RenderedImage::default() });
        }
        let mean = sums.mean().auxiliary;
        assert_eq!((&mean.depth[..], &mean.material[..]), (&[3.0, 0.0][..], &[7.0, NO_MATERIAL][..]));
        assert_eq!(mean.cell, [9.0, NO_MATERIAL]);
        assert_eq!((mean.normal[0], mean.albedo[0]), (Vec3::Y, Vec3::splat(0.5)));
        assert_eq!((mean.position[0], mean.motion[0]), (Vec3::X * 3.0, Vec2::new(3.0, 1.0)));
        let values: Vec<f64> = sums.parts().flatten().copied().collect();
        assert_eq!(Accumulation::from_values(sums.shape, values.into_iter()), Some(sums));
    }

    #[test]
    fn appended_parts_of_a_run_equal_the_whole_run() {
        let frame = |index: u32| RenderedImage {
            auxiliary: Auxiliary {
                normal: vec![Vec3::Y],
                albedo: vec![Vec3::ONE],
                depth: vec![if index < 3 { 0.0 } else { 2.0 }],
                position: vec![Vec3::ZERO],
                motion: vec![Vec2::ZERO],
                material: vec![index as f32],
                cell: vec![index as f32 + 1.0],
            },
            ..image((index * index) as f32, index as f32)
        };
        let sums = |frames: std::ops::Range<u32>, batches: u32| {
            let mut sums = Accumulation::from_frame(frames.start, batches);
            frames.for_each(|index| sums.add(&frame(index)));
            sums
        };
        for batches in [0, 4] {
            let mut joined = sums(0..3, batches);
            joined.append(&sums(3..4, batches));
            joined.append(&sums(4..10, batches));
            // Sums of small whole numbers are exact.
            assert_eq!(joined, sums(0..10, batches));
            let Auxiliary { material, cell, .. } = joined.mean().auxiliary;
            assert_eq!((material, cell), (vec![3.0], vec![4.0]));
        }
    }

    #[test]
    #[should_panic(expected = "follow each other")]
    fn appending_frames_behind_a_gap_panics() {
        let mut sums = Accumulation::default();
        sums.add(&image(1.0, 0.0));
        let mut next = Accumulation::from_frame(2, 0);
        next.add(&image(1.0, 0.0));
        sums.append(&next);
    }

    #[test]
    #[should_panic(expected = "images of one kind")]
    fn adding_images_of_two_methods_panics() {
        let mut sums = Accumulation::default();
        sums.add(&image(1.0, 1.0));
        sums.add(&RenderedImage {
            caustics: vec![],
            radius: vec![],
            depth: vec![],
            photons: vec![],
            ..image(1.0, 1.0)
        });
    }
}
