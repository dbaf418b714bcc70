//! Small scenes with one thing that moves, and how much of the caustics' energy a history keeps there.

use std::fs;
use std::path::Path;

use caustics::scene::Scene;
use caustics::settings::Settings;
use caustics_kernels::history::{History, NONE};
use serde_json::{Value, json};

use crate::frames::{Frames, sums};
use crate::scenes::committed;
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
    /// The lamp.
    Lamp,
    /// The eye.
    Camera,
    /// A plate below ring and lamp.
    Receiver,
}

impl Moving {
    /// Every kind.
    pub const ALL: [Moving; 6] = [
        Moving::MetalCaster,
        Moving::MetalAmongOthers,
        Moving::GlassCaster,
        Moving::Lamp,
        Moving::Camera,
        Moving::Receiver,
    ];

    /// The scene: `moving-caster` with one thing changed.
    pub fn scene(self) -> Scene {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/moving-caster");
        let file = fs::read(folder.join("scene.gltf")).expect("a committed scene");
        let mut document: Value = serde_json::from_slice(&file).expect("a glTF file");
        match self {
            Moving::MetalCaster => {}
            Moving::MetalAmongOthers => {
                for place in [[-0.9, 0.0, -0.6], [0.8, 0.0, -0.7], [-0.9, 0.0, 0.5]] {
                    add_root(
                        &mut document,
                        json!({ "mesh": 1, "translation": place, "scale": [0.7, 0.7, 0.7] }),
                    );
                }
            }
            Moving::GlassCaster => {
                let glass = json!({
                    "name": "ring",
                    "extensions": {
                        "KHR_materials_ior": { "ior": 1.5 },
                        "KHR_materials_transmission": { "transmissionFactor": 1.0 },
                        "KHR_materials_volume": { "thicknessFactor": 0.01 },
                    },
                    "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
                });
                document["materials"][1] = glass;
                let used = ["specular", "emissive_strength", "ior", "transmission", "volume"];
                document["extensionsUsed"] = used.map(|name| format!("KHR_materials_{name}")).to_vec().into();
            }
            Moving::Lamp => carry(&mut document, 2),
            Moving::Camera => carry(&mut document, 3),
            Moving::Receiver => return committed("sliding-receiver"),
        }
        let copy = tempfile::tempdir().expect("a folder");
        fs::copy(folder.join("scene.bin"), copy.path().join("scene.bin")).expect("a copy");
        let path = copy.path().join("scene.gltf");
        fs::write(&path, document.to_string()).expect("a file");
        Scene::load(&path).expect("the scene loads")
    }
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
    settings: &Settings,
    frames: u32,
    seeds: u32,
) -> [Mean; N] {
    let mut scene = moving.scene();
    let mut ratios = [const { Vec::new() }; N];
    for seed in 0..seeds {
        let settings = Settings { seed, ..settings.clone() };
        let mut energy = |history| {
            scene.pose(0.0).expect("a pose");
            let mut all = Frames::new(&scene, &settings, history);
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
    ratios.map(|ratios| Mean::of(&ratios))
}
