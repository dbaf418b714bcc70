//! Bad input: an error that names the file or the flag and says what to do, exit code 1 or 2, never a panic, and no
//! file left behind.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::{Value, json};
use tempfile::TempDir;

/// The smallest render that still shoots light paths.
const TINY: [&str; 8] = ["--width", "16", "--height", "9", "--light-paths", "1000", "--runner", "cpu"];

/// What a run of the program gave.
struct Run {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

fn caustics(folder: &Path, arguments: &[&str]) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_caustics"))
        .current_dir(folder)
        .args(arguments)
        .timeout(std::time::Duration::from_secs(120))
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// Every file below a folder.
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

/// Why a run is no proper refusal; none if it is one.
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

/// Runs in `folder`, and demands a refusal with this exit code and these words that leaves the folder as it was.
#[track_caller]
fn refuses(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let before = listing(folder);
    let run = caustics(folder, arguments);
    if let Some(fault) = fault(&run, code, words) {
        panic!("{arguments:?}: {fault}");
    }
    assert_eq!(listing(folder), before, "{arguments:?} left something behind");
}

/// Renders `scene` with more options into `out.exr` of its folder, and demands a refusal.
#[track_caller]
fn render_refuses(folder: &Path, scene: &str, options: &[&str], code: i32, words: &[&str]) {
    let arguments = [&["render", scene, "-o", "out.exr"], &TINY[..], options].concat();
    refuses(folder, &arguments, code, words);
}

/// A committed scene, to be spoilt: its document and its buffer.
struct Scene {
    json: Value,
    binary: Vec<u8>,
    folder: TempDir,
}

impl Scene {
    fn new(name: &str) -> Scene {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name);
        let json = serde_json::from_slice(&std::fs::read(source.join("scene.gltf")).unwrap()).unwrap();
        let binary = std::fs::read(source.join("scene.bin")).unwrap();
        Scene { json, binary, folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Writes `scene.gltf` and `scene.bin`.
    fn write(&self) -> &Self {
        std::fs::write(self.path().join("scene.gltf"), serde_json::to_vec(&self.json).unwrap()).unwrap();
        std::fs::write(self.path().join("scene.bin"), &self.binary).unwrap();
        self
    }

    /// The scene as a binary container.
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

    /// Where the buffer holds an accessor of the first mesh's first primitive.
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

    #[track_caller]
    fn refuses(&self, code: i32, words: &[&str]) {
        self.write();
        render_refuses(self.path(), "scene.gltf", &[], code, &[&["scene.gltf"], words].concat());
    }
}

#[test]
fn faults_are_found() {
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
    std::fs::write(scene.path().join("whole.glb"), scene.container()).unwrap();
    for (file, out) in [("scene.gltf", "a.exr"), ("whole.glb", "b.exr")] {
        let run = caustics(scene.path(), &[&["render", file, "-o", out], &TINY[..]].concat());
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(scene.path().join(out).is_file());
    }
}

#[test]
fn missing_scenes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    render_refuses(folder.path(), "missing.glb", &[], 1, &["missing.glb", "check the path"]);
    render_refuses(folder.path(), "missing/scene.gltf", &[], 1, &["missing/scene.gltf", "check the path"]);
    render_refuses(folder.path(), "no-such-room", &[], 2, &["no-such-room", "mirror-room", ".glb"]);
    refuses(folder.path(), &["scene", "info", "no-such-room"], 2, &["no-such-room", "mirror-room"]);
    refuses(folder.path(), &["scene", "make", "no-such-room"], 2, &["no-such-room", "mirror-room"]);
}

#[test]
fn truncated_containers_are_refused_wherever_they_end() {
    let scene = Scene::new("mirror-room");
    let whole = scene.container();
    let json = u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    let file = scene.path().join("cut.glb");
    for length in [0, 3, 4, 11, 12, 19, 20, 20 + json / 2, 20 + json, 24 + json, whole.len() - 1] {
        std::fs::write(&file, &whole[..length]).unwrap();
        render_refuses(scene.path(), "cut.glb", &[], 1, &["cut.glb"]);
    }
    std::fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    render_refuses(scene.path(), "cut.glb", &[], 1, &["cut.glb", "export or download it again"]);
}

#[test]
fn truncated_and_missing_buffers_are_refused() {
    let scene = Scene::new("mirror-room");
    scene.write();
    let buffer = scene.path().join("scene.bin");
    std::fs::write(&buffer, &scene.binary[..scene.binary.len() / 2]).unwrap();
    render_refuses(scene.path(), "scene.gltf", &[], 1, &["scene.gltf", "cut off", "restore the file"]);
    std::fs::remove_file(&buffer).unwrap();
    render_refuses(scene.path(), "scene.gltf", &[], 1, &["scene.gltf", "scene.bin", "restore the file"]);
}

#[test]
fn corrupted_json_is_refused() {
    let scene = Scene::new("mirror-room");
    let text = serde_json::to_vec(&scene.json).unwrap();
    for bytes in [&text[..text.len() / 2], b"{}", b"[1, 2]", b"\xff\xfe\x00", b""] {
        std::fs::write(scene.path().join("scene.gltf"), bytes).unwrap();
        render_refuses(scene.path(), "scene.gltf", &[], 1, &["scene.gltf", "not a glTF 2.0 document"]);
    }
}

#[test]
fn vertices_that_are_not_finite_are_refused() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut scene = Scene::new("mirror-room");
        scene.set_first_coordinate(value);
        scene.refuses(1, &["vertex 0 is not finite", "mesh", "repair the mesh"]);
    }
}

