//! `caustics sweep` from outside: measures, results on disk, shards, and refusals.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use caustics::scene;
use caustics_bench::error::{CAUSTICS_VARIANCE, FLIP, FLIP_CAUSTICS, RELMSE_CAUSTICS};
use caustics_bench::parameter::{HISTORY, METHOD, PATHS_PER_PIXEL};
use caustics_bench::result::RunResult;
use caustics_bench::store;
use caustics_kernels::gather::variant;
use caustics_kernels::history;

use crate::test_dir::{BINARY, Run, TestDir};

/// Tables for tiny images, of time and of error.
const TABLES: &str = "[time]\nwidth = 40\nheight = 24\nframes = 3\nwarm_up = 1\n\
                      [error]\nwidth = 32\nheight = 20\nseeds = 2\nreference_frames = 16\nframes = 3\n";

/// Folder of an experiment whose references are its own.
struct SweepDir(TestDir);

impl SweepDir {
    fn new(experiment: &str) -> SweepDir {
        let dir = SweepDir(TestDir::new());
        dir.write(experiment);
        dir
    }

    fn write(&self, experiment: &str) {
        self.0.write("e.toml", experiment);
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path(name)
    }

    /// Runs `caustics sweep` with its cache in the folder.
    fn run(&self, arguments: &[&str], environment: &[(&str, &str)]) -> Run {
        let mut command = self.0.command(&[&["sweep"], arguments].concat());
        for name in ["SLURM_ARRAY_TASK_ID", "PARALLEL_SEQ"] {
            command.env_remove(name);
        }
        command.envs(environment.iter().copied()).env("CAUSTICS_CACHE", self.path("cache"));
        Run::from_output(command.output().unwrap())
    }

    /// Runs `caustics sweep`, which must succeed.
    #[track_caller]
    fn sweep(&self, arguments: &[&str]) -> Run {
        self.run(arguments, &[]).expect_success(arguments)
    }

    #[track_caller]
    fn refuses(&self, arguments: &[&str], code: i32, words: &[&str]) {
        self.run(arguments, &[]).expect_refusal(arguments, code, words);
    }

    fn results(&self, folder: &str) -> Vec<RunResult> {
        store::read_all(&self.path(folder)).unwrap()
    }
}

/// Files of a folder and their bytes.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let paths = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
    paths.map(|path| (path.clone(), std::fs::read(&path).unwrap())).collect()
}

fn matrix(lines: &str) -> String {
    format!("{TABLES}\n[[matrix]]\nscene = [\"mirror-room\"]\nrunner = [\"cpu\"]\n{lines}\n")
}

#[test]
fn a_dry_run_counts_every_configuration_once_and_measures_nothing() {
    let gathers: Vec<String> = variant::ALL.iter().map(|gather| format!("{:?}", gather.name)).collect();
    let experiment = matrix(&format!(
        "method = [\"basic\", \"path\"]\ngather = [{}]\nhistory = [\"none\", \"paper\"]\npaths_per_pixel = [0.5, 1]\n\
         radius_px = [1, 2]\nmax_bounces = [3, 5]\n\n\
         [[matrix]]\nscene = [\"mirror-room\", \"moving-caster\"]\nrunner = [\"cpu\", \"auto\"]\n\
         method = [\"basic\", \"path\"]\ngather = [\"photons-grid\"]\npaths_per_pixel = [1]\n",
        gathers.join(", ")
    ));
    let dir = SweepDir::new(&experiment);
    let Run { stdout, stderr, .. } = dir.sweep(&["e.toml", "--dry-run"]);
    let software = variant::ALL.iter().filter(|gather| !gather.hardware).count();
    // The path tracer has one configuration for each number of bounces, whatever the gather. The second matrix adds only
    // the scene that moves.
    let still = 2 * (software * 2 * 2 * 2 + 1);
    let lines: Vec<&str> = stdout.lines().filter(|line| line.starts_with("missing")).collect();
    let missing = |scene: &str| lines.iter().filter(|line| line.contains(scene)).count();
    if !stderr.contains("runner auto: there is no Vulkan") && !stderr.contains("runner auto: no Vulkan") {
        eprintln!("skipped: with a GPU, auto is another runner");
        return;
    }
    assert_eq!((missing("mirror-room"), missing("moving-caster")), (still, 2), "{stdout}");
    assert_eq!(lines.iter().collect::<BTreeSet<_>>().len(), lines.len());
    // The still scene has one reference for each number of bounces, the other scene one for each frame.
    let last = stdout.lines().last().unwrap();
    assert_eq!(last, format!("{} run configurations, 0 done; {} references, 0 kept", still + 2, 2 + 3));
    assert!(stderr.contains("points-rt needs ray queries"), "{stderr}");
    assert!(!dir.path("cache").exists());
}

