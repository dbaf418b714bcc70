//! The six walls of a room that is a box.

use glam::DVec3;

use crate::gltf::{Document, lambert};
use crate::mesh::Mesh;

/// A wall: its name, its albedo, and the way that it faces, along an axis.
pub type Wall = (&'static str, [f64; 3], DVec3);

/// Adds Lambertian walls around `centre`, `half` the room's size away (m), each a mesh with a material of its own.
pub fn add_walls(document: &mut Document, centre: DVec3, half: DVec3, walls: [Wall; 6]) {
    for (name, albedo, facing) in walls {
        let material = document.material(name, lambert(albedo));
        document.mesh(name, material, &wall(centre, half, facing));
    }
}

/// The wall of a room that faces this way.
pub fn wall(centre: DVec3, half: DVec3, facing: DVec3) -> Mesh {
    let right = if facing.y == 0.0 { DVec3::Y.cross(facing) } else { DVec3::X };
    let up = facing.cross(right);
    Mesh::default().panel(centre - facing * half, right * half, up * half)
}
