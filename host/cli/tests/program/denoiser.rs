//! Typical use of `--denoiser`.

use caustics::image_file::Channels;
use serde_json::Value;

use crate::test_dir::{Run, TestDir};

fn render(dir: &TestDir, out: &str, options: &[&str]) -> Run {
    let size = ["--width", "64", "--height", "36", "--light-paths", "2000", "--runner", "cpu", "--json"];
    dir.run(&[&["render", "mirror-room", "-o", out], &size[..], options].concat())
}

/// Renders, which must succeed, and returns the report.
#[track_caller]
fn report(dir: &TestDir, out: &str, options: &[&str]) -> Value {
    render(dir, out, options).expect_success(options).json()
}

fn channel(dir: &TestDir, file: &str, name: &str) -> Vec<f32> {
    let image = exr::prelude::read_first_flat_layer_from_file(dir.path(file)).unwrap();
    let list = image.layer_data.channel_data.list;
    let found = list.iter().find(|channel| channel.name.to_string() == name).unwrap();
    found.sample_data.values_as_f32().collect()
}

#[test]
fn a_filter_has_its_own_time_and_leaves_caustics_alone() {
    let dir = TestDir::new();
    let plain = report(&dir, "plain.exr", &["--emission", "aimed"]);
    let smooth = report(&dir, "smooth.exr", &["--denoiser", "atrous", "--emission", "aimed"]);
    assert_eq!((&plain["denoiser"], &smooth["denoiser"]), (&"none".into(), &"atrous".into()));
    assert!(plain["pass_ms"]["denoise.atrous"].is_null());
    assert!(smooth["pass_ms"]["denoise.atrous"].as_f64().unwrap() > 0.0);
    let both = |name| ["plain.exr", "smooth.exr"].map(|file| channel(&dir, file, name));
    let [before, after] = both("caustics.G");
    assert!(before == after && before.iter().any(|&value| value > 0.0));
    let [before, after] = both("path.G");
    let sum = |values: &[f32]| values.iter().map(|&value| f64::from(value)).sum::<f64>();
    // The tolerance covers the roundings of 2304 pixels.
    assert!(before != after && (sum(&before) / sum(&after) - 1.0).abs() < 1.0e-5);
}

/// Settings do not depend on addresses of functions: two processes write the same ones.
#[test]
fn settings_of_a_filtered_run_are_the_same_in_every_process() {
    let dir = TestDir::new();
    let attributes = ["a.exr", "b.exr"].map(|file| {
        report(&dir, file, &["--denoiser", "atrous"]);
        let mut attributes = Channels::read(&dir.path(file)).unwrap().attributes;
        // The checksum depends on the seconds too.
        for name in ["seconds", "crc32"] {
            attributes.remove(name);
        }
        attributes
    });
    assert_eq!(attributes[0]["denoiser"], "atrous");
    assert_eq!(attributes[0], attributes[1]);
}

#[test]
fn methods_without_points_have_no_filter() {
    let dir = TestDir::new();
    let options = ["--denoiser", "atrous", "--method", "path"];
    let words = ["--denoiser atrous", "--method basic"];
    render(&dir, "out.exr", &options).expect_refusal(&options, 2, &words);
}

#[test]
fn a_missing_library_ends_the_run_before_a_file_and_says_how_to_install_it() {
    let dir = TestDir::new();
    let options = ["render", "mirror-room", "-o", "out.exr", "--denoiser", "oidn"];
    let output = dir.command(&options).env("CAUSTICS_OIDN", "/no/such/library.so").output().unwrap();
    let words = ["/no/such/library.so", "pip install pyoidn", "CAUSTICS_OIDN"];
    Run::from_output(output).expect_refusal(&options, 1, &words);
    assert!(!dir.path("out.exr").exists());
}

#[test]
fn other_commands_shards_and_methods_without_points_refuse_oidn() {
    let dir = TestDir::new();
    let oidn = ["--denoiser", "oidn"];
    for (command, output) in [("animate", "a####.exr"), ("bench", "b"), ("reference", "r.exr")] {
        dir.refuses(&[&[command, "mirror-room", "-o", output][..], &oidn].concat(), 2, &["--denoiser"]);
    }
    dir.refuses(&[&["inspect", "mirror-room", "--pixel", "1,1"][..], &oidn].concat(), 2, &["none, atrous"]);
    dir.refuses(&[&["view", "mirror-room"][..], &oidn].concat(), 2, &["none, atrous"]);
    let path = ["--denoiser", "oidn", "--method", "path"];
    render(&dir, "out.exr", &path).expect_refusal(&path, 2, &["--denoiser oidn", "--method basic"]);
    let shard = ["--denoiser", "oidn", "--shard", "1/2", "--frames", "2"];
    render(&dir, "out.exr", &shard).expect_refusal(&shard, 2, &["--denoiser oidn", "render without --shard"]);
}

#[test]
fn oidn_keeps_caustics_and_the_energy_of_the_path_layer() {
    let dir = TestDir::new();
    let options = ["--denoiser", "oidn", "--emission", "aimed", "--frames", "2"];
    let run = render(&dir, "smooth.exr", &options);
    if run.stderr.contains("pip install pyoidn") {
        return eprintln!("skipped: {}", run.stderr);
    }
    let smooth = run.expect_success(&options).json();
    let plain = report(&dir, "plain.exr", &["--emission", "aimed", "--frames", "2"]);
    assert_eq!((&smooth["denoiser"], &plain["oidn"]), (&"oidn".into(), &Value::Null));
    let both = |name| ["plain.exr", "smooth.exr"].map(|file| channel(&dir, file, name));
    let [before, after] = both("caustics.G");
    assert!(before == after && before.iter().any(|&value| value > 0.0));
    let sum = |file| -> f64 {
        let channels = ["path.R", "path.G", "path.B"].map(|name| channel(&dir, file, name));
        channels.iter().flatten().map(|&value| f64::from(value)).sum()
    };
    // The tolerance covers the roundings of 2304 pixels.
    let (before, after) = (sum("plain.exr"), sum("smooth.exr"));
    assert!(both("path.G")[0] != both("path.G")[1] && (before / after - 1.0).abs() < 1.0e-5);
    let Channels { attributes, channels, .. } = Channels::read(&dir.path("smooth.exr")).unwrap();
    assert_eq!(attributes["oidn_version"], smooth["oidn"]["version"].as_str().unwrap());
    assert_eq!(attributes["oidn_energy_ratio"], smooth["oidn"]["energy_ratio"].to_string());
    assert!(!channels.contains_key("variance.R") && !channels.contains_key("albedo.R"));
}