mod long {
    use super::*;

    #[test]
    #[ignore = "makes scenes of a million triangles"]
    fn the_scenes_of_the_experiments_exist() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
        let dir = SweepDir::new("");
        // A dry run reads the experiment's scenes too.
        for name in caustics_scenes::ON_DEMAND {
            caustics_scenes::make(name, &dir.path(scene::MADE), false).unwrap();
        }
        let mut count = 0;
        for entry in folder.read_dir().unwrap() {
            let file = entry.unwrap().path();
            if file.extension().is_some_and(|extension| extension == "toml") {
                let stdout = dir.sweep(&[file.to_str().unwrap(), "--dry-run"]).stdout;
                assert!(stdout.lines().count() > 4, "{}: {stdout}", file.display());
                count += 1;
            }
        }
        assert!(count >= 4, "{count} files in {}", folder.display());
    }
}

#[test]
fn a_finished_sweep_measures_nothing_anew_and_an_unfinished_one_what_is_missing() {
    let dir = SweepDir::new(&matrix("method = [\"basic\"]\npaths_per_pixel = [0.5, 2]\nradius_px = [1]"));
    let stderr = dir.sweep(&["e.toml", "-o", "out"]).stderr;
    assert!(
        stderr.contains("2 run configurations, 2 to measure") && stderr.contains("reference 1 of 1"),
        "{stderr}"
    );
    let whole = bytes(&dir.path("out/cells"));
    let results = dir.results("out");
    for RunResult { identity, config, time, error, .. } in &results {
        let (time, error) = (time.as_ref().unwrap(), error.as_ref().unwrap());
        // Both sizes have the same number of paths a pixel.
        let paths =
            |width: f64, height: f64| (config.number(&PATHS_PER_PIXEL) * width * height).round() as u32;
        assert_eq!((time.light_paths, error.light_paths), (paths(40.0, 24.0), paths(32.0, 20.0)));
        assert!(error.get(&FLIP).unwrap() > 0.0 && error.get(&RELMSE_CAUSTICS).unwrap() > 0.0);
        assert_eq!(time.frames, 3);
        for name in [&error.image, &error.error_map, &error.reference] {
            let png = &whole[&dir.path("out/cells").join(name.as_ref().unwrap())];
            assert!(png.starts_with(b"\x89PNG"), "{identity}");
        }
    }
    // Each run configuration has a JSON, an image and a map; there is one reference.
    assert_eq!(whole.len(), 2 * 3 + 1);
    let table = std::fs::read_to_string(dir.path("out/cells.csv")).unwrap();
    assert_eq!(table.lines().count(), 3);
    assert!(table.contains(&results[0].identity) && table.contains("mirror-room"));

    let stderr = dir.sweep(&["e.toml", "-o", "out"]).stderr;
    assert!(stderr.contains("2 run configurations, 0 to measure"), "{stderr}");
    assert_eq!(bytes(&dir.path("out/cells")), whole);
    let stdout = dir.sweep(&["e.toml", "-o", "out", "--dry-run"]).stdout;
    assert!(stdout.contains("2 run configurations, 2 done; 1 references, 1 kept"), "{stdout}");

    // A result without errors is incomplete: errors are measured, times are kept.
    let part = RunResult { error: None, ..results[0].clone() };
    store::write(&dir.path("out"), &part).unwrap();
    let stderr = dir.sweep(&["e.toml", "-o", "out"]).stderr;
    assert!(stderr.contains("1 to measure") && !stderr.contains("take turns"), "{stderr}");
    let again = &dir.results("out")[0];
    assert_eq!((&again.time, &again.error), (&results[0].time, &results[0].error), "the same bits");

    // Another seed gives another result.
    dir.write(&format!("seed = 5\n{}", std::fs::read_to_string(dir.path("e.toml")).unwrap()));
    let stdout = dir.sweep(&["e.toml", "-o", "out", "--dry-run"]).stdout;
    assert!(stdout.contains("2 run configurations, 0 done; 1 references, 1 kept"), "{stdout}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_keeps_finished_results() {
    let dir = SweepDir::new(
        &matrix("method = [\"basic\"]\npaths_per_pixel = [0.5, 1, 2]")
            .replace("reference_frames = 16", "reference_frames = 100000"),
    );
    let mut child = std::process::Command::new(BINARY)
        .current_dir(dir.0.folder())
        .args(["sweep", "e.toml", "-o", "out"])
        .env("CAUSTICS_CACHE", dir.path("cache"))
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // Times come first, then a reference that never ends.
    let start = std::time::Instant::now();
    while !dir.path("out/cells").exists() || dir.results("out").len() < 3 {
        assert!(start.elapsed() < Duration::from_secs(60), "no time was written");
        std::thread::sleep(Duration::from_millis(20));
    }
    let kill = format!("kill -INT {}", child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let results = dir.results("out");
    assert!(results.iter().all(|result| result.time.is_some() && result.error.is_none()), "{results:?}");
}

#[test]
fn shards_are_disjoint_and_merge_to_the_whole() {
    let lines = "method = [\"basic\", \"path\"]\nhistory = [\"none\", \"paper\"]\npaths_per_pixel = [1, 2]";
    // Measure times only, which takes a second.
    let experiment = matrix(lines).replace("frames = 3\nwarm_up = 1", "frames = 1\nwarm_up = 0");
    let error = experiment.find("[error]").unwrap()..experiment.find("[[matrix]]").unwrap();
    let dir = SweepDir::new(&(experiment[..error.start].to_string() + &experiment[error.end..]));
    let identities = |folder: &str| -> BTreeSet<String> {
        dir.results(folder).into_iter().map(|result| result.identity).collect()
    };
    dir.sweep(&["e.toml", "-o", "whole"]);
    assert_eq!(identities("whole").len(), 2 * 2 + 1);
    dir.sweep(&["e.toml", "-o", "one", "--shard", "1/2"]);
    let slurm =
        [("SLURM_ARRAY_TASK_ID", "9"), ("SLURM_ARRAY_TASK_MIN", "8"), ("SLURM_ARRAY_TASK_COUNT", "2")];
    let Run { code, stderr, .. } = dir.run(&["e.toml", "-o", "two"], &slurm);
    assert!(code == Some(0) && stderr.contains("part 2 of 2"), "{stderr}");
    assert!(identities("one").is_disjoint(&identities("two")));
    // All ratios refer to one run configuration, whichever shard has it.
    let firsts: BTreeSet<String> = ["one", "two"]
        .iter()
        .flat_map(|folder| dir.results(folder))
        .map(|result| result.time.unwrap().first)
        .collect();
    assert_eq!(firsts.len(), 1);
    let stderr = dir.sweep(&["--merge", "one", "two", "-o", "both"]).stderr;
    assert_eq!(identities("both"), identities("whole"), "{stderr}");
    let table = std::fs::read_to_string(dir.path("both/cells.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + identities("whole").len());
    // Both shards may write to one folder.
    for job in ["1", "2"] {
        let arguments = ["e.toml", "-o", "shared", "--shards", "2"];
        dir.run(&arguments, &[("PARALLEL_SEQ", job)]).expect_success(&arguments);
    }
    assert_eq!(identities("shared"), identities("whole"));
    let stderr = dir.sweep(&["--merge", "one", "-o", "both"]).stderr;
    assert!(stderr.contains("one: 0 taken"), "{stderr}");
}

#[test]
fn errors_fall_with_the_paths_and_histories_are_measured_at_their_last_frame() {
    let dir = SweepDir::new(&matrix(&format!(
        "method = [\"basic\"]\ncaustics = [\"any\"]\nemission = [\"power\"]\nhistory = [{}]\npaths_per_pixel = [0.125, 4]",
        history::ALL.iter().map(|history| format!("{:?}", history.name)).collect::<Vec<_>>().join(", ")
    )));
    dir.sweep(&["e.toml", "-o", "out"]);
    let results = dir.results("out");
    let error = |history: &str, paths: f64| {
        let is = |result: &&RunResult| {
            result.config.text(&HISTORY) == history && result.config.number(&PATHS_PER_PIXEL) == paths
        };
        results.iter().find(is).and_then(|result| result.error.clone()).unwrap()
    };
    // 32 times the paths give a 32nd of the variance. The radius leaves a bias, so the test demands a quarter.
    let (few, many) = (error("none", 0.125), error("none", 4.0));
    assert!(
        many.get(&RELMSE_CAUSTICS).unwrap() < few.get(&RELMSE_CAUSTICS).unwrap() / 4.0,
        "{few:?} {many:?}"
    );
    // Use the variance, since FLIP rates missing caustics as a smaller error than speckled ones.
    assert!(many.get(&CAUSTICS_VARIANCE).unwrap() < few.get(&CAUSTICS_VARIANCE).unwrap() / 8.0);
    // The mean of three frames has less noise than one frame.
    let kept = error("validated", 0.125);
    assert!(
        kept.get(&RELMSE_CAUSTICS).unwrap() < 0.8 * few.get(&RELMSE_CAUSTICS).unwrap(),
        "{kept:?} {few:?}"
    );
    // All results share one reference.
    let references: BTreeSet<_> =
        results.iter().map(|result| result.error.clone().unwrap().reference).collect();
    assert_eq!(references.len(), 1);
}

#[test]
fn the_method_of_the_reference_comes_near_it_and_few_paths_do_not() {
    // The reference has 16 frames of 4 paths a pixel. A frame of 64 has as many, with radii that have not shrunk.
    let dir = SweepDir::new(&matrix(
        "method = [\"progressive\", \"path\"]\nemission = [\"power\"]\npaths_per_pixel = [0.125, 64]",
    ));
    dir.sweep(&["e.toml", "-o", "out"]);
    let results = dir.results("out");
    assert_eq!(results.len(), 3, "path tracing shoots no light paths");
    let error = |method: &str, paths: f64| {
        let is = |result: &&RunResult| {
            result.config.text(&METHOD) == method && result.config.number(&PATHS_PER_PIXEL) == paths
        };
        results.iter().find(is).and_then(|result| result.error.clone()).unwrap()
    };
    let (few, own, path) = (error("progressive", 0.125), error("progressive", 64.0), error("path", 0.0));
    // 512 times the paths give a 22nd of the noise. The test demands half of the FLIP, since the radii blur.
    assert!(own.get(&FLIP_CAUSTICS).unwrap() < few.get(&FLIP_CAUSTICS).unwrap() / 2.0, "{own:?} {few:?}");
    assert!(
        path.get(&FLIP).unwrap() > own.get(&FLIP).unwrap(),
        "caustics found at random are noise: {path:?} {own:?}"
    );
    assert_eq!((path.get(&FLIP_CAUSTICS), path.get(&RELMSE_CAUSTICS)), (None, None), "it has no such layer");
}

#[test]
fn scenes_that_move_are_measured_frame_by_frame() {
    let dir = SweepDir::new(
        &matrix("method = [\"basic\"]\npaths_per_pixel = [1]").replace("mirror-room", "moving-caster"),
    );
    dir.sweep(&["e.toml", "-o", "out"]);
    let results = dir.results("out");
    let [RunResult { frames, error, time, .. }] = results.as_slice() else { panic!("{results:?}") };
    assert_eq!(frames.iter().map(|frame| frame.frame).collect::<Vec<_>>(), [0, 1, 2]);
    assert!(frames.iter().all(|frame| frame.total_ms.is_some() && frame.get(&FLIP).is_some()), "{frames:?}");
    let mean = frames.iter().map(|frame| frame.get(&FLIP).unwrap()).sum::<f64>() / 3.0;
    assert!((mean - error.as_ref().unwrap().get(&FLIP).unwrap()).abs() < 1e-12);
    assert_eq!(time.as_ref().unwrap().frames, 3);
}

#[test]
fn errors_name_file_line_and_key() {
    let fine = matrix("method = [\"basic\"]\npaths_per_pixel = [1]");
    for (from, to, named) in [
        ("runner", "runer", &["e.toml", "line 15", "runer"][..]),
        ("\"basic\"", "\"basik\"", &["e.toml", "line 16", "basik", "progressive"]),
        ("[1]", "[-1]", &["e.toml", "line 17", "paths_per_pixel"]),
        ("paths_per_pixel = [1]", "", &["e.toml", "line 13", "light_paths"]),
        ("seeds = 2", "seeds = 0", &["e.toml", "line 9", "seeds"]),
        ("\"mirror-room\"", "\"no-room\"", &["no-room"]),
        ("paths_per_pixel = [1]", "paths_per_pixel = [4000]\nmax_bounces = [64]", &[]),
        ("[1]", "[4000]\n[time]", &["e.toml", "time"]),
    ] {
        assert!(fine.contains(from), "{from}");
        let dir = SweepDir::new(&fine.replacen(from, to, 1));
        let Run { code, stderr, .. } = dir.run(&["e.toml", "--dry-run"], &[]);
        let is_fine = named.is_empty();
        assert_eq!(code, Some(if is_fine { 0 } else { 2 }), "{to}: {stderr}");
        assert!(named.iter().all(|name| stderr.contains(name)), "{to}: {stderr}");
    }
    let dir = SweepDir::new(&fine);
    for (options, named) in [
        (&["e.toml"][..], "--output"),
        (&["-o", "out"], "EXPERIMENT"),
        (&["e.toml", "-o", "out", "--shard", "3/2"], "--shard"),
        (&["e.toml", "-o", "out", "--shards", "2"], "--shard"),
        (&["e.toml", "--merge", "a", "-o", "out"], "--merge"),
    ] {
        dir.refuses(options, 2, &[named]);
    }
    dir.refuses(&["none.toml", "-o", "out"], 1, &[]);
    assert!(!dir.path("out").exists());
}

#[test]
fn a_time_that_cannot_be_met_is_noted_in_the_result() {
    // No machine renders a frame in a microsecond.
    let dir = SweepDir::new(&matrix("method = [\"basic\", \"path\"]\nequal_time_ms = 1e-3"));
    dir.sweep(&["e.toml", "-o", "out"]);
    let results = dir.results("out");
    assert_eq!(results.len(), 2);
    for RunResult { config, time, error, note, .. } in &results {
        assert!(time.is_some() && error.is_some());
        let has_paths = config.text(&METHOD) == "basic";
        // The path tracer has no light paths to search for.
        assert_eq!(
            note.as_ref().is_some_and(|note| note.contains("not met within 2 %")),
            has_paths,
            "{note:?}"
        );
        // The search starts at one path a pixel and goes down; noise of the machine decides which trial was the fastest.
        let max_paths = if has_paths { 1.0 } else { 0.0 };
        assert!(config.number(&PATHS_PER_PIXEL) <= max_paths, "{config:?}");
    }
}

#[test]
fn more_configurations_than_can_be_measured_are_refused_before_they_are_made() {
    let list = |count: usize, value: &str| vec![value; count].join(", ");
    let lines = format!(
        "method = [\"basic\"]\npaths_per_pixel = [{}]\nradius_px = [{}]\nmax_bounces = [{}]",
        list(1000, "1"),
        list(1000, "1"),
        list(1000, "5")
    );
    let dir = SweepDir::new(&matrix(&lines));
    dir.refuses(&["e.toml", "--dry-run"], 2, &["e.toml: line 13", "1000000000 run configurations"]);
}

#[test]
fn a_result_that_names_another_folder_is_not_merged() {
    let dir = SweepDir::new("");
    std::fs::create_dir_all(dir.path("d/cells")).unwrap();
    dir.0.write("precious.json", "precious");
    let result = RunResult { identity: "../../precious".into(), ..RunResult::default() };
    dir.0.write("d/cells/0123456789abcdef.json", serde_json::to_vec(&result).unwrap());
    dir.refuses(&["--merge", "d", "-o", "out"], 1, &["0123456789abcdef.json", "identity"]);
    assert_eq!(std::fs::read(dir.path("precious.json")).unwrap(), b"precious");
}
