//! Checkpoints: an accumulation on disk, from which a run goes on to the same bits.
//!
//! A line of JSON (what the run is, shape, seconds spent), then the sums as little-endian f64.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::accumulation::{Accumulation, Shape};
use crate::output::target::Target;

/// What a run is: all that decides its bits, by name.
pub type Identity = BTreeMap<String, String>;

/// Why a checkpoint cannot be used.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// There is none.
    #[error("--resume: there is no {}; leave --resume out to begin", .0.display())]
    Missing(PathBuf),
    /// It belongs to another run.
    #[error("--resume: {} belongs to another run: its {name} is {theirs:?}, not {ours:?}", path.display())]
    Other {
        /// The checkpoint.
        path: PathBuf,
        /// What differs.
        name: String,
        /// In the checkpoint.
        theirs: String,
        /// In this run.
        ours: String,
    },
}

#[derive(Serialize, Deserialize)]
struct Head {
    identity: Identity,
    shape: Shape,
    seconds: f64,
}

/// The checkpoint that belongs to an output file.
pub fn path_of(output: &Path) -> PathBuf {
    let mut name = OsString::from(output.as_os_str());
    name.push(".checkpoint");
    PathBuf::from(name)
}

/// Writes a checkpoint; an older one is replaced at once, or stays whole.
pub fn save(
    path: &Path,
    identity: &Identity,
    accumulation: &Accumulation,
    spent: Duration,
) -> anyhow::Result<()> {
    let head = Head { identity: identity.clone(), shape: accumulation.shape, seconds: spent.as_secs_f64() };
    let mut bytes = serde_json::to_vec(&head)?;
    bytes.push(b'\n');
    for part in accumulation.parts() {
        bytes.extend(part.iter().flat_map(|value| value.to_le_bytes()));
    }
    Ok(Target::claim(path, true)?.finish(&bytes)?)
}

/// In what two runs differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// What differs.
    pub name: String,
    /// In the other run; empty where it has none.
    pub theirs: String,
    /// In this run.
    pub ours: String,
}

/// The first that differs, by name.
pub fn difference(ours: &Identity, theirs: &Identity) -> Option<Difference> {
    let names: std::collections::BTreeSet<_> = ours.keys().chain(theirs.keys()).collect();
    let of = |identity: &Identity, name| identity.get(name).cloned().unwrap_or_default();
    let mut pairs = names.into_iter().map(|name| Difference {
        name: name.clone(),
        theirs: of(theirs, name),
        ours: of(ours, name),
    });
    pairs.find(|pair| pair.ours != pair.theirs)
}

/// Reads a checkpoint of the run that this identity names, and the time that it took.
pub fn load(path: &Path, identity: &Identity) -> anyhow::Result<(Accumulation, Duration)> {
    let file = File::open(path).map_err(|_| CheckpointError::Missing(path.into()))?;
    let mut reader = BufReader::new(file);
    let damaged = || format!("{} is no whole checkpoint; remove it and begin anew", path.display());
    let mut line = Vec::new();
    reader.by_ref().take(1 << 20).read_until(b'\n', &mut line).with_context(damaged)?;
    let head: Head = serde_json::from_slice(&line).with_context(damaged)?;
    if let Some(Difference { name, theirs, ours }) = difference(identity, &head.identity) {
        return Err(CheckpointError::Other { path: path.into(), name, theirs, ours }.into());
    }
    // The file's length vouches for the size before memory is asked for.
    let rest = reader.get_ref().metadata()?.len().saturating_sub(line.len() as u64);
    anyhow::ensure!(Accumulation::bytes(&head.shape) == u128::from(rest), damaged());
    let mut accumulation = Accumulation::zero(head.shape);
    for part in accumulation.parts_mut() {
        for value in part {
            let mut bytes = [0; 8];
            reader.read_exact(&mut bytes).with_context(damaged)?;
            *value = f64::from_le_bytes(bytes);
        }
    }
    Ok((accumulation, Duration::try_from_secs_f64(head.seconds).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;
    use glam::Vec3;

    fn sums() -> Accumulation {
        let mut sums = Accumulation::default();
        let path = vec![Vec3::new(0.1, 0.2, 0.3); 6];
        sums.add(&Picture { width: 3, height: 2, path, ..Picture::default() });
        sums
    }

    fn identity(seed: &str) -> Identity {
        Identity::from([("seed".into(), seed.into())])
    }

    #[test]
    fn what_is_saved_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let path = path_of(&folder.path().join("a.exr"));
        save(&path, &identity("1"), &sums(), Duration::from_secs(3)).unwrap();
        assert_eq!(load(&path, &identity("1")).unwrap(), (sums(), Duration::from_secs(3)));
        assert!(path.ends_with("a.exr.checkpoint"));
    }

    #[test]
    fn other_runs_and_damaged_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        assert!(load(&path, &identity("1")).unwrap_err().to_string().contains("there is no"));
        save(&path, &identity("1"), &sums(), Duration::ZERO).unwrap();
        let error = load(&path, &identity("2")).unwrap_err().to_string();
        assert!(error.contains("its seed is \"1\", not \"2\""), "{error}");
        let bytes = std::fs::read(&path).unwrap();
        for short in [0, 10, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..short]).unwrap();
            let error = load(&path, &identity("1")).unwrap_err().to_string();
            assert!(error.contains("no whole checkpoint"), "{error}");
        }
    }
}
