//! Pictures: the layers of a frame.

use glam::Vec3;

/// A picture and what it is made of, row by row from the top. Layers that a method does not make are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width (px).
    pub width: usize,
    /// Height (px).
    pub height: usize,
    /// Radiance that is no caustic (W m^-2 sr^-1); all radiance where there are no `caustics`.
    pub path: Vec<Vec3>,
    /// Radiance of the caustics (W m^-2 sr^-1).
    pub caustics: Vec<Vec3>,
    /// Radius of the collection points (m); 0 without a point.
    pub radius: Vec<f32>,
    /// Camera vertex of the collection points; 0 without a point.
    pub depth: Vec<f32>,
    /// Deposits taken.
    pub deposits: Vec<f32>,
}

impl Picture {
    /// All radiance (W m^-2 sr^-1).
    pub fn beauty(&self) -> Vec<Vec3> {
        if self.caustics.is_empty() {
            return self.path.clone();
        }
        self.path.iter().zip(&self.caustics).map(|(path, caustics)| *path + *caustics).collect()
    }
}
