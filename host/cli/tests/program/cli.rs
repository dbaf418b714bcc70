//! Typical use of the program: output, files and exit codes.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use caustics::scene::{Scene, resolve};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::trace::Tracer;
use serde_json::{Value, json};

use crate::test_dir::{BINARY, Run, TestDir};

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--light-paths", "2000"];

/// Renders on the CPU into `out`, which must succeed.
#[track_caller]
fn render(dir: &TestDir, scene: &str, out: &str, options: &[&str]) -> Run {
    dir.succeeds(&[&["render", scene, "-o", out, "--runner", "cpu"], options].concat())
}

/// Size and channels of an EXR file.
struct ExrImage {
    size: (usize, usize),
    channels: BTreeMap<String, Vec<f32>>,
}

impl ExrImage {
    fn read(path: &Path) -> ExrImage {
        let image = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
        let layer = image.layer_data;
        let values = layer.channel_data.list.iter().map(|channel| {
            (channel.name.to_string(), channel.sample_data.values_as_f32().collect::<Vec<_>>())
        });
        ExrImage { size: (layer.size.0, layer.size.1), channels: values.collect() }
    }

    fn sum(&self, name: &str) -> f64 {
        self.channels[name].iter().map(|&value| f64::from(value)).sum()
    }
}

#[test]
fn help_and_version_are_printed() {
    let dir = TestDir::new();
    assert!(dir.succeeds(&["--version"]).stdout.contains(env!("CARGO_PKG_VERSION")));
    for arguments in [&["--help"][..], &["render", "--help"]] {
        assert!(dir.succeeds(arguments).stdout.starts_with("Examples:"), "{arguments:?}");
    }
}

#[test]
fn scenes_are_listed_described_and_made() {
    let dir = TestDir::new();
    let list = dir.succeeds(&["scene", "list"]).stdout;
    for name in caustics_scenes::NAMES {
        assert!(list.lines().any(|line| line.starts_with(name)), "{name} is not in {list}");
    }
    assert!(dir.succeeds(&["scene", "info", "mirror-room"]).stdout.contains("features "));

    dir.succeeds(&["scene", "make", "ring", "-o", "made"]);
    let info = dir.succeeds(&["scene", "info", "made/ring", "--json"]).json();
    assert_eq!(info["name"], "ring");
    assert_eq!(info["cameras"][0], "main");
    assert!(info["triangles"].as_u64().unwrap() > 1000);
    assert!(info["features"].as_array().unwrap().contains(&"mirror".into()));
    assert!(!info["features"].as_array().unwrap().contains(&"glass".into()));
}

/// Makes a scene on demand and renders it by its name. Returns the JSON of `scene info`.
fn made_on_demand(name: &str) -> Value {
    let dir = TestDir::new();
    assert!(
        dir.succeeds(&["scene", "list"]).stdout.lines().any(|line| line.starts_with(&format!("{name} ")))
    );
    // Without -o, the scene is written where its name is searched for.
    let file = format!("scenes/generated/{name}/scene.gltf");
    let made = dir.succeeds(&["scene", "make", name]).stdout;
    assert_eq!(Path::new(made.trim()), Path::new(&file));
    let info = dir.succeeds(&["scene", "info", name, "--json"]).json();
    assert_eq!((&info["name"], &info["file"]), (&json!(name), &json!(file)));
    assert_eq!((&info["dropped_triangles"], &info["warnings"]), (&json!(0), &json!([])));

    let report = render(&dir, name, "made.exr", &[&TINY[..], &["--json"]].concat()).json();
    let counters = &report["counters"];
    assert!(counters["photons"].as_u64().unwrap() > 100, "{counters}");
    for fault in ["media_overflow", "non_finite", "clamped", "photons_dropped"] {
        assert_eq!(counters[fault], 0, "{fault}");
    }
    info
}

#[test]
fn a_small_scene_is_made_on_demand_and_found_by_its_name() {
    assert!(made_on_demand("cornell-1k")["triangles"].as_u64().unwrap() > 500);
}

mod long {
    use super::*;

    #[test]
    #[ignore = "makes a scene of half a million triangles"]
    fn the_bar_is_made_on_demand_and_found_by_its_name() {
        let info = made_on_demand("bar");
        assert!(info["triangles"].as_u64().unwrap() >= 500_000, "{}", info["triangles"]);
        assert_eq!(info["cameras"], json!(["main", "counter"]));
        // The scene has eleven lamps of six triangles each.
        assert_eq!(info["lights"], 66);
        let features = info["features"].as_array().unwrap();
        for need in ["casters", "receivers", "area-lights", "mirror", "glass", "absorption", "coat"] {
            assert!(features.contains(&need.into()), "{need} is not in {features:?}");
        }
        // The eye and the lamps are outside of glass, so no kernel has to search for initial media.
        assert!(!features.contains(&"starts-in-medium".into()), "{features:?}");
    }
}

