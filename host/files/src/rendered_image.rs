//! Images: the layers of a frame, or of a mean of frames.

use glam::Vec3;

pub mod auxiliary;

pub use auxiliary::{Aov, Auxiliary};

/// An image and what it is made of, row by row from the top. Layers that a method does not make are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderedImage {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// Radiance that is no caustic (W m^-2 sr^-1); all radiance where there are no `caustics`.
    pub path: Vec<Vec3>,
    /// Radiance of the caustics (W m^-2 sr^-1).
    pub caustics: Vec<Vec3>,
    /// Radius of each pixel's collection point (m); 0 where the pixel has none.
    pub radius: Vec<f32>,
    /// Which vertex of the camera path each pixel's collection point is, 1 being what is seen directly; 0 where it has none.
    pub depth: Vec<f32>,
    /// Number of photons that each pixel's collection point took.
    pub photons: Vec<f32>,
    /// What other tools ask of the pixels; empty where nobody does.
    pub auxiliary: Auxiliary,
}

impl RenderedImage {
    /// Appends an image of the rows below.
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

    /// All radiance of each pixel (W m^-2 sr^-1): `path` and `caustics` together.
    pub fn beauty(&self) -> Vec<Vec3> {
        if self.caustics.is_empty() {
            return self.path.clone();
        }
        self.path.iter().zip(&self.caustics).map(|(path, caustics)| *path + *caustics).collect()
    }
}
