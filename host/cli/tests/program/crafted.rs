//! Files with a right checksum that no run has written: they are refused, and change no image.

use std::path::Path;

use assert_cmd::Command;
use caustics::sealed;
use serde_json::Value;

/// Frames that leave nothing to each other.
const RUN: [&str; 16] = [
    "render",
    "mirror-room",
    "--frames",
    "4",
    "--width",
    "32",
    "--height",
    "18",
    "--light-paths",
    "500",
    "--emission",
    "aimed",
    "--runner",
    "cpu",
    "-o",
    "part.exr",
];

/// Exit code and stderr.
fn caustics(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustics"));
    command.current_dir(folder).args(arguments).timeout(std::time::Duration::from_secs(120));
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn shards_whose_sums_are_not_finite_are_neither_merged_nor_gone_on_from() {
    let folder = tempfile::tempdir().unwrap();
    let shard = |number: &str| caustics(folder.path(), &[&RUN[..], &["--shard", number]].concat());
    for number in ["1/2", "2/2"] {
        let (code, stderr) = shard(number);
        assert_eq!(code, Some(0), "{stderr}");
    }
    let names = ["part.shard-1-of-2.sums", "part.shard-2-of-2.sums"];
    let merge = || caustics(folder.path(), &["merge", names[0], names[1], "-o", "whole.exr"]);
    let second = folder.path().join(names[1]);
    let whole = std::fs::read(&second).unwrap();
    let (head, payload) = sealed::open::<Value>("checkpoint", &whole).unwrap();
    let refused = |(code, stderr): (Option<i32>, String)| {
        assert_eq!(code, Some(2), "{stderr}");
        let words = ["error: ", names[1], "is damaged", "not finite", "begin anew"];
        assert!(words.iter().all(|word| stderr.contains(word)), "{stderr}");
    };
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for at in [0, payload.len() / 16 * 8, payload.len() - 8] {
            let mut crafted = payload.to_vec();
            crafted[at..at + 8].copy_from_slice(&value.to_le_bytes());
            let file = sealed::seal("checkpoint", &head, |bytes| bytes.extend(crafted)).unwrap();
            std::fs::write(&second, file).unwrap();
            refused(merge());
            assert!(!folder.path().join("whole.exr").exists());
        }
    }
    refused(shard("2/2"));
    std::fs::write(&second, &whole).unwrap();
    let (code, stderr) = merge();
    assert_eq!(code, Some(0), "{stderr}");
}