#[test]
fn indices_out_of_range_are_refused() {
    let mut scene = Scene::new("mirror-room");
    let at = scene.offset(&scene.primitive()["indices"]);
    scene.binary[at..at + 2].copy_from_slice(&60_000_u16.to_le_bytes());
    scene.refuses(1, &["index 60000 is out of range", "mesh"]);

    // The same for every index of the document itself.
    let pointers = [
        ("/nodes/0/mesh", "mesh"),
        ("/meshes/0/primitives/0/material", "material"),
        ("/meshes/0/primitives/0/indices", "accessor"),
        ("/meshes/0/primitives/0/attributes/POSITION", "accessor"),
        ("/accessors/0/bufferView", "buffer view"),
        ("/bufferViews/0/buffer", "buffer"),
        ("/scenes/0/nodes/0", "node"),
    ];
    for (pointer, kind) in pointers {
        let mut scene = Scene::new("mirror-room");
        *scene.json.pointer_mut(pointer).unwrap() = json!(4321);
        scene.refuses(1, &[&format!("{kind} 4321")]);
    }
}

#[test]
fn scenes_without_camera_light_or_geometry_are_refused() {
    let mut scene = Scene::new("mirror-room");
    let camera = scene.node("main");
    scene.json["nodes"][camera].as_object_mut().unwrap().remove("camera");
    scene.refuses(1, &["no perspective camera", "add a camera"]);

    let mut scene = Scene::new("mirror-room");
    for material in scene.json["materials"].as_array_mut().unwrap() {
        material.as_object_mut().unwrap().remove("emissiveFactor");
    }
    scene.refuses(1, &["no light", "emissiveFactor"]);

    let mut scene = Scene::new("mirror-room");
    scene.json["scenes"][0]["nodes"] = json!([camera]);
    scene.refuses(1, &["no geometry", "add a mesh"]);
}

