//! `caustics bench` from outside: measures, output, results on disk, and refusals.

use caustics::render_config::Paths;
use std::path::{Path, PathBuf};

use caustics::image_file::Channels;
use caustics::render_config::RenderConfig;
use caustics::scene::{Scene, resolve};
use caustics_bench::error::{
    CAUSTICS_VARIANCE, FLICKER, FLICKER_CAUSTICS, FLIP, FLIP_CAUSTIC_REGION, MEASURES, PATH_BIAS2, RELMSE,
    RELMSE_CAUSTICS, RELMSE_FLICKER, RELMSE_TRIMMED, RELMSE_TRIMMED_CAUSTIC_REGION,
};
use caustics_bench::measure::measure;
use caustics_bench::parameter::{FEATURES, GATHER, HISTORY, MAX_BOUNCES, METHOD, RADIUS_PX};
use caustics_bench::plan::{Compared, MeasurementPlan};
use caustics_bench::record::FrameRecord;
use caustics_bench::result::RunResult;
use caustics_bench::run_config::RunConfig;
use caustics_bench::store;
use caustics_kernels::history;
use caustics_kernels::method::basic::BASIC;

use crate::test_dir::{Run, TestDir};

/// A tiny image with few light paths.
const TINY: [&str; 8] =
    ["--width", "40", "--height", "24", "--paths-per-pixel", "2", "--reference-frames", "8"];

/// Folder whose references are its own.
struct BenchDir(TestDir);

impl BenchDir {
    fn new() -> BenchDir {
        BenchDir(TestDir::new())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path(name)
    }

    /// Runs the program with its cache in the folder.
    fn run(&self, arguments: &[&str]) -> Run {
        let mut command = self.0.command(arguments);
        Run::from_output(command.env("CAUSTICS_CACHE", self.path("cache")).output().unwrap())
    }

    /// Measures mirror-room on the CPU.
    fn try_bench(&self, arguments: &[&str]) -> Run {
        self.run(&[&["bench", "mirror-room", "--runner", "cpu"], &TINY[..], arguments].concat())
    }

    /// Measures into the folder `out`, which must succeed.
    #[track_caller]
    fn bench(&self, arguments: &[&str]) -> Run {
        self.try_bench(&[&["-o", "out"], arguments].concat()).expect_success(arguments)
    }

    fn results(&self) -> Vec<RunResult> {
        store::read_all(&self.path("out")).unwrap()
    }
}

/// Files of a folder and of its subfolders.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.into_iter().flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn time_and_error_of_every_history_and_frame_are_measured() {
    let dir = BenchDir::new();
    let names: Vec<&str> = history::ALL.iter().map(|history| history.name).collect();
    let run = ["--measure", "time,error", "--every-frame", "--frames", "3", "--history", &names.join(",")];
    let Run { stdout, stderr, .. } = dir.bench(&run);
    assert!(
        stderr.contains("reference 1 of 3") && !stderr.contains("reference 2"),
        "nothing moves: {stderr}"
    );
    let results = dir.results();
    assert_eq!(results.len(), names.len());
    for RunResult { config, time, error, frames, .. } in &results {
        let (time, error) = (time.as_ref().unwrap(), error.as_ref().unwrap());
        assert_eq!((time.light_paths, error.light_paths, error.seeds), (1920, 1920, 4), "two a pixel");
        assert_eq!(frames.iter().map(|frame| frame.frame).collect::<Vec<_>>(), [0, 1, 2]);
        for measure in MEASURES {
            assert!(error.get(measure).is_some(), "{} of {config:?}", measure.key);
            for frame in frames {
                // The first frame has no frame before it.
                let is_missing = [&FLICKER, &FLICKER_CAUSTICS, &RELMSE_FLICKER]
                    .map(|flicker| flicker.key)
                    .contains(&measure.key)
                    && frame.frame == 0;
                assert_eq!(frame.get(measure).is_none(), is_missing, "{} of {frame:?}", measure.key);
            }
        }
        let passes: f64 = time.pass_ms.values().map(|ms| ms.lower).sum();
        assert!(passes > 0.0 && passes <= time.total_ms.upper, "{passes} of {:?}", time.total_ms);
        assert_eq!(time.memory_bytes["caustic_radiance"], 40 * 24 * 12);
        let cost = &time.costs["collect"];
        assert!(cost.rate_per_s > 0.0 && cost.expected_ms.unwrap() < 1e3 * cost.ms, "{cost:?}");
    }
    let row = |name: &str| stdout.lines().filter(|line| line.starts_with(name)).nth(1).unwrap().to_string();
    assert!(row("basic-none").trim_end().ends_with("1.00           0"), "none against itself: {stdout}");
    for name in names {
        assert!(stdout.contains(&format!("basic-{name}")), "{stdout}");
    }
    let lines = |name: &str| std::fs::read_to_string(dir.path("out").join(name)).unwrap().lines().count();
    assert_eq!(lines("cells.csv"), 1 + results.len());
    assert_eq!(lines("frames.csv"), 1 + 3 * results.len());
    let passes: usize = results.iter().map(|result| result.time.as_ref().unwrap().pass_ms.len()).sum();
    assert_eq!(lines("passes.csv"), 1 + passes);
}

