//! A bar at night, similar to Bistro Interior: bottles and glasses before a mirror, under many small lamps.
//!
//! Every glass is a solid with a wall, every bottle a solid of tinted glass. Nodes share shapes, so that the file is small; a
//! loader that bakes nodes makes separate triangles of each.

use glam::DVec3;

use self::furniture::{BACK_TOP, COUNTER_TOP, COUNTER_X, COUNTER_Z, POST, POSTS, SHELF_Z, SHELVES};
use self::glasses::Glasses;
use self::metal::{TABLE_TOP, TRAY, Turned};
use self::palette::Palette;
use crate::gltf::{Document, Shape};

mod bottles;
mod furniture;
mod glasses;
mod lights;
mod metal;
mod palette;

/// Size of the room (m); x is centred, y and z start at 0.
const ROOM: DVec3 = DVec3::new(7.2, 3.1, 5.2);
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.0005;
/// Positions of the tables in x and z (m).
const TABLES: [[f64; 2]; 3] = [[-2.1, 3.3], [-0.3, 4.1], [1.6, 3.9]];

/// Builds the bar.
pub fn build() -> Document {
    let mut document = Document::default();
    let palette = Palette::new(&mut document);
    furniture::add_room(&mut document, &palette);
    furniture::add_counter(&mut document, &palette);
    furniture::add_back_bar(&mut document, &palette);
    lights::add(&mut document, &palette);
    let glasses = Glasses::new(&mut document, &palette);
    let bottles = bottles::add(&mut document, &palette);
    let turned = Turned::new(&mut document, &palette);
    let mut scatter = Scatter(1);
    fill_shelves(&mut document, &mut scatter, &glasses, &bottles);
    fill_back_bar(&mut document, &mut scatter, &glasses, &turned);
    fill_counter(&mut document, &mut scatter, &glasses, &bottles, &turned);
    fill_room(&mut document, &mut scatter, &glasses, &turned);
    let main = (DVec3::new(2.95, 1.60, 2.60), DVec3::new(-0.3, 1.16, 0.60));
    document.camera("main", main.0, main.1, 45_f64.to_radians(), 16.0 / 9.0);
    let counter = (DVec3::new(1.55, 1.55, 2.45), DVec3::new(0.55, 1.12, 1.25));
    document.camera("counter", counter.0, counter.1, 40_f64.to_radians(), 16.0 / 9.0);
    document
}

/// Small deterministic displacements by a linear congruential generator.
struct Scatter(u32);

impl Scatter {
    /// Uniform in 0..count.
    fn pick(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 16) as usize % count
    }

    /// Uniform in [-`max_offset`, `max_offset`], in 2000 steps.
    fn within(&mut self, max_offset: f64) -> f64 {
        (self.pick(2001) as f64 / 1000.0 - 1.0) * max_offset
    }
}

/// Places a shape at a height, at x and z (m).
fn put(document: &mut Document, name: &str, shape: Shape, [x, height, z]: [f64; 3]) {
    let node = document.node(name, shape);
    document.place(node, DVec3::new(x, height + GAP, z));
}

/// Fills the two lower shelves with bottles, and the third with glasses.
fn fill_shelves(document: &mut Document, scatter: &mut Scatter, glasses: &Glasses, bottles: &[Shape]) {
    let middle = 0.5 * (SHELF_Z[0] + SHELF_Z[1]);
    for (row, height) in SHELVES.into_iter().enumerate() {
        let (pitch, max_offset) = if row < 2 { (0.124, 0.006) } else { (0.100, 0.003) };
        for ends in POSTS.windows(2) {
            let (from, to) = (ends[0] + POST + 0.085, ends[1] - POST - 0.085);
            let count = ((to - from) / pitch).floor();
            for k in 0..=count as u32 {
                let x = from + (to - from) * f64::from(k) / count + scatter.within(max_offset);
                let position = [x, height, middle + scatter.within(0.02)];
                if row < 2 {
                    // Bottles of a kind stand in runs; the carafe is rare.
                    let kind = (k as usize / 3 + 2 * row + scatter.pick(2)) % 6;
                    let kind = if scatter.pick(16) == 0 { 6 } else { kind };
                    put(document, "bottle", bottles[kind], position);
                } else {
                    let kind = [glasses.wine, glasses.flute, glasses.martini][(k as usize / 5 + row) % 3];
                    // A martini glass is as wide as the pitch: use every other position.
                    if (k as usize / 5 + row) % 3 < 2 || k.is_multiple_of(2) {
                        put(document, "glass", kind, position);
                    }
                }
            }
        }
    }
}

