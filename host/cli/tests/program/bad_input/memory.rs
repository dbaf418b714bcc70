//! Memory for every kind of input file: a limit of memory gives an error, and a table bounds the memory per byte.

use serde_json::{Value, json};

use super::{listing, shell};
use crate::test_dir::{Run, TestDir};

/// Address space of the program with a small scene and the stacks of a few threads (KiB).
const PROGRAM: u64 = 300_000;
/// Limits of address space (KiB), from one in which the program hardly starts.
const LIMITS: [u64; 4] = [60_000, 90_000, 130_000, 200_000];

/// A kind of file.
struct Kind {
    name: &'static str,
    /// File whose size counts.
    file: &'static str,
    /// Command that reads the file.
    command: String,
    /// Maximum memory (bytes) per byte of the file, or per pixel value of an image.
    factor: u64,
    /// Number of pixel values of an image.
    values: Option<u64>,
}

/// Side of the images (px).
const SIDE: u32 = 512;

/// Every kind of input file, with the memory of its worst case.
fn kinds() -> Vec<Kind> {
    let small = "--width 16 --height 9 --runner cpu";
    let render = format!("render ring -o out.exr {small} --light-paths 100 --frames 1");
    let text = |name, file, command: &str, factor| Kind {
        name,
        file,
        command: command.into(),
        factor,
        values: None,
    };
    let image = |name, file, command: &str, factor| Kind {
        values: Some(3 * u64::from(SIDE * SIDE)),
        ..text(name, file, command, factor)
    };
    let edits = |file: &str| format!("{render} --edits {file}");
    let sky = |file: &str| format!("{render} --environment {file}");
    let sweep = |file: &str| format!("sweep --dry-run {file}");
    let report = |folder: &str| format!("report {folder} -o out.html");
    let info = |file: &str| format!("scene info {file}");
    vec![
        text("edits, a list", "list.toml", &edits("list.toml"), 130),
        text("edits, keys", "keys.toml", &edits("keys.toml"), 130),
        text("edits, tables in tables", "dotted.toml", &edits("dotted.toml"), 500),
        text("a sweep, a list", "sweep-list.toml", &sweep("sweep-list.toml"), 130),
        text("a sweep, matrices", "sweep-matrices.toml", &sweep("sweep-matrices.toml"), 130),
        text("results, a list", "list/cells/0123456789abcdef.json", &report("list"), 60),
        text("results, frames", "frames/cells/0123456789abcdef.json", &report("frames"), 60),
        text("results, values", "values/cells/0123456789abcdef.json", &report("values"), 60),
        text("glTF, nodes", "nodes.gltf", &info("nodes.gltf"), 520),
        text("glTF, meshes on nodes", "placed.gltf", &info("placed.gltf"), 300),
        text("glTF, a list", "list.gltf", &info("list.gltf"), 70),
        text("glTF, instances", "instances.glb", &info("instances.glb"), 200),
        image("environment, Radiance HDR", "sky.hdr", &sky("sky.hdr"), 40),
        image("environment, EXR", "sky.exr", &sky("sky.exr"), 40),
        image("compare, EXR", "sky.exr", "compare sky.exr sky.exr", 180),
        image("compare, PNG", "white.png", "compare white.png white.png", 180),
        text("a checkpoint", "c.exr.checkpoint", &format!("reference ring -o c.exr --resume {small}"), 60),
        text("a shard", "a.sums", "merge a.sums a.sums -o out.exr", 60),
        text(
            "a state",
            "animation.state",
            &format!("animate moving-caster -o '#.exr' --frames 0..2 {small}"),
            60,
        ),
    ]
}

/// Text of about `size` bytes: a head, numbered lines, a tail.
fn lines(size: usize, head: &str, line: impl Fn(usize) -> String, tail: &str) -> String {
    let mut text = head.to_string();
    for number in 0.. {
        if text.len() + tail.len() >= size {
            break;
        }
        text += &line(number);
    }
    text + tail
}

/// A glTF document with these nodes, the first of which has a triangle.
fn document(nodes: impl Iterator<Item = Value>) -> Value {
    let data = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let nodes: Vec<Value> = std::iter::once(json!({ "mesh": 0 })).chain(nodes).collect();
    json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }], "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [{ "emissiveFactor": [1, 1, 1] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": data }],
    })
}