#[test]
fn references_of_whole_pixels_count_aliasing_as_bias() {
    let dir = BenchDir::new();
    let size = ["--width", "40", "--height", "24", "--paths-per-pixel", "0.1", "--reference-frames", "128"];
    let run =
        ["bench", "mirror-room", "--runner", "cpu", "--measure", "error", "--seeds", "16", "--frames", "1"];
    let bias2 = |filter: &[&str]| {
        let arguments = [&run[..], &size, &["-o", "out"], filter].concat();
        dir.run(&arguments).expect_success(&arguments);
        let results = dir.results();
        std::fs::remove_dir_all(dir.path("out")).unwrap();
        results[0].error.as_ref().unwrap().get(&PATH_BIAS2).unwrap()
    };
    let (centre, pixel) = (bias2(&[]), bias2(&["--reference-pixel-filter", "box"]));
    assert!(pixel > 3.0 * centre.abs(), "{pixel} {centre}");
}

#[test]
fn configurations_of_all_parameters_are_measured() {
    let dir = BenchDir::new();
    let run = [
        "--method",
        "basic,path",
        "--gather",
        "photons-grid,brute",
        "--features",
        "scene,all",
        "--frames",
        "5",
    ];
    let stdout = dir.bench(&run).stdout;
    let results = dir.results();
    // Two gathers and the path tracer, which has none, each with both sets of features.
    assert_eq!(results.len(), 2 * (2 + 1));
    for RunResult { identity, config, time, provenance, .. } in &results {
        let time = time.as_ref().unwrap();
        for ms in time.pass_ms.values().chain([&time.total_ms]) {
            assert!(ms.lower <= ms.median && ms.median <= ms.upper, "{identity}: {ms:?}");
        }
        assert_eq!((time.width, time.height, time.frames), (40, 24, 5));
        assert_eq!(time.first, "basic-none-photons-grid-scene");
        let has_gather = config.text(&METHOD) == "basic";
        assert_eq!(config.text(&GATHER).is_empty(), !has_gather);
        assert_eq!(time.light_paths, if has_gather { 1920 } else { 0 });
        assert_eq!((time.points_per_s.is_some(), time.light_paths_per_s.is_some()), (has_gather, has_gather));
        assert!(time.rays > 960.0 && time.rays_per_s > 1e4, "{time:?}");
        assert_eq!(time.memory_bytes["display_color"], 40 * 24 * 12);
        assert!(provenance.device.starts_with("CPU") && provenance.unix_s > 1_700_000_000);
    }
    let is_first = |result: &&RunResult| {
        result.config.text(&GATHER) == "photons-grid" && result.config.text(&FEATURES) == "scene"
    };
    let first = results.iter().find(is_first).unwrap();
    assert_eq!(first.time.as_ref().unwrap().ratio_to_first, Some(1.0));
    assert!(stdout.contains("path-none-all") && stdout.contains(" gather.brute"), "{stdout}");

    // --force measures the configurations again; other results stay.
    let another = "00000000000000aa";
    store::write(&dir.path("out"), &RunResult { identity: another.into(), ..RunResult::default() }).unwrap();
    let stderr = dir.bench(&run).stderr;
    assert!(stderr.contains("6 run configurations, 0 to measure"), "{stderr}");
    let stderr = dir.bench(&[&run[..], &["--force"]].concat()).stderr;
    assert!(stderr.contains("6 run configurations, 6 to measure"), "{stderr}");
    assert_eq!(dir.results().len(), 7);
}

