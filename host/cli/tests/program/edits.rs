//! `--edits`: what a file changes is in the image, and is part of what a run is.

use std::path::Path;

use assert_cmd::Command;
use caustics::image_file::Channels;
use serde_json::Value;
use tempfile::TempDir;

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--runner", "cpu"];
const PATHS: [&str; 2] = ["--light-paths", "2000"];
/// Its nodes are a plane, a ring, a lamp and a camera.
const SCENE: &str = "ring";

/// A folder with files of edits.
fn desk() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("moved.toml", "nodes = [{ node = 1, name = \"ring\", translation = [0.1, 0, 0] }]");
    write("seen.toml", "camera = { from = [0.3, 0.5, 0.4], look_at = [0, 0, 0], fov = 50 }");
    write(
        "keys.toml",
        "keys = [{ time = 0, nodes = [{ node = 1, translation = [0, 0, 0] }] },
                 { time = 1, nodes = [{ node = 1, translation = [0.2, 0, 0] }] }]",
    );
    write("other.toml", "nodes = [{ node = 1, name = \"vase\" }]");
    folder
}

/// Exit code, stdout and stderr.
fn run(folder: &TempDir, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustics"));
    command
        .current_dir(folder.path())
        .args(arguments)
        .args(TINY)
        .timeout(std::time::Duration::from_secs(120));
    let output = command.output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[track_caller]
fn done(folder: &TempDir, arguments: &[&str]) -> String {
    let (code, stdout, stderr) = run(folder, arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {stderr}");
    stdout
}

#[track_caller]
fn refused(folder: &TempDir, arguments: &[&str], code: i32, words: &str) {
    let (found, _, stderr) = run(folder, arguments);
    assert_eq!(found, Some(code), "{arguments:?}: {stderr}");
    assert!(stderr.contains(words), "{arguments:?}: {stderr}");
}

fn image(folder: &TempDir, name: &str) -> Channels {
    Channels::read(&Path::new(folder.path()).join(name)).unwrap()
}

#[test]
fn render_shows_what_a_file_changes() {
    let desk = desk();
    let render = |out: &str, options: &[&str]| {
        done(&desk, &[&["render", SCENE, "--frames", "1", "-o", out], &PATHS[..], options].concat());
        image(&desk, out)
    };
    let plain = render("plain.exr", &[]);
    let moved = render("moved.exr", &["--edits", "moved.toml"]);
    assert_ne!(moved.layer(""), plain.layer(""));
    assert!(moved.attributes.contains_key("edits") && !plain.attributes.contains_key("edits"));
    // Keys of that time say the same.
    let half = render("half.exr", &["--edits", "keys.toml", "--time", "0.5"]);
    assert_eq!(half.layer(""), moved.layer(""));
    // A camera is that of the options.
    let seen = render("seen.exr", &["--edits", "seen.toml"]);
    let placed = render("placed.exr", &["--from", "0.3,0.5,0.4", "--look-at", "0,0,0", "--fov", "50"]);
    assert_eq!(seen.layer(""), placed.layer(""));
    assert_eq!(seen.attributes["camera"], placed.attributes["camera"]);
    done(&desk, &["reference", SCENE, "--spp", "2", "-o", "r.exr", "--edits", "moved.toml"]);
}

#[test]
fn edits_that_are_of_something_else_are_refused() {
    let desk = desk();
    let render =
        |options: &[&'static str]| [&["render", SCENE, "--frames", "1", "-o", "a.exr"], options].concat();
    refused(&desk, &render(&["--edits", "none.toml"]), 1, "none.toml: cannot be read");
    refused(
        &desk,
        &render(&["--edits", "other.toml"]),
        1,
        "node 1 is called \"ring\", but the edits are of \"vase\"",
    );
    for camera in [["--camera", "main"], ["--fov", "30"]] {
        let options = [&["--edits", "seen.toml"], &camera[..]].concat();
        refused(&desk, &render(&options), 2, "--edits seen.toml: the file says where the camera is");
    }
    // The camera of the file moves no node: another may be looked through.
    done(&desk, &render(&["--edits", "moved.toml", "--fov", "30"]));
    // No image takes the place of the edits.
    std::fs::copy(desk.path().join("moved.toml"), desk.path().join("edits.exr")).unwrap();
    let over = ["render", SCENE, "-o", "edits.exr", "--edits", "edits.exr", "--force"];
    refused(&desk, &over, 2, "is a file of the scene");
    let over =
        ["animate", SCENE, "-o", "edits-#.exr", "--frames", "0..2", "--edits", "edits-1.exr", "--force"];
    std::fs::copy(desk.path().join("moved.toml"), desk.path().join("edits-1.exr")).unwrap();
    refused(&desk, &over, 2, "is a file of the scene");
    assert_eq!(
        std::fs::read(desk.path().join("edits-1.exr")).unwrap(),
        std::fs::read(desk.path().join("moved.toml")).unwrap()
    );
}

#[test]
fn animate_plays_the_keys_of_edits() {
    let desk = desk();
    let animate = [&["animate", SCENE, "-o", "f/##.exr", "--fps", "4", "--json"], &PATHS[..]].concat();
    refused(&desk, &animate, 2, "nothing moves in ring");
    refused(&desk, &[&animate[..], &["--edits", "moved.toml"]].concat(), 2, "nothing moves in ring");
    let keyed = [&animate[..], &["--edits", "keys.toml"]].concat();
    let report: Value = serde_json::from_str(&done(&desk, &keyed)).unwrap();
    assert_eq!((&report["first"], &report["end"]), (&0.into(), &4.into()));
    let frames: Vec<_> = (0..4).map(|frame| image(&desk, &format!("f/0{frame}.exr"))).collect();
    assert!(frames.windows(2).all(|pair| pair[0].layer("caustics") != pair[1].layer("caustics")));

    // Frames of other edits are not gone on from, even where no key has come yet.
    std::fs::remove_file(desk.path().join("f/03.exr")).unwrap();
    let text = std::fs::read_to_string(desk.path().join("keys.toml")).unwrap();
    std::fs::write(desk.path().join("keys.toml"), text.replace("0.2", "0.3")).unwrap();
    refused(&desk, &keyed, 2, "belongs to another run: its edits is");
    std::fs::write(desk.path().join("keys.toml"), text).unwrap();
    done(&desk, &keyed);
    assert_eq!(image(&desk, "f/03.exr").layer(""), frames[3].layer(""));
}
