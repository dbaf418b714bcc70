//! Inputs are never overwritten, even with --force, and outputs follow their folder when it moves.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use super::{TINY, listing, refuses};
use crate::test_dir::{BINARY, TestDir};

/// Makes a folder with one result and an image beside it.
fn results(dir: &TestDir) {
    let bench = [
        "bench",
        "ring",
        "-o",
        "res",
        "--runner",
        "cpu",
        "--frames",
        "1",
        "--warm-up",
        "0",
        "--light-paths",
        "100",
    ];
    dir.succeeds(&[&bench[..], &TINY[..4]].concat());
}

#[test]
fn a_report_is_written_over_no_result() {
    let dir = TestDir::new();
    results(&dir);
    let folder = dir.path("res/cells");
    let result = folder
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| path.extension().unwrap() == "json");
    let result = result.unwrap();
    let name = format!("res/cells/{}", result.file_name().unwrap().to_str().unwrap());
    let before = std::fs::read(&result).unwrap();
    dir.write("scene.gltf", "precious");
    for output in [&name, "res/cells.csv", "scene.gltf", "res/cells.png"] {
        refuses(&dir, &["report", "res", "-o", output, "--force"], 2, &[output, ".html"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&name, dir.path("soft.html")).unwrap();
        std::fs::hard_link(&result, dir.path("hard.html")).unwrap();
        for output in ["soft.html", "hard.html"] {
            let words = [output, "one of the results", "another name"];
            refuses(&dir, &["report", "res", "-o", output, "--force"], 2, &words);
        }
    }
    // The figures of a page go into a folder beside it.
    std::fs::rename(dir.path("res"), dir.path("page_files")).unwrap();
    for arguments in [&["page_files"][..], &["page_files", "--baseline", "page_files"]] {
        let report = [&["report", "-o", "page.html", "--force"], arguments].concat();
        refuses(&dir, &report, 2, &["page_files", "results", "another name"]);
    }
    let result = dir.path("page_files/cells").join(result.file_name().unwrap());
    assert_eq!(std::fs::read(result).unwrap(), before);
    dir.succeeds(&["report", "page_files", "-o", "other.html"]);
}

#[test]
fn companion_files_of_an_output_overwrite_no_file_of_the_scene() {
    let dir = TestDir::new();
    dir.succeeds(&[&["render", "ring", "-o", "sky.exr"], &TINY[..]].concat());
    let sky = std::fs::read(dir.path("sky.exr")).unwrap();
    std::fs::remove_file(dir.path("sky.exr")).unwrap();
    for (name, arguments) in [
        ("o.exr.checkpoint", &["render", "ring", "-o", "o.exr"][..]),
        (".caustics-o.exr.lock", &["render", "ring", "-o", "o.exr"]),
        ("o.exr.checkpoint", &["reference", "ring", "-o", "o.exr", "--spp", "2"]),
        ("o.shard-1-of-2.sums", &["render", "ring", "-o", "o.exr", "--shard", "1/2", "--frames", "2"]),
        ("animation.state", &["animate", "moving-caster", "-o", "#.exr", "--frames", "0..2"]),
        ("1.png", &["animate", "moving-caster", "-o", "#.exr", "--frames", "0..2", "--png"]),
    ] {
        dir.write(name, &sky);
        let size = if arguments[0] == "reference" { &TINY[..4] } else { &TINY[..] };
        let arguments = [arguments, size, &["--force", "--environment", name]].concat();
        refuses(&dir, &arguments, 2, &[name, "is a file of the scene"]);
        assert_eq!(std::fs::read(dir.path(name)).unwrap(), sky, "{arguments:?}");
        std::fs::remove_file(dir.path(name)).unwrap();
    }
    // Tables of results do not overwrite inputs either.
    std::fs::create_dir(dir.path("out")).unwrap();
    dir.write("out/cells.csv", &sky);
    let bench =
        ["bench", "ring", "-o", "out", "--runner", "cpu", "--environment", "out/cells.csv", "--force"];
    refuses(&dir, &bench, 2, &["out/cells.csv", "is a file of the scene"]);
}

/// Moves or removes the folder of a run that has claimed its files. Before its first frame a run names its method.
#[cfg(unix)]
fn run_and(dir: &TestDir, arguments: &[&str], then: impl Fn(&Path)) {
    let out = dir.path("out");
    std::fs::create_dir(&out).unwrap();
    let mut program = Command::new(BINARY)
        .current_dir(dir.folder())
        .args(arguments)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut errors = BufReader::new(program.stderr.take().unwrap());
    let mut printed = String::new();
    while !printed.contains(", method ") {
        assert_ne!(errors.read_line(&mut printed).unwrap(), 0, "{arguments:?}: {printed}");
    }
    then(&out);
    errors.read_to_string(&mut printed).unwrap();
    assert_eq!(program.wait().unwrap().code(), Some(0), "{printed}");
}

#[test]
#[cfg(unix)]
fn a_folder_that_moves_while_a_run_writes_keeps_the_result() {
    for (arguments, files) in [
        (
            &["render", "ring", "-o", "out/a.exr", "--png", "out/a.png", "--frames", "4"][..],
            &["a.exr", "a.png"][..],
        ),
        (&["render", "ring", "-o", "out/a.exr", "--shard", "1/2", "--frames", "8"], &["a.shard-1-of-2.sums"]),
        (&["animate", "moving-caster", "-o", "out/#.exr", "--frames", "0..3"], &["0.exr", "1.exr", "2.exr"]),
    ] {
        let dir = TestDir::new();
        let moved = dir.path("moved");
        let arguments = [arguments, &TINY].concat();
        run_and(&dir, &arguments, |out| std::fs::rename(out, &moved).unwrap());
        let names: Vec<_> = moved.read_dir().unwrap().map(|file| file.unwrap().file_name()).collect();
        let mut names: Vec<_> = names.iter().map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        assert_eq!(names, files, "{arguments:?}");
    }
}

#[test]
#[cfg(unix)]
fn a_folder_that_is_removed_while_a_run_writes_is_made_anew_for_the_result() {
    let dir = TestDir::new();
    // A run of seconds, so that the folder is gone before the run ends.
    let options = ["render", "ring", "-o", "out/a.exr", "--png", "out/a.png", "--frames", "512"];
    let render = [&options, &TINY[..]].concat();
    run_and(&dir, &render, |out| std::fs::remove_dir_all(out).unwrap());
    let out = dir.path("out");
    assert_eq!(listing(&out), [out.join("a.exr"), out.join("a.png")].into());
}
