//! Files with a right checksum that no run has written. They are refused, and change no image.

use caustics::sealed;
use serde_json::Value;

use crate::test_dir::TestDir;

/// Arguments of a run whose frames keep no state.
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

#[test]
fn shards_whose_sums_are_not_finite_are_neither_merged_nor_gone_on_from() {
    let dir = TestDir::new();
    let shard = |number: &'static str| [&RUN[..], &["--shard", number]].concat();
    for number in ["1/2", "2/2"] {
        dir.succeeds(&shard(number));
    }
    let names = ["part.shard-1-of-2.sums", "part.shard-2-of-2.sums"];
    let merge = ["merge", names[0], names[1], "-o", "whole.exr"];
    let whole = std::fs::read(dir.path(names[1])).unwrap();
    let (head, payload) = sealed::open::<Value>("checkpoint", &whole).unwrap();
    let words = ["error: ", names[1], "is damaged", "not finite", "begin anew"];
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for at in [0, payload.len() / 16 * 8, payload.len() - 8] {
            let mut crafted = payload.to_vec();
            crafted[at..at + 8].copy_from_slice(&value.to_le_bytes());
            let file = sealed::seal("checkpoint", &head, |bytes| bytes.extend(crafted)).unwrap();
            dir.write(names[1], file);
            dir.refuses(&merge, 2, &words);
            assert!(!dir.path("whole.exr").exists());
        }
    }
    dir.refuses(&shard("2/2"), 2, &words);
    dir.write(names[1], &whole);
    dir.succeeds(&merge);
}
