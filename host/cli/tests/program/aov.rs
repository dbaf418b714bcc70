//! `--aov`: additional layers in a file.

use caustics::image_file::Channels;

use crate::test_dir::TestDir;

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--runner", "cpu"];

/// Appends the size and the runner to arguments.
fn tiny<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    [arguments, &TINY].concat()
}

/// Layers of a file that are written only on request.
fn layers(image: &Channels) -> Vec<&str> {
    let names = image.channels.keys().map(String::as_str);
    names
        .filter(|name| {
            ["nor", "alb", "dep", "pos", "mot", "mat", "cel"].contains(&&name[..3.min(name.len())])
        })
        .collect()
}

#[test]
fn only_requested_layers_are_written() {
    let dir = TestDir::new();
    let read = |name: &str| Channels::read(&dir.path(name)).unwrap();
    dir.succeeds(&tiny(&["render", "mirror-room", "-o", "plain.exr", "--frames", "2"]));
    assert_eq!(layers(&read("plain.exr")), [""; 0]);
    let options = ["-o", "a.exr", "--frames", "2", "--aov", "material,normal"];
    dir.succeeds(&tiny(&[&["render", "mirror-room"], &options[..]].concat()));
    let image = read("a.exr");
    assert_eq!(layers(&image), ["material.V", "normal.X", "normal.Y", "normal.Z"]);
    assert_eq!(image.attributes["aov"], "normal,material");
    let names: Vec<String> = serde_json::from_str(&image.attributes["materials"]).unwrap();
    let material = &image.channels["material.V"];
    // The mirror's pixels describe the objects visible in it.
    let mirror = names.iter().position(|name| name == "mirror").unwrap() as f32;
    assert!(material.iter().all(|&index| index != mirror && index < names.len() as f32), "{material:?}");
    for color in ["R", "G", "B"] {
        assert_eq!(image.channels[color], read("plain.exr").channels[color]);
    }
    let reference = ["reference", "mirror-room", "-o", "r.exr", "--spp", "2"];
    dir.succeeds(&tiny(&[&reference[..], &["--aov", "depth,albedo,position"]].concat()));
    let expected = ["albedo.B", "albedo.G", "albedo.R", "depth.Z", "position.X", "position.Y", "position.Z"];
    assert_eq!(layers(&read("r.exr")), expected);

    dir.refuses(&tiny(&["render", "mirror-room", "-o", "b.exr", "--aov", "beauty"]), 2, &["motion"]);
}

/// The camera moves. A frame that is rendered again alone has the same bytes as after the frames before it.
#[test]
fn motion_is_from_the_frame_before_whether_it_is_rendered_or_not() {
    let dir = TestDir::new();
    let animate = ["animate", "animated-camera", "-o", "f/#.exr", "--frames", "0..4", "--emission", "aimed"];
    let animate = [&animate[..], &["--history", "none", "--path-history", "none"]].concat();
    let asked = tiny(&[&animate[..], &["--aov", "motion"]].concat());
    dir.succeeds(&asked);
    let frame = |index: u32| dir.path(&format!("f/{index}.exr"));
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
    dir.succeeds(&asked);
    assert!(std::fs::read(frame(3)).unwrap() == before);

    dir.refuses(&tiny(&animate), 2, &["its aov is"]);
}
