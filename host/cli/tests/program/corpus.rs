//! Replays the corpus of `fuzz/` through the targets' entry points, so that no known failure returns.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use caustics::accumulation::Accumulation;
use caustics::checkpoint::{self, Checkpoint};
use caustics::fuzzing;
use caustics::rendered_image::RenderedImage;
use glam::Vec3;

use crate::test_dir::declare_program;

/// Runs a target over its corpus: files named `whole*` must be accepted, those named `broken*` refused.
fn replay(name: &str, target: fn(&[u8]) -> bool) {
    declare_program();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(name);
    let mut count = [0; 2];
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let is_accepted = target(&std::fs::read(&path).unwrap());
        let stem = path.file_stem().unwrap().to_string_lossy();
        for (index, prefix) in ["broken", "whole"].into_iter().enumerate() {
            if stem.starts_with(prefix) {
                assert_eq!(is_accepted, index == 1, "{}", path.display());
                count[index] += 1;
            }
        }
    }
    assert!(count.iter().all(|&count| count > 0), "{name}: {count:?}");
}

#[test]
fn scenes_replay() {
    replay("scene", fuzzing::scene);
}

#[test]
fn images_replay() {
    replay("image", fuzzing::image);
}

#[test]
fn sweeps_replay() {
    replay("sweep", caustics_bench::fuzzing::sweep);
}

#[test]
fn edits_replay() {
    replay("edits", fuzzing::edits);
}

#[test]
fn results_replay() {
    replay("result", caustics_bench::fuzzing::result);
}

#[test]
fn compressed_meshes_replay() {
    replay("draco", fuzzing::draco);
    replay("meshopt", fuzzing::meshopt);
}

#[test]
fn textures_and_environments_replay() {
    replay("ktx2", fuzzing::ktx2);
    replay("webp", fuzzing::webp);
    replay("environment", fuzzing::environment);
}

#[test]
fn shards_replay() {
    replay("shard", fuzzing::shard);
}

#[test]
fn cached_bvhs_replay() {
    replay("bvh", fuzzing::bvh);
}

/// Every target has a corpus that a test above replays, and an entry in the manifest of `fuzz/`.
#[test]
fn every_target_of_fuzzing_has_a_corpus_that_is_replayed() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let manifest = std::fs::read_to_string(fuzz.join("Cargo.toml")).unwrap();
    let names = |folder: &str| {
        let entries = fuzz.join(folder).read_dir().unwrap().map(|entry| entry.unwrap().path());
        entries.map(|path| path.file_stem().unwrap().to_str().unwrap().to_string()).collect::<BTreeSet<_>>()
    };
    let (targets, corpora) = (names("targets"), names("corpus"));
    assert!(targets.len() > 10, "{targets:?}");
    assert!(targets.is_subset(&corpora), "{targets:?}, {corpora:?}");
    let texts = [include_str!("corpus.rs"), include_str!("../../src/command/view/taken.rs")];
    for name in &corpora {
        let calls = [format!("replay(\"{name}\", "), format!("fuzz/corpus/{name}\"")];
        let is_replayed = texts.iter().any(|text| calls.iter().any(|call| text.contains(call)));
        assert!(is_replayed, "{name} is not replayed");
    }
    for name in &targets {
        assert!(manifest.contains(&format!("name = \"{name}\"\n")), "{name} is not in the manifest");
    }
}

#[test]
fn checkpoints_replay() {
    declare_program();
    // Files of the current program are written here, beside those of the corpus.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let mut sums = Accumulation::default();
    for value in [0.25, 0.5] {
        sums.add(&RenderedImage {
            width: 2,
            height: 1,
            path: vec![Vec3::splat(value); 2],
            ..RenderedImage::default()
        });
    }
    let checkpoint = Checkpoint { sums, spent: Duration::from_secs(1), ..Checkpoint::default() };
    checkpoint::save(&path, &Default::default(), &checkpoint).unwrap();
    let whole = std::fs::read(&path).unwrap();
    assert!(fuzzing::checkpoint(&whole));
    for at in 0..whole.len() {
        assert!(!fuzzing::checkpoint(&whole[..at]), "cut at {at}");
        let mut damaged = whole.clone();
        damaged[at] ^= 0x41;
        fuzzing::checkpoint(&damaged);
    }
    // Files of the corpus are heads and sums, of which the target makes checkpoints.
    replay("checkpoint", fuzzing::checkpoint);
}