#[test]
fn each_configuration_gets_the_first_turn() {
    let scene = Scene::load(&resolve("mirror-room").unwrap()).unwrap();
    let mut runs: Vec<RunConfig> = history::ALL
        .iter()
        .map(|&history| RunConfig::new(&BASIC).with(|config| config.history = history))
        .collect();
    caustics_bench::run_parameters::name_all(&mut runs);
    let plan = MeasurementPlan {
        config: RenderConfig { width: 40, height: 24, ..RenderConfig::default() },
        camera: scene.cameras[0].name.clone(),
        frames: 0..runs.len() as u32,
        fps: 24.0,
        moment: Some(0.0),
        warm_up: 0,
        time: true,
        compared: Compared::Last,
        reference_pixel_filter: None,
        seeds: 1,
    };
    let mut records: Vec<FrameRecord> = Vec::new();
    let mut each = |new| {
        records.extend(new);
        Ok(())
    };
    measure(&plan, &scene, &runs, None, &|| false, &mut each).unwrap().unwrap();
    let firsts =
        records.iter().filter(|record| record.get("turn") == Some(0.0)).map(|record| record.run.as_str());
    let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
    assert_eq!(firsts.collect::<Vec<_>>(), names);
}

#[test]
fn references_are_kept_and_damaged_ones_made_anew() {
    let dir = BenchDir::new();
    let run = ["--measure", "error", "--seeds", "2", "--frames", "2", "--force"];
    let errors = || dir.results()[0].error.clone().unwrap().values;
    assert!(dir.bench(&run).stderr.contains("reference 1 of 1 rendered"));
    let first = errors();
    assert!(!dir.bench(&run).stderr.contains("reference"));
    assert_eq!(errors(), first, "the same bits");

    let kept = files(&dir.path("cache"));
    let [reference] = kept.as_slice() else { panic!("{kept:?}") };
    assert!(reference.ends_with("0000.exr"));
    let (bytes, whole) = (std::fs::read(reference).unwrap(), Channels::read(reference).unwrap());
    for damaged in [&bytes[..bytes.len() / 2], &b"nothing"[..], &[]] {
        std::fs::write(reference, damaged).unwrap();
        assert!(dir.bench(&run).stderr.contains("reference 1 of 1 rendered"));
        assert_eq!(errors(), first, "the same bits");
        assert_eq!(Channels::read(reference).unwrap(), whole);
    }
    // Other settings need other references; another exposure does not.
    let other = |option: &str, value: &str| dir.bench(&[&run[..], &[option, value]].concat()).stderr;
    assert!(!other("--exposure", "1").contains("reference"));
    assert!(other("--max-bounces", "4").contains("reference 1 of 1 rendered"));
    assert!(other("--specular-roughness", "0.3").contains("reference 1 of 1 rendered"));
    let flips: Vec<_> =
        dir.results().iter().map(|result| result.error.clone().unwrap().values["flip"]).collect();
    assert!(flips.len() == 4 && flips.iter().any(|flip| *flip != first["flip"]), "{flips:?}");
}

