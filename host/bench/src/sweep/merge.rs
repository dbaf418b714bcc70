//! Merges the results of several folders into one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::result::RunResult;
use crate::store;
use caustics::file::read_file;
use caustics::output::target::Target;

/// Numbers of results of a folder, by what was done with them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Joined {
    /// Copied.
    pub taken: usize,
    /// Left out, equal to an existing one.
    pub equal: usize,
    /// Left out in favour of a more complete or newer one.
    pub older: usize,
}

/// Copies every result of the folders, with its images, into `out`, and keeps the results already there. Of two results of
/// one identity, the more complete one wins (time and error), else the newer one. Returns counts for each folder.
pub fn merge(folders: &[PathBuf], out: &Path) -> anyhow::Result<Vec<Joined>> {
    store::create(out)?;
    let mut known: BTreeMap<String, RunResult> =
        store::read_all(out)?.into_iter().map(|result| (result.identity.clone(), result)).collect();
    let mut counts = Vec::new();
    for folder in folders {
        let mut joined = Joined::default();
        for result in store::read_all(folder)? {
            match known.get(&result.identity) {
                Some(old) if *old == result => joined.equal += 1,
                Some(old) if rank(old) >= rank(&result) => joined.older += 1,
                _ => {
                    joined.taken += 1;
                    copy_images(folder, out, &result)?;
                    store::write(out, &result)?;
                    known.insert(result.identity.clone(), result);
                }
            }
        }
        counts.push(joined);
    }
    Ok(counts)
}

fn rank(result: &RunResult) -> (usize, u64) {
    let parts = usize::from(result.time.is_some()) + usize::from(result.error.is_some());
    (parts, result.provenance.unix_s)
}

fn copy_images(from: &Path, to: &Path, result: &RunResult) -> anyhow::Result<()> {
    let Some(error) = &result.error else { return Ok(()) };
    for name in [&error.image, &error.error_map, &error.reference].into_iter().flatten() {
        let (source, target) = (store::results_folder(from).join(name), store::results_folder(to).join(name));
        let bytes = read_file(&source).with_context(|| format!("cannot read {}", source.display()))?;
        Target::claim(&target, true)?.finish(&bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::{ErrorResult, Provenance, TimeResult};

    /// Identity that ends in a digit.
    fn digit_identity(digit: &str) -> String {
        format!("{digit:0>16}")
    }

    fn result(digit: &str, unix_s: u64, is_whole: bool) -> RunResult {
        let identity = digit_identity(digit);
        let error = ErrorResult { image: Some(format!("{identity}.png")), ..ErrorResult::default() };
        RunResult {
            identity,
            time: is_whole.then(TimeResult::default),
            error: Some(error),
            provenance: Provenance { unix_s, ..Provenance::default() },
            ..RunResult::default()
        }
    }

    fn write(folder: &Path, results: &[RunResult], image: &str) {
        store::create(folder).unwrap();
        for result in results {
            store::write(folder, result).unwrap();
            std::fs::write(store::results_folder(folder).join(format!("{}.png", result.identity)), image)
                .unwrap();
        }
    }

    #[test]
    fn the_fuller_then_the_newer_result_wins_with_its_images() {
        let root = tempfile::tempdir().unwrap();
        let [a, b, out] = ["a", "b", "out"].map(|name| root.path().join(name));
        let old = ["1", "2", "3", "4"].map(|identity| result(identity, 10, true));
        write(&a, &old, "a");
        let new = [
            result("1", 10, true),
            result("2", 11, true),
            result("3", 9, true),
            result("4", 11, false),
            result("5", 1, true),
        ];
        write(&b, &new, "b");
        let counts = merge(&[a.clone(), b.clone()], &out).unwrap();
        let expected = Joined { taken: 2, equal: 1, older: 2 };
        assert_eq!(counts, [Joined { taken: 4, ..Joined::default() }, expected]);
        let merged = store::read_all(&out).unwrap();
        assert_eq!(merged, [&old[0], &new[1], &old[2], &old[3], &new[4]].map(Clone::clone));
        let images = ["1", "2", "3", "4", "5"].map(|name| {
            std::fs::read_to_string(store::results_folder(&out).join(digit_identity(name) + ".png")).unwrap()
        });
        assert_eq!(images, ["a", "b", "a", "a", "b"]);
        // Merging again in the other order changes nothing.
        merge(&[b, a], &out).unwrap();
        assert_eq!(store::read_all(&out).unwrap(), merged);
    }

    #[test]
    fn names_that_lead_out_of_the_folder_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let [a, out] = ["a", "out"].map(|name| root.path().join(name));
        let image = |name: &str| {
            let error = ErrorResult { image: Some(name.into()), ..ErrorResult::default() };
            RunResult { error: Some(error), ..result("1", 1, true) }
        };
        let named = |identity: &str| RunResult { identity: identity.into(), ..result("1", 1, true) };
        let precious = root.path().join("precious.json");
        let absolute = root.path().join("precious");
        std::fs::write(&precious, "precious").unwrap();
        let results = [
            (image("../x.png"), "image"),
            (image("/x.png"), "image"),
            (image("x\\y.png"), "image"),
            (image(".x.png"), "image"),
            (image(&format!("{}.json", digit_identity("2"))), "image"),
            (named("../../precious"), "identity"),
            (named(absolute.to_str().unwrap()), "identity"),
            (named(&digit_identity("2")), "identity"),
            (named("1"), "identity"),
        ];
        for (result, what) in results {
            store::create(&a).unwrap();
            let text = serde_json::to_vec(&result).unwrap();
            std::fs::write(store::file(&a, &digit_identity("1")), text).unwrap();
            let error = format!("{:#}", merge(std::slice::from_ref(&a), &out).unwrap_err());
            assert!(error.contains(what) && error.contains(&digit_identity("1")), "{error}");
            assert_eq!(store::results_folder(&out).read_dir().unwrap().count(), 0);
        }
        assert_eq!(std::fs::read(precious).unwrap(), b"precious");
    }
}
