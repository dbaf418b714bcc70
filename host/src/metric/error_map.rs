//! Error of each pixel, its mean, and its display as an image.

use glam::Vec3;

/// Map of errors.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// Error of each pixel in [0, 1], row by row from the top.
    pub values: Vec<f64>,
}

impl ErrorMap {
    /// Returns the mean error.
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// Returns display colours of the map Magma in 256 steps, from black over purple to light yellow.
    pub fn to_colors(&self) -> Vec<Vec3> {
        let color = |&value: &f64| {
            let step = (value.clamp(0.0, 1.0) * 255.0 + 0.5) as usize;
            let color = colorous::MAGMA.eval_rational(step, 256);
            Vec3::new(f32::from(color.r), f32::from(color.g), f32::from(color.b)) / 255.0
        };
        self.values.iter().map(color).collect()
    }

    /// Returns the mean of maps of one size; `None` if there are none.
    pub fn mean_of(maps: impl IntoIterator<Item = ErrorMap>) -> Option<ErrorMap> {
        let mut maps = maps.into_iter();
        let (mut mean, mut count) = (maps.next()?, 1.0);
        for map in maps {
            mean.values.iter_mut().zip(&map.values).for_each(|(sum, value)| *sum += value);
            count += 1.0;
        }
        mean.values.iter_mut().for_each(|value| *value /= count);
        Some(mean)
    }
}
