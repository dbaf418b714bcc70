//! Small scenes of one second in which one thing changes, for tests of histories.

use glam::DVec3;

use crate::gltf::{Document, Interpolation, Node, Property, emitter, lambert, looking, metal};
use crate::mesh::Mesh;

/// Half the light's side (m).
const LIGHT_HALF_SIDE: f64 = 0.05;
/// Radiance of a light (W m^-2 sr^-1): about 1 W/m^2 at its target.
const RADIANCE: f64 = 1400.0;
/// Offset of a light from its target (m).
const TO_LIGHT: DVec3 = DVec3::new(2.6, 2.6, 0.0);
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.001;
/// Time of the last key (s).
const END: f64 = 1.0;
/// Time of jumps (s).
const JUMP: f64 = 0.5;

/// One of two lamps goes out.
pub fn light_off() -> Document {
    let mut document = Document::default();
    add_floor(&mut document, 2.0, 0.0);
    add_ring(&mut document);
    add_light(&mut document, "lamp that stays", TO_LIGHT);
    let out = add_light(&mut document, "lamp that goes out", TO_LIGHT * DVec3::new(-1.0, 1.0, 1.0));
    let scales = [[1.0; 3], [0.0; 3], [0.0; 3]];
    document.animate(out, Property::Scale, Interpolation::Step, &[0.0, JUMP, END], &scales);
    look_down(&mut document);
    document
}

/// The caster slides over the floor, under a resting lamp.
pub fn moving_caster() -> Document {
    let mut document = Document::default();
    add_floor(&mut document, 2.0, 0.0);
    let ring = add_ring(&mut document);
    add_light(&mut document, "lamp", TO_LIGHT);
    slide(&mut document, ring);
    look_down(&mut document);
    document
}

/// A plate carries caster and lamp.
pub fn moving_receiver() -> Document {
    let mut document = Document::default();
    add_floor(&mut document, 4.0, -0.1);
    let plate = add_plate(&mut document, 1.0);
    let ring = add_ring(&mut document);
    let light = add_light(&mut document, "lamp", TO_LIGHT);
    let group = document.group("group", &[plate, ring, light]);
    slide(&mut document, group);
    look_down(&mut document);
    document
}

/// A plate slides below a resting caster and lamp.
pub fn sliding_receiver() -> Document {
    let mut document = Document::default();
    add_floor(&mut document, 4.0, -0.1);
    let plate = add_plate(&mut document, 1.5);
    add_ring(&mut document);
    add_light(&mut document, "lamp", TO_LIGHT);
    slide(&mut document, plate);
    look_down(&mut document);
    document
}

/// The camera jumps to the other side of a wall: the views share no point.
pub fn camera_cut() -> Document {
    let mut document = Document::default();
    add_floor(&mut document, 4.0, 0.0);
    let grey = document.material("wall", lambert([0.5, 0.5, 0.5]));
    let wall = Mesh::default().block(DVec3::new(-3.9, GAP, -0.05), DVec3::new(3.9, 5.0, 0.05));
    document.mesh("wall", grey, &wall);
    let side = DVec3::new(0.0, 0.0, 2.0);
    for (name, side) in [("front", side), ("back", -side)] {
        let ring = add_ring(&mut document);
        document.place(ring, side);
        let light = add_light(&mut document, &format!("{name} lamp"), TO_LIGHT);
        document.place(light, TO_LIGHT + side);
    }
    let front = (side + DVec3::new(0.0, 2.2, 1.3), side);
    let back = (-side - DVec3::new(0.0, -2.2, 1.3), -side);
    let camera = document.camera("main", front.0, front.1, 0.7, 16.0 / 9.0);
    let views = [front, back, back];
    let eyes = views.map(|(eye, _)| eye.to_array());
    let turns = views.map(|(eye, target)| looking(eye, target).to_array());
    let times = [0.0, JUMP, END];
    document.animate(camera, Property::Translation, Interpolation::Step, &times, &eyes);
    document.animate(camera, Property::Rotation, Interpolation::Step, &times, &turns);
    document
}

/// Adds a floor at this height (m).
fn add_floor(document: &mut Document, half: f64, height: f64) {
    let material = document.material("floor", lambert([0.6, 0.58, 0.55]));
    let centre = DVec3::new(0.0, height, 0.0);
    document.mesh("floor", material, &Mesh::default().panel(centre, half * DVec3::Z, half * DVec3::X));
}

/// Adds a plate slightly above the floor and below the ring.
fn add_plate(document: &mut Document, half_length: f64) -> Node {
    let material = document.material("plate", lambert([0.62, 0.62, 0.7]));
    let half = DVec3::new(half_length, 0.0, 0.8);
    let top = DVec3::new(0.0, -GAP, 0.0);
    let mesh = Mesh::default().block(-half + top - DVec3::Y * 0.05, half + top);
    document.mesh("plate", material, &mesh)
}

/// Adds a ring around the origin, on y = 0.
fn add_ring(document: &mut Document) -> Node {
    let material = document.material("ring", metal([0.95, 0.9, 0.8], 0.0));
    let base = DVec3::new(0.0, GAP, 0.0);
    document.mesh("ring", material, &Mesh::default().ring(base, 0.4, 0.408, 0.3, 256, 2))
}

/// Adds a light at `from` (m) that faces in the direction of the origin; its node is at the light.
fn add_light(document: &mut Document, name: &str, from: DVec3) -> Node {
    let material = document.material(name, emitter([1.0, 0.95, 0.85], RADIANCE));
    let facing = -from.normalize();
    let panel = Mesh::default().panel(
        DVec3::ZERO,
        LIGHT_HALF_SIDE * DVec3::Z,
        LIGHT_HALF_SIDE * facing.cross(DVec3::Z),
    );
    let light = document.mesh(name, material, &panel);
    document.place(light, from);
    light
}

/// Moves a node along x, from -0.3 to 0.3 m.
fn slide(document: &mut Document, node: Node) {
    let positions = [[-0.3, 0.0, 0.0], [0.3, 0.0, 0.0]];
    document.place(node, DVec3::from_array(positions[0]));
    document.animate(node, Property::Translation, Interpolation::Linear, &[0.0, END], &positions);
}

fn look_down(document: &mut Document) {
    document.camera("main", DVec3::new(0.0, 2.3, 1.3), DVec3::ZERO, 0.7, 16.0 / 9.0);
}
