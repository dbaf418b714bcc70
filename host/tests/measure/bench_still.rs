//! `caustics bench` without `--animation` from outside: cells, their table, and the files of `-o`.

use std::path::Path;
use std::time::Duration;

use assert_cmd::Command;
use caustics::experiment::result::CellResult;
use caustics::experiment::row::decode;
use caustics::experiment::store;

const TINY: [&str; 6] = ["--width", "40", "--height", "24", "--paths-per-pixel", "2"];

/// Exit code, stdout, stderr.
fn bench(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustics"));
    command.current_dir(folder).timeout(Duration::from_secs(120)).args(["bench", "mirror-room"]);
    let output = command.args(TINY).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn cells_are_measured_in_turns_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let run = [
        "--runner",
        "cpu",
        "--method",
        "basic,path",
        "--gather",
        "photons-grid,brute",
        "--features",
        "scene,all",
    ];
    let (code, stdout, stderr) = bench(folder.path(), &[&run[..], &["--frames", "5", "-o", "out"]].concat());
    assert_eq!(code, 0, "{stderr}");
    let out = folder.path().join("out");
    let results = store::read_all(&out).unwrap();
    // Two gathers and the path tracer, which has none, with either code.
    assert_eq!(results.len(), 2 * (2 + 1));
    for CellResult { identity, cell, time, provenance, .. } in &results {
        let time = time.as_ref().unwrap();
        for of in time.pass_ms.values().chain([&time.total_ms]) {
            assert!(of.lower <= of.median && of.median <= of.upper, "{identity}: {of:?}");
        }
        assert_eq!((time.width, time.height, time.frames), (40, 24, 5));
        assert_eq!(time.first, "basic-none-photons-grid-scene");
        let has_gather = cell.method == "basic";
        assert_eq!(cell.gather.is_empty(), !has_gather);
        assert_eq!(time.light_paths, if has_gather { 1920 } else { 0 });
        assert_eq!((time.points_per_s.is_some(), time.light_paths_per_s.is_some()), (has_gather, has_gather));
        let sum: f64 = time.pass_ms.values().map(|of| of.lower).sum();
        assert!(sum <= time.total_ms.upper, "{identity}: passes are parts of the frame");
        assert!(time.rays > 960.0 && time.rays_per_s > 1e4, "{time:?}");
        assert_eq!(time.memory_bytes["display_color"], 40 * 24 * 12);
        assert!(provenance.device.starts_with("CPU") && provenance.unix_s > 1_700_000_000);
    }
    let first =
        results.iter().find(|of| of.cell.gather == "photons-grid" && of.cell.features == "scene").unwrap();
    assert_eq!(first.time.as_ref().unwrap().ratio_to_first, Some(1.0));
    assert!(stdout.contains("path-none-all") && stdout.contains(" gather.brute"), "{stdout}");

    // Each of five frames of each of six cells, the first turns rotating.
    let rows = decode(&std::fs::read(out.join("frames.csv")).unwrap()).unwrap();
    assert_eq!(rows.len(), 5 * 6);
    let firsts: Vec<&str> =
        rows.iter().filter(|row| row.get("turn") == Some(0.0)).map(|row| row.cell.as_str()).collect();
    assert!(firsts.len() == 5 && firsts.windows(2).all(|pair| pair[0] != pair[1]), "{firsts:?}");
    let passes = std::fs::read_to_string(out.join("passes.csv")).unwrap();
    let expected: usize = results.iter().map(|of| of.time.as_ref().unwrap().pass_ms.len()).sum();
    assert_eq!(passes.lines().count(), 1 + expected);

    let (code, _, stderr) = bench(folder.path(), &["--runner", "cpu", "-o", "out"]);
    assert!(code == 2 && stderr.contains("--force"), "{stderr}");
    let another = "00000000000000aa";
    // By force: the cells of the run before are gone, those of others are not.
    store::write(&out, &CellResult { identity: another.into(), ..CellResult::default() }).unwrap();
    let (code, _, stderr) =
        bench(folder.path(), &["--runner", "cpu", "-o", "out", "--frames", "1", "--force"]);
    assert_eq!(code, 0, "{stderr}");
    let left: Vec<String> = store::read_all(&out).unwrap().into_iter().map(|of| of.identity).collect();
    assert!(left.len() == 2 && left.contains(&another.into()), "{left:?}");
}

#[test]
fn without_a_folder_there_is_a_table_only() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["--runner", "cpu", "--frames", "2", "--radius-px", "1,2", "--max-bounces", "3,5", "--json"];
    let (code, stdout, stderr) = bench(folder.path(), &run);
    assert_eq!(code, 0, "{stderr}");
    let results: Vec<CellResult> = serde_json::from_str(&stdout).unwrap();
    let mut settings: Vec<_> = results.iter().map(|of| (of.cell.max_bounces, of.cell.radius_px)).collect();
    settings.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(settings, [(3, 1.0), (3, 2.0), (5, 1.0), (5, 2.0)]);
    let rays = |bounces| {
        results.iter().find(|of| of.cell.max_bounces == bounces).and_then(|of| of.time.clone()).unwrap().rays
    };
    assert!(rays(5) > rays(3), "each cell has its own settings");
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[test]
fn a_gather_that_a_runner_lacks_is_skipped_among_others_and_an_error_alone() {
    let folder = tempfile::tempdir().unwrap();
    let run = |gather: &str| bench(folder.path(), &["--runner", "cpu", "--frames", "1", "--gather", gather]);
    let (code, stdout, stderr) = run("points-rt,photons-grid");
    assert!(code == 0 && stderr.contains("points-rt needs ray queries"), "{stderr}");
    assert!(stdout.contains("basic-none") && !stdout.contains("points_rt"), "{stdout}");
    let (code, _, stderr) = run("points-rt");
    assert!(code == 2 && stderr.contains("points-rt"), "{stderr}");
}

#[test]
fn what_cannot_be_measured_is_a_usage_error() {
    let folder = tempfile::tempdir().unwrap();
    for (options, named) in [
        (&["--frames", "0"][..], "--frames"),
        (&["--light-paths", "9"], "--paths-per-pixel"),
        (&["--radius-px", "1,0"], "--radius-px"),
        (&["--max-bounces", "5,65"], "--max-bounces"),
        (&["--runner", "cpu,abacus"], "--runner"),
        (&["--error"], "--animation"),
        (&["--time-s", "nan"], "--time-s"),
    ] {
        let (code, _, stderr) = bench(folder.path(), &[options, &["-o", "out"]].concat());
        assert!(code == 2 && stderr.contains(named), "{options:?}: {code} {stderr}");
    }
    assert!(!folder.path().join("out/frames.csv").exists());
}
