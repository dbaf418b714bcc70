//! Bounds on memory and time, checked before anything is read.

use std::path::Path;

use serde_json::{Value, json};

use super::textures::whole;
use super::{Scene, TINY, fault, listing, refuses, shell};
use crate::test_dir::TestDir;

/// Runs the program in 4 GiB of address space, where it must refuse and leave the folder as it was.
#[cfg(target_os = "linux")]
#[track_caller]
fn refuses_in_4_gib(dir: &TestDir, arguments: &str, words: &[&str]) {
    let before = listing(dir.folder());
    let run = shell(
        dir,
        &format!("ulimit -v 4194304; exec \"$0\" {arguments} -o out.exr --runner cpu --threads 1"),
    );
    if let Some(fault) = fault(&run, 1, words) {
        panic!("{arguments}: {fault}");
    }
    assert_eq!(listing(dir.folder()), before, "{arguments} left something behind");
}

#[test]
#[cfg(target_os = "linux")]
fn frames_beyond_memory_are_refused() {
    let dir = TestDir::new();
    let ring = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/ring");
    let large = format!("render '{}' --width 8192 --height 8192", ring.display());
    let words = ["--width 8192 and --height 8192", "are available", "lower --width and --height"];
    refuses_in_4_gib(&dir, &large, &words);
}

/// One small file of 8192 x 8192 is named 20 times, and each name is an image.
#[test]
#[cfg(target_os = "linux")]
fn textures_beyond_memory_are_refused_undecoded() {
    let mut scene = Scene::new("textured-room");
    image::GrayImage::new(8192, 8192).save(scene.dir.path("a.png")).unwrap();
    scene.json["images"] = (0..20).map(|_| json!({ "uri": "a.png" })).collect();
    scene.json["textures"] = (0..20).map(|source| json!({ "source": source })).collect();
    let primitive = scene.primitive();
    let material = |index: usize| json!({ "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": { "baseColorTexture": { "index": index } } });
    scene.json["materials"] = (0..20).map(material).collect();
    let with_material = |material: usize| {
        let mut primitive = primitive.clone();
        primitive["material"] = json!(material);
        primitive
    };
    let mesh = json!({ "primitives": (0..20).map(with_material).collect::<Vec<_>>() });
    scene.json["meshes"].as_array_mut().unwrap().fill(mesh);
    scene.write();
    refuses_in_4_gib(
        &scene.dir,
        "render scene.gltf",
        &["scene.gltf", "1789569700 texels", "make them smaller"],
    );
}

/// 100 nodes share a million triangles.
#[test]
#[cfg(target_os = "linux")]
fn triangles_beyond_memory_are_refused_unread() {
    let mut scene = Scene::new("ring");
    let count = |section: &Value| section.as_array().unwrap().len();
    let (indices, view) = (count(&scene.json["accessors"]), count(&scene.json["bufferViews"]));
    let accessor = json!({ "bufferView": view, "componentType": 5121, "count": 3_000_000, "type": "SCALAR" });
    scene.json["accessors"].as_array_mut().unwrap().push(accessor);
    let bytes = json!({ "buffer": 0, "byteOffset": scene.binary.len(), "byteLength": 3_000_000 });
    scene.json["bufferViews"].as_array_mut().unwrap().push(bytes);
    scene.binary.extend([0, 1, 2].repeat(1_000_000));
    scene.json["buffers"][0]["byteLength"] = json!(scene.binary.len());
    scene.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let nodes = scene.json["nodes"].as_array_mut().unwrap();
    let first = nodes.len();
    nodes.extend((0..100).map(|_| json!({ "mesh": 0 })));
    let all = scene.json["scenes"][0]["nodes"].as_array_mut().unwrap();
    all.extend((first..first + 100).map(|node| json!(node)));
    scene.write();
    refuses_in_4_gib(
        &scene.dir,
        "render scene.gltf --copies 1000000000",
        &["scene.gltf", "triangles would take", "are available"],
    );
}

#[test]
#[cfg(unix)]
fn pipes_and_devices_are_no_experiments() {
    let dir = TestDir::new();
    assert_eq!(shell(&dir, "mkfifo pipe.toml").code, Some(0));
    for file in ["pipe.toml", "/dev/zero"] {
        refuses(&dir, &["sweep", file, "-o", "out"], 1, &[file, "not a file"]);
    }
}

/// Such files look like regular files, and reading some of them never ends.
#[cfg(target_os = "linux")]
#[test]
fn files_that_the_system_makes_up_are_no_inputs() {
    let dir = TestDir::new();
    std::os::unix::fs::symlink("/proc/kmsg", dir.path("link")).unwrap();
    for input in ["/proc/kmsg", "/proc/self/maps", "/sys/kernel/uevent_seqnum", "./link"] {
        let before = listing(dir.folder());
        for arguments in [
            &["compare", input, input][..],
            &["sweep", input, "-o", "out"],
            &["merge", input, input, "-o", "out.exr"],
            &["scene", "info", input],
            &["render", "mirror-room", "-o", "out.exr", "--environment", input],
            &["render", "mirror-room", "-o", "out.exr", "--edits", input],
        ] {
            let run = dir.run(arguments);
            let code = run.code.unwrap_or_default();
            assert!((1..=2).contains(&code), "{arguments:?}: {code} {}", run.stderr);
            if let Some(fault) = fault(&run, code, &[input]) {
                panic!("{arguments:?}: {fault}");
            }
            assert_eq!(listing(dir.folder()), before, "{arguments:?} left something behind");
        }
        // A scene names the file for its vertices and for an image.
        let named = dir.path(input);
        let mut scene = Scene::new("mirror-room");
        scene.json["buffers"][0]["uri"] = json!(named);
        scene.refuses(1, &[input]);
        let mut scene = whole();
        scene.json["images"][0] = json!({ "uri": named });
        scene.replaces(&["image 0", input]);
    }
}

#[cfg(unix)]
#[test]
fn inputs_that_never_end_are_refused() {
    let dir = TestDir::new();
    let pipe = dir.path("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::fs::create_dir_all(dir.path("results/cells")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", dir.path("zero.exr.checkpoint")).unwrap();
    std::os::unix::fs::symlink(&pipe, dir.path("pipe.exr.checkpoint")).unwrap();
    for input in ["pipe", "/dev/zero"] {
        let words = [input, "not a file"];
        refuses(&dir, &["compare", input, input], 1, &words);
        refuses(&dir, &["merge", input, input, "-o", "out.exr"], 1, &words);
        refuses(&dir, &["sweep", input, "-o", "out"], 1, &words);
        let result = dir.path("results/cells/0000000000000001.json");
        std::os::unix::fs::symlink(dir.path(input), &result).unwrap();
        refuses(&dir, &["report", "results", "-o", "r.html"], 1, &["0000000000000001.json", "not a file"]);
        refuses(&dir, &["sweep", "--merge", "results", "-o", "results"], 1, &["not a file"]);
        std::fs::remove_file(&result).unwrap();
    }
    for out in ["zero.exr", "pipe.exr"] {
        let resume =
            [&["reference", "ring", "-o", out, "--resume"], &TINY[..2], &["--runner", "cpu"]].concat();
        dir.refuses(&resume, 2, &["not a file"]);
    }
}
