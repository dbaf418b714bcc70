//! Small scenes with one thing that moves, and how much of the caustics' energy a history keeps there.

use std::fs;

use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics_kernels::history::{History, NONE};
use serde_json::{Value, json};

use crate::frames::{Frames, sums};
use crate::scenes::{copied, make_glass};
use crate::statistics::Mean;

/// What moves, by 0.6 m in a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moving {
    /// A ring of metal, which hides where its caustics were.
    MetalCaster,
    /// The same, between rings that stand still.
    MetalAmongOthers,
    /// A ring of glass.
    GlassCaster,
    /// The light.
    Light,
    /// The eye.
    Camera,
    /// A plate below ring and light.
    Receiver,
}

impl Moving {
    /// Every kind.
    pub const ALL: [Moving; 6] = [
        Moving::MetalCaster,
        Moving::MetalAmongOthers,
        Moving::GlassCaster,
        Moving::Light,
        Moving::Camera,
        Moving::Receiver,
    ];

    /// The scene: `moving-caster` with one thing changed.
    pub fn scene(self) -> Scene {
        self.changed(|_| {})
    }

    /// The scene, looked at in a mirror that stands behind it; its light is so many times as wide, and gives the same light.
    pub fn in_a_mirror(self, light_scale: f64) -> Scene {
        self.changed(|document| {
            add_mirror(document);
            widen_light(document, light_scale);
        })
    }

    /// The scene with more changed of its document.
    fn changed(self, change: impl FnOnce(&mut Value)) -> Scene {
        let receiver = self == Moving::Receiver;
        let (folder, mut document) = copied(if receiver { "sliding-receiver" } else { "moving-caster" });
        match self {
            Moving::MetalCaster | Moving::Receiver => {}
            Moving::MetalAmongOthers => {
                for translation in [[-0.9, 0.0, -0.6], [0.8, 0.0, -0.7], [-0.9, 0.0, 0.5]] {
                    add_root(
                        &mut document,
                        json!({ "mesh": 1, "translation": translation, "scale": [0.7, 0.7, 0.7] }),
                    );
                }
            }
            Moving::GlassCaster => make_glass(&mut document),
            Moving::Light => carry(&mut document, 2),
            Moving::Camera => carry(&mut document, 3),
        }
        change(&mut document);
        let path = folder.path().join("scene.gltf");
        fs::write(&path, document.to_string()).expect("a file");
        Scene::load(&path).expect("the scene loads")
    }
}

/// A ring that stands still, looked at in a mirror that moves away by 0.6 m in a second; its light is so many times as wide.
pub fn moving_mirror(light_scale: f64) -> Scene {
    Moving::MetalCaster.changed(|document| {
        let mirror = add_mirror(document);
        widen_light(document, light_scale);
        carry(document, mirror);
        // The animation moves along x; in a group that is turned by a right angle that is -z.
        let roots = document["scenes"][0]["nodes"].as_array_mut().expect("roots");
        let group = roots.pop().expect("the carrying node");
        let turned = [0.0, HALF_ROOT, 0.0, HALF_ROOT];
        add_root(document, json!({ "rotation": turned, "children": [group] }));
        // Turned back by a right angle about y, after it was turned up by one about x.
        let node = &mut document["nodes"][mirror];
        node["rotation"] = json!([0.5, -0.5, 0.5, 0.5]);
        // (x, y, z) of the group is (z, y, -x) of the world.
        node["translation"] = json!([1.2, 1.1, 0.0]);
    })
}

/// Makes the light so many times as wide, with the same light.
fn widen_light(document: &mut Value, by: f64) {
    let materials = document["materials"].as_array_mut().expect("materials");
    let light = materials.iter_mut().position(|material| {
        let strength = material.pointer_mut("/extensions/KHR_materials_emissive_strength/emissiveStrength");
        let light =
            strength.map(|strength| *strength = json!(strength.as_f64().expect("a number") / (by * by)));
        light.is_some()
    });
    let meshes = document["meshes"].as_array().expect("meshes");
    let mesh = meshes.iter().position(|mesh| mesh["primitives"][0]["material"] == json!(light));
    let nodes = document["nodes"].as_array_mut().expect("nodes").iter_mut();
    for node in nodes.filter(|node| node["mesh"] == json!(mesh)) {
        node["scale"] = json!([by, by, by]);
    }
}

