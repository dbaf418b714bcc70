//! `caustics compare` from outside: output, exit codes and refusals.

use caustics::metric::METRICS;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
};
use serde_json::Value;

use crate::test_dir::{BINARY, Run, TestDir};

/// Layers of an image to write: name, and value at each pixel.
type Layers<'a> = &'a [(&'a str, &'a dyn Fn(usize, usize) -> [f32; 3])];

/// Folder with images of one size.
struct ImageDir {
    dir: TestDir,
    size: (usize, usize),
}

impl ImageDir {
    fn new(width: usize, height: usize) -> ImageDir {
        ImageDir { dir: TestDir::new(), size: (width, height) }
    }

    /// Writes an EXR file; the beauty layer's name is empty.
    fn write(&self, name: &str, layers: Layers) -> &Self {
        let (width, height) = self.size;
        let mut channels = SmallVec::<[_; 4]>::new();
        for (layer, at) in layers {
            for (index, letter) in ["R", "G", "B"].iter().enumerate() {
                let channel =
                    if layer.is_empty() { (*letter).to_string() } else { format!("{layer}.{letter}") };
                let values =
                    (0..width * height).map(|pixel| at(pixel % width, pixel / width)[index]).collect();
                channels.push(AnyChannel::new(channel.as_str(), FlatSamples::F32(values)));
            }
        }
        let attributes = LayerAttributes::default();
        let layer = Layer::new(self.size, attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
        Image::from_layer(layer).write().to_file(self.dir.path(name)).unwrap();
        self
    }

    /// Runs `caustics compare`.
    fn compare(&self, arguments: &[&str]) -> Run {
        self.dir.run(&[&["compare"], arguments].concat())
    }

    /// Returns the report of a run, which must succeed.
    #[track_caller]
    fn report(&self, arguments: &[&str]) -> Value {
        self.compare(&[arguments, &["--json"]].concat()).expect_success(arguments).json()
    }

    /// Runs `caustics compare`, which must refuse with these words, print nothing to stdout and leave no file.
    #[track_caller]
    fn refuses(&self, arguments: &[&str], code: i32, words: &[&str]) {
        let before = self.dir.folder().read_dir().unwrap().count();
        let run = self.compare(arguments);
        run.expect_refusal(arguments, code, words);
        assert!(run.stderr.starts_with("error: "), "{words:?}: {}", run.stderr);
        assert!(run.stdout.is_empty());
        assert_eq!(self.dir.folder().read_dir().unwrap().count(), before, "{arguments:?}");
    }
}

fn grey(value: f32) -> impl Fn(usize, usize) -> [f32; 3] {
    move |_, _| [value; 3]
}

/// Fixed pattern of noise between -1 and 1, whose mean is 0 over pairs of seeds 2k and 2k + 1.
fn noise(seed: u32) -> impl Fn(usize, usize) -> f32 {
    move |x, y| {
        let mut hash = (x as u32) ^ (y as u32).rotate_left(16) ^ (seed / 2).wrapping_mul(0x9e37_79b9);
        hash = (hash ^ (hash >> 16)).wrapping_mul(0x7feb_352d);
        hash = (hash ^ (hash >> 15)).wrapping_mul(0x846c_a68b);
        let value = (hash >> 8) as f32 / (1 << 23) as f32 - 1.0;
        if seed.is_multiple_of(2) { value } else { -value }
    }
}

/// An image of a constant with noise.
fn noisy(value: f32, seed: u32) -> impl Fn(usize, usize) -> [f32; 3] {
    let noise = noise(seed);
    move |x, y| [value * (1.0 + 0.3 * noise(x, y)); 3]
}

#[test]
fn every_metric_is_reported_with_its_value_or_the_reason() {
    let images = ImageDir::new(20, 12);
    images.write("a.exr", &[("", &grey(3.0))]).write("b.exr", &[("", &grey(2.0))]);
    let report = images.report(&["a.exr", "b.exr"]);
    let metrics = report["metrics"].as_object().unwrap();
    for name in METRICS.iter().map(|metric| metric.name) {
        assert!(metrics.contains_key(name), "{name}");
        assert_eq!(metrics[name].is_null(), report["unavailable"][name].is_string(), "{name}");
    }
    assert_eq!(metrics.len(), METRICS.len());
    for (name, value) in [("mse", 1.0), ("relmse", 1.0 / 4.04), ("smape", 0.2), ("energy_ratio", 1.5)] {
        assert!((metrics[name].as_f64().unwrap() - value).abs() < 1e-12, "{name}: {}", metrics[name]);
    }
    assert!(metrics["flip_hdr"].as_f64().unwrap() > 0.0 && metrics["flip_ldr"].as_f64().unwrap() > 0.0);
    assert!(metrics["z_image"].is_null() && metrics["relmse_bias2"].is_null());
    assert_eq!((&report["runs"], &report["layer"]), (&1.into(), &"beauty".into()));
    assert_eq!((&report["images"][0], &report["reference"]), (&"a.exr".into(), &"b.exr".into()));
    assert_eq!(report["region"], serde_json::json!({ "x": 0, "y": 0, "width": 20, "height": 12 }));

    // The table for the user has the same names.
    let Run { code, stdout: table, .. } = images.compare(&["a.exr", "b.exr"]);
    assert_eq!(code, Some(0));
    for (line, metric) in table.lines().zip(METRICS) {
        assert!(line.starts_with(metric.name), "{line}");
    }
    assert!(table.contains("1.500000"));
}

#[test]
fn equal_images_have_no_error() {
    let images = ImageDir::new(33, 17);
    images.write("a.exr", &[("", &noisy(1.0, 0))]);
    let metrics = &images.report(&["a.exr", "a.exr"])["metrics"];
    for name in ["flip_ldr", "flip_hdr", "relmse", "relmse_p999", "mse", "smape", "energy_error"] {
        assert_eq!(metrics[name], 0.0, "{name}");
    }
}

#[test]
fn limits_decide_the_exit_code() {
    let images = ImageDir::new(9, 9);
    images.write("a.exr", &[("", &grey(3.0))]).write("b.exr", &[("", &grey(2.0))]);
    let run = |limits: &[&str]| {
        let limits: Vec<_> = limits.iter().flat_map(|limit| ["--fail-above", limit]).collect();
        images.compare(&[&["a.exr", "b.exr", "--json"], &limits[..]].concat())
    };
    assert_eq!(run(&["mse=1.001", "relmse=0.25", "energy_ratio=1.5"]).code, Some(0));
    let failed = run(&["relmse=0.25", "mse=0.999"]);
    assert_eq!(failed.code, Some(3));
    let stderr = &failed.stderr;
    assert!(
        stderr.contains("failed: mse is 1.000000, above 0.999") && !stderr.contains("relmse"),
        "{stderr}"
    );
    assert_eq!(failed.json()["failed"].as_array().unwrap().len(), 1);
    // A metric without a value does not pass a limit.
    let Run { code, stderr, .. } = run(&["z_surprise=3"]);
    assert_eq!(code, Some(3));
    assert!(stderr.contains("z_surprise has no value") && stderr.contains("variance"), "{stderr}");
}

#[test]
fn pixels_that_are_not_finite_are_counted_and_fail() {
    let images = ImageDir::new(10, 10);
    let holes = |x: usize, y: usize| if y == 3 && x < 4 { [1.0, f32::NAN, 1.0] } else { [1.0; 3] };
    images.write("a.exr", &[("", &holes)]).write("b.exr", &[("", &grey(1.0))]);
    let run = images.compare(&["a.exr", "b.exr", "--json"]);
    let report = run.json();
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains("a.exr: 4 pixels"), "{}", run.stderr);
    assert_eq!(report["non_finite_px"], serde_json::json!({ "images": [4], "reference": 0 }));
    assert!(report["metrics"].as_object().unwrap().values().all(Value::is_null));
    assert_eq!(images.compare(&["a.exr", "b.exr", "--fail-above", "mse=1e30"]).code, Some(3));
    assert_eq!(images.compare(&["b.exr", "a.exr", "--fail-above", "flip_hdr=1"]).code, Some(3));
    // No map is written, and a message says so.
    let Run { code, stderr, .. } = images.compare(&["a.exr", "b.exr", "--map", "map.png"]);
    assert!(code.is_some() && stderr.contains("no map is written"), "{stderr}");
    assert!(!images.dir.path("map.png").exists(), "{stderr}");
    // Outside of the region, such pixels have no effect.
    let metrics = &images.report(&["a.exr", "b.exr", "--region", "0,4,10,6"])["metrics"];
    assert_eq!(metrics["mse"], 0.0);
}

