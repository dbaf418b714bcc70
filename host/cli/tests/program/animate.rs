//! `caustics animate` from outside: one file per frame, and runs that resume to the same bytes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant, SystemTime};

use assert_cmd::Command;
use caustics::image_file::Channels;
use caustics::sealed;
use serde_json::Value;

use crate::test_dir::{BINARY, Run, TestDir};

const TINY: [&str; 8] = ["--width", "32", "--height", "18", "--light-paths", "500", "--runner", "cpu"];

/// Arguments of a tiny animation.
fn arguments<'a>(scene: &'a str, options: &[&'a str]) -> Vec<&'a str> {
    [&["animate", scene, "-o", "f/##.exr"], &TINY[..], options].concat()
}

/// Folder of an animation.
struct AnimationDir(TestDir);

impl AnimationDir {
    fn new() -> AnimationDir {
        AnimationDir(TestDir::new())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path(name)
    }

    fn command(&self, scene: &str, options: &[&str]) -> Command {
        self.0.command(&arguments(scene, options))
    }

    fn run(&self, scene: &str, options: &[&str]) -> Run {
        self.0.run(&arguments(scene, options))
    }

    /// Returns stderr of a run, which must succeed.
    #[track_caller]
    fn animate(&self, scene: &str, options: &[&str]) -> String {
        self.0.succeeds(&arguments(scene, options)).stderr
    }

    /// Returns the summary of a run, which must succeed.
    #[track_caller]
    fn report(&self, scene: &str, options: &[&str]) -> Value {
        self.0.succeeds(&arguments(scene, &[options, &["--json"]].concat())).json()
    }

    #[track_caller]
    fn refuses(&self, scene: &str, options: &[&str], words: &[&str]) {
        self.0.refuses(&arguments(scene, options), 2, words);
    }

    /// Files of the animation by name.
    fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = self.path("f").read_dir().unwrap().map(|entry| entry.unwrap());
        entries
            .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()))
            .collect()
    }

    fn names(&self) -> Vec<String> {
        self.files().into_keys().collect()
    }

    fn remove(&self, names: &[&str]) {
        for name in names {
            std::fs::remove_file(self.path("f").join(name)).unwrap();
        }
    }
}

/// Indices of a report's rendered frames, and whether they were written.
fn rendered(report: &Value) -> Vec<(u64, bool)> {
    let frames = report["frames"].as_array().unwrap().iter();
    frames.map(|frame| (frame["frame"].as_u64().unwrap(), frame["written"].as_bool().unwrap())).collect()
}

fn modified(path: &Path) -> SystemTime {
    path.metadata().unwrap().modified().unwrap()
}

#[track_caller]
fn assert_same(a: &AnimationDir, b: &AnimationDir) {
    assert_eq!(a.names(), b.names());
    let (a, b) = (a.files(), b.files());
    let differ: Vec<_> = a.keys().filter(|name| a[*name] != b[*name]).collect();
    assert!(differ.is_empty(), "{differ:?}");
}

