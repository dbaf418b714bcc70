//! Deterministic generators of the scenes: equal bytes on every run. Imports no other crate of caustics.
//!
//! A scene is a function in its own file that fills a `gltf::Document` with meshes of `mesh`.

#![forbid(unsafe_code)]

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

mod animated_camera;
mod animated_light;
mod bar;
mod cornell;
pub mod corpus;
mod gltf;
mod lathe;
mod mesh;
mod moving;
mod prism;
mod ring;
mod room;
mod still_life;
mod texture;
mod textured;
mod uplight;
mod walls;

use cornell::Detail;

/// Names of the scenes.
pub const NAMES: [&str; 16] = [
    "still-life",
    "mirror-room",
    "glossy-room",
    "ring",
    "plain-room",
    "textured-room",
    "animated-camera",
    "animated-light",
    "light-off",
    "moving-caster",
    "moving-receiver",
    "sliding-receiver",
    "camera-cut",
    "cornell-box",
    "uplight",
    "prism",
];

/// Names of the scenes that are too large to be committed and are made on demand.
pub const ON_DEMAND: [&str; 5] = ["bar", "cornell-1k", "cornell-10k", "cornell-100k", "cornell-1m"];

/// Note of `cornell-box` with other numbers of triangles.
const CORNELL_CUT: &str = include_str!("notes/cornell-cut.md");

/// Describes a scene in one line.
pub fn description(name: &str) -> Option<&'static str> {
    Some(match name {
        "mirror-room" => {
            "A glass ball and a metal ring behind a screen: their caustics are seen only in a wall mirror."
        }
        "still-life" => {
            "Coloured glass and brass: caustics seen in a mirror and through a pane, in warm and cool light."
        }
        "glossy-room" => "mirror-room with a mirror of roughness 0.15.",
        "uplight" => "A lamp lights a spot of the ceiling, which a glass ball gathers on the floor.",
        "prism" => "A prism and a ball of dispersive glass: light fans out into colours.",
        "ring" => "A metal ring on a plane under a distant small emitter: the nephroid.",
        "textured-room" => {
            "Tiles, bricks, leaves, a metal polished in rings and a lamp of panes: every kind of texture."
        }
        "animated-camera" => {
            "A flight along a perfect and a glossy mirror, which show caustics on the floor."
        }
        "animated-light" => {
            "A lamp swings: its caustics run over floor and walls, before a perfect and a glossy mirror."
        }
        "light-off" => "A metal ring between two lamps, one of which goes out after 0.5 s.",
        "moving-caster" => "A metal ring slides over a floor.",
        "moving-receiver" => {
            "A plate moves and carries a metal ring and a lamp: the caustic is fixed to the plate."
        }
        "sliding-receiver" => {
            "A plate slides below a metal ring and a lamp: the caustic is fixed in the world."
        }
        "camera-cut" => "The camera jumps after 0.5 s to the other side of a wall.",
        "bar" => "Bottles and glasses before a mirror, under many lamps; 1.1 million triangles.",
        "cornell-box" => "A Cornell-like box with a mirror ball and a glass ball.",
        "cornell-1k" => "cornell-box in a thousand triangles.",
        "cornell-10k" => "cornell-box in ten thousand triangles.",
        "cornell-100k" => "cornell-box in a hundred thousand triangles.",
        "cornell-1m" => "cornell-box in a million triangles.",
        "plain-room" => "mirror-room with every surface Lambertian: no caster at all.",
        _ => return None,
    })
}

/// Files of a scene: names and contents.
fn files(name: &str) -> Option<Vec<(&'static str, Vec<u8>)>> {
    let mut images = Vec::new();
    let (document, notes) = match name {
        "mirror-room" => (room::build(room::Kind::Mirror), include_str!("notes/mirror-room.md")),
        "glossy-room" => (room::build(room::Kind::Glossy), include_str!("notes/glossy-room.md")),
        "bar" => (bar::build(), include_str!("notes/bar.md")),
        "ring" => (ring::build(), include_str!("notes/ring.md")),
        "prism" => (prism::build(), include_str!("notes/prism.md")),
        "uplight" => (uplight::build(), include_str!("notes/uplight.md")),
        "plain-room" => (room::build(room::Kind::Plain), include_str!("notes/plain-room.md")),
        "animated-camera" => (animated_camera::build(), include_str!("notes/animated-camera.md")),
        "animated-light" => (animated_light::build(), include_str!("notes/animated-light.md")),
        "light-off" => (moving::light_off(), include_str!("notes/light-off.md")),
        "moving-caster" => (moving::moving_caster(), include_str!("notes/moving-caster.md")),
        "moving-receiver" => (moving::moving_receiver(), include_str!("notes/moving-receiver.md")),
        "sliding-receiver" => (moving::sliding_receiver(), include_str!("notes/sliding-receiver.md")),
        "camera-cut" => (moving::camera_cut(), include_str!("notes/camera-cut.md")),
        "cornell-box" => (cornell::build(Detail::DEFAULT), include_str!("notes/cornell-box.md")),
        "cornell-1k" => (cornell::build(Detail::with_triangles(1_000)), CORNELL_CUT),
        "cornell-10k" => (cornell::build(Detail::with_triangles(10_000)), CORNELL_CUT),
        "cornell-100k" => (cornell::build(Detail::with_triangles(100_000)), CORNELL_CUT),
        "cornell-1m" => (cornell::build(Detail::with_triangles(1_000_000)), CORNELL_CUT),
        "still-life" => {
            let (document, textures) = still_life::build();
            images = textures;
            (document, include_str!("notes/still-life.md"))
        }
        "textured-room" => {
            let (document, textures) = textured::build();
            images = textures;
            (document, include_str!("notes/textured-room.md"))
        }
        _ => return None,
    };
    let (json, binary) = document.encode();
    let mut files = vec![("scene.gltf", json), ("scene.bin", binary), ("README.md", notes.into())];
    files.extend(images);
    Some(files)
}

