//! Furniture of boards: walls, counter, and the back bar with its mirror and glass shelves.

use glam::DVec3;

use super::{GAP, Palette, ROOM, metal};
use crate::gltf::{Document, lambert};
use crate::mesh::Mesh;
use crate::walls::{self, wall};

/// Ends of the counter along x (m).
pub const COUNTER_X: [f64; 2] = [-3.0, 2.6];
/// Edges of the counter's top along z (m).
pub const COUNTER_Z: [f64; 2] = [1.15, 1.75];
/// Height of the counter's top (m).
pub const COUNTER_TOP: f64 = 1.10;
/// Height of the back bar's top (m).
pub const BACK_TOP: f64 = 0.95;
/// Heights of the shelves' upper faces (m).
pub const SHELVES: [f64; 3] = [1.50, 1.88, 2.26];
/// Centres of the posts between shelves along x (m).
pub const POSTS: [f64; 4] = [-2.95, -1.12, 0.71, 2.54];
/// Rear and front edges of the shelves along z (m).
pub const SHELF_Z: [f64; 2] = [0.04, 0.25];
/// Thickness of a shelf (m).
const BOARD: f64 = 0.010;
/// Half width of a post (m).
pub const POST: f64 = 0.018;

/// Adds the six walls.
pub fn add_room(document: &mut Document, palette: &Palette) {
    let half = 0.5 * ROOM;
    let centre = half.with_x(0.0);
    let painted = [
        ("ceiling", [0.55, 0.53, 0.50], DVec3::NEG_Y),
        ("left wall", [0.36, 0.20, 0.16], DVec3::X),
        ("right wall", [0.30, 0.33, 0.30], DVec3::NEG_X),
        ("front wall", [0.38, 0.34, 0.28], DVec3::NEG_Z),
        ("back wall", [0.20, 0.18, 0.17], DVec3::Z),
    ];
    for (name, albedo, facing) in painted {
        let paint = document.material(name, lambert(albedo));
        document.mesh(name, paint, &walls::wall(centre, half, facing));
    }
    document.mesh("floor", palette.tiles, &wall(centre, half, DVec3::Y));
}

/// Adds the counter and its rails.
pub fn add_counter(document: &mut Document, palette: &Palette) {
    let ([left, right], [back, front]) = (COUNTER_X, COUNTER_Z);
    let top = Mesh::default()
        .block(DVec3::new(left, COUNTER_TOP - 0.045, back), DVec3::new(right, COUNTER_TOP, front));
    document.mesh("counter top", palette.wood, &top);
    let body = Mesh::default().block(
        DVec3::new(left + 0.05, GAP, back + 0.05),
        DVec3::new(right - 0.05, COUNTER_TOP - 0.045 - GAP, front - 0.15),
    );
    document.mesh("counter", palette.panelling, &body);
    let length = right - left;
    metal::rail(document, palette, "hand rail", DVec3::new(left, 1.00, front + 0.06), length, 0.022);
    metal::rail(document, palette, "foot rail", DVec3::new(left, 0.20, front + 0.05), length, 0.025);
}

/// Adds the back bar at the wall.
pub fn add_back_bar(document: &mut Document, palette: &Palette) {
    let ([left, right], back) = (COUNTER_X, GAP);
    let cabinet = Mesh::default()
        .block(DVec3::new(left, GAP, back), DVec3::new(right, BACK_TOP - 0.03 - GAP, 0.40))
        .block(DVec3::new(left, BACK_TOP - 0.03, back), DVec3::new(right, BACK_TOP, 0.43));
    document.mesh("back bar", palette.panelling, &cabinet);

    framed_mirror(
        document,
        palette,
        DVec3::new(0.5 * (POSTS[0] + POSTS[3]), 1.73, 0.014),
        DVec3::X * (0.5 * (POSTS[3] - POSTS[0]) - 0.03),
        DVec3::Y * 0.74,
    );
    // A mirror at the end of the room, which shows the counter lengthwise.
    framed_mirror(
        document,
        palette,
        DVec3::new(-0.5 * ROOM.x + 0.014, 1.65, 2.7),
        DVec3::NEG_Z * 0.55,
        DVec3::Y * 0.65,
    );

    let mut posts = Mesh::default();
    for x in POSTS {
        let (min, max) =
            (DVec3::new(x - POST, BACK_TOP + GAP, 0.016), DVec3::new(x + POST, 2.52, SHELF_Z[0] - GAP));
        posts = posts.block(min, max);
    }
    document.mesh("posts", palette.panelling, &posts);
    let mut shelves = Mesh::default();
    for height in SHELVES {
        for ends in POSTS.windows(2) {
            let min = DVec3::new(ends[0] + POST + GAP, height - BOARD, SHELF_Z[0]);
            let max = DVec3::new(ends[1] - POST - GAP, height, SHELF_Z[1]);
            shelves = shelves.block(min, max);
        }
    }
    document.mesh("glass shelves", palette.glass, &shelves);
}

/// Adds a mirror and a brass frame of four flat bars in its plane, 3 cm wide.
fn framed_mirror(document: &mut Document, palette: &Palette, centre: DVec3, right: DVec3, up: DVec3) {
    document.mesh("mirror", palette.mirror, &Mesh::default().panel(centre, right, up));
    let bar = 0.015;
    let (along, upwards) = (right.normalize() * bar, up.normalize() * bar);
    let mut bars = Mesh::default();
    for sign in [1.0, -1.0] {
        bars = bars.panel(centre + sign * (right + along), along, up + 2.0 * upwards).panel(
            centre + sign * (up + upwards),
            right,
            upwards,
        );
    }
    document.mesh("mirror frame", palette.brass, &bars);
}