/// Writes a file of every kind.
fn write(dir: &TestDir) {
    let size = 1 << 18;
    dir.write("list.toml", lines(size, "x = [", |_| "0,".into(), "]"));
    dir.write("keys.toml", lines(size, "", |at| format!("[[keys]]\ntime={at}\n"), ""));
    dir.write("dotted.toml", lines(size / 2, "x = [", |_| "{a.b.c.d=0},".into(), "]"));
    let head = "[time]\nwidth = 64\nheight = 36\n";
    let matrix = "[[matrix]]\nscene=[\"ring\"]\nmethod=\"path\"\nrunner=\"cpu\"\npaths_per_pixel=1\n";
    dir.write(
        "sweep-list.toml",
        lines(size, &format!("{head}{matrix}max_bounces=["), |_| "5,".into(), "]\n"),
    );
    dir.write("sweep-matrices.toml", lines(size, head, |_| matrix.into(), ""));

    // Results: only files of run configurations are read.
    let identity = "0123456789abcdef";
    let result = |values: &str, frames: &str| {
        format!(
            "{{\"identity\":\"{identity}\",\"cell\":{{\"scene\":\"a\",\"camera\":\"b\"{values}}},\"time\":null,\"error\":null,\
             \"frames\":[{frames}],\"provenance\":{{\"commit\":\"\",\"kernels\":\"\",\"device\":\"\",\"seed\":0,\"wall_s\":0,\
             \"unix_s\":0}}}}"
        )
    };
    for (name, text) in [
        ("list", result(&lines(size, ",\"x\":[", |_| "0,".into(), "0]"), "")),
        (
            "frames",
            result("", &lines(size, "{\"frame\":0}", |at| format!(",{{\"frame\":{at},\"a\":1}}"), "")),
        ),
        ("values", result(&lines(size, "", |at| format!(",\"{at:x}\":1"), ""), "")),
    ] {
        std::fs::create_dir_all(dir.path(name).join("cells")).unwrap();
        dir.write(&format!("{name}/cells/{identity}.json"), text);
    }

    dir.write("nodes.gltf", document((0..50_000).map(|_| json!({}))).to_string());
    dir.write("placed.gltf", document((0..20_000).map(|_| json!({ "mesh": 0 }))).to_string());
    let mut list = document(std::iter::empty());
    list["extras"] = vec![0; size / 2].into();
    dir.write("list.gltf", list.to_string());
    dir.write("instances.glb", instances(20_000));

    // The heads are lists, and the checksums are right.
    for (name, kind) in
        [("c.exr.checkpoint", "checkpoint"), ("a.sums", "checkpoint"), ("animation.state", "animation")]
    {
        let sealed = caustics::sealed::seal(kind, &vec![0; size / 2], |_| {}).unwrap();
        dir.write(name, sealed);
    }

    let image = image::RgbImage::from_pixel(SIDE, SIDE, image::Rgb([200, 200, 200]));
    image.save(dir.path("white.png")).unwrap();
    let float = image::DynamicImage::ImageRgb8(image).into_rgb32f();
    float.save(dir.path("sky.hdr")).unwrap();
    let pixels = float.pixels().map(|pixel| pixel.0);
    let image = caustics::rendered_image::RenderedImage {
        width: SIDE as usize,
        height: SIDE as usize,
        path: pixels.map(Into::into).collect(),
        ..Default::default()
    };
    let bytes = caustics::output::exr::encode(&image, None, &Default::default()).unwrap();
    dir.write("sky.exr", bytes);
}

/// A triangle with this many instances, on a node that moves.
fn instances(count: usize) -> Vec<u8> {
    let mut document = document(std::iter::empty());
    let mut binary: Vec<u8> =
        [0_f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut add = |values: &[f32], shape: &str, components: usize| {
        let views = document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": 4 * values.len() }));
        let view = views.len() - 1;
        let count = values.len() / components;
        let accessor = json!({ "bufferView": view, "componentType": 5126, "count": count, "type": shape });
        document["accessors"].as_array_mut().unwrap().push(accessor);
        binary.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    };
    add(&[0., 1.], "SCALAR", 1);
    add(&[0., 0., 0., 1., 1., 1.], "VEC3", 3);
    let translations: Vec<f32> =
        (0..count).flat_map(|at| [(at % 100) as f32, (at / 100) as f32, 0.]).collect();
    add(&translations, "VEC3", 3);
    document["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
        "samplers": [{ "input": 1, "output": 2 }],
    }]);
    document["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 3 } } });
    document["materials"] = json!([{}]);
    document["buffers"] = json!([{ "byteLength": binary.len() }]);
    let mut json = serde_json::to_vec(&document).unwrap();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |value: usize| (value as u32).to_le_bytes();
    let mut out = b"glTF".to_vec();
    out.extend([word(2), word(28 + json.len() + binary.len()), word(json.len())].concat());
    out.extend([b"JSON".as_slice(), &json, &word(binary.len()), b"BIN\0", &binary].concat());
    out
}

