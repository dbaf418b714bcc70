//! Small scenes with one moving object, and the share of the caustics' energy that a history keeps there.

use std::fs;

use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics_kernels::history::{History, NONE};
use serde_json::{Value, json};

use crate::frames::{Frames, sums};
use crate::scenes::{copied, make_glass};
use crate::statistics::Mean;

/// The moving object, whose speed is 0.6 m/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moving {
    /// A ring of metal, which hides the previous position of its caustics.
    MetalCaster,
    /// A ring of metal between rings that stand still.
    MetalAmongOthers,
    /// A ring of glass.
    GlassCaster,
    /// The light.
    Light,
    /// The camera.
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

    /// Builds the scene: `moving-caster` with one change.
    pub fn scene(self) -> Scene {
        self.changed(|_| {})
    }

    /// Builds the scene with a mirror behind it, in which the camera sees it. The light is `light_scale` times as wide
    /// and emits the same flux.
    pub fn in_a_mirror(self, light_scale: f64) -> Scene {
        self.changed(|document| {
            add_mirror(document);
            widen_light(document, light_scale);
        })
    }

    /// Builds the scene with further changes of its document.
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

/// A ring at rest, seen in a mirror that moves away by 0.6 m/s; its light is `light_scale` times as wide.
pub fn moving_mirror(light_scale: f64) -> Scene {
    Moving::MetalCaster.changed(|document| {
        let mirror = add_mirror(document);
        widen_light(document, light_scale);
        carry(document, mirror);
        // The animation moves along x; in a group that is turned by a right angle, this is -z.
        let roots = document["scenes"][0]["nodes"].as_array_mut().expect("roots");
        let group = roots.pop().expect("the carrying node");
        let turned = [0.0, HALF_ROOT, 0.0, HALF_ROOT];
        add_root(document, json!({ "rotation": turned, "children": [group] }));
        // Turn up by a right angle about x, then back by one about y.
        let node = &mut document["nodes"][mirror];
        node["rotation"] = json!([0.5, -0.5, 0.5, 0.5]);
        // (x, y, z) of the group is (z, y, -x) of the world.
        node["translation"] = json!([1.2, 1.1, 0.0]);
    })
}

/// Widens the light by a factor and keeps its flux.
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

/// Puts a mirror of 2.4 x 2.4 m behind the scene, 1.2 m from its middle, and the camera before it. Returns the mirror's
/// node.
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
    // The floor's square, scaled and turned to face +z.
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

/// Keeps the ring at rest in the middle, and lets the animation move this node instead.
fn carry(document: &mut Value, node: usize) {
    document["nodes"][1]["translation"] = json!([0.0, 0.0, 0.0]);
    let roots = document["scenes"][0]["nodes"].as_array_mut().expect("roots");
    roots.retain(|root| root.as_u64() != Some(node as u64));
    let group = add_root(document, json!({ "translation": [-0.3, 0.0, 0.0], "children": [node] }));
    document["animations"][0]["channels"][0]["target"]["node"] = json!(group);
}

/// Sum of the caustics over the first frames at 24 per second: with each history over without, over several seeds. All
/// runs trace the same light paths.
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