#[test]
fn devices_are_listed_or_missed_with_exit_code_4() {
    let dir = TestDir::new();
    let run = dir.run(&["device", "--json"]);
    if run.code == Some(0) {
        let devices = run.json();
        let devices = devices.as_array().unwrap();
        assert!(!devices.is_empty());
        assert!(devices.iter().all(|device| device["name"].is_string() && device["usable"].is_boolean()));
        assert!(dir.succeeds(&["device"]).stdout.contains("ray queries:"));
    } else {
        assert_eq!(run.code, Some(4));
    }

    // Replace the driver by one that does not exist.
    for arguments in [
        &["device"][..],
        &["render", "ring", "-o", "out.exr", "--runner", "gpu"],
        &["view", "ring", "--port", "0", "--runner", "gpu"],
    ] {
        let mut command = dir.command(arguments);
        command.env("VK_DRIVER_FILES", "/missing.json").env("VK_ICD_FILENAMES", "/missing.json");
        let run = Run::from_output(command.output().unwrap());
        run.expect_refusal(arguments, 4, &["--runner cpu"]);
        assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    }
    assert_eq!(dir.folder().read_dir().unwrap().count(), 0);
}

#[test]
fn a_folder_without_kernels_is_refused_before_a_device_is_looked_for() {
    let dir = TestDir::new();
    let render = |runner: &str| {
        let arguments = [&["render", "ring", "-o", "out.exr"], &TINY[..], &["--runner", runner]].concat();
        let output = dir.command(&arguments).env("CAUSTICS_KERNELS", "none").output().unwrap();
        Run::from_output(output)
    };
    let Run { code, stderr, .. } = render("gpu");
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.contains("kernels.lock is missing") && stderr.contains("--runner cpu"), "{stderr}");
    assert_eq!(dir.folder().read_dir().unwrap().count(), 0);
    assert_eq!(render("cpu").code, Some(0));
}

#[test]
fn a_render_reports_times_counters_needs_and_device() {
    let dir = TestDir::new();
    let report = render(&dir, "mirror-room", "out.exr", &[&TINY[..], &["--json"]].concat()).json();
    for pass in
        ["collect", "shoot.guided", "index.photons_grid.fill", "gather.photons_grid", "resolve", "display"]
    {
        assert!(report["pass_ms"][pass].as_f64().unwrap() >= 0.0, "{pass}");
    }
    assert_eq!(report["counters"]["light_paths"], 2000);
    // 2000 paths balance to about 1 / sqrt(2000).
    let energy = |key: &str| report["energy"][key].as_f64().unwrap();
    let spent = energy("absorbed") + energy("escaped") + energy("cut") + energy("shading_normals");
    let spent = spent + energy("left_to_camera");
    assert!(energy("emitted") > 0.0 && energy("absorbed") > 0.0 && energy("cut") > 0.0);
    assert!((spent / energy("emitted") - 1.0).abs() < 0.1 && energy("residual").abs() < 0.1);
    for counter in ["camera_rays", "shadow_rays", "light_rays", "photons"] {
        assert!(report["counters"][counter].as_u64().unwrap() > 0, "{counter}");
    }
    assert!(report["rates"]["light_paths_per_s"].as_f64().unwrap() > 0.0);
    assert!(report["features"].as_array().unwrap().contains(&"glass".into()));
    assert!(report["device"].as_str().unwrap().starts_with("CPU"));
    assert_eq!((&report["width"], &report["height"], &report["frames"]), (&32.into(), &18.into(), &1.into()));
}

