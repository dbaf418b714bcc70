//! `caustics device --compile` from outside, on any Vulkan device.

use std::process::{Command, Output};

use caustics::kernels::Source;
use serde_json::Value;

use crate::test_dir::BINARY;

fn compile(arguments: &[&str]) -> Output {
    let mut command = Command::new(BINARY);
    command.args(["device", "--compile"]).args(arguments).output().unwrap()
}

/// Returns the output, or none with a message that the test is skipped; with `CAUSTICS_REQUIRE_GPU=1` it fails instead.
fn compiled(arguments: &[&str]) -> Option<String> {
    let output = compile(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    if Source::from_environment().unchecked().is_err() || output.status.code() == Some(4) {
        assert!(std::env::var("CAUSTICS_REQUIRE_GPU").as_deref() != Ok("1"), "{stderr}");
        eprintln!("skipped: {stderr}");
        return None;
    }
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stderr}\n{stdout}");
    Some(stdout)
}

#[test]
fn entry_points_of_both_modules_compile_for_all_needs_and_for_none() {
    let Some(json) =
        compiled(&["--pass", "display,gather.brute,step.hit", "--features", "all,none", "--json"])
    else {
        return;
    };
    let report: Value = serde_json::from_str(&json).unwrap();
    let hardware = report["device"]["ray_queries"] == true;
    let rows = report["entry_points"].as_array().unwrap();
    let has = |module: &str, entry: &str, features: &str| {
        rows.iter()
            .filter(|row| row["module"] == module && row["entry"] == entry && row["features"] == features)
            .count()
    };
    for features in ["all", "none"] {
        let found = ["display", "gather.brute", "step.hit"].map(|entry| has("base.spv", entry, features));
        assert_eq!(found, [1, 1, 1]);
        assert_eq!(has("rayquery.spv", "step.hit", features), usize::from(hardware));
    }
    for row in rows {
        assert!(row["error"].is_null() && row["compile_ms"].as_f64().unwrap() > 0.0, "{row}");
        assert!(row["executables"].is_array(), "{row}");
    }
}

#[test]
fn the_table_names_device_modules_and_entry_points() {
    let Some(text) = compiled(&["--pass", "display"]) else { return };
    assert!(text.contains("base.spv      display"), "{text}");
    assert!(text.contains("features of all:") && text.ends_with("1 of 1 entry points compiled\n"), "{text}");
}

#[test]
fn unknown_names_are_errors_that_name_them() {
    for (arguments, named) in
        [(["--pass", "displya"], "display"), (["--features", "no-such-room"], "no-such-room")]
    {
        let output = compile(&arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        // A missing device, or kernels older than their sources, is reported first.
        if Source::from_environment().unchecked().is_ok() && output.status.code() != Some(4) {
            assert_eq!(output.status.code(), Some(2), "{stderr}");
            assert!(stderr.contains(named), "{stderr}");
        }
    }
    // Options of --compile are refused without it.
    let output = Command::new(BINARY).args(["device", "--pass", "display"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