#[test]
fn textures_that_cannot_be_had_are_refused() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/textured-room");
    let tiles = std::fs::read(source.join("tiles.png")).unwrap();
    let whole = || {
        let scene = Scene::new("textured-room");
        for file in ["tiles.png", "bricks.png", "rings.png", "leaves.png", "panes.png"] {
            std::fs::copy(source.join(file), scene.path().join(file)).unwrap();
        }
        scene
    };
    let run =
        caustics(whole().write().path(), &[&["render", "scene.gltf", "-o", "out.exr"], &TINY[..]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);

    // The file: missing, empty, no picture, cut off, and with a damaged length.
    let scene = whole();
    std::fs::remove_file(scene.path().join("tiles.png")).unwrap();
    scene.refuses(1, &["image 0", "tiles.png", "PNG or JPEG"]);
    let mut damaged = tiles.clone();
    damaged[40] ^= 0xff;
    let contents: [(&[u8], &str); 5] = [
        (b"", "neither a PNG nor a JPEG"),
        (b"GIF89a and so on", "neither a PNG nor a JPEG"),
        (b"\x89PNG\r\n\x1a\n", "cannot be decoded"),
        (&tiles[..tiles.len() / 2], "cannot be decoded"),
        (&damaged, "cannot be decoded"),
    ];
    for (bytes, words) in contents {
        let scene = whole();
        std::fs::write(scene.path().join("tiles.png"), bytes).unwrap();
        scene.refuses(1, &["image 0", words]);
    }

    // A size that no picture has room for.
    let mut huge = tiles.clone();
    huge[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let scene = whole();
    std::fs::write(scene.path().join("tiles.png"), &huge).unwrap();
    scene.refuses(1, &["image 0", "cannot be decoded"]);

    // Indices of the document.
    for (pointer, kind) in [
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", "texture"),
        ("/textures/0/source", "image"),
    ] {
        let mut scene = whole();
        *scene.json.pointer_mut(pointer).unwrap() = json!(4321);
        scene.refuses(1, &[&format!("{kind} 4321")]);
    }
    let mut scene = whole();
    scene.json["images"][0] = json!({ "bufferView": 4321 });
    scene.refuses(1, &["image 0", "buffer view 4321"]);
    let mut scene = whole();
    scene.json["images"][0] = json!({});
    scene.refuses(1, &["image 0", "neither a uri nor a bufferView"]);

    // Coordinates: missing, not finite, of the wrong kind.
    let mut scene = whole();
    scene.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    scene.refuses(1, &["mesh", "TEXCOORD_0"]);
    let mut scene = whole();
    let at = scene.offset(&scene.primitive()["attributes"]["TEXCOORD_0"]);
    scene.binary[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    scene.refuses(1, &["texture coordinate 0", "mesh"]);
    let mut scene = whole();
    let position = scene.primitive()["attributes"]["POSITION"].clone();
    scene.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = position;
    scene.refuses(1, &["accessor", "two floats or shares"]);

    // The background of the scene.
    let mut scene = whole();
    scene.json["scenes"][0]["extras"] = json!({ "background": [1, -1, 0] });
    scene.refuses(1, &["extras.background", "three radiances"]);
}

#[test]
fn singular_transforms_are_refused() {
    let zero_axis = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    for (key, value) in [("scale", json!([1, 0, 1])), ("matrix", json!(zero_axis))] {
        let mut scene = Scene::new("mirror-room");
        let ball = scene.node("ball");
        scene.json["nodes"][ball][key] = value;
        scene.refuses(1, &["node \"ball\"", "singular", "repair the node"]);
    }
}

#[test]
fn triangles_without_an_area_are_dropped_and_counted() {
    let mut scene = Scene::new("mirror-room");
    let info = |scene: &Scene| -> Value {
        let run = caustics(scene.write().path(), &["scene", "info", "scene.gltf", "--json"]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        serde_json::from_str(&run.stdout).unwrap()
    };
    assert_eq!(info(&scene)["dropped_triangles"], 0);
    let triangles = info(&scene)["triangles"].as_u64().unwrap();

    // Let the first triangle begin and end at one vertex.
    let at = scene.offset(&scene.primitive()["indices"]);
    scene.binary.copy_within(at..at + 2, at + 2);
    let spoilt = info(&scene);
    assert_eq!(spoilt["dropped_triangles"], 1);
    assert_eq!(spoilt["triangles"], triangles - 1);
    let run = caustics(scene.path(), &[&["render", "scene.gltf", "-o", "out.exr"], &TINY[..]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn sizes_and_counts_out_of_range_are_usage_errors() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &str); 18] = [
        (&["--width", "0", "--height", "0"], "--width 0"),
        (&["--width", "100000", "--height", "100000"], "--width 100000"),
        (&["--width", "16384", "--height", "16384"], "area"),
        (&["--light-paths", "0"], "--light-paths"),
        (&["--frames", "0"], "--frames"),
        (&["--max-bounces", "0"], "--max-bounces"),
        (&["--max-bounces", "65"], "--max-bounces"),
        (&["--radius-px", "NaN"], "--radius-px"),
        (&["--radius-px", "-1"], "--radius-px"),
        (&["--radius-px", "0"], "--radius-px"),
        (&["--radius-px", "inf"], "--radius-px"),
        (&["--specular-roughness", "1.5"], "--specular-roughness"),
        (&["--specular-roughness", "NaN"], "--specular-roughness"),
        (&["--exposure", "NaN"], "--exposure"),
        (&["--background", "1,2"], "--background"),
        (&["--background", "1,NaN,0"], "--background"),
        (&["--width", "-1"], "--width"),
        (&["--light-paths", "many"], "--light-paths"),
    ];
    for (options, words) in cases {
        let arguments = [&["render", "mirror-room", "-o", "out.exr", "--runner", "cpu"], options].concat();
        refuses(folder.path(), &arguments, 2, &[words]);
    }
}

#[test]
fn names_and_combinations_that_do_not_exist_are_usage_errors() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &[&str]); 7] = [
        (&["--gather", "telepathy"], &["--gather", "telepathy", "photons-grid"]),
        (&["--camera", "nobody"], &["--camera nobody", "main"]),
        (&["--gather", "points-rt"], &["--gather points-rt", "ray queries", "photons-grid"]),
        (&["--tracer", "hardware"], &["--tracer hardware", "--runner gpu"]),
        (&["--debug", "validation"], &["--debug validation", "--runner gpu"]),
        (&["--method", "magic"], &["--method", "basic"]),
        (&["--no-such-flag"], &["--no-such-flag"]),
    ];
    for (options, words) in cases {
        render_refuses(folder.path(), "mirror-room", options, 2, words);
    }
}