#[test]
fn regions_and_layers_are_cut_out() {
    let images = ImageDir::new(16, 8);
    let half = |x: usize, _: usize| if x < 4 { [5.0; 3] } else { [1.0; 3] };
    images.write("a.exr", &[("", &half), ("caustics", &grey(4.0)), ("path", &grey(1.0))]);
    images.write("b.exr", &[("", &grey(1.0)), ("caustics", &grey(2.0)), ("path", &grey(1.0))]);
    let mse = |options: &[&str]| {
        let report = images.report(&[&["a.exr", "b.exr"], options].concat());
        report["metrics"]["mse"].as_f64().unwrap()
    };
    assert_eq!(mse(&[]), 4.0);
    assert_eq!(mse(&["--region", "0,0,4,8"]), 16.0);
    assert_eq!(mse(&["--region", "2,1,4,3"]), 8.0);
    assert_eq!(mse(&["--region", "4,0,12,8"]), 0.0);
    assert_eq!(mse(&["--layer", "caustics"]), 4.0);
    assert_eq!(mse(&["--layer", "path"]), 0.0);
    assert_eq!(mse(&["--layer", "caustics.R", "--region", "15,7,1,1"]), 4.0);
}

#[test]
fn runs_split_the_error_and_the_z_test_tells_noise_from_bias() {
    let images = ImageDir::new(64, 48);
    // Uniform noise of +-0.3 has a variance of 0.03; the reference has a quarter of its deviation.
    let reference = |x: usize, y: usize| [1.0 + 0.075 * noise(1000)(x, y); 3];
    images.write("reference.exr", &[("", &reference), ("variance", &grey(0.03 / 16.0))]);
    let names: Vec<String> = (0..8).map(|seed| format!("{seed}.exr")).collect();
    let report = |gain: f32, options: &[&str]| {
        for (seed, name) in names.iter().enumerate() {
            // Take every second seed, so that runs are independent.
            images.write(name, &[("", &noisy(gain, 2 * seed as u32))]);
        }
        let mut files: Vec<&str> = names.iter().map(String::as_str).collect();
        files.push("reference.exr");
        images.report(&[&files, options].concat())
    };
    let same = report(1.0, &[]);
    let metrics = &same["metrics"];
    let get = |metrics: &Value, name: &str| metrics[name].as_f64().unwrap();
    assert_eq!((&same["runs"], &same["z_blocks"]), (&8.into(), &48.into()));
    // For 3072 grey pixels, four deviations of the mean of squares of size s^2/8 + v are 0.0006.
    assert!(get(metrics, "mse_bias2").abs() < 6e-4, "{metrics}");
    assert!((get(metrics, "mse_variance") - 0.03).abs() < 0.002, "{metrics}");
    assert!((get(metrics, "mse_reference") - 0.03 / 16.0).abs() < 1e-8, "{metrics}");
    assert!(get(metrics, "z_surprise") < 3.0, "{metrics}");
    // For three equal channels of 48 blocks, one deviation of the mean of z^2 is 0.2.
    assert!((get(metrics, "z_mean_square") - 1.0).abs() < 0.8, "{metrics}");
    assert!(
        (get(metrics, "energy_ratio") - 1.0).abs() < 4.0 * get(metrics, "energy_standard_error"),
        "{metrics}"
    );

    let brighter = report(1.02, &[]);
    assert!(get(&brighter["metrics"], "z_surprise") > 3.0, "{brighter}");
    assert!(get(&brighter["metrics"], "z_image") > 4.0, "{brighter}");

    // One image with its variance is enough.
    images.write("one.exr", &[("", &noisy(1.02, 0)), ("variance", &grey(0.03))]);
    let arguments = ["one.exr", "reference.exr", "--fail-above", "z_image=4"];
    assert_eq!(images.compare(&arguments).code, Some(3));
    images.write("one.exr", &[("", &noisy(1.0, 0)), ("variance", &grey(0.03))]);
    assert_eq!(images.compare(&arguments).code, Some(0));
}