/// Places few things below the shelves, so that the mirror shows the counter.
fn fill_back_bar(document: &mut Document, scatter: &mut Scatter, glasses: &Glasses, turned: &Turned) {
    for k in 0..10_u32 {
        for row in 0..2_u32 {
            let x = -2.6 + 0.1 * f64::from(k);
            let position = [x + scatter.within(0.004), BACK_TOP, 0.16 + 0.1 * f64::from(row)];
            put(document, "glass", if row == 0 { glasses.highball } else { glasses.tumbler }, position);
        }
    }
    for x in [-1.0, -0.8, 1.9] {
        put(document, "shaker", turned.shaker, [x, BACK_TOP, 0.22 + scatter.within(0.03)]);
    }
}

/// Places served drinks, and a tray of flutes.
fn fill_counter(
    document: &mut Document,
    scatter: &mut Scatter,
    glasses: &Glasses,
    bottles: &[Shape],
    turned: &Turned,
) {
    let [back, front] = COUNTER_Z;
    let served = [
        ("tumbler of whiskey", glasses.whiskey),
        ("wine glass", glasses.wine),
        ("highball", glasses.highball),
        ("tumbler", glasses.tumbler),
        ("martini glass", glasses.martini),
        ("glass of red wine", glasses.red_wine),
        ("flute", glasses.flute),
        ("tumbler", glasses.tumbler),
    ];
    // A grid of cells with gaps; each object stands at random in its own cell.
    let (columns, width) = (20_u32, (COUNTER_X[1] - COUNTER_X[0] - 0.3) / 20.0);
    for column in 0..columns {
        let x = COUNTER_X[0] + 0.15 + width * (f64::from(column) + 0.5);
        for (row, z) in [front - 0.13, front - 0.32].into_iter().enumerate() {
            let (name, shape) = served[(column as usize * 3 + row * 5 + scatter.pick(2)) % served.len()];
            let position = [x + scatter.within(0.07), COUNTER_TOP, z + scatter.within(0.03)];
            let is_clear = (4..6).contains(&column) || (10..12).contains(&column);
            if !is_clear && scatter.pick(4) > 0 {
                put(document, name, shape, position);
            }
        }
    }
    let tray = [-1.45, 0.5 * (back + front)];
    put(document, "tray", turned.tray, [tray[0], COUNTER_TOP, tray[1]]);
    for (x, z) in [(0.0, 0.0), (0.09, 0.05), (-0.09, 0.05), (0.07, -0.08), (-0.07, -0.08)] {
        put(
            document,
            "flute of sparkling wine",
            glasses.sparkling,
            [tray[0] + x, COUNTER_TOP + TRAY + GAP, tray[1] + z],
        );
    }
    put(document, "tap", turned.tap, [0.1, COUNTER_TOP, back + 0.13]);
    put(document, "bucket", turned.bucket, [0.4, COUNTER_TOP, back + 0.14]);
    for (k, x) in [-2.7, -2.4, -0.8, -0.6, 1.0, 1.2, 2.2].into_iter().enumerate() {
        let position = [x, COUNTER_TOP, back + 0.1];
        match k % 3 {
            0 => put(document, "shaker", turned.shaker, position),
            _ => put(document, "bottle", bottles[(2 * k) % 7], position),
        }
    }
}

/// Places stools, tables and the glasses on them.
fn fill_room(document: &mut Document, scatter: &mut Scatter, glasses: &Glasses, turned: &Turned) {
    for x in [-2.5, -1.5, -0.5, 0.5, 1.5] {
        put(document, "stool", turned.stool, [x + scatter.within(0.08), 0.0, 2.12 + scatter.within(0.05)]);
    }
    for [x, z] in TABLES {
        put(document, "table", turned.table, [x, 0.0, z]);
        let set = [glasses.red_wine, glasses.wine, glasses.water, glasses.whiskey, glasses.sparkling];
        let offsets = [[0.0, -0.22], [0.21, -0.04], [0.13, 0.2], [-0.14, 0.19], [-0.2, -0.05]];
        for (shape, [dx, dz]) in set.into_iter().zip(offsets) {
            let position = [x + dx + scatter.within(0.02), TABLE_TOP + GAP, z + dz + scatter.within(0.02)];
            put(document, "glass", shape, position);
        }
    }
}