#[test]
fn errors_are_those_of_compare() {
    let dir = BenchDir::new();
    dir.bench(&["--measure", "error", "--seeds", "2", "--seed", "7", "--frames", "1"]);
    let error = dir.results()[0].error.clone().unwrap();
    let kept = files(&dir.path("cache"));
    let reference = kept[0].to_str().unwrap();
    for seed in ["7", "8"] {
        let size = ["--width", "40", "--height", "24", "--light-paths", "1920", "--seed", seed];
        let out = format!("{seed}.exr");
        let render = [&["render", "mirror-room", "--runner", "cpu", "-o", &out], &size[..]].concat();
        dir.run(&render).expect_success(&render);
    }
    let measured = |layer: &str, name: &str| {
        let images = ["compare", "7.exr", "8.exr", reference];
        let compare = [&images[..], &["--layer", layer, "--exposure", "0", "--json"]].concat();
        let report = dir.run(&compare).expect_success(&compare).json();
        report["metrics"][name].as_f64().unwrap()
    };
    // The numbers are equal, but summed in another order.
    let same = |own: Option<f64>, theirs: f64| {
        let own = own.unwrap();
        assert!((own - theirs).abs() <= 1e-12 * theirs, "{own} {theirs}");
    };
    same(error.get(&FLIP), measured("beauty", "flip_ldr"));
    same(error.get(&FLIP_CAUSTIC_REGION), measured("beauty", "flip_ldr_caustic_region"));
    same(error.get(&RELMSE_TRIMMED), measured("beauty", "relmse_trimmed"));
    same(error.get(&RELMSE_TRIMMED_CAUSTIC_REGION), measured("beauty", "relmse_trimmed_caustic_region"));
    same(error.get(&RELMSE_CAUSTICS), measured("caustics", "relmse"));
    // The whole image is stored as the sum of its layers, with one more rounding.
    let relmse = (error.get(&RELMSE).unwrap(), measured("beauty", "relmse"));
    assert!((relmse.0 / relmse.1 - 1.0).abs() < 1e-5, "{relmse:?}");
    same(error.get(&CAUSTICS_VARIANCE), measured("caustics", "mse_variance"));
}

#[test]
fn a_still_reference_leaves_the_flicker_of_the_configuration() {
    let dir = BenchDir::new();
    let run = ["--measure", "error", "--every-frame", "--seeds", "2", "--seed", "7", "--frames", "2"];
    dir.bench(&[&run[..], &["--emission", "power"]].concat());
    let flicker = dir.results()[0].frames[1].get(&FLICKER).unwrap();
    let shown = shown_change(&[7, 8]);
    assert!((flicker - shown).abs() <= 1e-12 * shown, "{flicker} {shown}");
}