#[test]
fn every_frame_is_a_file_of_its_time() {
    let dir = AnimationDir::new();
    // The animation has two seconds of two frames each.
    let report = dir.report("animated-light", &["--fps", "2"]);
    assert_eq!(dir.names(), ["00.exr", "01.exr", "02.exr", "03.exr"]);
    assert_eq!(rendered(&report), [(0, true), (1, true), (2, true), (3, true)]);
    assert_eq!((&report["history"], &report["fps"]), (&"validated".into(), &2.0.into()));
    let times: Vec<_> = report["frames"].as_array().unwrap().iter().map(|frame| &frame["time_s"]).collect();
    assert_eq!(times, [0.0, 0.5, 1.0, 1.5]);
    assert!(report["frames"][1]["pass_ms"]["reuse.validated"].as_f64().unwrap() > 0.0);
    assert_eq!(report["frames"][1]["counters"]["light_paths"], 500);
    for frame in 0..4u32 {
        let image = Channels::read(&dir.path(&format!("f/0{frame}.exr"))).unwrap();
        assert_eq!(image.attributes["frame"], frame.to_string());
        assert_eq!(image.attributes["time_s"], (f64::from(frame) / 2.0).to_string());
    }

    // Without history, the first frame equals `render` at that time, except for the random numbers of frame 0.
    let still = AnimationDir::new();
    still.animate("animated-light", &["--frames", "0..1", "--fps", "1", "--history", "none"]);
    let render = ["render", "animated-light", "-o", "r.exr", "--preset", "frame"];
    still.0.succeeds(&[&render[..], &TINY].concat());
    let ours = Channels::read(&still.path("f/00.exr")).unwrap().channels;
    assert_eq!(ours, Channels::read(&still.path("r.exr")).unwrap().channels);

    // The camera is at rest, so only the light differs: equal random numbers tell the two times apart.
    let later = AnimationDir::new();
    later.animate("animated-light", &["--frames", "1..2", "--fps", "1", "--history", "none"]);
    let sooner = AnimationDir::new();
    sooner.animate("animated-light", &["--frames", "1..2", "--fps", "1000", "--history", "none"]);
    let layer = |dir: &AnimationDir| Channels::read(&dir.path("f/01.exr")).unwrap().channels;
    let (later, sooner) = (layer(&later), layer(&sooner));
    assert_eq!(later["points.depth"], sooner["points.depth"]);
    assert_ne!(later["path.G"], sooner["path.G"]);
}

#[test]
fn a_second_run_renders_nothing() {
    let dir = AnimationDir::new();
    dir.animate("animated-light", &["--frames", "0..3"]);
    let before = ["00", "01", "02"].map(|name| modified(&dir.path(&format!("f/{name}.exr"))));
    let again = dir.animate("animated-light", &["--frames", "0..3"]);
    assert!(again.contains("all 3 frames are there; nothing to render"), "{again}");
    let after = ["00", "01", "02"].map(|name| modified(&dir.path(&format!("f/{name}.exr"))));
    assert_eq!(before, after);
    dir.animate("animated-light", &["--frames", "0..3", "--force"]);
    assert!(modified(&dir.path("f/00.exr")) > before[0]);
}

#[test]
fn missing_frames_come_back_to_the_same_bytes() {
    let configurations =
        [("validated", "power", 8), ("paper", "aimed", 8), ("none", "power", 3), ("none", "guided", 8)];
    for (history, emission, again) in configurations {
        let options = ["--frames", "0..8", "--history", history, "--emission", emission];
        let (whole, dir) = (AnimationDir::new(), AnimationDir::new());
        whole.animate("moving-caster", &options);
        dir.animate("moving-caster", &options);
        assert_same(&dir, &whole);
        dir.remove(&["03.exr", "06.exr", "07.exr"]);
        let report = dir.report("moving-caster", &options);
        assert_eq!(report["kept"], 5);
        let frames = rendered(&report);
        assert_eq!(
            frames.len(),
            again,
            "{history}, {emission}: what something goes through is rendered again"
        );
        let written: Vec<_> =
            frames.iter().filter(|(_, written)| *written).map(|(frame, _)| *frame).collect();
        assert_eq!(written, [3, 6, 7]);
        assert_same(&dir, &whole);
    }
}

#[test]
fn a_longer_run_goes_on_from_a_shorter_one() {
    let (whole, dir) = (AnimationDir::new(), AnimationDir::new());
    whole.animate("animated-camera", &["--frames", "0..6"]);
    dir.animate("animated-camera", &["--frames", "0..3"]);
    dir.animate("animated-camera", &["--frames", "0..6", "--threads", "1"]);
    assert_same(&dir, &whole);
    // Reused light is visible: without the frames before it, the frame differs.
    let short = AnimationDir::new();
    short.animate("animated-camera", &["--frames", "5..6"]);
    assert_ne!(short.files()["05.exr"], whole.files()["05.exr"]);
}

