//! Shards from outside: four processes, one of which is killed and restarted, give the result of one run.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use caustics::image_file::Channels;
use caustics_bench::store;

use crate::test_dir::{BINARY, Run, TestDir};

const TINY: [&str; 6] = ["--width", "32", "--height", "18", "--runner", "cpu"];
/// Options of frames that reuse nothing.
const APART: [&str; 6] = ["--emission", "aimed", "--light-paths", "500", "--indirect-end", "path"];

fn command(dir: &TestDir, arguments: &[&str]) -> Command {
    let mut command = Command::new(BINARY);
    command.current_dir(dir.folder()).args(arguments).env("CAUSTICS_CACHE", dir.path("cache"));
    for name in ["SLURM_ARRAY_TASK_ID", "PARALLEL_SEQ"] {
        command.env_remove(name);
    }
    command
}

fn run(dir: &TestDir, arguments: &[&str]) -> Run {
    Run::from_output(command(dir, arguments).output().unwrap())
}

/// Returns stderr of a run, which must succeed.
#[track_caller]
fn runs(dir: &TestDir, arguments: &[&str]) -> String {
    run(dir, arguments).expect_success(arguments).stderr
}

#[track_caller]
fn refuses(dir: &TestDir, arguments: &[&str], words: &[&str]) {
    run(dir, arguments).expect_refusal(arguments, 2, words);
}

/// Runs four shards at once and kills the third when its first file exists. Arguments and file depend on the number of the
/// shard. Returns when the other three have succeeded.
fn run_three_of_four(dir: &TestDir, arguments: &dyn Fn(u32) -> Vec<String>, file: &str) {
    let start = |number: u32| -> Child {
        let arguments = arguments(number);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let mut command = command(dir, &arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let mut shards: Vec<Child> = (1..=4).map(start).collect();
    let since = Instant::now();
    while !dir.path(file).exists() {
        assert!(since.elapsed() < Duration::from_secs(100), "there is no {file}");
        std::thread::sleep(Duration::from_millis(1));
    }
    shards[2].kill().unwrap();
    let ended: Vec<bool> = shards.iter_mut().map(|shard| shard.wait().unwrap().success()).collect();
    assert_eq!((ended[0], ended[1], ended[3]), (true, true, true));
}

/// Arguments of a shard.
fn shard_arguments(arguments: &[&str], number: u32) -> Vec<String> {
    let own = ["--shard".to_string(), format!("{number}/4")];
    arguments.iter().map(|argument| argument.to_string()).chain(own).collect()
}

#[track_caller]
fn run_shard(dir: &TestDir, arguments: &[&str], number: u32) -> String {
    let arguments = shard_arguments(arguments, number);
    runs(dir, &arguments.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Files of a folder and their bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = folder.read_dir().unwrap().map(|entry| entry.unwrap());
    entries
        .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()))
        .collect()
}

/// Asserts that two images agree to an ulp, except for variances, which are differences of large sums.
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
    let dir = TestDir::new();
    let frames = |out| {
        [
            &["animate", "moving-caster", "-o", out, "--frames", "2..42", "--history", "none"],
            &TINY[..],
            &APART,
        ]
        .concat()
    };
    runs(&dir, &frames("whole/##.exr"));
    let parts = frames("parts/##.exr");
    run_three_of_four(&dir, &|number| shard_arguments(&parts, number), "parts/22.exr");
    let messages = run_shard(&dir, &parts, 3);
    assert!(!messages.contains("warning"), "{messages}");
    let messages = runs(&dir, &parts);
    assert!(messages.contains("all 40 frames are there"), "{messages}");
    assert!(files(&dir.path("parts")) == files(&dir.path("whole")));
    // PNGs need the exposure of the first frame, which may be another shard's.
    let messages = run_shard(&dir, &[&parts[..], &["--png"]].concat(), 2);
    assert!(messages.contains("the same command without --shard"), "{messages}");
    assert!(!dir.path("parts/12.png").exists());
}

#[test]
fn shards_with_a_history_are_runs_of_their_own() {
    let dir = TestDir::new();
    let frames = [&["animate", "moving-caster", "-o", "f/#.exr", "--frames", "0..4"], &TINY[..]].concat();
    let messages = run_shard(&dir, &frames, 2);
    for option in
        ["--history validated", "--path-history validated", "--emission guided", "--light-paths auto"]
    {
        assert!(messages.contains(option), "{messages}");
    }
    assert!(messages.contains("is a run of its own from frame 1 on"), "{messages}");
    refuses(&dir, &frames, &["first_frame", "\"1\", not \"0\""]);
    // Two concurrent shards have separate states, and resume from them.
    run_shard(&dir, &frames, 1);
    assert!(run_shard(&dir, &frames, 2).contains("all 1 frames are there"));
    let mean = [&["render", "mirror-room", "-o", "a.exr", "--frames", "8"], &TINY[..]].concat();
    let messages = run_shard(&dir, &mean, 2);
    assert!(messages.contains("--emission guided and --light-paths auto reuse earlier frames"), "{messages}");
}

