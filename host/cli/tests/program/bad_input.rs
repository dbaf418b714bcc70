//! Bad input gives an error that names the file or the flag and says what to do, and exit code 1 or 2. It never panics and
//! leaves no file behind.

mod bounds;
mod document;
mod inputs;
mod memory;
mod options;
mod outputs;
mod terminal;
mod textures;
mod threads;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

use crate::test_dir::{BINARY, Run, TestDir};

/// Options of the smallest render that still shoots light paths.
const TINY: [&str; 8] = ["--width", "16", "--height", "9", "--light-paths", "1000", "--runner", "cpu"];

/// Runs a line of shell, which gets the program as `$0`.
#[cfg(unix)]
fn shell(dir: &TestDir, line: &str) -> Run {
    let output = Command::new("sh")
        .current_dir(dir.folder())
        .args(["-c", line, BINARY])
        .timeout(std::time::Duration::from_secs(60))
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// All files below a folder.
fn listing(folder: &Path) -> BTreeSet<PathBuf> {
    let mut files = BTreeSet::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(listing(&path));
        }
        files.insert(path);
    }
    files
}

/// Returns why a run is not a proper refusal; none if it is one.
fn fault(run: &Run, code: i32, words: &[&str]) -> Option<String> {
    let missing: Vec<_> = words.iter().filter(|word| !run.stderr.contains(**word)).collect();
    let fault = if run.code != Some(code) {
        format!("exit code {:?}, not {code}", run.code)
    } else if run.stderr.contains("panicked") || !run.stderr.starts_with("error: ") {
        "no error message of its own".into()
    } else if !missing.is_empty() {
        format!("the message lacks {missing:?}")
    } else if !run.stdout.is_empty() {
        "it talks on stdout".into()
    } else {
        return None;
    };
    Some(format!("{fault}: {}", run.stderr))
}

/// Runs the program, which must refuse with this exit code and these words and leave the folder as it was.
#[track_caller]
fn refuses(dir: &TestDir, arguments: &[&str], code: i32, words: &[&str]) {
    let before = listing(dir.folder());
    let run = dir.run(arguments);
    if let Some(fault) = fault(&run, code, words) {
        panic!("{arguments:?}: {fault}");
    }
    assert_eq!(listing(dir.folder()), before, "{arguments:?} left something behind");
}

/// Renders `scene` with more options into `out.exr` of its folder, which must be refused.
#[track_caller]
fn render_refuses(dir: &TestDir, scene: &str, options: &[&str], code: i32, words: &[&str]) {
    let arguments = [&["render", scene, "-o", "out.exr"], &TINY[..], options].concat();
    refuses(dir, &arguments, code, words);
}

/// A committed scene to damage: its document and its buffer.
pub struct Scene {
    pub json: Value,
    binary: Vec<u8>,
    pub dir: TestDir,
}

impl Scene {
    pub fn new(name: &str) -> Scene {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
        let json = serde_json::from_slice(&std::fs::read(source.join("scene.gltf")).unwrap()).unwrap();
        let binary = std::fs::read(source.join("scene.bin")).unwrap();
        Scene { json, binary, dir: TestDir::new() }
    }

    /// Writes `scene.gltf` and `scene.bin`.
    pub fn write(&self) -> &Self {
        self.dir.write("scene.gltf", serde_json::to_vec(&self.json).unwrap());
        self.dir.write("scene.bin", &self.binary);
        self
    }

    /// Returns the scene as a binary container.
    fn container(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0].as_object_mut().unwrap().remove("uri");
        let mut json = serde_json::to_vec(&json).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let word = |value: usize| (value as u32).to_le_bytes();
        let mut out = b"glTF".to_vec();
        out.extend([word(2), word(28 + json.len() + binary.len()), word(json.len())].concat());
        out.extend([b"JSON".as_slice(), &json, &word(binary.len()), b"BIN\0", &binary].concat());
        out
    }

    /// Offset in the buffer of an accessor of the first mesh's first primitive.
    fn offset(&self, accessor: &Value) -> usize {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        (view["byteOffset"].as_u64().unwrap() + accessor["byteOffset"].as_u64().unwrap_or(0)) as usize
    }

    fn primitive(&self) -> Value {
        self.json["meshes"][0]["primitives"][0].clone()
    }

    /// Overwrites the first coordinate of the first mesh.
    fn set_first_coordinate(&mut self, value: f32) {
        let at = self.offset(&self.primitive()["attributes"]["POSITION"]);
        self.binary[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }

    /// Index of the node of this name.
    fn node(&self, name: &str) -> usize {
        let nodes = self.json["nodes"].as_array().unwrap();
        nodes.iter().position(|node| node["name"] == name).unwrap()
    }

    /// Expects a refusal with --strict; without it, expects an image and a warning with these words.
    #[track_caller]
    fn replaces(&self, words: &[&str]) {
        self.write();
        let words = [&["scene.gltf"], words].concat();
        render_refuses(&self.dir, "scene.gltf", &["--strict"], 1, &words);
        let run = self.dir.succeeds(&[&["render", "scene.gltf", "-o", "out.exr"], &TINY[..]].concat());
        let is_named =
            |line: &str| line.starts_with("warning: ") && words.iter().all(|word| line.contains(word));
        assert!(run.stderr.lines().any(is_named), "{words:?}: {}", run.stderr);
    }

    #[track_caller]
    fn refuses(&self, code: i32, words: &[&str]) {
        self.write();
        render_refuses(&self.dir, "scene.gltf", &[], code, &[&["scene.gltf"], words].concat());
    }
}

#[test]
fn detects_runs_that_are_no_proper_refusal() {
    let run = |code, stderr: &str| Run { code, stdout: String::new(), stderr: stderr.into() };
    assert!(fault(&run(Some(1), "error: a.gltf: repair it"), 1, &["a.gltf"]).is_none());
    assert!(fault(&run(Some(2), "error: a.gltf"), 1, &["a.gltf"]).is_some());
    assert!(fault(&run(Some(1), "error: b.gltf"), 1, &["a.gltf"]).is_some());
    assert!(fault(&run(Some(101), "thread 'main' panicked at"), 101, &[]).is_some());
    assert!(fault(&run(None, "error: killed"), 1, &[]).is_some());
}

#[test]
fn a_proper_scene_renders() {
    let scene = Scene::new("mirror-room");
    scene.write();
    scene.dir.write("whole.glb", scene.container());
    for (file, out) in [("scene.gltf", "a.exr"), ("whole.glb", "b.exr")] {
        scene.dir.succeeds(&[&["render", file, "-o", out], &TINY[..]].concat());
        assert!(scene.dir.path(out).is_file());
    }
}