/// Writes `<dir>/<name>/` with `scene.gltf`, `scene.bin` and `README.md`; returns the path of the first.
///
/// Overwrites only with `force`. Each file appears whole or not at all.
pub fn make(name: &str, dir: &Path, force: bool) -> anyhow::Result<PathBuf> {
    let Some(files) = files(name) else {
        bail!("no scene {name:?} can be made; known are {}", [&NAMES[..], &ON_DEMAND].concat().join(", "));
    };
    let folder = dir.join(name);
    if !force && let Some((file, _)) = files.iter().find(|(file, _)| folder.join(file).exists()) {
        bail!("{} exists; give --force to overwrite it", folder.join(file).display());
    }
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    for (file, bytes) in files {
        let path = folder.join(file);
        let part = folder.join(format!("{file}.part"));
        fs::write(&part, bytes)
            .and_then(|()| fs::rename(&part, &path))
            .inspect_err(|_| drop(fs::remove_file(&part)))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(folder.join("scene.gltf"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn committed_scenes_equal_the_generated_files() {
        let committed = Path::new(env!("CARGO_MANIFEST_DIR"));
        for name in NAMES {
            for (file, bytes) in files(name).unwrap() {
                let path = committed.join(name).join(file);
                let found = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                assert!(found == bytes, "{} differs: make the scene again", path.display());
            }
        }
    }

    /// The radiances in a note are those of the scene's lamps.
    #[test]
    fn notes_state_the_radiances_of_their_scenes() {
        let mut named = 0;
        for name in NAMES {
            let files = files(name).unwrap();
            let text = |wanted: &str| {
                let bytes = &files.iter().find(|(file, _)| *file == wanted).unwrap().1;
                String::from_utf8(bytes.clone()).unwrap()
            };
            let scene: serde_json::Value = serde_json::from_str(&text("scene.gltf")).unwrap();
            let strength = |material: &serde_json::Value| {
                material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"].as_f64()
            };
            let strengths: Vec<f64> =
                scene["materials"].as_array().unwrap().iter().filter_map(strength).collect();
            let words: Vec<String> = text("README.md").split_whitespace().map(Into::into).collect();
            for window in words.windows(4).filter(|window| window[1..3] == ["W", "m^-2"]) {
                if let Ok(radiance) = window[0].trim_start_matches('(').parse::<f64>() {
                    assert!(strengths.contains(&radiance), "{name}: {radiance} is not among {strengths:?}");
                    named += 1;
                }
            }
        }
        assert!(named >= 7, "too few radiances are named: {named}");
    }

    #[test]
    fn generated_scenes_are_reproducible_and_small() {
        for name in NAMES {
            assert!(description(name).is_some());
            let (first, second) = (files(name).unwrap(), files(name).unwrap());
            assert_eq!(first, second);
            assert!(first.iter().all(|(_, bytes)| bytes.len() < 1 << 20));
        }
    }

    #[test]
    fn scenes_on_demand_are_reproducible() {
        for name in ON_DEMAND {
            assert!(description(name).is_some() && !NAMES.contains(&name));
            assert!(files(name).unwrap() == files(name).unwrap(), "{name}");
        }
    }

    #[test]
    fn make_overwrites_only_by_force() {
        let dir = std::env::temp_dir().join(format!("caustics-scenes-{}", std::process::id()));
        let made = make("ring", &dir, false).unwrap();
        let again = make("ring", &dir, false).unwrap_err().to_string();
        assert!(again.contains("--force"), "{again}");
        assert_eq!(make("ring", &dir, true).unwrap(), made);
        assert!(make("unknown", &dir, true).unwrap_err().to_string().contains("mirror-room"));
        fs::remove_dir_all(dir).unwrap();
    }
}