#[test]
fn nothing_is_overwritten_without_force() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("out.exr");
    std::fs::write(&file, "precious").unwrap();
    render_refuses(folder.path(), "mirror-room", &[], 2, &["out.exr", "--force"]);
    std::fs::rename(&file, folder.path().join("out.png")).unwrap();
    render_refuses(folder.path(), "mirror-room", &["--png", "out.png"], 2, &["out.png", "--force"]);
    assert_eq!(std::fs::read(folder.path().join("out.png")).unwrap(), b"precious");

    // Nor does a failing run touch what --force allows to overwrite.
    std::fs::write(&file, "precious").unwrap();
    render_refuses(folder.path(), "missing.gltf", &["--force"], 1, &["missing.gltf"]);
    assert_eq!(std::fs::read(&file).unwrap(), b"precious");
    render_refuses(folder.path(), "mirror-room", &["--force", "--png", "out.exr"], 2, &["--png", "out.exr"]);
    render_refuses(
        folder.path(),
        "mirror-room",
        &["--force", "--png", "./out.exr"],
        2,
        &["--png", "out.exr"],
    );

    std::fs::create_dir(folder.path().join("ring")).unwrap();
    std::fs::write(folder.path().join("ring/scene.gltf"), "precious").unwrap();
    refuses(folder.path(), &["scene", "make", "all", "-o", "."], 2, &["ring", "--force"]);
}

#[test]
fn folders_that_cannot_be_written_are_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    for out in ["missing/out.exr", "file/out.exr"] {
        let arguments = [&["render", "mirror-room", "-o", out], &TINY[..]].concat();
        refuses(folder.path(), &arguments, 1, &[out, "-o"]);
    }
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    let arguments = [&["render", "mirror-room", "-o", "folder", "--force"], &TINY[..]].concat();
    refuses(folder.path(), &arguments, 2, &["folder is a folder", "name a file"]);
    let arguments = [&["render", "mirror-room", "-o", "out.exr", "--png", "missing/out.png"], &TINY[..]];
    refuses(folder.path(), &arguments.concat(), 1, &["missing/out.png", "create the folder"]);
    refuses(folder.path(), &["scene", "make", "ring", "-o", "file"], 1, &["file/ring"]);
}

/// What a method learns from frame to frame is in no checkpoint: going on from one would not give the same bits.
#[test]
fn a_method_that_learns_is_not_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/ring");
    let scene = scene.to_str().unwrap();
    render_refuses(folder.path(), scene, &["--method", "yang2021", "--resume"], 2, &["--resume", "yang2021"]);
    let run = caustics(
        folder.path(),
        &[&["render", scene, "-o", "out.exr", "--method", "yang2021"], &TINY[..]].concat(),
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn a_name_that_speaks_of_another_kind_of_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let render = |options: &[&str], words: &[&str]| {
        refuses(folder.path(), &[&["render", "ring"], options, &TINY[..]].concat(), 2, words);
    };
    render(&["-o", "a.png"], &["-o a.png", "EXR", ".exr"]);
    render(&["-o", "a.PNG"], &["-o a.PNG", ".exr"]);
    render(&["-o", "a.exr", "--png", "b.exr"], &["--png b.exr", "PNG", ".png"]);
    refuses(folder.path(), &["merge", "a.exr", "b.exr", "-o", "c.png"], 2, &["-o c.png", ".exr"]);
    refuses(folder.path(), &["compare", "a.exr", "b.exr", "--map", "c.exr"], 2, &["--map c.exr", ".png"]);
}

