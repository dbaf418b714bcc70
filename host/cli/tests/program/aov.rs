//! `--aov`: layers for other tools, as a file has them.

use std::path::Path;

use assert_cmd::Command;
use caustics::image_file::Channels;

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--runner", "cpu"];

/// Exit code and stderr of a run in a folder.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustics"));
    let output = command.current_dir(folder).args(arguments).args(TINY).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[track_caller]
fn write(folder: &Path, arguments: &[&str]) {
    let (code, stderr) = run(folder, arguments);
    assert_eq!(code, 0, "{arguments:?}: {stderr}");
}

/// The layers of a file that are not made without being asked for.
fn layers(image: &Channels) -> Vec<&str> {
    let names = image.channels.keys().map(String::as_str);
    names
        .filter(|name| ["nor", "alb", "dep", "pos", "mot", "mat"].contains(&&name[..3.min(name.len())]))
        .collect()
}

#[test]
fn what_is_asked_for_is_there_and_nothing_else() {
    let desk = tempfile::tempdir().unwrap();
    let read = |name: &str| Channels::read(&desk.path().join(name)).unwrap();
    write(desk.path(), &["render", "mirror-room", "-o", "plain.exr", "--frames", "2"]);
    assert_eq!(layers(&read("plain.exr")), [""; 0]);
    write(
        desk.path(),
        &["render", "mirror-room", "-o", "a.exr", "--frames", "2", "--aov", "material,normal"],
    );
    let image = read("a.exr");
    assert_eq!(layers(&image), ["material.V", "normal.X", "normal.Y", "normal.Z"]);
    assert_eq!(image.attributes["aov"], "normal,material");
    let names: Vec<String> = serde_json::from_str(&image.attributes["materials"]).unwrap();
    let material = &image.channels["material.V"];
    // In the mirror are things, not the mirror.
    let mirror = names.iter().position(|name| name == "mirror").unwrap() as f32;
    assert!(material.iter().all(|&index| index != mirror && index < names.len() as f32), "{material:?}");
    for color in ["R", "G", "B"] {
        assert_eq!(image.channels[color], read("plain.exr").channels[color]);
    }
    write(
        desk.path(),
        &["reference", "mirror-room", "-o", "r.exr", "--spp", "2", "--aov", "depth,albedo,position"],
    );
    let expected = ["albedo.B", "albedo.G", "albedo.R", "depth.Z", "position.X", "position.Y", "position.Z"];
    assert_eq!(layers(&read("r.exr")), expected);

    let (code, stderr) = run(desk.path(), &["render", "mirror-room", "-o", "b.exr", "--aov", "beauty"]);
    assert!(code == 2 && stderr.contains("motion"), "{stderr}");
}

/// A camera that moves: a frame that is rendered again alone has the bytes that it had after the frames before it.
#[test]
fn motion_is_from_the_frame_before_whether_it_is_rendered_or_not() {
    let desk = tempfile::tempdir().unwrap();
    let animate = ["animate", "animated-camera", "-o", "f/#.exr", "--frames", "0..4", "--emission", "aimed"];
    let animate = [&animate[..], &["--history", "none", "--path-history", "none"]].concat();
    let asked = [&animate[..], &["--aov", "motion"]].concat();
    write(desk.path(), &asked);
    let frame = |index: u32| desk.path().join(format!("f/{index}.exr"));
    let longest = |index| {
        let image = Channels::read(&frame(index)).unwrap();
        image.channels["motion.X"].iter().fold(0.0f32, |largest, x| largest.max(x.abs()))
    };
    assert!(
        longest(0) == 0.0 && (1..4).all(|index| longest(index) > 0.05),
        "{:?}",
        [0, 1, 2, 3].map(longest)
    );
    let before = std::fs::read(frame(3)).unwrap();
    for index in [1, 3] {
        std::fs::remove_file(frame(index)).unwrap();
    }
    write(desk.path(), &asked);
    assert!(std::fs::read(frame(3)).unwrap() == before);

    let (code, stderr) = run(desk.path(), &animate);
    assert!(code == 2 && stderr.contains("its aov is"), "{stderr}");
}