/// Starts an endless run and ends it by a signal once it has some frames. Returns its exit code.
#[cfg(unix)]
fn end_early(dir: &AnimationDir, scene: &str, options: &[&str], signal: &str) -> Option<i32> {
    let mut child = std::process::Command::new(BINARY)
        .current_dir(dir.0.folder())
        .args(["animate", scene, "-o", "f/##.exr", "--frames", "0..100000"])
        .args(TINY)
        .args(options)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !dir.path("f/04.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(100), "there are no frames");
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = format!("kill -{signal} {}", child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    child.wait().unwrap().code()
}

#[cfg(unix)]
#[test]
fn an_interrupted_or_killed_run_goes_on_from_its_state() {
    let cases: [(&str, &[&str], &str, Option<i32>); 3] = [
        ("moving-caster", &[], "INT", Some(130)),
        ("animated-camera", &["--history", "paper"], "INT", Some(130)),
        ("animated-camera", &["--checkpoint-every", "0"], "KILL", None),
    ];
    for (scene, options, signal, code) in cases {
        let dir = AnimationDir::new();
        assert_eq!(end_early(&dir, scene, options, signal), code);
        assert!(dir.path("f/animation.state").exists());
        let done = dir.names().iter().filter(|name| name.ends_with(".exr") && !name.starts_with('.')).count();
        dir.refuses(
            scene,
            &[options, &["--frames", "0..100000", "--max-bounces", "4"]].concat(),
            &["max_bounces"],
        );

        // Remove one finished frame too: the state is of a later frame, or the frame is rendered again.
        let range = format!("0..{}", done + 2);
        let options = [options, &["--frames", &range]].concat();
        let report = dir.report(scene, &options);
        let frames = rendered(&report);
        assert!(frames[0].0 + 2 > done as u64 && frames.len() <= 4, "{scene}: {frames:?} of {done}");
        assert!(!dir.path("f/animation.state").exists());
        // A killed run leaves no partial file.
        assert!(dir.names().iter().all(|name| !name.starts_with('.')), "{:?}", dir.names());
        let whole = AnimationDir::new();
        whole.animate(scene, &options);
        assert_same(&dir, &whole);
    }
}

#[cfg(unix)]
#[test]
fn a_state_helps_only_frames_behind_it_and_of_its_run() {
    let scene = "moving-caster";
    let (dir, whole) = (AnimationDir::new(), AnimationDir::new());
    assert_eq!(end_early(&dir, scene, &[], "INT"), Some(130));
    let state = dir.files()["animation.state"].clone();
    // A file with a right checksum and invalid numbers.
    let (head, payload) = sealed::open::<Value>("animation", &state).unwrap();
    let crafted = vec![0xff; payload.len()];
    let crafted = sealed::seal("animation", &head, |bytes| bytes.extend(crafted)).unwrap();
    dir.0.write("f/animation.state", crafted);
    let more = format!("0..{}", dir.names().len() + 1);
    let words = ["animation.state", "is damaged", "not finite", "remove it"];
    dir.refuses(scene, &["--frames", &more], &words);
    dir.0.write("f/animation.state", &state);
    // The state holds light of frames after the missing one.
    let range = format!("0..{}", dir.names().len() - 1);
    dir.remove(&["02.exr"]);
    let report = dir.report(scene, &["--frames", &range]);
    assert_eq!(rendered(&report), [(0, false), (1, false), (2, true)]);
    whole.animate(scene, &["--frames", &range]);
    std::fs::remove_file(dir.path("f/animation.state")).unwrap_or_default();
    assert_same(&dir, &whole);

    // Without frames, the state alone shows the difference.
    for name in dir.names() {
        dir.remove(&[&name]);
    }
    let mut flipped = state.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    dir.0.write("f/animation.state", &flipped);
    dir.refuses(scene, &["--frames", "0..2"], &["animation.state", "is damaged", "remove it"]);
    dir.0.write("f/animation.state", &state);
    dir.refuses(scene, &["--frames", "0..2", "--seed", "1"], &["animation.state", "seed", "--force"]);
    assert_eq!(dir.names(), ["animation.state"]);
    dir.animate(scene, &["--frames", "0..2", "--seed", "1", "--force"]);
    assert_eq!(dir.names(), ["00.exr", "01.exr"]);
}

/// Histories are the default of `animate`: an option that does not go with them is not dropped.
#[test]
fn options_that_do_not_go_with_a_history_are_refused() {
    let dir = AnimationDir::new();
    for (options, words) in [
        (&["--indirect-share", "points"][..], ["--indirect-share points", "--path-history none"]),
        (&["--indirect-end", "cache"], ["--indirect-end cache", "--path-history none"]),
        (&["--collection-points", "4"], ["--collection-points 4", "--history none"]),
        (&["--caustics", "any", "--thin-walls", "event"], ["--thin-walls event", "--caustics first"]),
    ] {
        dir.refuses("animated-light", &[&["--frames", "0..2"], options].concat(), &words);
    }
    let alone =
        ["--path-history", "none", "--denoiser", "none", "--indirect-share", "points", "--frames", "0..1"];
    dir.animate("animated-light", &alone);
    let image = Channels::read(&dir.path("f/00.exr")).unwrap();
    assert_eq!(image.attributes["indirect_share"], "points");
}

#[test]
fn frames_of_another_run_are_refused_by_what_differs() {
    let dir = AnimationDir::new();
    let frames = ["--frames", "1..3"];
    dir.animate("animated-light", &frames);
    let before = dir.files();
    for (options, words) in [
        (["--light-paths", "600"], ["01.exr", "light_paths", "\"500\", not \"600\""]),
        (["--seed", "1"], ["01.exr", "seed", "--force"]),
        (["--history", "none"], ["01.exr", "history", "--force"]),
        (["--emission", "aimed"], ["01.exr", "emission", "\"guided\", not \"aimed\""]),
        (["--caustics", "any"], ["01.exr", "caustics", "\"first\", not \"any\""]),
        (["--denoiser", "none"], ["01.exr", "denoiser", "\"atrous\", not \"none\""]),
        (["--fps", "12"], ["01.exr", "fps", "\"24\", not \"12\""]),
    ] {
        // An option of TINY is given only once.
        let animate = ["animate", "animated-light", "-o", "f/##.exr"].into_iter().chain(frames);
        let tiny = TINY.chunks(2).filter(|pair| pair[0] != options[0]).flatten().copied();
        let arguments: Vec<&str> = animate.chain(tiny).chain(options).collect();
        dir.0.refuses(&arguments, 2, &words);
    }
    dir.refuses("moving-caster", &frames, &["01.exr", "scene", "animated-light", "moving-caster"]);
    dir.refuses("animated-light", &["--frames", "0..3"], &["01.exr", "first_frame", "\"1\", not \"0\""]);
    assert_eq!(dir.files(), before);
    // A frame has the name of another.
    std::fs::copy(dir.path("f/01.exr"), dir.path("f/02.exr")).unwrap();
    dir.refuses("animated-light", &frames, &["02.exr", "frame", "\"1\", not \"2\""]);
    dir.animate("animated-light", &["--frames", "1..3", "--force"]);
    assert_eq!(dir.files(), before);
    dir.animate("moving-caster", &["--frames", "1..3", "--force"]);
    assert_ne!(dir.files(), before);
    dir.0.write("f/02.exr", "no image");
    let Run { code, stderr, .. } = dir.run("moving-caster", &frames);
    assert!(code == Some(1) && stderr.contains("02.exr cannot be read as EXR"), "{stderr}");
}

#[test]
fn invalid_animations_are_usage_errors() {
    let dir = AnimationDir::new();
    for name in ["a.exr", "#a#.exr", "####.png", "#/a.exr"] {
        let animate = ["animate", "animated-light", "-o", name];
        dir.0.refuses(&[&animate[..], &TINY].concat(), 2, &[name, "frames/####.exr"]);
    }
    dir.refuses("ring", &[], &["ring", "--frames A..B"]);
    dir.refuses("animated-light", &["--method", "path", "--history", "paper"], &["paper", "path", "basic"]);
    dir.refuses("animated-light", &["--method", "progressive", "--history", "validated"], &["validated"]);
    dir.refuses("animated-light", &["--method", "path", "--denoiser", "atrous"], &["atrous", "path"]);
    dir.refuses("animated-light", &["--fps", "0"], &["--fps 0"]);
    dir.refuses("animated-light", &["--fps", "1e9"], &["--frames A..B"]);
    dir.refuses("animated-light", &["--frames", "3..3"], &["A..B"]);
    dir.refuses("animated-light", &["--resume"], &["--resume"]);
    assert!(!dir.path("f").exists());
    // A PNG of another origin is not overwritten.
    std::fs::create_dir(dir.path("f")).unwrap();
    dir.0.write("f/01.png", "mine");
    dir.refuses("animated-light", &["--frames", "0..2", "--png"], &["01.png", "--force"]);
    assert_eq!(dir.names(), ["01.png"]);
}

#[test]
fn other_methods_have_no_history_and_still_scenes_may_be_animated() {
    let dir = AnimationDir::new();
    let report = dir.report("ring", &["--method", "path", "--frames", "0..2"]);
    assert_eq!((&report["history"], &report["gather"]), (&"none".into(), &"none".into()));
    let whole = dir.files();
    assert_ne!(whole["00.exr"], whole["01.exr"], "each frame has its own random numbers");
    dir.remove(&["01.exr"]);
    assert_eq!(rendered(&dir.report("ring", &["--method", "path", "--frames", "0..2"])), [(1, true)]);
    assert_eq!(dir.files(), whole);
}

#[test]
fn pngs_are_those_of_the_frames_whenever_they_are_written() {
    for options in [&["--frames", "0..2"][..], &["--frames", "0..2", "--method", "path"]] {
        let (at_once, later) = (AnimationDir::new(), AnimationDir::new());
        at_once.animate("animated-light", &[options, &["--png"]].concat());
        assert_eq!(at_once.names(), ["00.exr", "00.png", "01.exr", "01.png"]);
        later.animate("animated-light", options);
        let messages = later.animate("animated-light", &[options, &["--png"]].concat());
        assert!(messages.contains("nothing to render"));
        assert_same(&later, &at_once);
        // The exposure is the first frame's, even where its file is missing.
        later.remove(&["00.exr", "00.png", "01.png"]);
        later.animate("animated-light", &[options, &["--png"]].concat());
        assert_same(&later, &at_once);
        later.animate("animated-light", &[options, &["--png", "--exposure", "2"]].concat());
        assert_eq!(later.files()["01.exr"], at_once.files()["01.exr"]);
        assert_ne!(later.files()["01.png"], at_once.files()["01.png"]);
    }
}

#[test]
fn without_ffmpeg_there_are_pngs_and_a_warning() {
    let dir = AnimationDir::new();
    let mut command = dir.command("animated-light", &["--frames", "0..2", "--video"]);
    let Run { code, stderr, .. } = Run::from_output(command.env("PATH", "").output().unwrap());
    assert_eq!(code, Some(0), "{stderr}");
    assert_eq!(stderr.lines().filter(|line| line.contains("no ffmpeg on the PATH")).count(), 1, "{stderr}");
    assert_eq!(dir.names(), ["00.exr", "00.png", "01.exr", "01.png"]);
}

/// A script replaces ffmpeg and writes its arguments into the video.
#[cfg(unix)]
#[test]
fn a_video_is_made_of_the_pngs() {
    use std::os::unix::fs::PermissionsExt;

    let dir = AnimationDir::new();
    let bin = dir.path("bin");
    std::fs::create_dir(&bin).unwrap();
    let script =
        "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor last; do :; done\necho \"$@\" > \"$last\"\n";
    dir.0.write("bin/ffmpeg", script);
    std::fs::set_permissions(bin.join("ffmpeg"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let video = |frames: &str| {
        let mut command = dir.command("animated-light", &["--frames", frames, "--video"]);
        Run::from_output(command.env("PATH", &path).output().unwrap())
    };
    assert_eq!(video("1..3").code, Some(0));
    assert_eq!(dir.names(), ["01.exr", "01.png", "02.exr", "02.png", "animation.mp4"]);
    let asked = std::fs::read_to_string(dir.path("f/animation.mp4")).unwrap();
    for word in ["-framerate 24", "-start_number 1", "-i f/%02d.png", "-frames:v 2"] {
        assert!(asked.contains(word), "{asked}");
    }
    // A longer animation replaces its own video, but no other file.
    assert_eq!(video("1..4").code, Some(0));
    assert!(std::fs::read_to_string(dir.path("f/animation.mp4")).unwrap().contains("-frames:v 3"));
    dir.0.write("f/animation.mp4", "mine");
    let Run { code, stderr, .. } = video("1..4");
    assert!(code == Some(2) && stderr.contains("animation.mp4 exists"), "{stderr}");
    std::fs::remove_file(dir.path("f/animation.mp4")).unwrap();
    dir.0.write("bin/ffmpeg", "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\necho broken >&2\nexit 1\n");
    let Run { code, stderr, .. } = video("1..4");
    assert!(code == Some(1) && stderr.contains("ffmpeg failed: broken"), "{stderr}");
    assert!(!dir.path("f/animation.mp4").exists() && dir.names().iter().all(|name| !name.starts_with('.')));
}

#[test]
fn damaged_frames_are_rendered_anew_to_the_same_bytes() {
    let dir = AnimationDir::new();
    let options = ["--frames", "0..4", "--history", "none", "--emission", "power"];
    dir.animate("animated-light", &options);
    let whole = dir.files();
    // One file is cut off after its header; a bit in the last pixels of another is flipped.
    let cut = &whole["01.exr"];
    dir.0.write("f/01.exr", &cut[..3 * cut.len() / 4]);
    let mut flipped = whole["03.exr"].clone();
    let at = flipped.len() - 9;
    flipped[at] ^= 4;
    dir.0.write("f/03.exr", &flipped);
    let run = dir.run("animated-light", &[&options[..], &["--json"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let warning = "01.exr is damaged and rendered anew; 2 of the frames";
    assert!(run.stderr.contains(warning), "{}", run.stderr);
    assert_eq!(rendered(&run.json()), [(1, true), (3, true)]);
    assert!(dir.files() == whole);
}

#[cfg(unix)]
#[test]
fn two_runs_do_not_write_one_animation() {
    let dir = AnimationDir::new();
    let mut first = std::process::Command::new(BINARY)
        .current_dir(dir.0.folder())
        .args(["animate", "animated-light", "-o", "f/##.exr", "--frames", "0..100000"])
        .args(TINY)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !dir.path("f/00.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(100), "there are no frames");
        std::thread::sleep(Duration::from_millis(5));
    }
    let Run { code, stderr, .. } = dir.run("animated-light", &["--frames", "0..2"]);
    assert!(code == Some(1) && stderr.contains("another run writes f/animation.state"), "{code:?}: {stderr}");
    first.kill().unwrap();
    first.wait().unwrap();
    dir.animate("animated-light", &["--frames", "0..2"]);
}
