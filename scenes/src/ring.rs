//! A metal ring on a plane under a distant small emitter.

use glam::DVec3;

use crate::gltf::{Document, emitter, lambert, metal};
use crate::mesh::Mesh;

/// Distance of the emitter from the ring's centre (m).
const DISTANCE: f64 = 10.0;
/// Half the emitter's side (m).
const HALF_SIDE: f64 = 0.05;
/// Radiance of the emitter (W m^-2 sr^-1): about 1 W/m^2 on the plane.
const RADIANCE: f64 = 14_000.0;

/// Builds the scene.
pub fn build() -> Document {
    let mut document = Document::default();
    let plane = document.material("plane", lambert([0.7, 0.7, 0.7]));
    let ring = document.material("ring", metal([0.95, 0.9, 0.8], 0.0));
    let light = document.material("lamp", emitter([1.0, 1.0, 1.0], RADIANCE));

    document.mesh("plane", plane, &Mesh::default().panel(DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X));
    // Slightly above the plane, so that no faces coincide.
    let base = DVec3::new(0.0, 0.001, 0.0);
    document.mesh("ring", ring, &Mesh::default().ring(base, 1.0, 1.01, 0.8, 512, 2));

    // The emitter stands 45 degrees high on the +x side and faces the ring.
    let to_light = DVec3::new(1.0, 1.0, 0.0).normalize();
    let (right, up) = (DVec3::Z, DVec3::new(1.0, -1.0, 0.0).normalize());
    let panel = Mesh::default().panel(DISTANCE * to_light, HALF_SIDE * right, -HALF_SIDE * up);
    document.mesh("lamp", light, &panel);

    document.camera("main", DVec3::new(0.0, 4.6, 2.2), DVec3::new(0.0, 0.1, 0.1), 0.7, 16.0 / 9.0);
    document
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn emitter_faces_the_ring() {
        let up = DVec3::new(1.0, -1.0, 0.0).normalize();
        let normal = DVec3::Z.cross(-up);
        assert!((normal + DVec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-12, "{normal}");
    }
}