#[test]
fn maps_show_where_the_error_is() {
    let images = ImageDir::new(48, 32);
    let spot = |x: usize, y: usize| if x.abs_diff(36) < 3 && y.abs_diff(8) < 3 { [2.0; 3] } else { [0.5; 3] };
    images.write("a.exr", &[("", &spot)]).write("b.exr", &[("", &grey(0.5))]);
    images.report(&["a.exr", "b.exr", "--map", "map.png"]);
    let map = image::open(images.dir.path("map.png")).unwrap().into_rgb8();
    assert_eq!(map.dimensions(), (48, 32));
    // Magma starts at black and gets lighter; FLIP's filters reach 10 pixels.
    assert_eq!(map.get_pixel(2, 28).0, [0, 0, 4]);
    let light = |pixel: &image::Rgb<u8>| pixel.0.iter().map(|&value| u32::from(value)).sum::<u32>();
    let (x, y, _) = map.enumerate_pixels().max_by_key(|(_, _, pixel)| light(pixel)).unwrap();
    assert!(x.abs_diff(36) <= 3 && y.abs_diff(8) <= 3, "{x}, {y}");
    // The error is at least 0.3.
    assert!(light(map.get_pixel(36, 8)) > 200, "{:?}", map.get_pixel(36, 8));

    // The map of a region has the region's size.
    images.report(&["a.exr", "b.exr", "--map", "part.png", "--region", "30,2,12,9"]);
    assert_eq!(image::open(images.dir.path("part.png")).unwrap().into_rgb8().dimensions(), (12, 9));

    // No file is overwritten without --force, and a compared image never is.
    images.refuses(&["a.exr", "b.exr", "--map", "map.png"], 2, &["map.png", "--force"]);
    images.report(&["a.exr", "b.exr", "--map", "map.png", "--force"]);
    images.refuses(&["a.exr", "b.exr", "--map", "./b.exr", "--force"], 2, &["--map", "b.exr"]);
    images.refuses(&["a.exr", "b.exr", "--map", "no/map.png"], 1, &["no/map.png"]);
    images.refuses(&["a.exr", "b.exr", "--map", "."], 2, &["--map", "folder"]);
}

