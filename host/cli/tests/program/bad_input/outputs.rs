//! Output files: no file is lost, and no name misleads.

use std::path::Path;

use serde_json::json;

use super::{Scene, TINY, listing, refuses, render_refuses, shell};
use crate::test_dir::TestDir;

#[test]
fn nothing_is_overwritten_without_force() {
    let dir = TestDir::new();
    let file = dir.path("out.exr");
    dir.write("out.exr", "precious");
    render_refuses(&dir, "mirror-room", &[], 2, &["out.exr", "--force"]);
    std::fs::rename(&file, dir.path("out.png")).unwrap();
    render_refuses(&dir, "mirror-room", &["--png", "out.png"], 2, &["out.png", "--force"]);
    assert_eq!(std::fs::read(dir.path("out.png")).unwrap(), b"precious");

    // A failing run does not overwrite a file despite --force.
    dir.write("out.exr", "precious");
    render_refuses(&dir, "missing.gltf", &["--force"], 1, &["missing.gltf"]);
    assert_eq!(std::fs::read(&file).unwrap(), b"precious");
    render_refuses(&dir, "mirror-room", &["--force", "--png", "out.exr"], 2, &["--png", "out.exr"]);
    render_refuses(&dir, "mirror-room", &["--force", "--png", "./out.exr"], 2, &["--png", "out.exr"]);

    std::fs::create_dir(dir.path("ring")).unwrap();
    dir.write("ring/scene.gltf", "precious");
    refuses(&dir, &["scene", "make", "all", "-o", "."], 2, &["ring", "--force"]);
}

#[test]
fn folders_that_cannot_be_written_are_named() {
    let dir = TestDir::new();
    dir.write("file", "");
    for out in ["missing/out.exr", "file/out.exr"] {
        let arguments = [&["render", "mirror-room", "-o", out], &TINY[..]].concat();
        refuses(&dir, &arguments, 1, &[out, "-o"]);
    }
    std::fs::create_dir(dir.path("folder")).unwrap();
    let arguments = [&["render", "mirror-room", "-o", "folder", "--force"], &TINY[..]].concat();
    refuses(&dir, &arguments, 2, &["folder is a folder", "name a file"]);
    let arguments = [&["render", "mirror-room", "-o", "out.exr", "--png", "missing/out.png"], &TINY[..]];
    refuses(&dir, &arguments.concat(), 1, &["missing/out.png", "create the folder"]);
    refuses(&dir, &["scene", "make", "ring", "-o", "file"], 1, &["file/ring"]);
}

/// Limit of file sizes, in blocks of 512 bytes or 1 KiB, below the size of each output.
#[cfg(unix)]
#[test]
fn a_file_beyond_the_limit_of_files_is_an_error_that_leaves_nothing() {
    let dir = TestDir::new();
    let tiny = "--width 64 --height 36 --light-paths 1000 --runner cpu";
    for line in [
        format!("render mirror-room -o out.exr {tiny}"),
        format!("render mirror-room -o out.exr --png out.png {tiny} --force"),
        format!("render mirror-room -o out.exr --frames 2 --shard 1/2 {tiny}"),
        format!("animate moving-caster -o out/##.exr --frames 0..2 {tiny}"),
        "reference mirror-room -o out.exr --spp 2 --width 64 --height 36 --runner cpu".to_string(),
        "scene make mirror-room -o made".to_string(),
    ] {
        let _ = std::fs::create_dir(dir.path("out"));
        let before = listing(dir.folder());
        let run = shell(&dir, &format!("export CAUSTICS_CACHE=$PWD/none; ulimit -f 1; exec $0 {line}"));
        assert!(
            run.code.is_some_and(|code| (1..=2).contains(&code)),
            "{line}: {:?} {}",
            run.code,
            run.stderr
        );
        assert!(run.stderr.contains("error: "), "{line}: {}", run.stderr);
        let made = dir.path("made");
        let left: Vec<_> = listing(dir.folder()).difference(&before).cloned().collect();
        assert!(left.iter().all(|path| path.starts_with(&made) && path.is_dir()), "{line}: {left:?}");
    }
    let line = format!("ulimit -f 1; exec $0 render mirror-room -o out.exr {tiny}");
    let run = shell(&dir, &line);
    assert!(run.stderr.contains("out.exr") && run.stderr.contains("ulimit -f"), "{}", run.stderr);
}

