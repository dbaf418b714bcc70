//! Layers for other tools: `--aov`.

use std::collections::BTreeSet;

use caustics::rendered_image::Aov;
use caustics::scene::Scene;
use clap::ValueEnum;
use serde_json::json;

/// The names of layers, in one order.
pub fn names(layers: &[Aov]) -> String {
    let layers: BTreeSet<Aov> = layers.iter().copied().collect();
    layers.into_iter().map(Aov::name).collect::<Vec<_>>().join(",")
}

/// The layers of these names.
pub fn layers(names: &str) -> Vec<Aov> {
    names.split(',').filter_map(|name| Aov::from_str(name, false).ok()).collect()
}

/// What a file says of its layers: which they are, and the names of the materials.
pub fn attributes(layers: &[Aov], scene: &Scene) -> Vec<(String, String)> {
    let mut attributes = Vec::new();
    if !layers.is_empty() {
        attributes.push(("aov".into(), names(layers)));
    }
    if layers.contains(&Aov::Material) {
        attributes.push(("materials".into(), json!(scene.material_names).to_string()));
    }
    attributes
}
