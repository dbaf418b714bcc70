//! Files without a camera or a light are rendered too. Messages name all additions as options, which repeat the image.

use std::path::Path;

use caustics::image_file::Channels;
use serde_json::{Value, json};

use crate::test_dir::{Run, TestDir};

const TINY: [&str; 10] =
    ["--width", "32", "--height", "18", "--light-paths", "2000", "--runner", "cpu", "--frames", "2"];

/// Copies `ring` to a folder and changes it. Without `emissiveFactor`, its emissive strength has no effect.
fn changed(change: impl Fn(&mut Value)) -> TestDir {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/ring");
    let dir = TestDir::new();
    let mut json: Value = serde_json::from_slice(&std::fs::read(source.join("scene.gltf")).unwrap()).unwrap();
    change(&mut json);
    dir.write("scene.gltf", serde_json::to_vec(&json).unwrap());
    std::fs::copy(source.join("scene.bin"), dir.path("scene.bin")).unwrap();
    dir
}

fn without_camera(json: &mut Value) {
    for node in json["nodes"].as_array_mut().unwrap() {
        node.as_object_mut().unwrap().remove("camera");
    }
}

fn without_light(json: &mut Value) {
    for material in json["materials"].as_array_mut().unwrap() {
        material.as_object_mut().unwrap().remove("emissiveFactor");
    }
}

/// Renders to `out`, which must succeed. Returns the image and stderr.
#[track_caller]
fn render(dir: &TestDir, out: &str, options: &[&str]) -> (Channels, String) {
    let run = dir.succeeds(&[&["render", "scene.gltf", "-o", out], &TINY[..], options].concat());
    (Channels::read(&dir.path(out)).unwrap(), run.stderr)
}

#[test]
fn a_file_without_camera_and_light_is_rendered_with_additions() {
    let dir = changed(|json| {
        without_camera(json);
        without_light(json);
    });
    let (image, stderr) = render(&dir, "a.exr", &[]);
    assert!(
        stderr.contains("no light in scene.gltf: lit by") && stderr.contains("--no-default-light"),
        "{stderr}"
    );
    let camera = image.attributes["camera"].clone();
    assert!(stderr.contains(&format!("no camera in scene.gltf: seen by {camera}")), "{stderr}");
    assert!(image.attributes["light"].contains("spot"), "{:?}", image.attributes);
    let beauty = image.layer("").unwrap();
    let lit = beauty[1].iter().filter(|value| value.is_finite() && **value > 0.0).count();
    assert_eq!(lit, 32 * 18, "nothing is black");
    assert!(image.layer("caustics").unwrap()[1].iter().any(|value| *value > 0.0), "a ring casts caustics");

    // The options in the message give the same bits.
    let pasted: Vec<&str> = camera.split(' ').collect();
    let (again, _) = render(&dir, "b.exr", &pasted);
    assert_eq!(again.layer(""), image.layer(""));
    assert_eq!(again.attributes["camera"], camera);

    let Run { code, stderr, .. } = dir.run(&["render", "scene.gltf", "-o", "c.exr", "--no-default-light"]);
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.starts_with("error: scene.gltf: no light"), "{stderr}");
    assert!(!dir.path("c.exr").exists());
}

#[test]
fn a_file_that_has_both_keeps_them() {
    let dir = changed(|_| {});
    let (image, stderr) = render(&dir, "a.exr", &["--no-default-light"]);
    assert!(!stderr.contains("no camera") && !stderr.contains("no light"), "{stderr}");
    assert!(!image.attributes.contains_key("light") && !image.attributes.contains_key("origin"));
    assert!(!image.attributes["camera"].contains("--from"));

    // Options replace the camera; the light stays.
    let (other, stderr) = render(&dir, "b.exr", &["--from", "-1,2,1", "--fov", "60"]);
    assert!(other.attributes["camera"].starts_with("--from -1,2,1 --look-at "), "{stderr}");
    assert_ne!(other.layer(""), image.layer(""));
    let (orbit, _) = render(&dir, "c.exr", &["--camera", "orbit:-90,30"]);
    assert!(orbit.attributes["camera"].starts_with("--from -"), "{:?}", orbit.attributes["camera"]);
}

#[test]
fn lights_are_added_to_glowing_objects() {
    let dir = changed(without_camera);
    let sum = |image: &Channels| image.layer("").unwrap()[1].iter().sum::<f32>();
    let (own, _) = render(&dir, "a.exr", &["--no-default-light"]);
    assert!(!own.attributes.contains_key("light"));
    for (file, options, note) in [
        ("b.exr", &[][..], "no light but what its materials emit: lit by a spot"),
        ("c.exr", &["--default-light"], "beside its own light: a spot"),
    ] {
        let (both, stderr) = render(&dir, file, options);
        assert!(stderr.contains(note), "{stderr}");
        assert!(both.attributes.contains_key("light") && sum(&both) > sum(&own));
    }
    let both = ["--default-light", "--no-default-light"];
    dir.refuses(&[&["render", "scene.gltf", "-o", "d.exr"], &both[..]].concat(), 2, &[]);
}

