//! Terminal behaviour: streams, names in messages, interrupts.

use std::path::Path;

use serde_json::{Value, json};

use super::{Scene, TINY, fault, shell};
use crate::test_dir::TestDir;

#[test]
#[cfg(target_os = "linux")]
fn closed_streams_end_no_run() {
    let dir = TestDir::new();
    let ring = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/ring");
    let render = format!("\"$0\" render '{}' -o out.exr --force {}", ring.display(), TINY.join(" "));
    for rest in ["2>/dev/full", "2>&-"] {
        let run = shell(&dir, &format!("{render} {rest}"));
        assert_eq!((run.code, run.stdout.as_str()), (Some(0), ""), "{rest}");
        std::fs::remove_file(dir.path("out.exr")).unwrap();
    }
    // The reader has closed the stream before the first line.
    let closed = |command: &str, file: &str| {
        let line = format!(
            "{{ sleep 0.2; {command}; echo $? > code; }} {file} | true; while [ ! -s code ]; do sleep 0.1; done; cat code; rm code"
        );
        shell(&dir, &line).stdout
    };
    assert_eq!(closed(&render, "2>&1"), "0\n");
    assert!(dir.path("out.exr").is_file());
    assert_eq!(closed("\"$0\" scene list", ""), "0\n");
    // An error keeps its exit code.
    assert_eq!(closed("\"$0\" scene info nowhere.glb", "2>&1"), "1\n");
}

#[test]
fn names_of_a_file_command_no_terminal_and_drown_no_message() {
    let active = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{9b}1m\u{202e}\nerror: forged";
    let is_harmless = |text: &str| text.chars().all(|c| c == '\n' || !(c.is_control() || c == '\u{202e}'));
    let mut scene = Scene::new("ring");
    for section in ["materials", "nodes", "cameras", "meshes"] {
        for element in scene.json[section].as_array_mut().unwrap() {
            element["name"] = json!(active);
            element["extensions"] = json!({ active: {} });
        }
    }
    let info = scene.write().dir.succeeds(&["scene", "info", "scene.gltf"]);
    assert!(is_harmless(&info.stdout) && info.stdout.contains("u001b]0;owned"), "{}", info.stdout);
    assert!(!info.stdout.contains("\nerror"), "{}", info.stdout);
    let info = scene.dir.run(&["scene", "info", "scene.gltf", "--json"]);
    assert!(is_harmless(&info.stdout), "{}", info.stdout);
    assert_eq!(info.json()["materials"][0], active);
    let run = scene.dir.succeeds(&[&["render", "scene.gltf", "-o", "out.exr"], &TINY[..]].concat());
    assert!(is_harmless(&run.stderr), "{}", run.stderr);
    // Warnings of one kind share a line, whatever their source.
    let lines = run.stderr.lines().filter(|line| line.contains("is not supported")).count();
    assert_eq!(lines, 1, "{}", run.stderr);

    // Repeat this with errors, and with long ones.
    let long = |text: &str| text.repeat(100_000);
    let spoil: [fn(&mut Value, String); 3] = [
        |json, text| json["extensionsRequired"] = json!([text]),
        |json, text| json["buffers"][0]["uri"] = json!(text),
        |json, text| json["buffers"][0]["uri"] = json!(format!("http://{text}")),
    ];
    for spoil in spoil {
        for text in [active.to_string(), long(active), long("a")] {
            let mut scene = Scene::new("ring");
            spoil(&mut scene.json, text);
            let run = scene.write().dir.run(&["scene", "info", "scene.gltf", "--strict"]);
            assert_eq!(fault(&run, 1, &["scene.gltf", ";"]), None);
            assert!(is_harmless(&run.stderr), "{}", run.stderr);
            assert!(run.stderr.len() < 8000, "{}", run.stderr.len());
        }
    }

    // A cause is printed once.
    let run = scene.dir.run(&["scene", "info", "missing.glb"]);
    assert_eq!(run.stderr.matches("No such file").count(), 1, "{}", run.stderr);
}

#[test]
#[cfg(unix)]
fn a_second_interrupt_ends_at_once() {
    let dir = TestDir::new();
    let ring = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/ring");
    let begin = std::time::Instant::now();
    // One frame takes minutes. The first interrupt waits for it, the second does not.
    let line = format!(
        "\"$0\" render '{}' -o out.exr --runner cpu --threads 1 --width 16 --height 9 --light-paths 300000000 2> said & \
         while ! grep -q method said; do sleep 0.1; done; sleep 0.3; kill -INT $!; sleep 0.5; \
         kill -0 $! && echo waits; kill -INT $!; wait $!; echo $?; cat said",
        ring.display()
    );
    // Background jobs of a shell ignore interrupts unless job control is on.
    let run = shell(&dir, &format!("set -m; {line}"));
    assert!(run.stdout.starts_with("waits\n130\n"), "{} {}", run.stdout, run.stderr);
    assert!(run.stdout.contains("once more ends at once"), "{}", run.stdout);
    assert!(begin.elapsed().as_secs() < 30, "{:?}", begin.elapsed());
}
