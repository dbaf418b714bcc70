//! Files that are written: none is lost, and none has a misleading name.

use std::path::Path;

use serde_json::json;

use super::{Scene, TINY, caustics, listing, refuses, render_refuses, shell};

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

/// The limit of files, in blocks of 512 bytes or of 1 KiB, is below what each of these writes.
#[cfg(unix)]
#[test]
fn a_file_beyond_the_limit_of_files_is_an_error_that_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let tiny = "--width 64 --height 36 --light-paths 1000 --runner cpu";
    for line in [
        format!("render mirror-room -o out.exr {tiny}"),
        format!("render mirror-room -o out.exr --png out.png {tiny} --force"),
        format!("render mirror-room -o out.exr --frames 2 --shard 1/2 {tiny}"),
        format!("animate moving-caster -o out/##.exr --frames 0..2 {tiny}"),
        "reference mirror-room -o out.exr --spp 2 --width 64 --height 36 --runner cpu".to_string(),
        "scene make mirror-room -o made".to_string(),
    ] {
        let _ = std::fs::create_dir(folder.path().join("out"));
        let before = listing(folder.path());
        let run =
            shell(folder.path(), &format!("export CAUSTICS_CACHE=$PWD/none; ulimit -f 1; exec $0 {line}"));
        assert!(
            run.code.is_some_and(|code| (1..=2).contains(&code)),
            "{line}: {:?} {}",
            run.code,
            run.stderr
        );
        assert!(run.stderr.contains("error: "), "{line}: {}", run.stderr);
        let made = folder.path().join("made");
        let left: Vec<_> = listing(folder.path()).difference(&before).cloned().collect();
        assert!(left.iter().all(|path| path.starts_with(&made) && path.is_dir()), "{line}: {left:?}");
    }
    let line = format!("ulimit -f 1; exec $0 render mirror-room -o out.exr {tiny}");
    let run = shell(folder.path(), &line);
    assert!(run.stderr.contains("out.exr") && run.stderr.contains("ulimit -f"), "{}", run.stderr);
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
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/textured-room");
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
    // The image of all around is one too; a radiance is none.
    std::fs::copy(scene.path().join("a buffer.exr"), scene.path().join("sky.exr")).unwrap();
    let render = ["render", "scene.gltf", "--force", "-o", "sky.exr", "--environment", "./sky.exr"];
    refuses(scene.path(), &[&render[..], &TINY].concat(), 2, &["sky.exr is a file of the scene"]);
    let run = caustics(scene.path(), &[&["render", "ring", "-o", "sky1.exr"], &TINY[..]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let options = ["-o", "sky#.exr", "--frames", "0..3", "--environment", "sky1.exr"];
    let animate = [&["animate", "scene.gltf", "--force"], &options[..], &TINY].concat();
    refuses(scene.path(), &animate, 2, &["sky1.exr is a file of the scene"]);
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
