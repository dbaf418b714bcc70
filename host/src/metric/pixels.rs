//! The pixels that are compared: three channels, row by row from the top, and how far they may be trusted.

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
    /// Columns to the left of it (px).
    pub x: usize,
    /// Rows above it (px).
    pub y: usize,
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
}

impl Region {
    /// The whole of an image.
    pub fn whole(image: &Channels) -> Region {
        Region { x: 0, y: 0, width: image.width, height: image.height }
    }

    /// Whether it has pixels and all are those of an image of this size.
    pub fn is_within(&self, width: usize, height: usize) -> bool {
        let side = |start: usize, length: usize, limit: usize| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= limit)
        };
        side(self.x, self.width, width) && side(self.y, self.height, height)
    }
}

impl Pixels {
    /// A layer (see [`Channels::layer`]) within a region, which must be within the image; display colours are
    /// decoded to display-linear ones. `None` if the image has no such layer.
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

    /// Number of pixels in which a channel is NaN or infinite.
    pub fn non_finite_count(&self) -> usize {
        self.values.iter().filter(|value| !value.is_finite()).count()
    }

    /// Mean of all channels of all pixels.
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|value| value.element_sum()).sum::<f64>() / (3 * self.values.len()) as f64
    }

    /// Each pixel changed by a function.
    pub fn map(&self, change: impl Fn(DVec3) -> DVec3 + Sync) -> Pixels {
        Pixels {
            values: self.values.par_iter().map(|&value| change(value)).collect(),
            width: self.width,
            height: self.height,
        }
    }
}

/// An image with noise: an estimate of the expected one.
#[derive(Clone, Debug, Default)]
pub struct Estimate {
    /// The estimate.
    pub mean: Pixels,
    /// Variance of `mean`, per pixel and channel, if it is known; pixels are taken as independent.
    pub variance: Option<Pixels>,
    /// What of `mean` are caustics, if it is all light and they are known apart.
    pub caustics: Option<Pixels>,
}

impl Estimate {
    /// A layer and its variance, if the file has it: `variance.R` and so on for the beauty layer, `NAME.variance.R` for
    /// another. With the beauty layer come its caustics, if the file has them. None without the layer.
    pub fn from_layer(image: &Channels, layer: &str, region: Region) -> Option<Estimate> {
        let variance = if layer.is_empty() { "variance".into() } else { format!("{layer}.variance") };
        Some(Estimate {
            mean: Pixels::from_layer(image, layer, region)?,
            variance: Pixels::from_layer(image, &variance, region),
            caustics: if layer.is_empty() { Pixels::from_layer(image, "caustics", region) } else { None },
        })
    }
}

/// Mean of several images of one size, pixel by pixel.
pub fn mean_of(runs: &[Estimate]) -> Pixels {
    let mut mean = runs[0].mean.clone();
    for run in &runs[1..] {
        mean.values.iter_mut().zip(&run.mean.values).for_each(|(sum, value)| *sum += *value);
    }
    mean.values.iter_mut().for_each(|value| *value /= runs.len() as f64);
    mean
}
