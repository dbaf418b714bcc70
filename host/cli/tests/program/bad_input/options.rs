//! Options of the command line.

use super::{refuses, render_refuses, shell};
use crate::test_dir::TestDir;

#[test]
fn sizes_and_counts_out_of_range_are_usage_errors() {
    let dir = TestDir::new();
    let cases: [(&[&str], &str); 18] = [
        (&["--width", "0", "--height", "0"], "--width 0"),
        (&["--width", "100000", "--height", "100000"], "--width 100000"),
        (&["--width", "16384", "--height", "16384"], "area"),
        (&["--light-paths", "0"], "--light-paths"),
        (&["--frames", "0"], "--frames"),
        (&["--max-bounces", "0"], "--max-bounces"),
        (&["--max-bounces", "65"], "--max-bounces"),
        (&["--radius-px", "NaN"], "--radius-px"),
        (&["--radius-px", "-1"], "--radius-px"),
        (&["--radius-px", "0"], "--radius-px"),
        (&["--radius-px", "inf"], "--radius-px"),
        (&["--specular-roughness", "1.5"], "--specular-roughness"),
        (&["--specular-roughness", "NaN"], "--specular-roughness"),
        (&["--exposure", "NaN"], "--exposure"),
        (&["--background", "1,2"], "--background"),
        (&["--background", "1,NaN,0"], "--background"),
        (&["--width", "-1"], "--width"),
        (&["--light-paths", "many"], "--light-paths"),
    ];
    for (options, words) in cases {
        let arguments = [&["render", "mirror-room", "-o", "out.exr", "--runner", "cpu"], options].concat();
        refuses(&dir, &arguments, 2, &[words]);
    }
}

#[test]
fn names_and_combinations_that_do_not_exist_are_usage_errors() {
    let dir = TestDir::new();
    let cases: [(&[&str], &[&str]); 9] = [
        (&["--gather", "telepathy"], &["--gather", "telepathy", "photons-grid"]),
        (&["--camera", "nobody"], &["--camera nobody", "main"]),
        (&["--gather", "points-rt"], &["--gather points-rt", "ray queries", "photons-grid"]),
        (&["--tracer", "hardware"], &["--tracer hardware", "--runner gpu"]),
        (&["--debug", "validation"], &["--debug validation", "--runner gpu"]),
        (&["--device", "nonsense"], &["--device \"nonsense\"", "--runner gpu"]),
        (&["--threads", "4294967295"], &["--threads 4294967295", "at most 1024"]),
        (&["--method", "magic"], &["--method", "basic"]),
        (&["--no-such-flag"], &["--no-such-flag"]),
    ];
    for (options, words) in cases {
        render_refuses(&dir, "mirror-room", options, 2, words);
    }
}

#[test]
fn too_many_digits_of_a_frame_are_refused() {
    let dir = TestDir::new();
    let name = format!("{}.exr", "#".repeat(70_000));
    refuses(&dir, &["animate", "moving-caster", "-o", &name], 2, &["70000 # in a row", "####.exr"]);
}

#[test]
fn impossible_values_of_scenes_and_frames_are_usage_errors() {
    let dir = TestDir::new();
    let cases: [(&[&str], &str); 11] = [
        (&["--environment", "nan,1,1"], "--environment nan,1,1"),
        (&["--environment", "1,-1,1"], "--environment 1,-1,1"),
        (&["--environment", "1,1,1", "--environment-scale", "nan"], "--environment-scale NaN"),
        (&["--environment", "1,1,1", "--environment-scale", "-1"], "--environment-scale -1"),
        (&["--environment", "1,1,1", "--environment-rotation", "inf"], "--environment-rotation inf"),
        (&["--variant", "none"], "variant \"none\""),
        (&["--animation", "none"], "animation \"none\""),
        (&["--camera", "orbit:nan,0"], "orbit"),
        (&["--fov", "1e308"], "--fov"),
        (&["--time", "inf"], "--time inf"),
        (&["--checkpoint-every", "1e308"], "--checkpoint-every"),
    ];
    for (options, words) in cases {
        render_refuses(&dir, "mirror-room", options, 2, &[words]);
    }
    let cases: [(&[&str], &str); 9] = [
        (&["--equal-time-ms", "1e308"], "600000 ms"),
        (&["--equal-time-ms", "1e-308"], "0.001"),
        (&["--fps", "1e-308"], "--fps"),
        (&["--fps", "1e308"], "--fps"),
        (&["--frames", "4294967290..4294967295"], "at most 1000000"),
        (&["--warm-up", "4294967295"], "at most 1000000"),
        (&["--environment", "nan,1,1"], "--environment nan,1,1"),
        (&["--moment", "inf"], "moment"),
        (&["--radius-px", "1e39"], "radius-px"),
    ];
    for (options, words) in cases {
        refuses(&dir, &[&["bench", "ring", "--runner", "cpu"], options].concat(), 2, &[words]);
    }
}

/// Output that the user asked for and did not get is an error.
#[test]
#[cfg(target_os = "linux")]
fn help_that_cannot_be_written_is_an_error() {
    let dir = TestDir::new();
    for option in ["--help", "--version", "render --help"] {
        let run = shell(&dir, &format!("exec \"$0\" {option} >/dev/full"));
        assert_eq!(run.code, Some(1), "{option}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: cannot write to stdout"), "{option}: {}", run.stderr);
    }
}