#[test]
fn images_have_their_size_and_layers_and_beauty_is_their_sum() {
    let dir = TestDir::new();
    let options = ["--png", "out.png", "--width", "48", "--height", "27", "--light-paths", "200000"];
    render(&dir, "mirror-room", "out.exr", &options);
    let image = ExrImage::read(&dir.path("out.exr"));
    assert_eq!(image.size, (48, 27));
    let names: Vec<_> = image.channels.keys().map(String::as_str).collect();
    let expected = [
        ["B", "G", "R", "caustics.B"],
        ["caustics.G", "caustics.R", "path.B", "path.G"],
        ["path.R", "photons.count", "points.depth", "points.radius"],
    ];
    assert_eq!(names, expected.concat());
    for channel in ["R", "G", "B"] {
        let (path, caustics) =
            (&image.channels[&format!("path.{channel}")], &image.channels[&format!("caustics.{channel}")]);
        let sum: Vec<f32> = path.iter().zip(caustics).map(|(path, caustic)| path + caustic).collect();
        assert_eq!(image.channels[channel], sum);
        assert!(path.iter().chain(caustics).all(|value| value.is_finite() && *value >= 0.0));
        assert!(image.sum(&format!("path.{channel}")) > 0.0);
        assert!(image.sum(&format!("caustics.{channel}")) > 0.0);
    }
    // Exactly the points with a depth have a radius, and only those have photons.
    for ((radius, depth), photons) in image.channels["points.radius"]
        .iter()
        .zip(&image.channels["points.depth"])
        .zip(&image.channels["photons.count"])
    {
        assert_eq!(*radius > 0.0, *depth > 0.0);
        assert!(*photons == 0.0 || *depth > 0.0);
    }

    let png = image::open(dir.path("out.png")).unwrap().into_rgb8();
    assert_eq!(png.dimensions(), (48, 27));
    assert!(png.pixels().any(|pixel| pixel.0.iter().any(|&value| value > 32)));
}

#[test]
fn more_frames_have_less_noise() {
    let dir = TestDir::new();
    let noise = |frames: &str| {
        let [a, b] = ["1", "2"].map(|seed| {
            let options = ["--frames", frames, "--seed", seed, "--pixel-filter", "centre", "--force"];
            let options = [&TINY[..], &options].concat();
            render(&dir, "mirror-room", "out.exr", &options);
            ExrImage::read(&dir.path("out.exr"))
        });
        // Use the path layer: caustics of so few paths are a handful of bright pixels.
        let pairs = a.channels["path.G"].iter().zip(&b.channels["path.G"]);
        let mut squares: Vec<f64> = pairs.map(|(a, b)| f64::from(a - b).powi(2)).collect();
        // Leave out the brightest hundredth, which may be one rare path of one run.
        squares.sort_unstable_by(f64::total_cmp);
        squares[..squares.len() * 99 / 100].iter().sum::<f64>()
    };
    let ratio = noise("64") / noise("1");
    // The expected ratio is at most 1/64.
    assert!(ratio < 1.0 / 16.0, "{ratio}");
}

#[test]
fn code_that_a_scene_does_not_need_changes_no_bit() {
    let dir = TestDir::new();
    for scene in ["mirror-room", "ring"] {
        let options = [&TINY[..], &["--force"]].concat();
        render(&dir, scene, "scene.exr", &options);
        render(&dir, scene, "all.exr", &[&options[..], &["--features", "all"]].concat());
        let [a, b] = ["scene.exr", "all.exr"].map(|file| ExrImage::read(&dir.path(file)));
        assert!(a.channels == b.channels, "{scene}");
    }
}

/// Passes are compiled twice for the CPU. The image does not depend on the version, nor on the BVH that its rays use.
#[test]
fn every_cpu_makes_the_same_bits() {
    let dir = TestDir::new();
    let runs = [
        ("mirror-room", &["--frames", "3"][..]),
        ("glossy-room", &["--method", "yang2021", "--light-sampler", "power"]),
        ("animated-light", &["--method", "path", "--sampler", "independent", "--features", "all"]),
    ];
    for (scene, options) in runs {
        let [any, best] = ["0", "1"].map(|avx2| {
            let out = format!("{avx2}.exr");
            let render = ["render", scene, "-o", &out, "--runner", "cpu", "--force"];
            let arguments = [&render[..], &TINY, options].concat();
            let output = dir.command(&arguments).env("CAUSTICS_AVX2", avx2).output().unwrap();
            Run::from_output(output).expect_success(&arguments);
            ExrImage::read(&dir.path(&out))
        });
        assert!(any.sum("G") > 0.0 && any.channels == best.channels, "{scene} {options:?}");
    }
}

#[test]
fn a_scene_without_casters_shoots_nothing() {
    let dir = TestDir::new();
    for features in ["scene", "all"] {
        let options = [&TINY[..], &["--force", "--json", "--features", features]].concat();
        let report = render(&dir, "plain-room", "out.exr", &options).json();
        assert_eq!(report["counters"]["light_rays"], 0);
        let image = ExrImage::read(&dir.path("out.exr"));
        for name in ["caustics.R", "caustics.G", "caustics.B", "photons.count"] {
            assert!(image.channels[name].iter().all(|&value| value == 0.0), "{name} --features {features}");
        }
    }
}

