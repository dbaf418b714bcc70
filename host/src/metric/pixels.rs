//! Pixels that are compared: three channels, row by row from the top, with their variance if it is known.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::flip::color;
use caustics_files::image_file::{Channels, Encoding};

/// Colours of a rectangle of pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixels {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// Scene-linear or display-linear red, green and blue.
    pub values: Vec<DVec3>,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Number of columns to the left of the region (px).
    pub x: usize,
    /// Number of rows above the region (px).
    pub y: usize,
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
}

impl Region {
    /// Returns the region of a whole image.
    pub fn whole(image: &Channels) -> Region {
        Region { x: 0, y: 0, width: image.width, height: image.height }
    }

    /// Whether the region has pixels and all are within an image of this size.
    pub fn is_within(&self, width: usize, height: usize) -> bool {
        let side = |start: usize, length: usize, limit: usize| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= limit)
        };
        side(self.x, self.width, width) && side(self.y, self.height, height)
    }
}

impl Pixels {
    /// Reads a layer (see [`Channels::layer`]) within a region of the image. Display colours are decoded to display-linear
    /// ones. `None` if the image has no such layer.
    pub fn from_layer(image: &Channels, layer: &str, region: Region) -> Option<Pixels> {
        let rgb = image.layer(layer)?;
        let rows = region.y..region.y + region.height;
        let index = |row| (row * image.width + region.x..).take(region.width);
        let color = |pixel: usize| Vec3::from_array(rgb.map(|channel| channel[pixel])).as_dvec3();
        let mut values: Vec<DVec3> = rows.flat_map(index).map(color).collect();
        if image.encoding == Encoding::Srgb {
            values.iter_mut().for_each(|value| *value = color::from_srgb(*value));
        }
        Some(Pixels { width: region.width, height: region.height, values })
    }

    /// Returns the number of pixels in which a channel is NaN or infinite.
    pub fn non_finite_count(&self) -> usize {
        self.values.iter().filter(|value| !value.is_finite()).count()
    }

    /// Returns the mean of all channels of all pixels.
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|value| value.element_sum()).sum::<f64>() / (3 * self.values.len()) as f64
    }

    /// Returns the difference to an image of the same size.
    pub fn minus(&self, other: &Pixels) -> Pixels {
        let pairs = self.values.iter().zip(&other.values);
        Pixels { values: pairs.map(|(a, b)| a - b).collect(), width: self.width, height: self.height }
    }

    /// Applies a function to each pixel.
    pub fn map(&self, change: impl Fn(DVec3) -> DVec3 + Sync) -> Pixels {
        Pixels {
            values: self.values.par_iter().map(|&value| change(value)).collect(),
            width: self.width,
            height: self.height,
        }
    }
}

/// Estimate of an image, with its noise.
#[derive(Clone, Debug, Default)]
pub struct Estimate {
    /// Estimated image.
    pub mean: Pixels,
    /// Variance of `mean` per pixel and channel, if it is known. Pixels count as independent.
    pub variance: Option<Pixels>,
    /// Caustics in `mean`, if `mean` is all light and the file has a layer of its caustics.
    pub caustics: Option<Pixels>,
}

impl Estimate {
    /// Reads a layer and, if the file has it, the layer's variance. `None` without the layer.
    /// The variance is `variance.R` and so on for the beauty layer, `NAME.variance.R` for another. The beauty layer also
    /// has its caustics, if the file has them.
    pub fn from_layer(image: &Channels, layer: &str, region: Region) -> Option<Estimate> {
        let variance = if layer.is_empty() { "variance".into() } else { format!("{layer}.variance") };
        Some(Estimate {
            mean: Pixels::from_layer(image, layer, region)?,
            variance: Pixels::from_layer(image, &variance, region),
            caustics: if layer.is_empty() { Pixels::from_layer(image, "caustics", region) } else { None },
        })
    }
}

/// Returns the mean of several images of one size, pixel by pixel.
pub fn mean_of(runs: &[Estimate]) -> Pixels {
    let mut mean = runs[0].mean.clone();
    for run in &runs[1..] {
        mean.values.iter_mut().zip(&run.mean.values).for_each(|(sum, value)| *sum += *value);
    }
    mean.values.iter_mut().for_each(|value| *value /= runs.len() as f64);
    mean
}
