//! Shards from outside: four processes, one of which is killed and started again, make what one run makes.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use caustics::image_file::Channels;
use caustics_bench::store;

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--runner", "cpu"];
/// Frames that reuse nothing of each other.
const APART: [&str; 4] = ["--emission", "aimed", "--light-paths", "500"];

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustics"));
    command.current_dir(folder).args(arguments).env("CAUSTICS_CACHE", folder.join("cache"));
    for name in ["SLURM_ARRAY_TASK_ID", "PARALLEL_SEQ"] {
        command.env_remove(name);
    }
    command
}

/// Exit code and stderr.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = command(folder, arguments).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Runs; it must succeed. What it says.
#[track_caller]
fn runs(folder: &Path, arguments: &[&str]) -> String {
    let (code, stderr) = run(folder, arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {stderr}");
    stderr
}

/// Runs; it must refuse, and say these words.
#[track_caller]
fn refuses(folder: &Path, arguments: &[&str], words: &[&str]) {
    let (code, stderr) = run(folder, arguments);
    assert_eq!(code, Some(2), "{arguments:?}: {stderr}");
    assert!(words.iter().all(|word| stderr.contains(word)), "{arguments:?}: {stderr}");
}

/// Runs four shards at a time and kills the third once its first file is there; the arguments and that file are made of the number
/// of a shard. It ends when the other three have ended well.
fn run_three_of_four(folder: &Path, arguments: &dyn Fn(u32) -> Vec<String>, file: &str) {
    let start = |number: u32| -> Child {
        let arguments = arguments(number);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let mut command = command(folder, &arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let mut shards: Vec<Child> = (1..=4).map(start).collect();
    let since = Instant::now();
    while !folder.join(file).exists() {
        assert!(since.elapsed() < Duration::from_secs(100), "there is no {file}");
        std::thread::sleep(Duration::from_millis(1));
    }
    shards[2].kill().unwrap();
    let ended: Vec<bool> = shards.iter_mut().map(|shard| shard.wait().unwrap().success()).collect();
    assert_eq!((ended[0], ended[1], ended[3]), (true, true, true));
}

/// The arguments of a shard.
fn shard_arguments(arguments: &[&str], number: u32) -> Vec<String> {
    let own = ["--shard".to_string(), format!("{number}/4")];
    arguments.iter().map(|argument| argument.to_string()).chain(own).collect()
}

#[track_caller]
fn run_shard(folder: &Path, arguments: &[&str], number: u32) -> String {
    let arguments = shard_arguments(arguments, number);
    runs(folder, &arguments.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Files of a folder and their bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = folder.read_dir().unwrap().map(|entry| entry.unwrap());
    entries
        .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()))
        .collect()
}

/// Whether two images are one to an ulp, variances aside: those are differences of large sums.
#[track_caller]
fn assert_one(whole: &Channels, merged: &Channels) {
    assert!(whole.channels.keys().eq(merged.channels.keys()), "{:?}", merged.channels.keys());
    for (name, values) in &whole.channels {
        for (pixel, (a, b)) in values.iter().zip(&merged.channels[name]).enumerate() {
            let is_one = match name.starts_with("variance") {
                true => (a - b).abs() <= 1e-5 * a.abs(),
                false => a.to_bits().abs_diff(b.to_bits()) <= 1,
            };
            assert!(is_one, "{name} {pixel}: {a} {b}");
        }
    }
    let of_run = |image: &Channels| {
        let mut attributes = image.attributes.clone();
        attributes.retain(|name, _| !["seconds", "crc32"].contains(&name.as_str()));
        attributes
    };
    assert_eq!(of_run(whole), of_run(merged));
}

#[test]
fn shards_of_an_animation_are_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    let frames = |out| {
        [
            &["animate", "moving-caster", "-o", out, "--frames", "2..42", "--history", "none"],
            &TINY[..],
            &APART,
        ]
        .concat()
    };
    runs(folder.path(), &frames("whole/##.exr"));
    let parts = frames("parts/##.exr");
    run_three_of_four(folder.path(), &|number| shard_arguments(&parts, number), "parts/22.exr");
    let messages = run_shard(folder.path(), &parts, 3);
    assert!(!messages.contains("warning"), "{messages}");
    let messages = runs(folder.path(), &parts);
    assert!(messages.contains("all 40 frames are there"), "{messages}");
    assert!(files(&folder.path().join("parts")) == files(&folder.path().join("whole")));
    // PNGs have the exposure of the first frame, whoever renders it.
    let messages = run_shard(folder.path(), &[&parts[..], &["--png"]].concat(), 2);
    assert!(messages.contains("the same command without --shard"), "{messages}");
    assert!(!folder.path().join("parts/12.png").exists());
}

#[test]
fn shards_that_lend_from_frame_to_frame_are_runs_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let frames = [&["animate", "moving-caster", "-o", "f/#.exr", "--frames", "0..4"], &TINY[..]].concat();
    let messages = run_shard(folder.path(), &frames, 2);
    for option in
        ["--history validated", "--path-history validated", "--emission guided", "--light-paths auto"]
    {
        assert!(messages.contains(option), "{messages}");
    }
    assert!(messages.contains("is a run of its own from frame 1 on"), "{messages}");
    refuses(folder.path(), &frames, &["first_frame", "\"1\", not \"0\""]);
    // Two at once have a state each, and go on by it.
    run_shard(folder.path(), &frames, 1);
    assert!(run_shard(folder.path(), &frames, 2).contains("all 1 frames are there"));
    let mean = [&["render", "mirror-room", "-o", "a.exr", "--frames", "8"], &TINY[..]].concat();
    let messages = run_shard(folder.path(), &mean, 2);
    assert!(messages.contains("--emission guided and --light-paths auto reuse earlier frames"), "{messages}");
}

