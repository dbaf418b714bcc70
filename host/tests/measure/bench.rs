//! `caustics bench --animation` from outside: its tables, its figures, what it keeps and what it refuses.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use assert_cmd::Command;
use caustics::experiment::row::{MEASURES, Row, decode};
use caustics::image::Channels;
use caustics_kernels::history;
use serde_json::Value;
use tempfile::TempDir;

/// A tiny picture with few light paths.
const TINY: [&str; 8] =
    ["--width", "40", "--height", "24", "--paths-per-pixel", "2", "--reference-frames", "8"];

/// A folder with references of its own.
struct Desk(TempDir);

impl Desk {
    fn new() -> Desk {
        Desk(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs in the folder: exit code, stdout, stderr.
    fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_caustics"));
        command.current_dir(self.0.path()).timeout(Duration::from_secs(300));
        let output = command.env("CAUSTICS_CACHE", self.path("cache")).args(arguments).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
    }

    /// Measures; the run must succeed. Gives stderr.
    #[track_caller]
    fn bench(&self, arguments: &[&str]) -> String {
        let command = ["bench", "mirror-room", "--animation", "--runner", "cpu", "-o", "out"];
        let (code, _, stderr) = self.run(&[&command, &TINY[..], arguments].concat());
        assert_eq!(code, 0, "{arguments:?}: {stderr}");
        stderr
    }

    fn rows(&self) -> Vec<Row> {
        decode(&std::fs::read(self.path("out/frames.csv")).unwrap()).unwrap()
    }

    fn summary(&self) -> Value {
        serde_json::from_slice(&std::fs::read(self.path("out/summary.json")).unwrap()).unwrap()
    }
}

/// Files of a folder, with those of its folders.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.into_iter().flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn a_run_of_both_modes_has_every_row_and_measure() {
    let desk = Desk::new();
    let stderr = desk.bench(&["--time", "--error", "--frames", "2..5", "--fps", "8"]);
    assert!(stderr.contains("references: 1 rendered, 0 replaced"), "nothing moves: {stderr}");
    let rows = desk.rows();
    let cells: BTreeSet<String> =
        history::ALL.iter().map(|history| format!("basic-{}", history.name)).collect();
    assert_eq!(rows.len(), 3 * cells.len());
    assert_eq!(rows.iter().map(|row| row.cell.clone()).collect::<BTreeSet<_>>(), cells);
    for row in &rows {
        assert_eq!(row.time, f64::from(row.frame) / 8.0);
        for measure in MEASURES {
            // The first frame has none before it.
            let is_missing = measure.starts_with("flicker") && row.frame == 2;
            assert_eq!(row.get(measure).is_none(), is_missing, "{measure} of {row:?}");
        }
        let passes: f64 = row.passes().map(|(_, ms)| ms).sum();
        let total = row.get("total_ms").unwrap();
        assert!(passes > 0.0 && passes <= total, "{passes} of {total} ms");
        assert!(row.passes().any(|(pass, _)| pass == "collect"));
        assert_eq!(row.get("light_paths"), Some(1920.0), "two a pixel");
    }
    for row in rows.iter().filter(|row| row.cell == "basic-none") {
        assert_eq!(row.get("gain"), Some(1.0), "none against itself");
    }
    // Each cell has the first turn in turn.
    let firsts: BTreeSet<&str> =
        rows.iter().filter(|row| row.get("turn") == Some(0.0)).map(|row| row.cell.as_str()).collect();
    assert_eq!(firsts.len(), cells.len().min(3));

    let summary = desk.summary();
    let none = &summary["cells"]["basic-none"];
    assert_eq!(none["measures"]["frames"], 3);
    assert_eq!(none["measures"]["paired_ratio"], 1.0);
    assert_eq!(none["measures"]["frames_flip_above_none"], 0);
    assert_eq!(none["memory"]["buffers_bytes"]["caustic_radiance"], 40 * 24 * 12);
    let rate = none["cost"]["collect"]["rate_per_s"].as_f64().unwrap();
    assert!(rate > 0.0 && rate < 1e3 * summary["closest_hits_per_s"].as_f64().unwrap());
}