#[test]
fn misleading_file_extensions_are_refused() {
    let dir = TestDir::new();
    let render = |options: &[&str], words: &[&str]| {
        refuses(&dir, &[&["render", "ring"], options, &TINY[..]].concat(), 2, words);
    };
    render(&["-o", "a.png"], &["-o a.png", "EXR", ".exr"]);
    render(&["-o", "a.PNG"], &["-o a.PNG", ".exr"]);
    render(&["-o", "a.exr", "--png", "b.exr"], &["--png b.exr", "PNG", ".png"]);
    refuses(&dir, &["merge", "a.exr", "b.exr", "-o", "c.png"], 2, &["-o c.png", ".exr"]);
    refuses(&dir, &["compare", "a.exr", "b.exr", "--map", "c.exr"], 2, &["--map c.exr", ".png"]);
}

#[test]
fn force_overwrites_no_file_of_the_scene() {
    let mut scene = Scene::new("textured-room");
    scene.json["buffers"][0]["uri"] = json!("a%20buffer.exr");
    scene.write();
    std::fs::rename(scene.dir.path("scene.bin"), scene.dir.path("a buffer.exr")).unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/textured-room");
    for file in ["tiles.png", "bricks.png", "rings.png", "leaves.png", "panes.png"] {
        std::fs::copy(source.join(file), scene.dir.path(file)).unwrap();
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a buffer.exr", scene.dir.path("link.exr")).unwrap();
        std::fs::hard_link(scene.dir.path("tiles.png"), scene.dir.path("hard.png")).unwrap();
    }
    let links = if cfg!(unix) { &[["link.exr", "b.png"], ["b.exr", "hard.png"]][..] } else { &[] };
    for &[exr, png] in
        [["a buffer.exr", "b.png"], ["./a buffer.exr", "b.png"], ["b.exr", "tiles.png"]].iter().chain(links)
    {
        let render = ["render", "scene.gltf", "--force", "-o", exr, "--png", png];
        refuses(&scene.dir, &[&render[..], &TINY].concat(), 2, &["is a file of the scene", "another name"]);
    }
    // The environment's image is a file of the scene too; a radiance is not.
    std::fs::copy(scene.dir.path("a buffer.exr"), scene.dir.path("sky.exr")).unwrap();
    let render = ["render", "scene.gltf", "--force", "-o", "sky.exr", "--environment", "./sky.exr"];
    refuses(&scene.dir, &[&render[..], &TINY].concat(), 2, &["sky.exr is a file of the scene"]);
    scene.dir.succeeds(&[&["render", "ring", "-o", "sky1.exr"], &TINY[..]].concat());
    let options = ["-o", "sky#.exr", "--frames", "0..3", "--environment", "sky1.exr"];
    let animate = [&["animate", "scene.gltf", "--force"], &options[..], &TINY].concat();
    refuses(&scene.dir, &animate, 2, &["sky1.exr is a file of the scene"]);
    // Each frame of an animation has its own name.
    std::fs::rename(scene.dir.path("a buffer.exr"), scene.dir.path("01.exr")).unwrap();
    scene.json["buffers"][0]["uri"] = json!("01.exr");
    scene.dir.write("scene.gltf", serde_json::to_vec(&scene.json).unwrap());
    let animate = ["animate", "scene.gltf", "--force", "-o", "##.exr", "--frames", "0..3"];
    refuses(&scene.dir, &[&animate[..], &TINY].concat(), 2, &["01.exr is a file of the scene"]);
    assert_eq!(std::fs::read(scene.dir.path("01.exr")).unwrap(), scene.binary);
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_nowhere_is_refused_before_anything_is_rendered() {
    let dir = TestDir::new();
    std::os::unix::fs::symlink("nowhere", dir.path("out.exr")).unwrap();
    // The scene is not even opened.
    render_refuses(&dir, "missing.gltf", &[], 2, &["out.exr is a link", "--force"]);
}
