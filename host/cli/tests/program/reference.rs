//! `caustics reference`, `merge` and long renders from outside: stops, resuming to the same bits, and merging by samples.

use std::path::Path;
use std::time::{Duration, Instant};

use caustics::image_file::Channels;
use serde_json::{Value, json};

use crate::test_dir::{BINARY, Run, TestDir};

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--runner", "cpu"];

/// Renders a reference of the mirror room, which must succeed.
#[track_caller]
fn reference(dir: &TestDir, out: &str, options: &[&str]) -> Run {
    dir.succeeds(&[&["reference", "mirror-room", "-o", out], &TINY[..], options].concat())
}

fn channels(dir: &TestDir, file: &str) -> Channels {
    Channels::read(&dir.path(file)).unwrap()
}

/// Returns the sorted file names of a folder.
fn files(dir: &TestDir) -> Vec<String> {
    let entries = dir.folder().read_dir().unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Starts a run, waits for its checkpoint, and ends it by a signal. Returns its exit code.
fn end_early(dir: &TestDir, arguments: &[&str], checkpoint: &str, signal: &str) -> Option<i32> {
    let mut child = std::process::Command::new(BINARY)
        .current_dir(dir.folder())
        .args(arguments)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !dir.path(checkpoint).exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "there is no checkpoint");
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = format!("kill -{signal} {}", child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    child.wait().unwrap().code()
}

#[test]
fn a_reference_holds_mean_variance_and_number_of_samples() {
    let dir = TestDir::new();
    let report = reference(&dir, "a.exr", &["--spp", "80", "--json", "--png", "a.png"]).json();
    assert_eq!((&report["method"], &report["frames"]), (&"path".into(), &80.into()));
    assert!(report["rates"]["camera_paths_per_s"].as_f64().unwrap() > 1000.0);
    let image = channels(&dir, "a.exr");
    let names: Vec<&str> = image.channels.keys().map(String::as_str).collect();
    assert_eq!(names, ["B", "G", "R", "samples.count", "variance.B", "variance.G", "variance.R"]);
    assert!(image.channels["samples.count"].iter().all(|&samples| samples == 80.0));
    assert_eq!(files(&dir), ["a.exr", "a.png"]);

    // The variance in the file is the variance between independent runs.
    let (mut square, mut stated) = (0.0, 0.0);
    for seed in 1..=12 {
        let (left, right) = (format!("{seed}"), format!("{}", 100 + seed));
        reference(&dir, "l.exr", &["--spp", "16", "--seed", &left, "--force"]);
        reference(&dir, "r.exr", &["--spp", "16", "--seed", &right, "--force"]);
        let (left, right) = (channels(&dir, "l.exr"), channels(&dir, "r.exr"));
        for (pixel, (a, b)) in left.channels["G"].iter().zip(&right.channels["G"]).enumerate() {
            square += f64::from(a - b).powi(2);
            let variance = |run: &Channels| f64::from(run.channels["variance.G"][pixel]);
            stated += variance(&left) + variance(&right);
        }
    }
    // Both are sums over one heavy tail: bright paths are in both.
    assert!((square / stated - 1.0).abs() < 0.25, "{square} {stated}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_or_killed_reference_goes_on_to_the_same_bits() {
    let dir = TestDir::new();
    let common = [&["reference", "mirror-room"], &TINY[..], &["--spp", "1500"]].concat();
    dir.succeeds(&[&common[..], &["-o", "whole.exr"]].concat());
    let whole = channels(&dir, "whole.exr");
    for (signal, code) in [("INT", Some(130)), ("KILL", None)] {
        let part = [&common[..], &["-o", "part.exr", "--checkpoint-every", "0.05"]].concat();
        assert_eq!(end_early(&dir, &part, "part.exr.checkpoint", signal), code);
        if signal == "INT" {
            let partial = channels(&dir, "part.exr");
            assert!(partial.channels["samples.count"][0] < 1500.0, "the run ended before the signal");
        }
        // Without --resume, no checkpoint is discarded.
        dir.refuses(&part, 2, &[]);

        dir.write(".caustics-killed", "part");
        let resume = ["-o", "part.exr", "--resume", "--threads", "1"];
        dir.succeeds(&[&common[..], &resume].concat());
        // Neither a lock nor a partial file is left.
        assert_eq!(files(&dir), ["part.exr", "whole.exr"], "after {signal}");
        let resumed = channels(&dir, "part.exr");
        assert_eq!(whole.channels, resumed.channels, "after {signal}");
        assert!(!dir.path("part.exr.checkpoint").exists());
        std::fs::remove_file(dir.path("part.exr")).unwrap();
    }
}

/// Rays go anywhere in a pixel where frames are averaged, and through its centre in a single frame, unless the user
/// chooses. The file states how reliable its variance is.
#[test]
fn means_take_the_box_filter_and_state_how_reliable_their_variance_is() {
    let dir = TestDir::new();
    let rendered = |command: &str, options: &[&str]| {
        dir.succeeds(&[&[command, "ring", "-o", "a.exr", "--force"], &TINY[..], options].concat());
        channels(&dir, "a.exr").attributes
    };
    let few = ["--light-paths", "100"];
    for (command, options, filter) in [
        ("render", &["--frames", "1"][..], "centre"),
        ("render", &["--frames", "2"], "box"),
        ("render", &["--frames", "2", "--pixel-filter", "centre"], "centre"),
        ("render", &["--frames", "1", "--pixel-filter", "box"], "box"),
        ("reference", &["--spp", "2"], "box"),
        ("reference", &["--spp", "2", "--pixel-filter", "centre"], "centre"),
    ] {
        let options = if command == "render" { [options, &few[..]].concat() } else { options.to_vec() };
        let attributes = rendered(command, &options);
        assert_eq!(attributes["pixel_filter"], filter, "{command} {options:?}");
        let has_variance = !options.contains(&"1");
        assert_eq!(
            attributes.get("variance_note").is_some_and(|note| note.contains("too small")),
            has_variance
        );
    }
}

/// Checkpoints hold the state that passes from frame to frame: maps of an emission, and of a method.
#[cfg(unix)]
#[test]
fn a_render_that_learns_goes_on_to_the_same_bits() {
    let dir = TestDir::new();
    for learns in [["--emission", "guided"], ["--method", "yang2021"]] {
        let frames = ["render", "mirror-room", "--light-paths", "3000", "--frames", "100", "--force"];
        let common = [&frames[..], &learns, &TINY].concat();
        dir.succeeds(&[&common[..], &["-o", "whole.exr"]].concat());
        let part = [&common[..], &["-o", "part.exr", "--checkpoint-every", "0.05"]].concat();
        assert_eq!(end_early(&dir, &part, "part.exr.checkpoint", "KILL"), None);
        dir.succeeds(&[&part[..], &["--resume"]].concat());
        let (whole, part) = (channels(&dir, "whole.exr"), channels(&dir, "part.exr"));
        assert_eq!(whole.channels, part.channels, "{learns:?}");
    }
}

#[cfg(unix)]
#[test]
fn a_progressive_render_goes_on_to_the_same_bits() {
    let dir = TestDir::new();
    let frame = ["render", "mirror-room", "--method", "progressive", "--light-paths", "3000"];
    let frame = [&frame[..], &TINY].concat();
    let common = [&frame[..], &["--frames", "100"]].concat();
    dir.succeeds(&[&common[..], &["-o", "whole.exr"]].concat());
    let part = [&common[..], &["-o", "part.exr", "--checkpoint-every", "0.05"]].concat();
    assert_eq!(end_early(&dir, &part, "part.exr.checkpoint", "KILL"), None);
    dir.succeeds(&[&part[..], &["--resume"]].concat());
    let (whole, part) = (channels(&dir, "whole.exr"), channels(&dir, "part.exr"));
    assert_eq!(whole.channels, part.channels);
    // The radii in the mean are smaller than in the first frame.
    dir.succeeds(&[&frame[..], &["-o", "one.exr"]].concat());
    let radius = |image: &Channels| image.channels["points.radius"].iter().sum::<f32>();
    assert!(radius(&whole) < 0.8 * radius(&channels(&dir, "one.exr")));
}

#[test]
fn a_checkpoint_of_another_run_is_refused() {
    let dir = TestDir::new();
    let resume = [&["reference", "ring", "-o", "a.exr", "--resume"], &TINY[..]].concat();
    dir.refuses(&resume, 2, &["there is no a.exr.checkpoint"]);

    let endless = [&["reference", "ring", "-o", "a.exr", "--spp", "100000000"], &TINY[..]].concat();
    let killed = [&endless[..], &["--checkpoint-every", "0.01"]].concat();
    end_early(&dir, &killed, "a.exr.checkpoint", "KILL");
    dir.write("moved.toml", "nodes = [{ node = 1, scale = [2, 2, 2] }]");
    for (options, name) in [
        (&["--seed", "7"][..], "seed"),
        (&["--edits", "moved.toml"], "edits"),
        (&["--max-bounces", "3"], "max_bounces"),
        (&["--pixel-filter", "centre"], "pixel_filter"),
        (&["--texture-filter", "cone"], "texture_filter"),
    ] {
        let other = [&endless[..], options, &["--resume"]].concat();
        dir.refuses(&other, 2, &[&format!("its {name} is")]);
    }
}

#[test]
fn time_and_error_stop_a_reference() {
    let dir = TestDir::new();
    let start = Instant::now();
    reference(&dir, "time.exr", &["--seconds", "0.5"]);
    assert!(start.elapsed() >= Duration::from_millis(500));
    let samples = |file| channels(&dir, file).channels["samples.count"][0];
    assert!(samples("time.exr") > 1.0);
    let report = |target: &str, out: &str| {
        let report = reference(&dir, out, &["--target-relmse", target, "--json"]).json();
        report["estimated_relmse"].as_f64().unwrap()
    };
    assert!(report("0.05", "coarse.exr") <= 0.05 && report("0.005", "fine.exr") <= 0.005);
    assert!(samples("fine.exr") > 2.0 * samples("coarse.exr"));
    for (flag, value) in [("--spp", "1"), ("--seconds", "-1"), ("--target-relmse", "0"), ("--seconds", "nan")]
    {
        let wrong = [&["reference", "ring", "-o", "x.exr", flag, value], &TINY[..]].concat();
        dir.refuses(&wrong, 2, &[flag]);
    }
}

#[test]
fn merged_references_weigh_by_samples() {
    let dir = TestDir::new();
    reference(&dir, "a.exr", &["--spp", "10", "--seed", "1"]);
    reference(&dir, "b.exr", &["--spp", "30", "--seed", "2"]);
    dir.succeeds(&["merge", "a.exr", "b.exr", "-o", "ab.exr"]);
    let [a, b, ab] = ["a.exr", "b.exr", "ab.exr"].map(|file| channels(&dir, file));
    let close = |x: f32, y: f32| (x - y).abs() <= 1e-6 * x.abs().max(y.abs());
    for pixel in 0..32 * 18 {
        let values = |name: &str| [&a, &b, &ab].map(|image| image.channels[name][pixel]);
        let [mean_a, mean_b, mean] = values("R");
        let [variance_a, variance_b, variance] = values("variance.R");
        assert!(close(mean, 0.25 * mean_a + 0.75 * mean_b));
        assert!(close(variance, 0.0625 * variance_a + 0.5625 * variance_b));
    }
    assert_eq!(ab.channels["samples.count"][0], 40.0);
    assert_eq!((&ab.attributes["seed"][..], &ab.attributes["frames"][..]), ("1, 2", "40"));

    // Prepare the same samples twice, other views, and images that are not references.
    reference(&dir, "deep.exr", &["--spp", "10", "--seed", "3", "--max-bounces", "7"]);
    reference(&dir, "again.exr", &["--spp", "12", "--seed", "2"]);
    dir.succeeds(&[&["render", "ring", "-o", "frame.exr", "--light-paths", "100"], &TINY[..]].concat());
    for (other, what) in
        [("again.exr", "share seed 2"), ("deep.exr", "differ in"), ("frame.exr", "has no mean")]
    {
        dir.refuses(&["merge", "ab.exr", other, "-o", "x.exr"], 2, &[what]);
    }
    assert!(!dir.path("x.exr").exists());
}

/// Writes the mirror room with a changed document to this folder.
fn changed_room(folder: &Path, name: &str, change: impl FnOnce(&mut Value)) {
    let file = caustics::scene::resolve("mirror-room").unwrap();
    let mut scene: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    change(&mut scene);
    std::fs::write(folder.join(name), scene.to_string()).unwrap();
    std::fs::copy(file.with_file_name("scene.bin"), folder.join("scene.bin")).unwrap();
}

#[test]
fn another_view_of_the_same_name_is_not_merged() {
    let dir = TestDir::new();
    let mut references = Vec::new();
    for (seed, x) in [("1", 0.0), ("2", 0.25)] {
        changed_room(dir.folder(), "room.gltf", |scene| {
            let nodes = scene["nodes"].as_array_mut().unwrap();
            let camera = nodes.iter_mut().find(|node| node["camera"].is_number()).unwrap();
            // EXR cannot hold this name; the run must not fail because of it.
            camera["name"] = "カメラ".into();
            let translation_x = if camera["matrix"].is_array() {
                &mut camera["matrix"][12]
            } else {
                &mut camera["translation"][0]
            };
            *translation_x = (translation_x.as_f64().unwrap() + x).into();
        });
        let out = format!("{seed}.exr");
        let room = ["reference", "room.gltf", "-o", &out, "--spp", "2", "--seed", seed];
        dir.succeeds(&[&room[..], &TINY].concat());
        references.push(out);
    }
    // Merging compares the scene first, which includes the camera's node.
    let merge = ["merge", &references[0], &references[1], "-o", "x.exr"];
    dir.refuses(&merge, 2, &["they are of two views"]);
    dir.refuses(&["merge", "1.exr", "2.exr", "-o", "1.exr", "--force"], 2, &["is the input"]);
}

#[test]
fn light_that_no_path_can_find_is_warned_of() {
    let dir = TestDir::new();
    let stderr = reference(&dir, "a.exr", &["--spp", "2"]).stderr;
    assert!(!stderr.contains("progressive"), "area lights only: {stderr}");
    changed_room(dir.folder(), "lit.gltf", |scene| {
        scene["extensions"]["KHR_lights_punctual"] = json!({ "lights": [{ "type": "point" }] });
        let nodes = scene["nodes"].as_array_mut().unwrap();
        nodes.push(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
        let last = nodes.len() - 1;
        scene["scenes"][0]["nodes"].as_array_mut().unwrap().push(last.into());
    });
    let lit = ["reference", "lit.gltf", "-o", "b.exr", "--spp", "2"];
    let stderr = dir.succeeds(&[&lit[..], &TINY].concat()).stderr;
    assert!(stderr.contains("--method progressive sees them"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn a_damaged_checkpoint_is_refused() {
    let dir = TestDir::new();
    let endless = [&["reference", "ring", "-o", "a.exr", "--spp", "100000000"], &TINY[..]].concat();
    end_early(&dir, &[&endless[..], &["--checkpoint-every", "0.01"]].concat(), "a.exr.checkpoint", "KILL");
    let checkpoint = dir.path("a.exr.checkpoint");
    let whole = std::fs::read(&checkpoint).unwrap();
    let goes_on = [&["reference", "ring", "-o", "a.exr", "--spp", "2", "--resume"], &TINY[..]].concat();
    let payload = whole.len() - 4 - 8 * 6 * 32 * 18;
    for (at, bit) in [(3, 0), (payload / 2, 4), (payload, 0), (payload + 4007, 6), (whole.len() - 1, 7)] {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << bit;
        std::fs::write(&checkpoint, &bytes).unwrap();
        let refused = dir.run(&goes_on);
        assert_eq!(refused.code, Some(2), "byte {at}: {}", refused.stderr);
        assert!(refused.stderr.contains("a.exr.checkpoint is damaged"), "{}", refused.stderr);
        assert!(!dir.path("a.exr").exists());
    }
    std::fs::write(&checkpoint, &whole).unwrap();
    dir.succeeds(&goes_on);
}

/// Starts a run that does not end by itself, and waits until it is ready.
#[cfg(unix)]
fn start(dir: &TestDir, arguments: &[&str]) -> (std::process::Child, impl Iterator<Item = String> + use<>) {
    use std::io::{BufRead, BufReader};
    let mut child = std::process::Command::new(BINARY)
        .current_dir(dir.folder())
        .args(arguments)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    lines.find(|line| line.contains("method path")).expect("the line that comes when all is ready");
    (child, lines)
}

#[cfg(unix)]
#[test]
fn two_runs_do_not_write_one_file() {
    let dir = TestDir::new();
    let endless = [&["reference", "ring", "-o", "a.exr", "--spp", "100000000"], &TINY[..]].concat();
    let (mut first, _lines) = start(&dir, &endless);
    let second = [&["reference", "ring", "-o", "./a.exr", "--spp", "2", "--force"], &TINY[..]].concat();
    dir.refuses(&second, 1, &["another run writes ./a.exr", ".caustics-a.exr.lock"]);
    reference(&dir, "b.exr", &["--spp", "2"]);
    // The system releases the lock of a killed run.
    first.kill().unwrap();
    first.wait().unwrap();
    dir.succeeds(&second);
    assert_eq!(files(&dir), ["a.exr", "b.exr"]);
}

#[cfg(unix)]
#[test]
fn a_checkpoint_that_cannot_be_written_does_not_end_the_run() {
    let dir = TestDir::new();
    let options = ["reference", "ring", "-o", "a.exr", "--seconds", "1", "--checkpoint-every", "0.3"];
    let (mut child, lines) = start(&dir, &[&options[..], &TINY].concat());
    // A folder has the name of the checkpoint, so that it cannot be written.
    std::fs::create_dir(dir.path("a.exr.checkpoint")).unwrap();
    let messages: Vec<String> = lines.collect();
    let warnings = messages.iter().filter(|line| line.contains("a checkpoint is not written"));
    assert_eq!(warnings.count(), 1, "{messages:?}");
    assert_eq!(child.wait().unwrap().code(), Some(0), "{messages:?}");
    assert!(channels(&dir, "a.exr").channels["samples.count"][0] > 2.0);
}

#[test]
fn texts_in_the_header_are_utf_8() {
    let dir = TestDir::new();
    let room = dir.path("büro");
    std::fs::create_dir(&room).unwrap();
    changed_room(&room, "raum.gltf", |_| {});
    let file = "büro/raum.gltf";
    dir.succeeds(&[&["reference", file, "-o", "a.exr", "--spp", "2"], &TINY[..]].concat());
    let bytes = std::fs::read(dir.path("a.exr")).unwrap();
    // The name is right in the bytes of the file, and when it is read back.
    assert!(bytes.windows(file.len()).any(|window| window == file.as_bytes()));
    assert_eq!(channels(&dir, "a.exr").attributes["scene_file"], file);
}

#[test]
fn equal_runs_are_equal_files_where_that_is_asked_for() {
    let dir = TestDir::new();
    let file = |out: &str, epoch: Option<&str>| {
        let arguments = [&["reference", "ring", "-o", out, "--spp", "2"], &TINY[..]].concat();
        let mut command = dir.command(&arguments);
        command.env_remove("SOURCE_DATE_EPOCH").envs(epoch.map(|epoch| ("SOURCE_DATE_EPOCH", epoch)));
        Run::from_output(command.output().unwrap()).expect_success(&arguments);
        std::fs::read(dir.path(out)).unwrap()
    };
    assert!(file("a.exr", Some("0")) == file("b.exr", Some("0")));
    file("c.exr", None);
    assert!(channels(&dir, "c.exr").attributes["seconds"].parse::<f64>().unwrap() > 0.0);
    assert!(!channels(&dir, "a.exr").attributes.contains_key("seconds"));
}

#[cfg(unix)]
#[test]
fn an_input_is_not_overwritten_through_a_link() {
    let dir = TestDir::new();
    reference(&dir, "a.exr", &["--spp", "2", "--seed", "1"]);
    reference(&dir, "b.exr", &["--spp", "2", "--seed", "2"]);
    std::os::unix::fs::symlink("a.exr", dir.path("link.exr")).unwrap();
    let before = std::fs::read(dir.path("a.exr")).unwrap();
    for (input, out) in [("link.exr", "a.exr"), ("a.exr", "link.exr")] {
        let merge = ["merge", input, "b.exr", "-o", out, "--force"];
        dir.refuses(&merge, 2, &[&format!("-o {out} is the input {input}")]);
    }
    assert_eq!(std::fs::read(dir.path("a.exr")).unwrap(), before);
}
