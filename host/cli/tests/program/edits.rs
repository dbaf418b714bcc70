//! `--edits`: changes of a file are in the image and in the identity of a run.

use caustics::image_file::Channels;

use crate::test_dir::{Run, TestDir};

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--runner", "cpu"];
const PATHS: [&str; 2] = ["--light-paths", "2000"];
/// A scene whose nodes are a plane, a ring, a lamp and a camera.
const SCENE: &str = "ring";

/// Makes a folder with files of edits.
fn dir_with_edits() -> TestDir {
    let dir = TestDir::new();
    dir.write("moved.toml", "nodes = [{ node = 1, name = \"ring\", translation = [0.1, 0, 0] }]");
    dir.write("seen.toml", "camera = { from = [0.3, 0.5, 0.4], look_at = [0, 0, 0], fov = 50 }");
    dir.write(
        "keys.toml",
        "keys = [{ time = 0, nodes = [{ node = 1, translation = [0, 0, 0] }] },
                 { time = 1, nodes = [{ node = 1, translation = [0.2, 0, 0] }] }]",
    );
    dir.write("other.toml", "nodes = [{ node = 1, name = \"vase\" }]");
    dir
}

/// Runs the program on tiny images, which must succeed.
#[track_caller]
fn done(dir: &TestDir, arguments: &[&str]) -> Run {
    dir.succeeds(&[arguments, &TINY].concat())
}

#[track_caller]
fn refused(dir: &TestDir, arguments: &[&str], code: i32, words: &str) {
    dir.refuses(&[arguments, &TINY].concat(), code, &[words]);
}

fn image(dir: &TestDir, name: &str) -> Channels {
    Channels::read(&dir.path(name)).unwrap()
}

#[test]
fn render_shows_what_a_file_changes() {
    let dir = dir_with_edits();
    let render = |out: &str, options: &[&str]| {
        done(&dir, &[&["render", SCENE, "--frames", "1", "-o", out], &PATHS[..], options].concat());
        image(&dir, out)
    };
    let plain = render("plain.exr", &[]);
    let moved = render("moved.exr", &["--edits", "moved.toml"]);
    assert_ne!(moved.layer(""), plain.layer(""));
    assert!(moved.attributes.contains_key("edits") && !plain.attributes.contains_key("edits"));
    // Keys give the same positions at that time.
    let half = render("half.exr", &["--edits", "keys.toml", "--time", "0.5"]);
    assert_eq!(half.layer(""), moved.layer(""));
    // A camera of the edits equals one of the options.
    let seen = render("seen.exr", &["--edits", "seen.toml"]);
    let placed = render("placed.exr", &["--from", "0.3,0.5,0.4", "--look-at", "0,0,0", "--fov", "50"]);
    assert_eq!(seen.layer(""), placed.layer(""));
    assert_eq!(seen.attributes["camera"], placed.attributes["camera"]);
    done(&dir, &["reference", SCENE, "--spp", "2", "-o", "r.exr", "--edits", "moved.toml"]);
}

#[test]
fn edits_of_another_scene_are_refused() {
    let dir = dir_with_edits();
    let render =
        |options: &[&'static str]| [&["render", SCENE, "--frames", "1", "-o", "a.exr"], options].concat();
    refused(&dir, &render(&["--edits", "none.toml"]), 1, "none.toml: cannot be read");
    refused(
        &dir,
        &render(&["--edits", "other.toml"]),
        1,
        "node 1 is called \"ring\", but the edits are of \"vase\"",
    );
    for camera in [["--camera", "main"], ["--fov", "30"]] {
        let options = [&["--edits", "seen.toml"], &camera[..]].concat();
        refused(&dir, &render(&options), 2, "--edits seen.toml: the file says where the camera is");
    }
    // The camera of the file moves no node, so another one may be used.
    done(&dir, &render(&["--edits", "moved.toml", "--fov", "30"]));
    // No image overwrites the edits.
    std::fs::copy(dir.path("moved.toml"), dir.path("edits.exr")).unwrap();
    let over = ["render", SCENE, "-o", "edits.exr", "--edits", "edits.exr", "--force"];
    refused(&dir, &over, 2, "is a file of the scene");
    let over =
        ["animate", SCENE, "-o", "edits-#.exr", "--frames", "0..2", "--edits", "edits-1.exr", "--force"];
    std::fs::copy(dir.path("moved.toml"), dir.path("edits-1.exr")).unwrap();
    refused(&dir, &over, 2, "is a file of the scene");
    assert_eq!(
        std::fs::read(dir.path("edits-1.exr")).unwrap(),
        std::fs::read(dir.path("moved.toml")).unwrap()
    );
}

#[test]
fn animate_plays_the_keys_of_edits() {
    let dir = dir_with_edits();
    let animate = [&["animate", SCENE, "-o", "f/##.exr", "--fps", "4", "--json"], &PATHS[..]].concat();
    refused(&dir, &animate, 2, "nothing moves in ring");
    refused(&dir, &[&animate[..], &["--edits", "moved.toml"]].concat(), 2, "nothing moves in ring");
    let keyed = [&animate[..], &["--edits", "keys.toml"]].concat();
    let report = done(&dir, &keyed).json();
    assert_eq!((&report["first"], &report["end"]), (&0.into(), &4.into()));
    let frames: Vec<_> = (0..4).map(|frame| image(&dir, &format!("f/0{frame}.exr"))).collect();
    assert!(frames.windows(2).all(|pair| pair[0].layer("caustics") != pair[1].layer("caustics")));

    // Frames of other edits are not resumed, even before the first key.
    std::fs::remove_file(dir.path("f/03.exr")).unwrap();
    let text = std::fs::read_to_string(dir.path("keys.toml")).unwrap();
    dir.write("keys.toml", text.replace("0.2", "0.3"));
    refused(&dir, &keyed, 2, "belongs to another run: its edits is");
    dir.write("keys.toml", text);
    done(&dir, &keyed);
    assert_eq!(image(&dir, "f/03.exr").layer(""), frames[3].layer(""));
}