#[test]
fn shards_of_a_reference_merge_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let samples = |out| [&["reference", "mirror-room", "-o", out, "--spp", "401"], &TINY[..]].concat();
    runs(folder.path(), &samples("whole.exr"));
    let parts = samples("part.exr");
    let third = "part.shard-3-of-4.sums";
    // The one that is killed keeps every frame.
    let often = [&parts[..], &["--checkpoint-every", "0"]].concat();
    run_three_of_four(
        folder.path(),
        &|number| shard_arguments(if number == 3 { &often } else { &parts }, number),
        third,
    );
    let sums: Vec<String> = (1..=4).map(|number| format!("part.shard-{number}-of-4.sums")).collect();
    let merge = |sums: &[&String]| -> Vec<String> {
        let words = ["merge", "-o", "part.exr"].map(str::to_string);
        words.into_iter().chain(sums.iter().map(|name| name.to_string())).collect()
    };
    let merges = |names: &[&String]| {
        let arguments = merge(names);
        run(folder.path(), &arguments.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let (code, messages) = merges(&[&sums[0], &sums[2], &sums[3]]);
    assert!(code == Some(2) && messages.contains("shards 2,3 of 4 are missing or not done"), "{messages}");
    refuses(folder.path(), &[&parts[..], &["--shard", "3/4", "--seed", "1"]].concat(), &[third, "seed"]);
    run_shard(folder.path(), &parts, 3);
    let (code, messages) = merges(&[&sums[0], &sums[1], &sums[1], &sums[3]]);
    assert!(code == Some(2) && messages.contains("are both shard 2/4"), "{messages}");
    // In any order.
    let (code, messages) = merges(&[&sums[3], &sums[1], &sums[0], &sums[2]]);
    assert!(code == Some(0) && messages.contains("the mean of 401 frames from 4 shards"), "{messages}");
    let [whole, merged] =
        ["whole.exr", "part.exr"].map(|name| Channels::read(&folder.path().join(name)).unwrap());
    assert_one(&whole, &merged);
    // What is there is not rendered again.
    let messages = run_shard(folder.path(), &parts, 1);
    assert!(messages.contains("0 frames rendered"), "{messages}");

    refuses(folder.path(), &["merge", "-o", "x.exr", &sums[0], "whole.exr"], &["alone"]);
    for (options, word) in [
        (&["reference", "ring", "-o", "x.exr", "--seconds", "1"][..], "--spp"),
        (&["reference", "ring", "-o", "x.exr", "--spp", "3"], "at most 3 shards"),
        (&["render", "ring", "-o", "x.exr", "--preset", "final"], "--frames"),
        (&["render", "ring", "-o", "x.exr", "--frames", "8", "--png", "x.png"], "--png"),
    ] {
        refuses(folder.path(), &[options, &["--shard", "2/4"], &TINY].concat(), &[word]);
    }
}

#[test]
fn shards_of_a_mean_have_all_its_layers() {
    let folder = tempfile::tempdir().unwrap();
    let mean = |out| {
        let frames = ["render", "mirror-room", "-o", out, "--method", "progressive", "--frames", "11"];
        [&frames[..], &["--aov", "material,normal"], &TINY, &APART].concat()
    };
    runs(folder.path(), &mean("whole.exr"));
    for number in 1..=4 {
        run_shard(folder.path(), &mean("part.exr"), number);
    }
    let sums = [1, 2, 3, 4].map(|number| format!("part.shard-{number}-of-4.sums"));
    let merge = ["merge", "-o", "part.exr", &sums[0], &sums[1], &sums[2], &sums[3]];
    runs(folder.path(), &merge);
    let [whole, merged] =
        ["whole.exr", "part.exr"].map(|name| Channels::read(&folder.path().join(name)).unwrap());
    assert_one(&whole, &merged);
    assert!(whole.channels.contains_key("material.V") && whole.channels.contains_key("caustics.R"));
}

#[test]
fn shards_of_a_sweep_merge_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let experiment = "[error]\nwidth = 16\nheight = 10\nseeds = 1\nreference_frames = 2\n\n[[matrix]]\n\
        scene = [\"mirror-room\"]\nrunner = [\"cpu\"]\nmethod = [\"basic\"]\nemission = [\"power\", \"aimed\"]\n\
        paths_per_pixel = [1, 2, 4, 8]\n";
    std::fs::write(folder.path().join("e.toml"), experiment).unwrap();
    runs(folder.path(), &["sweep", "e.toml", "-o", "whole"]);
    let out = |number: u32| format!("part-{number}");
    let shard = |number: u32| shard_arguments(&["sweep", "e.toml", "-o", &out(number)], number);
    run_three_of_four(folder.path(), &shard, "part-3/experiment.toml");
    let again = shard(3);
    runs(folder.path(), &again.iter().map(String::as_str).collect::<Vec<_>>());
    runs(folder.path(), &["sweep", "--merge", "part-1", "part-2", "part-3", "part-4", "-o", "merged"]);
    let errors = |name: &str| -> Vec<_> {
        let results = store::read_all(&folder.path().join(name)).unwrap().into_iter();
        results.map(|result| (result.identity, result.error)).collect()
    };
    assert_eq!(errors("whole").len(), 8);
    assert_eq!(errors("whole"), errors("merged"));
}
