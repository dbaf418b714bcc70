//! Rendered images: the layers of a frame, or of a mean of frames.

use glam::Vec3;

pub mod auxiliary;

pub use auxiliary::{Aov, Auxiliary};

/// Rendered image by layers, row by row from the top. Layers that a method does not make are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderedImage {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// Radiance without the caustics (W m^-2 sr^-1); all radiance if `caustics` is empty.
    pub path: Vec<Vec3>,
    /// Radiance of the caustics (W m^-2 sr^-1).
    pub caustics: Vec<Vec3>,
    /// Radius of each pixel's collection point (m); 0 where the pixel has none.
    pub radius: Vec<f32>,
    /// Index of the camera path's vertex at each pixel's collection point; 1 is the first visible surface, 0 stands for no
    /// point.
    pub depth: Vec<f32>,
    /// Number of photons gathered at each pixel's collection point.
    pub photons: Vec<f32>,
    /// Layers for other tools; empty unless requested.
    pub auxiliary: Auxiliary,
}

impl RenderedImage {
    /// Appends the image of the rows below.
    pub fn append(&mut self, below: RenderedImage) {
        self.width = below.width;
        self.height += below.height;
        self.path.extend(below.path);
        self.caustics.extend(below.caustics);
        self.radius.extend(below.radius);
        self.depth.extend(below.depth);
        self.photons.extend(below.photons);
        self.auxiliary.append(below.auxiliary);
    }

    /// Returns all radiance of each pixel (W m^-2 sr^-1): the sum of `path` and `caustics`.
    pub fn beauty(&self) -> Vec<Vec3> {
        if self.caustics.is_empty() {
            return self.path.clone();
        }
        self.path.iter().zip(&self.caustics).map(|(path, caustics)| *path + *caustics).collect()
    }
}
