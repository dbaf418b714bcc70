//! The small files of `tests/corpus`: what exporters write and viewers show, a feature or two each. Most have neither camera nor
//! light. `CAUSTICS_BLESS=1 cargo test --workspace -p caustics-scenes corpus` writes them.
//!
//! A file is a function and a line of [`ALL`].

use serde_json::json;

use self::small::Small;

mod geometry;
mod nodes;
mod small;
mod surfaces;

/// A file of the corpus.
#[derive(Clone, Copy, Debug)]
pub struct CorpusFile {
    /// Its name, with the ending that says what it is.
    pub name: &'static str,
    /// What it has.
    pub about: &'static str,
    make: fn() -> Small,
}

/// All files.
pub const ALL: [CorpusFile; 21] = [
    of("plain.gltf", "neither camera nor light; its buffer is a data URI", nodes::plain),
    of(
        "negative-scale.gltf",
        "nested nodes, one with a scale of -1, one mirrored by a matrix",
        nodes::negative_scale,
    ),
    of("shared-mesh.gltf", "one mesh on many nodes, at several depths", nodes::shared_mesh),
    of("several-scenes.gltf", "three scenes, of which the second is the default", nodes::several_scenes),
    of("no-scene.gltf", "nodes and no scene", nodes::no_scene),
    of("unused.gltf", "nodes, meshes, materials and cameras that no scene has", nodes::unused),
    of("unicode.gltf", "names in many scripts, and extras of every type", nodes::unicode),
    of("lights.gltf", "a camera; a point, a spot and a directional light", nodes::lights),
    of("animation.gltf", "a node that turns (LINEAR) and one that jumps (STEP)", nodes::animation),
    of("strips-fans.gltf", "triangle strips and fans, with and without indices", geometry::strips_fans),
    of("no-normals.gltf", "positions alone: no normals, no indices, no material", geometry::no_normals),
    of(
        "small-types.gltf",
        "indices of a byte, normalised texture coordinates, interleaved vertices",
        geometry::small_types,
    ),
    of("far.gltf", "a thing of 2 mm, 30 km from the origin", geometry::far),
    of("sheet.gltf", "bounds without a depth", geometry::sheet),
    of("packed.glb", "a binary container with its picture inside", surfaces::packed),
    of("mask.gltf", "holes by alpha (MASK), seen from both sides", surfaces::mask),
    of("normal-map.gltf", "a normal map with a scale, without tangents", surfaces::normal_map),
    of("texture-transform.gltf", "KHR_texture_transform on a base colour", surfaces::texture_transform),
    of(
        "glass.gltf",
        "transmission, a volume with attenuation, an index of refraction; a metal",
        surfaces::glass,
    ),
    of(
        "dispersion.gltf",
        "KHR_materials_dispersion: a ball that parts colours, in the sun",
        surfaces::dispersion,
    ),
    of("emissive.gltf", "KHR_materials_emissive_strength: the light of the scene", surfaces::emissive),
];

const fn of(name: &'static str, about: &'static str, make: fn() -> Small) -> CorpusFile {
    CorpusFile { name, about, make }
}

impl CorpusFile {
    /// Its contents.
    pub fn bytes(&self) -> Vec<u8> {
        let small = (self.make)();
        if self.name.ends_with(".glb") { small.glb() } else { small.gltf() }
    }
}

/// What `tests/corpus/README.md` says.
pub fn readme() -> String {
    let head = "\
# Corpus

Small files that must load and render: [`caustics-scenes`](../../scenes/src/corpus.rs) makes those of the first table, and
`tests/tests/house/corpus.rs` renders each and compares it with `tests/golden/corpus`. To add one, write a function and a
line there, or put a file of at most 200 KB under CC0 here with a line in the second table; then

```sh
CAUSTICS_BLESS=1 cargo test --workspace -p caustics-scenes corpus
CAUSTICS_BLESS=1 cargo test --workspace --test house corpus
```

All are CC0, as far as anybody can own a box.

| file | what it has |
|---|---|
";
    let rows: String = ALL.iter().map(|file| format!("| {} | {} |\n", file.name, file.about)).collect();
    format!("{head}{rows}{OTHERS}")
}

/// The second table, of files that others made.
const OTHERS: &str = "
| file of others | what it has | source | licence |
|---|---|---|---|
";

/// A plain rough material of this colour.
fn paint(color: [f64; 3]) -> serde_json::Value {
    json!({ "pbrMetallicRoughness": {
        "baseColorFactor": [color[0], color[1], color[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9,
    } })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const LARGEST: u64 = 200_000;
    const ALL_TOGETHER: u64 = 2_000_000;

    #[test]
    fn the_corpus_is_what_is_made_now_and_small() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/corpus");
        let made = ALL.iter().map(|file| (file.name, file.bytes()));
        for (name, bytes) in made.chain([("README.md", readme().into_bytes())]) {
            let path = folder.join(name);
            if std::env::var_os("CAUSTICS_BLESS").is_some() {
                std::fs::create_dir_all(&folder).unwrap();
                std::fs::write(&path, &bytes).unwrap();
            }
            let found = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            assert!(found == bytes, "{name} differs: make the corpus again");
        }
        let entries = || folder.read_dir().unwrap().map(|entry| entry.unwrap());
        let sizes: Vec<u64> = entries().map(|entry| entry.metadata().unwrap().len()).collect();
        assert!(sizes.iter().all(|size| *size <= LARGEST) && sizes.iter().sum::<u64>() <= ALL_TOGETHER);
        // Each file stands in the table.
        for entry in entries() {
            let name = entry.file_name().into_string().unwrap();
            assert!(name == "README.md" || readme().contains(&format!("| {name} |")), "{name}");
        }
    }
}