/// A file lit only by glowing surfaces is a scene if the user places the camera, else an object to light.
#[test]
fn no_light_is_added_to_glowing_objects_where_a_camera_is_placed() {
    let dir = changed(without_camera);
    let (own, _) = render(&dir, "a.exr", &["--no-default-light", "--from", "-1,2,1"]);
    let (placed, stderr) = render(&dir, "b.exr", &["--from", "-1,2,1"]);
    assert!(!stderr.contains("lit by") && !placed.attributes.contains_key("light"), "{stderr}");
    assert_eq!(placed.layer(""), own.layer(""));
    let edits = "[camera]\nfrom = [-1.0, 2.0, 1.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 40.0\n";
    dir.write("edits.toml", edits);
    let (edited, stderr) = render(&dir, "c.exr", &["--edits", "edits.toml"]);
    assert!(!stderr.contains("lit by") && !edited.attributes.contains_key("light"), "{stderr}");

    // With an orbit, a field of view, a look-at point or no option, the file is an object that gets a light. Its camera and
    // light can be given again as options.
    for (file, options) in [
        ("d.exr", &["--camera", "orbit:20,30"][..]),
        ("e.exr", &["--fov", "50"]),
        ("f.exr", &["--look-at", "0,0,0"]),
        ("g.exr", &[]),
    ] {
        let (thing, stderr) = render(&dir, file, options);
        assert!(
            stderr.contains("lit by") && stderr.contains("--default-light keeps"),
            "{options:?}: {stderr}"
        );
        let mut again: Vec<&str> = thing.attributes["camera"].split(' ').collect();
        again.push("--default-light");
        let (again, _) = render(&dir, &format!("again-{file}"), &again);
        assert_eq!(again.layer(""), thing.layer(""), "{options:?}");
    }

    // A file without light gets one wherever the camera is.
    let dark = changed(|json| {
        without_camera(json);
        without_light(json);
    });
    let (lit, _) = render(&dark, "a.exr", &["--from", "-1,2,1"]);
    assert!(lit.attributes.contains_key("light"));
}

#[test]
fn invalid_camera_options_are_refused_by_name() {
    let dir = changed(|_| {});
    for (options, word) in [
        (&["--from", "1,2"][..], "--from"),
        (&["--look-at", "a,b,c"], "--look-at"),
        (&["--fov", "180"], "--fov 180"),
        (&["--camera", "orbit:1"], "azimuth"),
        (&["--camera", "orbit:1,2", "--from", "1,2,3"], "orbit"),
        (&["--camera", "main", "--fov", "30"], "leave one out"),
        (&["--from", "1,2,3", "--look-at", "1,2,3"], "looks at where it is"),
        (&["--camera", "nobody"], "nobody"),
    ] {
        dir.refuses(&[&["render", "scene.gltf", "-o", "a.exr"], options].concat(), 2, &[word]);
    }
}

#[test]
fn a_floor_receives_the_caustics_of_a_lone_object() {
    // Keep the ring alone, without its floor.
    let alone = |json: &mut Value| {
        without_camera(json);
        without_light(json);
        let ring = json["nodes"].as_array().unwrap().iter().position(|node| node["name"] == "ring").unwrap();
        json["scenes"][0]["nodes"] = json!([ring]);
    };
    let dir = changed(alone);
    let caustics = |image: &Channels| image.layer("caustics").unwrap()[1].iter().sum::<f32>();
    let (void, _) = render(&dir, "a.exr", &[]);
    let (standing, _) = render(&dir, "b.exr", &["--floor"]);
    assert_eq!(caustics(&void), 0.0, "nothing to fall on");
    assert!(caustics(&standing) > 0.0);
    assert!(standing.attributes["floor"].contains("Lambertian"));
    assert_eq!(void.attributes["camera"], standing.attributes["camera"], "the floor is not looked at");
}

#[test]
fn other_commands_take_such_files_too() {
    let dir = changed(|json| {
        without_camera(json);
        without_light(json);
    });
    dir.succeeds(&["scene", "info", "scene.gltf"]);
    let small = ["--width", "16", "--height", "9", "--runner", "cpu"];
    let orbit = ["--camera", "orbit:10,20"];
    let reference = [&["reference", "scene.gltf", "-o", "r.exr", "--spp", "2"], &small[..], &orbit].concat();
    let bench = [
        &["bench", "scene.gltf", "--frames", "1", "--warm-up", "0", "--light-paths", "500", "-o", "bench"],
        &small[..],
        &orbit,
    ]
    .concat();
    let animate = [
        &["animate", "scene.gltf", "-o", "f-#.exr", "--frames", "0..1", "--light-paths", "500"],
        &small[..],
        &orbit,
    ]
    .concat();
    for arguments in [&reference, &bench, &animate] {
        let stderr = dir.succeeds(arguments).stderr;
        assert!(stderr.contains("camera: --from ") && stderr.contains("lit by"), "{stderr}");
    }
    // Another camera gives another run.
    let other: Vec<&str> =
        animate.iter().map(|word| if *word == "orbit:10,20" { "orbit:10,21" } else { word }).collect();
    dir.refuses(&other, 2, &["its camera is"]);

    let sweep = "[time]\nwidth = 16\nheight = 9\nframes = 1\nwarm_up = 0\n\n[[matrix]]\nscene = [\"scene.gltf\"]\n\
                 method = [\"basic\"]\nlight_paths = [500]\nrunner = [\"cpu\"]\nfrom = [0.0, 2.0, 2]\nfov = 50\n";
    dir.write("sweep.toml", sweep);
    let stderr = dir.succeeds(&["sweep", "sweep.toml", "-o", "swept"]).stderr;
    assert!(stderr.contains("camera: --from 0,2,2 --look-at "), "{stderr}");
    dir.write("sweep.toml", format!("default_light = \"never\"\n{sweep}"));
    dir.refuses(&["sweep", "sweep.toml", "-o", "refused"], 1, &["no light"]);
}