#[test]
fn shards_of_a_reference_merge_to_it() {
    let dir = TestDir::new();
    let samples = |out| [&["reference", "mirror-room", "-o", out, "--spp", "401"], &TINY[..]].concat();
    runs(&dir, &samples("whole.exr"));
    let parts = samples("part.exr");
    let third = "part.shard-3-of-4.sums";
    // The killed shard saves every frame.
    let often = [&parts[..], &["--checkpoint-every", "0"]].concat();
    run_three_of_four(
        &dir,
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
        run(&dir, &arguments.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let Run { code, stderr: messages, .. } = merges(&[&sums[0], &sums[2], &sums[3]]);
    assert!(code == Some(2) && messages.contains("shards 2,3 of 4 are missing or not done"), "{messages}");
    refuses(&dir, &[&parts[..], &["--shard", "3/4", "--seed", "1"]].concat(), &[third, "seed"]);
    run_shard(&dir, &parts, 3);
    let Run { code, stderr: messages, .. } = merges(&[&sums[0], &sums[1], &sums[1], &sums[3]]);
    assert!(code == Some(2) && messages.contains("are both shard 2/4"), "{messages}");
    // The order of the inputs does not matter.
    let Run { code, stderr: messages, .. } = merges(&[&sums[3], &sums[1], &sums[0], &sums[2]]);
    assert!(code == Some(0) && messages.contains("the mean of 401 frames from 4 shards"), "{messages}");
    let [whole, merged] = ["whole.exr", "part.exr"].map(|name| Channels::read(&dir.path(name)).unwrap());
    assert_one(&whole, &merged);
    // Finished frames are not rendered again.
    let messages = run_shard(&dir, &parts, 1);
    assert!(messages.contains("0 frames rendered"), "{messages}");

    refuses(&dir, &["merge", "-o", "x.exr", &sums[0], "whole.exr"], &["alone"]);
    for (options, word) in [
        (&["reference", "ring", "-o", "x.exr", "--seconds", "1"][..], "--spp"),
        (&["reference", "ring", "-o", "x.exr", "--spp", "3"], "at most 3 shards"),
        (&["render", "ring", "-o", "x.exr", "--preset", "final"], "--frames"),
        (&["render", "ring", "-o", "x.exr", "--frames", "8", "--png", "x.png"], "--png"),
    ] {
        refuses(&dir, &[options, &["--shard", "2/4"], &TINY].concat(), &[word]);
    }
}

#[test]
fn shards_of_a_mean_have_all_its_layers() {
    let dir = TestDir::new();
    let mean = |out| {
        let frames = ["render", "mirror-room", "-o", out, "--method", "progressive", "--frames", "11"];
        [&frames[..], &["--aov", "material,normal"], &TINY, &APART].concat()
    };
    runs(&dir, &mean("whole.exr"));
    for number in 1..=4 {
        run_shard(&dir, &mean("part.exr"), number);
    }
    let sums = [1, 2, 3, 4].map(|number| format!("part.shard-{number}-of-4.sums"));
    let merge = ["merge", "-o", "part.exr", &sums[0], &sums[1], &sums[2], &sums[3]];
    runs(&dir, &merge);
    let [whole, merged] = ["whole.exr", "part.exr"].map(|name| Channels::read(&dir.path(name)).unwrap());
    assert_one(&whole, &merged);
    assert!(whole.channels.contains_key("material.V") && whole.channels.contains_key("caustics.R"));
}

#[test]
fn shards_of_a_sweep_merge_to_it() {
    let dir = TestDir::new();
    let experiment = "[error]\nwidth = 16\nheight = 10\nseeds = 1\nreference_frames = 2\n\n[[matrix]]\n\
        scene = [\"mirror-room\"]\nrunner = [\"cpu\"]\nmethod = [\"basic\"]\nemission = [\"power\", \"aimed\"]\n\
        paths_per_pixel = [1, 2, 4, 8]\n";
    dir.write("e.toml", experiment);
    runs(&dir, &["sweep", "e.toml", "-o", "whole"]);
    let out = |number: u32| format!("part-{number}");
    let shard = |number: u32| shard_arguments(&["sweep", "e.toml", "-o", &out(number)], number);
    run_three_of_four(&dir, &shard, "part-3/experiment.toml");
    let again = shard(3);
    runs(&dir, &again.iter().map(String::as_str).collect::<Vec<_>>());
    runs(&dir, &["sweep", "--merge", "part-1", "part-2", "part-3", "part-4", "-o", "merged"]);
    let errors = |name: &str| -> Vec<_> {
        let results = store::read_all(&dir.path(name)).unwrap().into_iter();
        results.map(|result| (result.identity, result.error)).collect()
    };
    assert_eq!(errors("whole").len(), 8);
    assert_eq!(errors("whole"), errors("merged"));
}