#[test]
fn figures_are_xml_with_a_line_a_cell() {
    let desk = Desk::new();
    desk.bench(&["--time", "--error", "--seeds", "2", "--frames", "0..3"]);
    let cells = history::ALL.len();
    for name in ["frame-time.svg", "flip.svg", "flip-caustics.svg", "gain.svg"] {
        let text = std::fs::read_to_string(desk.path("out").join(name)).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let mut dots = BTreeMap::new();
        for dot in document.descendants().filter(|node| node.has_tag_name("circle")) {
            *dots.entry(dot.attribute("fill").unwrap()).or_insert(0) += 1;
        }
        assert_eq!(dots.len(), cells, "{name}: a colour a cell");
        assert!(dots.values().all(|count| *count == 3), "{name}: a dot a frame: {dots:?}");
        // Of the colour of the dots: each line and its sample in the legend.
        let lines = document.descendants().filter(|node| node.has_tag_name("polyline"));
        let drawn = lines.filter(|node| dots.contains_key(node.attribute("stroke").unwrap_or_default()));
        assert!(drawn.count() >= 2 * cells, "{name}");
        for label in ["frame", "basic-none"] {
            let is_there = |node: roxmltree::Node| node.text().is_some_and(|text| text.trim() == label);
            assert!(document.descendants().any(is_there), "{name} has no {label}");
        }
    }
    let text = std::fs::read_to_string(desk.path("out/passes.svg")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    for label in ["collect", "shoot", "basic-none", "mean time of a frame [ms]"] {
        assert!(
            document.descendants().any(|node| node.text().is_some_and(|text| text.trim() == label)),
            "{label}"
        );
    }
}

#[test]
fn references_are_kept_and_damaged_ones_made_anew() {
    let desk = Desk::new();
    let run = ["--error", "--seeds", "2", "--history", "none", "--frames", "0..2", "--force"];
    assert!(desk.bench(&run).contains("references: 1 rendered, 0 replaced"));
    let first = desk.rows();
    assert!(desk.bench(&run).contains("references: 0 rendered, 0 replaced"));
    assert_eq!(desk.rows(), first, "the same bits");

    let kept = files(&desk.path("cache"));
    let [reference] = kept.as_slice() else { panic!("{kept:?}") };
    assert!(reference.ends_with("0000.exr"));
    let (bytes, whole) = (std::fs::read(reference).unwrap(), Channels::read(reference).unwrap());
    for damaged in [&bytes[..bytes.len() / 2], &b"nothing"[..], &[]] {
        std::fs::write(reference, damaged).unwrap();
        assert!(desk.bench(&run).contains("references: 0 rendered, 1 replaced"));
        assert_eq!(desk.rows(), first, "the same bits");
        assert_eq!(Channels::read(reference).unwrap(), whole);
    }
    // Other settings are other references; another exposure is not.
    assert!(desk.bench(&[&run[..], &["--exposure", "1"]].concat()).contains("references: 0 rendered"));
    assert_ne!(desk.rows()[0].get("flip"), first[0].get("flip"));
    assert!(desk.bench(&[&run[..], &["--max-bounces", "4"]].concat()).contains("references: 1 rendered"));
}

#[test]
fn errors_are_those_of_compare() {
    let desk = Desk::new();
    desk.bench(&["--error", "--seeds", "2", "--seed", "7", "--history", "none", "--frames", "0..1"]);
    let rows = desk.rows();
    let kept = files(&desk.path("cache"));
    let reference = kept[0].to_str().unwrap();
    for seed in ["7", "8"] {
        let size = ["--width", "40", "--height", "24", "--light-paths", "1920", "--seed", seed];
        let out = format!("{seed}.exr");
        let (code, _, stderr) =
            desk.run(&[&["render", "mirror-room", "--runner", "cpu", "-o", &out], &size[..]].concat());
        assert_eq!(code, 0, "{stderr}");
    }
    let measured = |layer: &str, name: &str| {
        let (code, stdout, stderr) =
            desk.run(&["compare", "7.exr", "8.exr", reference, "--layer", layer, "--json"]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).unwrap()["metrics"][name].as_f64().unwrap()
    };
    // The same numbers, summed in another order.
    let same = |own: Option<f64>, theirs: f64| {
        let own = own.unwrap();
        assert!((own - theirs).abs() <= 1e-12 * theirs, "{own} {theirs}");
    };
    same(rows[0].get("flip"), measured("beauty", "flip_ldr"));
    same(rows[0].get("relmse_caustics"), measured("caustics", "relmse"));
    // The whole is kept as the sum of its layers, rounded once more.
    let relmse = (rows[0].get("relmse").unwrap(), measured("beauty", "relmse"));
    assert!((relmse.0 / relmse.1 - 1.0).abs() < 1e-5, "{relmse:?}");
    same(rows[0].get("caustics_variance_radiance2"), measured("caustics", "mse_variance"));
}

#[test]
fn a_still_reference_leaves_the_flicker_of_the_cell() {
    let desk = Desk::new();
    desk.bench(&["--error", "--seeds", "2", "--seed", "7", "--history", "none", "--frames", "0..2"]);
    let flicker = desk.rows()[1].get("flicker").unwrap();
    let shown = shown_change(&[7, 8]);
    assert!((flicker - shown).abs() <= 1e-12 * shown, "{flicker} {shown}");
}

/// Mean FLIP between the frames 0 and 1 of each seed.
fn shown_change(seeds: &[u32]) -> f64 {
    use caustics::image::Encoding;
    use caustics::metric::flip::PIXELS_PER_DEGREE;
    use caustics::metric::flip_ldr::flip_ldr;
    use caustics::metric::pixels::Pixels;
    use caustics::scene::{Scene, resolve};
    use caustics::session::{RunnerChoice, Session};
    use caustics::settings::Settings;
    use caustics_kernels::gather::variant::PHOTONS_GRID;
    use caustics_kernels::method::basic::BASIC;

    let scene = Scene::load(&resolve("mirror-room").unwrap()).unwrap();
    let of_seed = |&seed: &u32| {
        let settings = Settings { width: 40, height: 24, light_paths: 1920, seed, ..Settings::default() };
        let features = scene.features(settings.specular_roughness);
        let (choice, camera) = (RunnerChoice::Cpu { threads: 1 }, &scene.cameras[0]);
        let mut session =
            Session::new(&choice, &scene, camera, &settings, &BASIC, &PHOTONS_GRID, features).unwrap();
        let [first, second] = [0, 1].map(|frame| {
            session.frame(frame).unwrap();
            let values = session.picture().unwrap().beauty();
            Pixels {
                width: 40,
                height: 24,
                values: values.into_iter().map(|value| value.as_dvec3()).collect(),
            }
        });
        flip_ldr(&second, &first, Encoding::Linear, 0.0, PIXELS_PER_DEGREE).mean()
    };
    seeds.iter().map(of_seed).sum::<f64>() / seeds.len() as f64
}

#[test]
fn finished_cells_are_kept_and_unfinished_ones_measured_from_their_first_frame() {
    let desk = Desk::new();
    let run = |frames: &str, more: &[&str]| {
        desk.bench(&[&["--error", "--seeds", "2", "--history", "none", "--frames", frames], more].concat())
    };
    assert!(run("0..3", &[]).contains("1 cells to measure"));
    let whole = desk.rows();
    let again = run("0..3", &[]);
    assert!(again.contains("0 cells to measure") && !again.contains("references:"), "{again}");
    assert_eq!(desk.rows(), whole);

    // An interrupted run leaves fewer rows.
    let table = std::fs::read_to_string(desk.path("out/frames.csv")).unwrap();
    let part: Vec<&str> = table.lines().take(2).collect();
    std::fs::write(desk.path("out/frames.csv"), part.join("\n") + "\n").unwrap();
    assert!(run("0..3", &[]).contains("1 cells to measure"));
    assert_eq!(desk.rows(), whole, "an interrupted run ends with the bits of a whole one");

    // A shorter run needs nothing new; a longer one goes on to the same rows and more.
    assert!(run("0..2", &[]).contains("0 cells to measure"));
    assert_eq!(desk.summary()["cells"]["basic-none"]["measures"]["frames"], 2);
    assert!(run("0..4", &[]).contains("1 cells to measure"));
    assert_eq!(desk.rows()[..3], whole);
    assert!(run("0..4", &["--force"]).contains("1 cells to measure"));
}

#[test]
fn rows_of_another_run_are_refused() {
    let desk = Desk::new();
    let base = ["bench", "mirror-room", "--animation", "--runner", "cpu", "-o", "out", "--history", "none"];
    let run = |more: &[&str]| desk.run(&[&base, &TINY[..], &["--frames", "0..1"], more].concat());
    assert_eq!(run(&["--time"]).0, 0);
    let table = std::fs::read(desk.path("out/frames.csv")).unwrap();
    for other in [&["--time", "--seed", "1"][..], &["--time", "--warm-up", "1"], &["--error"]] {
        let (code, _, stderr) = run(other);
        assert!(code == 2 && stderr.contains("--force"), "{other:?}: {code} {stderr}");
        assert_eq!(std::fs::read(desk.path("out/frames.csv")).unwrap(), table);
    }
    std::fs::write(desk.path("out/frames.csv"), "mine\n").unwrap();
    let (code, _, stderr) = run(&["--time"]);
    assert!(code == 2 && stderr.contains("frames.csv"), "{code} {stderr}");
    assert_eq!(run(&["--time", "--force"]).0, 0);
}

#[test]
fn what_cannot_be_measured_is_a_usage_error() {
    let desk = Desk::new();
    let base = ["bench", "mirror-room", "--runner", "cpu", "-o", "out"];
    for (options, named) in [
        (&["--time"][..], "--animation"),
        (&["--animation"], "--time"),
        (&["--animation", "--error", "--seeds", "1"], "--seeds"),
        (&["--animation", "--error", "--seed", "1919247973"], "--seed"),
        (&["--animation", "--error", "--warm-up", "1"], "--warm-up"),
        (&["--animation", "--error", "--reference-frames", "0"], "--reference-frames"),
        (&["--animation", "--time", "--frames", "3..3"], "--frames"),
        (&["--animation", "--time", "--fps", "0"], "--fps"),
        (&["--animation", "--time", "--paths-per-pixel", "-1"], "--paths-per-pixel"),
        (&["--animation", "--time", "--paths-per-pixel", "1", "--light-paths", "9"], "--paths-per-pixel"),
        (&["--animation", "--time", "--history", "nothing"], "--history"),
        (&["--animation", "--time", "--png", "a.png"], "--png"),
    ] {
        let (code, _, stderr) = desk.run(&[&base, options].concat());
        assert!(code == 2 && stderr.contains(named), "{options:?}: {code} {stderr}");
    }
    assert!(!desk.path("out").exists());
}