#[test]
fn force_overwrites_no_file_of_the_scene() {
    let mut scene = Scene::new("textured-room");
    scene.json["buffers"][0]["uri"] = json!("a%20buffer.exr");
    scene.write();
    std::fs::rename(scene.path().join("scene.bin"), scene.path().join("a buffer.exr")).unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/textured-room");
    for file in ["tiles.png", "bricks.png", "rings.png", "leaves.png", "panes.png"] {
        std::fs::copy(source.join(file), scene.path().join(file)).unwrap();
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a buffer.exr", scene.path().join("link.exr")).unwrap();
        std::fs::hard_link(scene.path().join("tiles.png"), scene.path().join("hard.png")).unwrap();
    }
    let links = if cfg!(unix) { &[["link.exr", "b.png"], ["b.exr", "hard.png"]][..] } else { &[] };
    for &[exr, png] in
        [["a buffer.exr", "b.png"], ["./a buffer.exr", "b.png"], ["b.exr", "tiles.png"]].iter().chain(links)
    {
        let render = ["render", "scene.gltf", "--force", "-o", exr, "--png", png];
        refuses(scene.path(), &[&render[..], &TINY].concat(), 2, &["is a file of the scene", "another name"]);
    }
    // Of an animation each frame has a name.
    std::fs::rename(scene.path().join("a buffer.exr"), scene.path().join("01.exr")).unwrap();
    scene.json["buffers"][0]["uri"] = json!("01.exr");
    std::fs::write(scene.path().join("scene.gltf"), serde_json::to_vec(&scene.json).unwrap()).unwrap();
    let animate = ["animate", "scene.gltf", "--force", "-o", "##.exr", "--frames", "0..3"];
    refuses(scene.path(), &[&animate[..], &TINY].concat(), 2, &["01.exr is a file of the scene"]);
    assert_eq!(std::fs::read(scene.path().join("01.exr")).unwrap(), scene.binary);
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_nowhere_is_refused_before_anything_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("nowhere", folder.path().join("out.exr")).unwrap();
    // The scene is not even looked for.
    render_refuses(folder.path(), "missing.gltf", &[], 2, &["out.exr is a link", "--force"]);
}

#[cfg(unix)]
#[test]
fn inputs_that_never_end_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::fs::create_dir_all(folder.path().join("results/cells")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.exr.checkpoint")).unwrap();
    std::os::unix::fs::symlink(&pipe, folder.path().join("pipe.exr.checkpoint")).unwrap();
    for input in ["pipe", "/dev/zero"] {
        let words = [input, "not a file"];
        refuses(folder.path(), &["compare", input, input], 1, &words);
        refuses(folder.path(), &["merge", input, input, "-o", "out.exr"], 1, &words);
        refuses(folder.path(), &["sweep", input, "-o", "out"], 1, &words);
        let cell = folder.path().join("results/cells/0000000000000001.json");
        std::os::unix::fs::symlink(folder.path().join(input), &cell).unwrap();
        refuses(
            folder.path(),
            &["report", "results", "-o", "r.html"],
            1,
            &["0000000000000001.json", "not a file"],
        );
        refuses(folder.path(), &["sweep", "--merge", "results", "-o", "results"], 1, &["not a file"]);
        std::fs::remove_file(&cell).unwrap();
    }
    for out in ["zero.exr", "pipe.exr"] {
        let resume =
            [&["reference", "ring", "-o", out, "--resume"], &TINY[..2], &["--runner", "cpu"]].concat();
        let run = caustics(folder.path(), &resume);
        assert!(run.code == Some(2) && run.stderr.contains("not a file"), "{}", run.stderr);
    }
}
