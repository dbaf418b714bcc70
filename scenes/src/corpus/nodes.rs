//! Files with nodes, scenes, names, cameras, lights and animations.

use glam::DVec3;
use serde_json::json;

use super::paint;
use super::small::Small;
use crate::mesh::Mesh;

/// A box of half a metre on y = 0.
fn block() -> Mesh {
    Mesh::default().block(DVec3::new(-0.25, 0.0, -0.25), DVec3::new(0.25, 0.5, 0.25))
}

/// A wedge without symmetry, so that its mirror image differs.
fn wedge() -> Mesh {
    let [a, b, c] = [DVec3::ZERO, DVec3::X * 0.6, DVec3::Y * 0.4];
    let back = DVec3::NEG_Z * 0.3;
    let tip = DVec3::new(0.1, 0.1, 0.5);
    Mesh::default().quad([a, b, tip, c]).quad([b, a, a + back, b + back]).quad([
        c + back,
        b + back,
        a + back,
        c + back,
    ])
}

fn floor() -> Mesh {
    Mesh::default().panel(DVec3::ZERO, DVec3::Z * 1.5, DVec3::X * 1.5)
}

pub fn plain() -> Small {
    let mut small = Small::new();
    small.thing(paint([0.6, 0.6, 0.6]), &floor());
    small.thing(paint([0.8, 0.2, 0.1]), &block());
    small
}

pub fn negative_scale() -> Small {
    let mut small = Small::new();
    let red = small.push("materials", paint([0.8, 0.3, 0.1]));
    let mesh = small.mesh(red, &wedge());
    small.root(json!({ "mesh": mesh, "translation": [0.2, 0.0, 0.0] }));
    let inner = small.push("nodes", json!({ "mesh": mesh, "scale": [-1.0, 1.0, 1.0] }));
    // A mirrored node below a mirrored node is not mirrored.
    let twice = small
        .push("nodes", json!({ "mesh": mesh, "scale": [1.0, 1.0, -1.0], "translation": [0.0, 0.5, 0.0] }));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    small.root(json!({
        "children": [inner, twice], "translation": [-0.2, 0.0, 0.0], "scale": [1.0, 1.0, -1.2],
        "rotation": [0.0, half, 0.0, half],
    }));
    small.root(json!({ "mesh": mesh, "matrix": [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0.3, 0.9, 0, 1] }));
    small
}

pub fn shared_mesh() -> Small {
    let mut small = Small::new();
    small.thing(paint([0.5, 0.5, 0.6]), &floor());
    let green = small.push("materials", paint([0.2, 0.7, 0.3]));
    let mesh = small.mesh(green, &block());
    let mut below = None;
    for step in 0..4 {
        let mut node = json!({ "mesh": mesh, "translation": [0.6, 0.1, 0.1], "scale": [0.8, 0.8, 0.8] });
        if let Some(child) = below {
            node["children"] = json!([child]);
        }
        below = Some(match step {
            3 => small.root(node),
            _ => small.push("nodes", node),
        });
    }
    small.root(json!({ "mesh": mesh, "translation": [-0.8, 0.0, 0.4] }));
    small
}

pub fn several_scenes() -> Small {
    let mut small = Small::new();
    let node = small.thing(paint([0.9, 0.1, 0.1]), &floor());
    let blue = small.push("materials", paint([0.2, 0.3, 0.9]));
    let mesh = small.mesh(blue, &block());
    let shown = small.push("nodes", json!({ "mesh": mesh }));
    small.push("scenes", json!({ "name": "shown", "nodes": [shown] }));
    small.push("scenes", json!({ "name": "both", "nodes": [node, shown] }));
    small.json["scene"] = json!(1);
    small
}

pub fn no_scene() -> Small {
    let mut small = plain();
    let object = small.json.as_object_mut().expect("an object");
    object.remove("scene");
    object.remove("scenes");
    small
}

pub fn unused() -> Small {
    let mut small = plain();
    let material = small.push("materials", paint([1.0, 0.0, 1.0]));
    let mesh = small.mesh(material, &wedge());
    let camera =
        small.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }));
    let child = small.push("nodes", json!({ "mesh": mesh, "scale": [0.0, 0.0, 0.0] }));
    small.push("nodes", json!({ "camera": camera, "children": [child] }));
    small.push("nodes", json!({}));
    small.root(json!({ "name": "empty" }));
    small
}

pub fn unicode() -> Small {
    let mut small = plain();
    let names = ["Würfel \u{1f9ca}", "立方体", "مكعب", "a\u{0301}\u{202e}\u{0}\n\t\"\\"];
    small.json["nodes"][0]["name"] = json!(names[0]);
    small.json["nodes"][1]["name"] = json!(names[1]);
    small.json["materials"][0]["name"] = json!(names[2]);
    small.json["meshes"][0]["name"] = json!(names[3]);
    small.json["extras"] = json!([null, true, 1, -1.5e300, "text", {}, { "deep": [[[[{}]]]] }]);
    small.json["asset"]["extras"] = json!("text");
    small.json["nodes"][0]["extras"] = json!(null);
    small.json["nodes"][1]["extras"] = json!(7);
    small.json["materials"][0]["extras"] = json!(["list", { "priority": "none of ours" }]);
    small.json["meshes"][0]["extras"] = json!(false);
    small.json["scenes"][0]["extras"] = json!({ "background of the web page": "#fff" });
    small
}

pub fn lights() -> Small {
    let mut small = plain();
    small.uses("KHR_lights_punctual");
    small.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "color": [1.0, 0.8, 0.6], "intensity": 2.0 },
        { "type": "spot", "intensity": 6.0, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.4 } },
        { "type": "directional", "color": [0.6, 0.8, 1.0], "intensity": 0.5 },
    ] } });
    let lit = |light: usize| json!({ "KHR_lights_punctual": { "light": light } });
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let down = [-half, 0.0, 0.0, half];
    small.root(json!({ "extensions": lit(0), "translation": [-0.8, 1.0, 0.8] }));
    small.root(json!({ "extensions": lit(1), "translation": [0.7, 1.5, 0.3], "rotation": down }));
    small.root(json!({ "extensions": lit(2), "rotation": [-0.5, 0.0, 0.0, 0.9] }));
    let camera =
        small.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }));
    small.root(json!({ "camera": camera, "name": "eye", "translation": [0.0, 1.0, 3.0], "rotation": [-0.13, 0.0, 0.0, 0.99] }));
    small
}

pub fn animation() -> Small {
    let mut small = plain();
    let mesh = small.json["nodes"][1]["mesh"].clone();
    let other = small.root(json!({ "mesh": mesh, "translation": [0.9, 0.0, 0.0] }));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let times = small.floats("SCALAR", 2, &[0.0, 1.0]);
    small.json["accessors"][times]["min"] = json!([0.0]);
    small.json["accessors"][times]["max"] = json!([1.0]);
    let turns = small.floats("VEC4", 2, &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]);
    let jumps = small.floats("VEC3", 2, &[0.9, 0.0, 0.0, 0.9, 0.5, 0.0]);
    small.push(
        "animations",
        json!({
            "samplers": [
                { "input": times, "output": turns, "interpolation": "LINEAR" },
                { "input": times, "output": jumps, "interpolation": "STEP" },
            ],
            "channels": [
                { "sampler": 0, "target": { "node": 1, "path": "rotation" } },
                { "sampler": 1, "target": { "node": other, "path": "translation" } },
            ],
        }),
    );
    small
}