/// Whether the camera's ray through each pixel's centre first hits the wall mirror.
fn mirror_region(width: usize, height: usize) -> Vec<bool> {
    let scene = Scene::load(&resolve("mirror-room").unwrap()).unwrap();
    let camera = scene.cameras[0].camera(width as u32, height as u32);
    let mirror = scene.material_names.iter().position(|name| name == "mirror").unwrap() as u32;
    let mut tracer = scene.tracer(Features(0));
    let mut is_mirror = |pixel: usize| {
        let x = ((pixel % width) as f32 + 0.5) / width as f32 * 2.0 - 1.0;
        let y = 1.0 - ((pixel / width) as f32 + 0.5) / height as f32 * 2.0;
        let direction = (camera.forward + x * camera.right + y * camera.up).normalize();
        let hit = tracer.closest(&Ray::endless(camera.position, direction));
        !hit.is_miss() && scene.surfaces[hit.triangle as usize].material == mirror
    };
    (0..width * height).map(&mut is_mirror).collect()
}

#[test]
fn caustics_of_the_mirror_room_are_seen_in_the_mirror() {
    let dir = TestDir::new();
    let (width, height) = (480, 270);
    render(&dir, "mirror-room", "out.exr", &["--width", "480", "--height", "270", "--preset", "frame"]);
    let image = ExrImage::read(&dir.path("out.exr"));
    let region = mirror_region(width, height);
    let (mut inside, mut all) = (0.0, 0.0);
    for (pixel, &mirror) in region.iter().enumerate() {
        let energy: f64 = ["R", "G", "B"]
            .map(|channel| f64::from(image.channels[&format!("caustics.{channel}")][pixel]))
            .iter()
            .sum();
        all += energy;
        inside += if mirror { energy } else { 0.0 };
    }
    let area = region.iter().filter(|mirror| **mirror).count() as f64 / (width * height) as f64;
    println!("{:.2} % of the caustics' energy on {:.1} % of the image", 100.0 * inside / all, 100.0 * area);
    assert!(all > 0.0 && inside > 0.95 * all, "{inside} of {all}");
    assert!((0.05..0.8).contains(&area), "{area}");

    // Points seen in the mirror come after a mirror vertex; those beside it are primary hits.
    let depth = &image.channels["points.depth"];
    assert!(region.iter().zip(depth).all(|(&mirror, &depth)| depth == 0.0 || mirror == (depth >= 2.0)));
}

#[test]
fn a_gpu_renders_under_validation() {
    let dir = TestDir::new();
    let options = ["render", "mirror-room", "-o", "out.exr", "--runner", "gpu", "--debug", "validation"];
    let Run { code, stderr, .. } = dir.run(&[&options[..], &TINY].concat());
    let absent = code == Some(4) || stderr.contains("VK_LAYER_KHRONOS_validation, which is not");
    if absent && std::env::var_os("CAUSTICS_REQUIRE_GPU").is_none_or(|value| value != "1") {
        println!("skipped: {stderr}");
        return;
    }
    assert_eq!(code, Some(0), "{stderr}");
    let image = ExrImage::read(&dir.path("out.exr"));
    assert!(image.sum("path.G") > 0.0 && image.sum("photons.count") > 0.0);
}

#[cfg(unix)]
#[test]
fn ctrl_c_saves_the_finished_frames() {
    let dir = TestDir::new();
    let mut child = std::process::Command::new(BINARY)
        .current_dir(dir.folder())
        .args(["render", "mirror-room", "-o", "out.exr", "--runner", "cpu", "--frames", "10000000", "--json"])
        .args(TINY)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The line that names the gather comes when the session is ready.
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    lines.find(|line| line.as_ref().unwrap().contains("gather photons-grid")).unwrap().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    let kill = format!("kill -INT {}", child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let mut report = String::new();
    child.stdout.take().unwrap().read_to_string(&mut report).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));

    let report: Value = serde_json::from_str(&report).unwrap();
    assert!((1..10_000_000).contains(&report["frames"].as_u64().unwrap()));
    let image = ExrImage::read(&dir.path("out.exr"));
    assert_eq!(image.size, (32, 18));
    // The folder has the image, and the checkpoint for --resume.
    assert_eq!(dir.folder().read_dir().unwrap().count(), 2);
    assert!(dir.path("out.exr.checkpoint").exists());
}

#[test]
fn renamed_options_and_variables_are_refused_with_their_new_names() {
    let dir = TestDir::new();
    for (arguments, variable, expected) in [
        (
            &["render", "ring", "--connections", "power"][..],
            None,
            "--connections is called --light-sampler now",
        ),
        (
            &["scene", "list"],
            Some("CAUSTICS_TREES_MIB"),
            "CAUSTICS_TREES_MIB is called CAUSTICS_BVH_CACHE_MIB now",
        ),
    ] {
        let mut command = dir.command(arguments);
        command.envs(variable.map(|name| (name, "64")));
        Run::from_output(command.output().unwrap()).expect_refusal(arguments, 2, &[expected]);
    }
}