#[test]
fn rendered_images_are_compared_as_exr_and_as_png() {
    let images = ImageDir::new(0, 0);
    for (seed, name) in [("1", "a"), ("2", "b")] {
        let (exr, png) = (format!("{name}.exr"), format!("{name}.png"));
        let size = ["--width", "64", "--height", "36", "--light-paths", "20000", "--runner", "cpu"];
        let files = ["--seed", seed, "-o", &exr, "--png", &png];
        images.dir.succeeds(&[&["render", "mirror-room"], &size[..], &files].concat());
    }
    let (linear, display) = (images.report(&["a.exr", "b.exr"]), images.report(&["a.png", "b.png"]));
    let flip = |report: &Value| report["metrics"]["flip_ldr"].as_f64().unwrap();
    println!("flip_ldr {} of EXR, {} of PNG", flip(&linear), flip(&display));
    // The PNG is rounded to bytes; a step of grey alone gives 0.03 (see flip.rs of the crate caustics-tests).
    assert!(flip(&linear) > 0.05 && (flip(&linear) - flip(&display)).abs() < 0.02);
    assert!(display["metrics"]["flip_hdr"].is_null());
    assert!(display["unavailable"]["flip_hdr"].as_str().unwrap().contains("EXR"));
    for layer in ["path", "caustics"] {
        assert!(
            images.report(&["a.exr", "b.exr", "--layer", layer])["metrics"]["relmse"].as_f64().unwrap() > 0.0
        );
    }
    images.refuses(&["a.png", "b.exr"], 2, &["a.png", "b.exr", "two of a kind"]);
}

#[test]
fn incomparable_files_are_refused() {
    let mut images = ImageDir::new(9, 6);
    images.write("wide.exr", &[("", &grey(1.0))]);
    images.size = (8, 6);
    images.write("a.exr", &[("", &grey(1.0)), ("path", &grey(1.0))]).write("plain.exr", &[("", &grey(1.0))]);
    images.refuses(&["a.exr"], 2, &["REFERENCE"]);
    images.refuses(&["a.exr", "none.exr"], 1, &["none.exr", "check the path"]);
    images.dir.write("text.exr", "hello");
    images.refuses(&["a.exr", "text.exr"], 1, &["text.exr", "EXR"]);
    images.refuses(&["wide.exr", "a.exr"], 2, &["wide.exr has 9x6", "a.exr 8x6"]);
    images.refuses(&["a.exr", "plain.exr", "--layer", "path"], 2, &["--layer path", "plain.exr", "beauty"]);
    images.refuses(&["a.exr", "a.exr", "--layer", "nothing"], 2, &["--layer nothing", "beauty, path"]);
    images.refuses(&["a.exr", "a.exr", "--region", "5,0,4,6"], 2, &["--region 5,0,4,6", "8x6", "a.exr"]);
    for region in ["1,1,0,4", "1,1,2", "a,b,c,d", "-1,0,2,2", "1,1,2,2,2"] {
        let region = format!("--region={region}");
        images.refuses(&["a.exr", "a.exr", &region], 2, &["--region"]);
    }
    for limit in ["mse", "mse=", "mse=NaN", "mse=inf", "speed=3"] {
        images.refuses(&["a.exr", "a.exr", "--fail-above", limit], 2, &["--fail-above"]);
    }
    images.refuses(&["a.exr", "a.exr", "--fail-above", "speed=3"], 2, &["speed", "relmse_p999"]);
    for value in ["0", "NaN", "-3", "1e9"] {
        images.refuses(&["a.exr", "a.exr", "--pixels-per-degree", value], 2, &["--pixels-per-degree"]);
    }
    images.refuses(&["a.exr", "a.exr", "--exposure", "NaN"], 2, &["--exposure"]);
}

#[test]
fn help_opens_with_examples() {
    let images = ImageDir::new(1, 1);
    let Run { code, stdout, .. } = images.compare(&["--help"]);
    assert!(code == Some(0) && stdout.starts_with("Examples:"), "{stdout}");
}

#[test]
fn a_closed_stdout_is_not_an_error() {
    let images = ImageDir::new(5, 5);
    images.write("a.exr", &[("", &grey(1.0))]);
    for options in [&[][..], &["--json"]] {
        let mut child = std::process::Command::new(BINARY)
            .current_dir(images.dir.folder())
            .args([&["compare", "a.exr", "a.exr"], options].concat())
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    }
}