/// Mean FLIP between the frames 0 and 1 of each seed.
fn shown_change(seeds: &[u32]) -> f64 {
    use caustics::image_file::Encoding;
    use caustics::metric::flip::PIXELS_PER_DEGREE;
    use caustics::metric::flip_ldr::flip_ldr;
    use caustics::metric::pixels::Pixels;
    use caustics::session::{RunnerChoice, Session};

    use caustics_kernels::interface::choice::Sampler;

    let scene = Scene::load(&resolve("mirror-room").unwrap()).unwrap();
    let of_seed = |&seed: &u32| {
        let sampler = Sampler::Sobol;
        let config = RenderConfig {
            width: 40,
            height: 24,
            light_paths: Paths::Count(1920),
            seed,
            sampler,
            ..RenderConfig::default()
        };
        let features = scene.features(config.specular_roughness);
        let (choice, camera) = (RunnerChoice::Cpu { threads: 1 }, &scene.cameras[0]);
        let mut session = Session::new(&choice, &scene, camera, &config, features).unwrap();
        let [first, second] = [0, 1].map(|frame| {
            session.frame(frame).unwrap();
            let values = session.image().unwrap().beauty();
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
fn finished_configurations_are_kept_and_others_measured() {
    let dir = BenchDir::new();
    let run = |more: &[&str]| {
        dir.bench(&[&["--measure", "error", "--seeds", "2", "--frames", "3"], more].concat()).stderr
    };
    assert!(run(&[]).contains("1 run configurations, 1 to measure"));
    let whole = dir.results();
    let again = run(&[]);
    assert!(again.contains("1 run configurations, 0 to measure") && !again.contains("reference"), "{again}");
    assert_eq!(dir.results(), whole);
    // Other settings give additional results.
    assert!(run(&["--history", "none,paper"]).contains("2 run configurations, 1 to measure"));
    assert!(run(&["--seed", "1"]).contains("1 run configurations, 1 to measure"));
    let results = dir.results();
    assert!(results.len() == 3 && results.iter().any(|result| result.config.text(&HISTORY) == "paper"));
    // A damaged result is measured again.
    std::fs::write(store::file(&dir.path("out"), &whole[0].identity), "mine\n").unwrap();
    assert!(run(&[]).contains("1 run configurations, 1 to measure"));
    assert_eq!(dir.results().len(), 3);
}

#[test]
fn without_a_folder_there_is_a_table_only() {
    let dir = BenchDir::new();
    let run = ["--frames", "2", "--radius-px", "1,2", "--max-bounces", "3,5", "--json"];
    let stdout = dir.try_bench(&run).expect_success(&run).stdout;
    let results: Vec<RunResult> = serde_json::from_str(&stdout).unwrap();
    let bounces = |result: &RunResult| result.config.number(&MAX_BOUNCES);
    let mut config: Vec<_> =
        results.iter().map(|result| (bounces(result), result.config.number(&RADIUS_PX))).collect();
    config.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(config, [(3.0, 1.0), (3.0, 2.0), (5.0, 1.0), (5.0, 2.0)]);
    let rays = |wanted: f64| {
        results
            .iter()
            .find(|result| bounces(result) == wanted)
            .and_then(|result| result.time.clone())
            .unwrap()
            .rays
    };
    assert!(rays(5.0) > rays(3.0), "each run configuration has its own settings");
    let left = dir.0.folder().read_dir().unwrap().count();
    assert_eq!(left, 0);
}

#[test]
fn a_gather_that_a_runner_lacks_is_skipped_among_others_and_an_error_alone() {
    let dir = BenchDir::new();
    let run = |gather: &str| dir.try_bench(&["--frames", "1", "--gather", gather]);
    let Run { code, stdout, stderr } = run("points-rt,photons-grid");
    assert!(code == Some(0) && stderr.contains("points-rt needs ray queries"), "{stderr}");
    assert!(stdout.contains("basic-none") && !stdout.contains("points_rt"), "{stdout}");
    let Run { code, stderr, .. } = run("points-rt");
    assert!(code == Some(2) && stderr.contains("points-rt"), "{stderr}");
}

#[test]
fn invalid_measurements_are_usage_errors() {
    let dir = BenchDir::new();
    let base = ["bench", "mirror-room", "--runner", "cpu", "-o", "out"];
    let error = ["--measure", "error"];
    for (options, named) in [
        (&[&error[..], &["--seeds", "1"]].concat()[..], "--seeds"),
        (&[&error[..], &["--seed", "1919247973"]].concat(), "seed"),
        (&[&error[..], &["--reference-frames", "0"]].concat(), "--reference-frames"),
        (&["--frames", "0"], "--frames"),
        (&["--frames", "3..3"], "--frames"),
        (&["--fps", "0"], "--fps"),
        (&["--paths-per-pixel", "-1"], "--paths-per-pixel"),
        (&["--paths-per-pixel", "1", "--light-paths", "9"], "--light-paths"),
        (&["--radius-px", "1,0"], "--radius-px"),
        (&["--max-bounces", "5,65"], "--max-bounces"),
        (&["--runner", "cpu,abacus"], "--runner"),
        (&["--moment", "nan"], "moment"),
        (&["--width", "0"], "--width"),
        (&["--history", "nothing"], "--history"),
        (&["--png", "a.png"], "--png"),
        (&["--filter", "atrous"], "--filter is called --denoiser now"),
        (&["--error"], "--measure error"),
        (&["--connections", "power"], "--connections is called --light-sampler now"),
        (&["--tree-quality", "fast"], "--tree-quality is called --bvh-quality now"),
    ] {
        let arguments = [&base, options].concat();
        dir.run(&arguments).expect_refusal(&arguments, 2, &[named]);
    }
    assert!(!dir.path("out").exists());
}
