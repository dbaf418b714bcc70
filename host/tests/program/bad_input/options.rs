//! The command line.

use super::{refuses, render_refuses};

#[test]
fn sizes_and_counts_out_of_range_are_usage_errors() {
    let folder = tempfile::tempdir().unwrap();
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
        refuses(folder.path(), &arguments, 2, &[words]);
    }
}

#[test]
fn names_and_combinations_that_do_not_exist_are_usage_errors() {
    let folder = tempfile::tempdir().unwrap();
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
        render_refuses(folder.path(), "mirror-room", options, 2, words);
    }
}

#[test]
fn too_many_digits_of_a_frame_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("{}.exr", "#".repeat(70_000));
    refuses(folder.path(), &["animate", "moving-caster", "-o", &name], 2, &["70000 # in a row", "####.exr"]);
}