/// Runs a command with one thread in limited address space (KiB), and removes its outputs.
fn run_in(dir: &TestDir, limit: u64, arguments: &str) -> Run {
    let before = listing(dir.folder());
    let line = "export RAYON_NUM_THREADS=1 CAUSTICS_CACHE=; ulimit -v";
    let run = shell(dir, &format!("{line} {limit}; exec \"$0\" {arguments}"));
    for path in listing(dir.folder()).difference(&before) {
        let _ = std::fs::remove_file(path);
    }
    run
}

/// Returns why a run ended improperly: by a signal, a panic, a wrong exit code, or without a message.
fn fault(run: &Run) -> Option<String> {
    let is_reported = run.code == Some(0) || !run.stderr.is_empty();
    let is_fine = matches!(run.code, Some(0..=2)) && is_reported && !run.stderr.contains("panicked");
    (!is_fine).then(|| format!("exit code {:?}: {}", run.code, run.stderr))
}

#[test]
#[cfg(target_os = "linux")]
fn every_kind_of_file_ends_in_an_error_where_memory_is_short() {
    let dir = TestDir::new();
    write(&dir);
    let mut faults = Vec::new();
    for Kind { name, command, .. } in kinds() {
        for limit in LIMITS {
            let fault = fault(&run_in(&dir, limit, &command));
            faults.extend(fault.map(|fault| format!("{name} in {limit} KiB: {fault}")));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
#[cfg(target_os = "linux")]
fn every_kind_of_file_takes_no_more_memory_than_its_bytes_may() {
    let dir = TestDir::new();
    write(&dir);
    let mut faults = Vec::new();
    for Kind { name, file, command, factor, values } in kinds() {
        let bytes = values.unwrap_or(dir.path(file).metadata().unwrap().len());
        let run = run_in(&dir, PROGRAM + factor * bytes / 1024, &command);
        let words = ["of memory", "memory allocation", "the system lets this process"];
        let is_short = words.iter().any(|words| run.stderr.contains(words));
        let fault = fault(&run).or(is_short.then(|| run.stderr.clone()));
        faults.extend(fault.map(|fault| format!("{name}, {factor} times {bytes} bytes: {fault}")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn elements_without_bytes_are_as_many_as_the_file_has_bytes() {
    let dir = TestDir::new();
    let mut document = document(std::iter::empty());
    let node = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 1 } } });
    document["nodes"][0]["extensions"] = node;
    let info = |count: u64, document: &mut Value| {
        document["accessors"][1] = json!({ "componentType": 5126, "count": count, "type": "VEC3" });
        dir.write("a.gltf", document.to_string());
        dir.run(&["scene", "info", "a.gltf"])
    };
    document["accessors"].as_array_mut().unwrap().push(Value::Null);
    let few = info(10, &mut document);
    assert_eq!(few.code, Some(0), "{}", few.stderr);
    let many = info(1_000_000, &mut document);
    assert_eq!(many.code, Some(1), "{}", many.stderr);
    assert!(many.stderr.contains("1000000 elements without a buffer view"), "{}", many.stderr);
}

/// Copies of one table. Counting each from the beginning of the file once took more than a minute.
#[test]
fn many_matrices_of_one_configuration_are_one_configuration() {
    let dir = TestDir::new();
    let matrix = "[[matrix]]\nscene=[\"ring\"]\nmethod=\"path\"\nrunner=\"cpu\"\npaths_per_pixel=1\n";
    let text = format!("[time]\nwidth = 64\nheight = 36\n{}", matrix.repeat(20_000));
    dir.write("a.toml", text);
    let run = dir.succeeds(&["sweep", "a.toml", "--dry-run"]);
    assert!(run.stdout.contains("1 run configurations, 0 done"), "{}", run.stdout);
}
