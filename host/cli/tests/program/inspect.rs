//! `caustics inspect` from outside: output and refusals.

use serde_json::json;

use crate::test_dir::{Run, TestDir};

const VIEW: [&str; 8] = ["--width", "64", "--height", "36", "--runner", "cpu", "--light-paths", "20000"];

/// Runs `caustics inspect` with options. The run must write no file.
fn inspect(options: &[&str]) -> Run {
    let dir = TestDir::new();
    let run = dir.run(&[&["inspect"], options, &VIEW].concat());
    assert_eq!(dir.folder().read_dir().unwrap().count(), 0, "it writes no file");
    run
}

#[test]
fn a_pixel_is_printed_as_a_table_and_as_json() {
    // The pixel lies in the caustic in every frame.
    let options = ["mirror-room", "--pixel", "24,22", "--method", "basic"];
    for frame in ["0", "2"] {
        let run = |more: &[&str]| {
            let options = [&options[..], &["--frame", frame], more].concat();
            inspect(&options).expect_success(&options)
        };
        let inspection = run(&["--json"]).json();
        let photons = &inspection["photons"];
        assert_eq!(
            (&inspection["pixel"], &inspection["frame"]),
            (&json!([24, 22]), &json!(frame.parse::<u32>().unwrap()))
        );
        // This also holds in the first frame, whose emission learns halfway.
        assert_eq!((&photons["count"], &photons["skipped"]), (&photons["gathered"], &json!(0)));
        assert!(photons["count"].as_u64().unwrap() > 0, "{photons}");
        assert_eq!(
            inspection["light_paths"].as_array().unwrap().len(),
            photons["some"].as_array().unwrap().len()
        );

        let table = run(&[]).stdout;
        let count = &photons["count"];
        assert!(table.contains(&format!("\nphotons: {count} of 20000 light paths, ")), "{table}");
        assert!(table.contains("collection point: lambert"), "{table}");
        let paths = table.lines().filter(|line| line.starts_with("light path ")).count();
        assert_eq!(paths, inspection["light_paths"].as_array().unwrap().len());
    }
}

#[test]
fn invalid_pixels_are_refused() {
    for (pixel, hint) in [("64,0", "64 by 36"), ("0,36", "64 by 36"), ("5", "300,400"), ("-1,2", "300,400")] {
        let Run { code, stdout, stderr } = inspect(&["mirror-room", "--pixel", pixel]);
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{pixel}: {stderr}");
        assert!(stderr.contains("--pixel") && stderr.contains(hint), "{stderr}");
    }
    let options = ["mirror-room", "--pixel", "1,1", "--frame", "4294967295"];
    inspect(&options).expect_refusal(&options, 2, &[]);
}
