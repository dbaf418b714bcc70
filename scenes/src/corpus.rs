//! The small files of `tests/corpus`: features that exporters write and viewers show, one or two a file. Most files have neither
//! camera nor light. `CAUSTICS_BLESS=1 cargo test --workspace -p caustics-scenes corpus` writes them.
//!
//! To add a file, add a function and a line of [`ALL`].

use serde_json::json;

use self::small::Small;

mod extensions;
mod geometry;
mod nodes;
mod small;
mod surfaces;

/// A file of the corpus.
#[derive(Clone, Copy, Debug)]
pub struct CorpusFile {
    /// Name of the file, with its extension.
    pub name: &'static str,
    /// Contents, in a few words.
    pub description: &'static str,
    make: fn() -> Small,
}

/// All files.
pub const ALL: [CorpusFile; 32] = [
    entry("plain.gltf", "neither camera nor light; its buffer is a data URI", nodes::plain),
    entry("negative-scale.gltf", "a scale of -1, and a mirror by a matrix", nodes::negative_scale),
    entry("shared-mesh.gltf", "one mesh on many nodes, at several depths", nodes::shared_mesh),
    entry("several-scenes.gltf", "three scenes; the second is the default", nodes::several_scenes),
    entry("no-scene.gltf", "nodes and no scene", nodes::no_scene),
    entry("unused.gltf", "nodes, meshes, materials, cameras of no scene", nodes::unused),
    entry("unicode.gltf", "names in many scripts, extras of every type", nodes::unicode),
    entry("lights.gltf", "a camera; point, spot and directional lights", nodes::lights),
    entry("animation.gltf", "a node that turns (LINEAR), one that jumps (STEP)", nodes::animation),
    entry("strips-fans.gltf", "strips and fans, with and without indices", geometry::strips_fans),
    entry("no-normals.gltf", "positions alone: no normals, indices, material", geometry::no_normals),
    entry("small-types.gltf", "integers of a byte, normalised; interleaved", geometry::small_types),
    entry("far.gltf", "a thing of 2 mm, 30 km from the origin", geometry::far),
    entry("sheet.gltf", "bounds without a depth", geometry::sheet),
    entry("packed.glb", "a binary container with its image inside", surfaces::packed),
    entry("mask.gltf", "holes by alpha (MASK), seen from both sides", surfaces::mask),
    entry("normal-map.gltf", "a normal map with a scale, without tangents", surfaces::normal_map),
    entry("texture-transform.gltf", "KHR_texture_transform", surfaces::texture_transform),
    entry("glass.gltf", "transmission, volume, index of refraction; a metal", surfaces::glass),
    entry("dispersion.gltf", "KHR_materials_dispersion: a ball in the sun", surfaces::dispersion),
    entry("emissive.gltf", "KHR_materials_emissive_strength, the only light", surfaces::emissive),
    entry("blend.gltf", "alphaMode BLEND, by factor and texture", extensions::blend),
    entry("environment.gltf", "`extras.environment` of the scene", extensions::environment),
    entry("sparse.gltf", "sparse accessors, one without a view", extensions::sparse),
    entry("variants.gltf", "KHR_materials_variants, none chosen", extensions::variants),
    entry("clearcoat.gltf", "KHR_materials_clearcoat, smooth and rough", extensions::clearcoat),
    entry("specular-glossiness.gltf", "the extension of that name", extensions::specular_glossiness),
    entry("unlit.gltf", "KHR_materials_unlit beside the same, lit", extensions::unlit),
    entry("vertex-colors.gltf", "COLOR_0 that varies, and that does not", extensions::vertex_colors),
    entry("instancing.gltf", "EXT_mesh_gpu_instancing", extensions::instancing),
    entry("second-coordinates.gltf", "TEXCOORD_1; no source", extensions::second_coordinates),
    entry("left-out.gltf", "points, lines, what nobody knows, empty scenes", extensions::left_out),
];

const fn entry(name: &'static str, description: &'static str, make: fn() -> Small) -> CorpusFile {
    CorpusFile { name, description, make }
}

impl CorpusFile {
    /// Contents of the file.
    pub fn bytes(&self) -> Vec<u8> {
        let small = (self.make)();
        if self.name.ends_with(".glb") { small.glb() } else { small.gltf() }
    }
}

/// Text of `tests/corpus/README.md`.
pub fn readme() -> String {
    let head = "\
# Corpus

Small files that must load and render: [`caustics-scenes`](../../scenes/src/corpus.rs) makes those of the first table, and
`tests/tests/architecture/corpus.rs` renders each and compares it with `tests/golden/corpus`. To add one, write a function and a
line there, or put a file of at most 200 KB under CC0 here with a line in the second table; `npx gltf-transform` is `npx @gltf-transform/cli`
4.5. Then

```sh
CAUSTICS_BLESS=1 cargo test --workspace -p caustics-scenes corpus
CAUSTICS_BLESS=1 cargo test --workspace --test architecture corpus
CAUSTICS_BLESS=1 cargo test --workspace -p caustics-scene verdicts
```

All are CC0, as far as anybody can own a box.

| file | what it has |
|---|---|
";
    let rows: String = ALL.iter().map(|file| format!("| {} | {} |\n", file.name, file.description)).collect();
    format!("{head}{rows}{OTHERS}")
}

/// Second table: files that other programs make from those of the first.
const OTHERS: &str = "
| made of them | what it has | source | licence |
|---|---|---|---|
| draco.glb | KHR_draco_mesh_compression | `npx gltf-transform draco glass.gltf draco.glb` | CC0 |
| meshopt.glb | EXT_meshopt_compression of meshes and keys, KHR_mesh_quantization | `npx gltf-transform meshopt animation.gltf meshopt.glb` | CC0 |
| quantized.glb | KHR_mesh_quantization alone | `npx gltf-transform quantize negative-scale.gltf quantized.glb` | CC0 |
| webp.glb | EXT_texture_webp | `npx gltf-transform webp --lossless true packed.glb webp.glb` | CC0 |
| basis-etc1s.glb, basis-uastc.glb | KHR_texture_basisu | packed.glb by `ktx2` of the npm package ktx2-encoder 0.6 | CC0 |
";

/// A rough dielectric of this colour.
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
    fn corpus_equals_the_generated_files_and_is_small() {
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
        // The table lists each file.
        for entry in entries() {
            let name = entry.file_name().into_string().unwrap();
            let is_named = readme().split(['|', ',', ' ']).any(|word| word == name);
            assert!(name == "README.md" || is_named, "{name}");
        }
    }
}
