//! The six walls of a box-shaped room.

use glam::DVec3;

use crate::gltf::{Document, lambert};
use crate::mesh::Mesh;

/// Name, albedo and axis-parallel facing direction of a wall.
pub type Wall = (&'static str, [f64; 3], DVec3);

/// Adds Lambertian walls around `centre`, each a mesh with its own material; `half` is half the room's size (m).
pub fn add_walls(document: &mut Document, centre: DVec3, half: DVec3, walls: [Wall; 6]) {
    for (name, albedo, facing) in walls {
        let material = document.material(name, lambert(albedo));
        document.mesh(name, material, &wall(centre, half, facing));
    }
}

/// The wall of a room that faces in a direction.
pub fn wall(centre: DVec3, half: DVec3, facing: DVec3) -> Mesh {
    let right = if facing.y == 0.0 { DVec3::Y.cross(facing) } else { DVec3::X };
    let up = facing.cross(right);
    Mesh::default().panel(centre - facing * half, right * half, up * half)
}
