//! What a refactoring must not change: the bits of every picture on the CPU runner. Bits differ between processors and
//! compilers, so that none are committed. Write them down before a change, compare after it:
//!
//! ```text
//! CAUSTICS_PICTURES=/tmp/pictures.txt cargo test --release -p caustics-tests --test house -- --ignored pictures::
//! ```

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use caustics::scene::{Scene, SceneCamera};
use caustics::session::{RunnerChoice, Session};
use caustics::settings::Settings;
use caustics_kernels::gather::variant::{self, Variant};
use caustics_kernels::method::{self, Method};
use caustics_kernels::{denoiser, history};

/// Frames of each picture: two that history lends to.
const FRAMES: u32 = 3;

/// FNV-1a, 64 bits.
fn hash(bytes: &[u8], start: u64) -> u64 {
    bytes.iter().fold(start, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The hash of all that a session's frames leave.
fn picture(
    scene: &mut Scene,
    settings: &Settings,
    method: &'static Method,
    gather: &'static Variant,
) -> Result<u64, Box<dyn std::error::Error>> {
    scene.pose(0.0)?;
    let camera = |scene: &Scene| -> SceneCamera { scene.cameras[0].clone() };
    let features = scene.features(settings.specular_roughness);
    let cpu = RunnerChoice::Cpu { threads: 0 };
    let mut session = Session::new(&cpu, scene, &camera(scene), settings, method, gather, features)?;
    let mut found = 0xcbf2_9ce4_8422_2325;
    for frame in 0..FRAMES {
        scene.pose(f64::from(frame) / 24.0)?;
        session.pose(scene, &camera(scene))?;
        session.frame(frame)?;
        let mut buffers = vec!["path_radiance", "counters"];
        if method.gathers {
            buffers.extend(["caustic_radiance", "point_geometry", "point_shading", "accumulator"]);
            buffers.push("display_color");
        }
        for buffer in buffers {
            found = hash(&session.read::<u8>(buffer)?, found);
        }
    }
    Ok(found)
}

/// The hashes of all that can be combined in a scene, by name.
fn pictures(name: &str, scene: &mut Scene, all: &mut BTreeMap<String, u64>) {
    let gathers: Vec<&'static Variant> = variant::ALL.iter().filter(|gather| !gather.hardware).collect();
    for &method in method::ALL {
        for &gather in if method.chooses_gather { &gathers[..] } else { &gathers[..1] } {
            for &history in if method.gathers { history::ALL } else { &history::ALL[..1] } {
                for &denoiser in if method.gathers { denoiser::ALL } else { &denoiser::ALL[..1] } {
                    let settings = Settings {
                        width: 48,
                        height: 27,
                        light_paths: 3000,
                        seed: 7,
                        pixel_filter: 1,
                        history,
                        denoiser,
                        ..Settings::default()
                    };
                    let key = [name, method.name, gather.name, history.name, denoiser.name].join(" ");
                    let found = picture(scene, &settings, method, gather);
                    all.insert(key, found.expect("a picture"));
                }
            }
        }
    }
}

#[test]
#[ignore = "compares with what CAUSTICS_PICTURES holds"]
fn every_picture_is_what_it_was() {
    let file = std::env::var("CAUSTICS_PICTURES").expect("CAUSTICS_PICTURES names a file");
    let mut all = BTreeMap::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    for name in caustics_scenes::NAMES {
        let mut scene = Scene::load(&scenes.join(name).join("scene.gltf")).expect("a committed scene");
        pictures(name, &mut scene, &mut all);
    }
    let text = all.iter().fold(String::new(), |mut text, (key, hash)| {
        writeln!(text, "{hash:016x} {key}").expect("text");
        text
    });
    let Ok(before) = std::fs::read_to_string(&file) else {
        return std::fs::write(&file, text).expect("CAUSTICS_PICTURES can be written");
    };
    let differs: Vec<&str> = text.lines().filter(|line| !before.lines().any(|old| old == *line)).collect();
    assert!(differs.is_empty(), "{} of {} differ:\n{}", differs.len(), all.len(), differs.join("\n"));
    assert_eq!(before.lines().count(), all.len(), "{file} has others");
}
