//! Files with materials and textures.

use glam::DVec3;
use serde_json::{Value, json};

use super::paint;
use super::small::Small;
use crate::mesh::Mesh;
use crate::texture::{draw, normal};

/// An upright square of two metres before a wall.
pub(super) fn panel() -> Mesh {
    Mesh::default().mapped_panel(DVec3::new(0.0, 1.0, 0.5), DVec3::X, DVec3::Y, 1.0)
}

pub(super) fn wall(small: &mut Small) {
    small.thing(
        paint([0.3, 0.5, 0.8]),
        &Mesh::default().panel(DVec3::new(0.0, 1.0, 0.0), DVec3::X * 1.5, DVec3::Y * 1.2),
    );
}

pub(super) fn textured(texture: &Value) -> Value {
    json!({ "pbrMetallicRoughness": {
        "baseColorTexture": texture, "metallicFactor": 0.0, "roughnessFactor": 0.8,
    } })
}

/// A checkerboard of two colours.
pub(super) fn checks() -> Vec<u8> {
    draw(16, |u, v| {
        let is_light = ((u * 4.0) as u32 + (v * 4.0) as u32).is_multiple_of(2);
        if is_light { [230, 220, 200, 255] } else { [60, 30, 20, 255] }
    })
}

pub fn packed() -> Small {
    let mut small = Small::new();
    let texture = small.texture(&checks());
    small.thing(textured(&json!({ "index": texture })), &panel());
    small
}

pub fn mask() -> Small {
    let mut small = Small::new();
    wall(&mut small);
    let texture = small.texture(&draw(32, |u, v| {
        let inside = (u - 0.5).hypot(v - 0.5) < 0.35;
        [220, 120, 40, if inside { 0 } else { 255 }]
    }));
    let mut material = textured(&json!({ "index": texture }));
    material["alphaMode"] = json!("MASK");
    material["alphaCutoff"] = json!(0.4);
    material["doubleSided"] = json!(true);
    small.thing(material, &panel());
    small
}

pub fn normal_map() -> Small {
    let mut small = Small::new();
    let texture = small.texture(&draw(32, |u, v| {
        let wave = |x: f64| 0.6 * (x * 2.0 * std::f64::consts::TAU).sin();
        normal(wave(u), wave(v))
    }));
    let mut material = paint([0.7, 0.7, 0.7]);
    material["normalTexture"] = json!({ "index": texture, "scale": 0.8 });
    small.thing(material, &panel());
    small
}

pub fn texture_transform() -> Small {
    let mut small = Small::new();
    small.uses("KHR_texture_transform");
    let texture = small.texture(&checks());
    let transform = json!({ "offset": [0.25, 0.0], "rotation": 0.5, "scale": [0.5, 0.25] });
    let info = json!({ "index": texture, "extensions": { "KHR_texture_transform": transform } });
    small.thing(textured(&info), &panel());
    small
}

pub fn glass() -> Small {
    let mut small = Small::new();
    for extension in ["ior", "transmission", "volume"] {
        small.uses(&format!("KHR_materials_{extension}"));
    }
    small.thing(paint([0.7, 0.7, 0.7]), &Mesh::default().panel(DVec3::ZERO, DVec3::Z * 1.5, DVec3::X * 1.5));
    let glass = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
        "extensions": {
            "KHR_materials_ior": { "ior": 1.5 },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": {
                "thicknessFactor": 0.5, "attenuationColor": [0.6, 0.9, 0.8], "attenuationDistance": 0.5,
            },
        },
    });
    small.thing(glass, &Mesh::default().sphere(DVec3::new(-0.5, 0.45, 0.2), 0.4, 24, 12));
    let metal = json!({ "pbrMetallicRoughness": {
        "baseColorFactor": [0.9, 0.7, 0.4, 1.0], "metallicFactor": 1.0, "roughnessFactor": 0.05,
    } });
    small.thing(metal, &Mesh::default().sphere(DVec3::new(0.5, 0.4, -0.1), 0.35, 24, 12));
    small
}

pub fn dispersion() -> Small {
    let mut small = Small::new();
    for extension in ["dispersion", "ior", "transmission", "volume"] {
        small.uses(&format!("KHR_materials_{extension}"));
    }
    small.thing(paint([0.7, 0.7, 0.7]), &Mesh::default().panel(DVec3::ZERO, DVec3::Z * 1.5, DVec3::X * 1.5));
    let glass = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
        "extensions": {
            "KHR_materials_dispersion": { "dispersion": 4.0 },
            "KHR_materials_ior": { "ior": 1.8 },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": 0.8 },
        },
    });
    small.thing(glass, &Mesh::default().sphere(DVec3::new(0.0, 0.6, 0.0), 0.5, 32, 16));
    small.uses("KHR_lights_punctual");
    small.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "intensity": 3.0 },
    ] } });
    // Turn the light down and to the left.
    small.root(json!({
        "rotation": [-0.611, -0.251, -0.213, 0.720],
        "extensions": { "KHR_lights_punctual": { "light": 0 } },
    }));
    small
}

pub fn emissive() -> Small {
    let mut small = Small::new();
    small.uses("KHR_materials_emissive_strength");
    wall(&mut small);
    let light = json!({
        "emissiveFactor": [1.0, 0.8, 0.5], "doubleSided": true,
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 4.0 } },
    });
    small.thing(
        light,
        &Mesh::default().panel(DVec3::new(0.0, 1.8, 0.8), DVec3::X * 0.3, DVec3::new(0.0, 0.1, 0.2)),
    );
    small
}