/// Sine of 45 degrees.
const HALF_ROOT: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Puts a mirror of 2.4 x 2.4 m behind the scene, 1.2 m from its middle, and the camera before it; the mirror's node.
fn add_mirror(document: &mut Value) -> usize {
    let push = |list: &mut Value, value: Value| {
        let list = list.as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    };
    let material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.95, 0.95, 0.95, 1.0], "metallicFactor": 1.0, "roughnessFactor": 0.0 },
    });
    let material = push(&mut document["materials"], material);
    // The floor's square, made smaller and turned to face +z.
    let mut square = document["meshes"][0]["primitives"][0].clone();
    let positions = square["attributes"]["POSITION"].as_u64().expect("an accessor") as usize;
    let half = document["accessors"][positions]["max"][0].as_f64().expect("a bound");
    square["material"] = json!(material);
    let mesh = push(&mut document["meshes"], json!({ "primitives": [square] }));
    let scale = 1.2 / half;
    let mirror = json!({
        "mesh": mesh,
        "scale": [scale, scale, scale],
        "rotation": [HALF_ROOT, 0.0, 0.0, HALF_ROOT],
        "translation": [0.0, 1.1, -1.2],
    });
    // The ring's image is at (0, 0, -2.4).
    let pitch = -(1.5f64 / 3.0).atan();
    let cameras = document["nodes"].as_array_mut().expect("nodes").iter_mut();
    for node in cameras.filter(|node| node["camera"].is_u64()) {
        node["translation"] = json!([0.0, 1.5, 0.6]);
        node["rotation"] = json!([(0.5 * pitch).sin(), 0.0, 0.0, (0.5 * pitch).cos()]);
    }
    add_root(document, mirror)
}

fn add_root(document: &mut Value, node: Value) -> usize {
    let nodes = document["nodes"].as_array_mut().expect("nodes");
    nodes.push(node);
    let id = nodes.len() - 1;
    document["scenes"][0]["nodes"].as_array_mut().expect("roots").push(json!(id));
    id
}

/// Lets the ring stand in the middle, and the animation move this node instead.
fn carry(document: &mut Value, node: usize) {
    document["nodes"][1]["translation"] = json!([0.0, 0.0, 0.0]);
    let roots = document["scenes"][0]["nodes"].as_array_mut().expect("roots");
    roots.retain(|root| root.as_u64() != Some(node as u64));
    let group = add_root(document, json!({ "translation": [-0.3, 0.0, 0.0], "children": [node] }));
    document["animations"][0]["channels"][0]["target"]["node"] = json!(group);
}

/// Sum of the caustics over the first frames, 24 a second, with each history over that without: from seed to seed. All have
/// the same light paths.
pub fn kept<const N: usize>(
    moving: Moving,
    histories: [&'static History; N],
    config: &RenderConfig,
    frames: u32,
    seeds: u32,
) -> [Mean; N] {
    let mut scene = moving.scene();
    let mut ratios = [const { Vec::new() }; N];
    for seed in 0..seeds {
        let config = RenderConfig { seed, ..config.clone() };
        let mut energy = |history| {
            scene.pose(0.0).expect("a pose");
            let mut all = Frames::new(&scene, &config, history);
            let frame = |frame| {
                scene.pose(f64::from(frame) / 24.0).expect("a pose");
                sums(&all.pose(&scene, &scene.cameras[0].clone())).iter().sum::<f64>()
            };
            (0..frames).map(frame).sum::<f64>()
        };
        let none = energy(&NONE);
        for (ratios, history) in ratios.iter_mut().zip(histories) {
            ratios.push(energy(history) / none);
        }
    }
    ratios.map(|ratios| Mean::from_samples(&ratios))
}
