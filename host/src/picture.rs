//! Pictures: the layers of a frame, and the mean of several.

use glam::Vec3;

/// A picture and what it is made of, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width [px].
    pub width: usize,
    /// Height [px].
    pub height: usize,
    /// Radiance that is no caustic [W m^-2 sr^-1].
    pub path: Vec<Vec3>,
    /// Radiance of the caustics [W m^-2 sr^-1].
    pub caustics: Vec<Vec3>,
    /// Radius of the collection points [m]; 0 without a point.
    pub radius: Vec<f32>,
    /// Camera vertex of the collection points; 0 without a point.
    pub depth: Vec<f32>,
    /// Deposits taken.
    pub deposits: Vec<f32>,
}

/// The mean of several pictures.
#[derive(Clone, Debug, Default)]
pub struct Average {
    sum: Picture,
    frames: u32,
}

impl Average {
    /// Adds a picture; all must have one size.
    pub fn add(&mut self, picture: Picture) {
        if self.frames == 0 {
            self.sum = picture;
        } else {
            let vectors =
                |sum: &mut [Vec3], new: &[Vec3]| sum.iter_mut().zip(new).for_each(|(s, n)| *s += *n);
            let numbers = |sum: &mut [f32], new: &[f32]| sum.iter_mut().zip(new).for_each(|(s, n)| *s += *n);
            vectors(&mut self.sum.path, &picture.path);
            vectors(&mut self.sum.caustics, &picture.caustics);
            numbers(&mut self.sum.radius, &picture.radius);
            numbers(&mut self.sum.depth, &picture.depth);
            numbers(&mut self.sum.deposits, &picture.deposits);
        }
        self.frames += 1;
    }

    /// Pictures added.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The mean.
    pub fn mean(&self) -> Picture {
        let scale = 1.0 / self.frames.max(1) as f32;
        let mut mean = self.sum.clone();
        if self.frames > 1 {
            mean.path.iter_mut().chain(&mut mean.caustics).for_each(|value| *value *= scale);
            let numbers = mean.radius.iter_mut().chain(&mut mean.depth).chain(&mut mean.deposits);
            numbers.for_each(|value| *value *= scale);
        }
        mean
    }
}
