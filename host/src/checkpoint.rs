//! Checkpoints: an accumulation on disk, from which a run resumes to the same bits.
//!
//! A checkpoint is a sealed file. Its head holds the run's identity, the shape and the seconds spent. Its payload holds the
//! sums as little-endian f64 and the buffers that outlive a frame.
//! A shard of a run leaves a checkpoint in which the sums of its frames are complete.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::accumulation::{Accumulation, Shape};
use caustics_files::file::{self, read_file};
use caustics_files::memory;
use caustics_files::output::target::{Target, TargetError};
use caustics_files::sealed::{self, Unusable};

/// Identity of a run: everything that decides its bits, by name.
pub type Identity = BTreeMap<String, String>;

/// Kind of the sealed file.
pub(crate) const KIND: &str = "checkpoint";
/// Number of values that are written at a time.
const WRITTEN: usize = 1 << 16;
/// Maximum number of frames in a checkpoint. The rest of 32 bits is for the frames that follow.
const MAX_FRAMES: u32 = 1 << 31;
/// Maximum time that a checkpoint may claim (s).
const MAX_SECONDS: f64 = 1e10;

/// Error of reading or writing a checkpoint.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The checkpoint does not exist.
    #[error("--resume: there is no {}; leave --resume out to begin", .0.display())]
    Missing(PathBuf),
    /// The system cannot read the checkpoint.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The checkpoint.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The checkpoint cannot be written.
    #[error("{0}")]
    Write(#[from] TargetError),
    /// The head cannot be written as JSON.
    #[error("{0}")]
    Head(#[from] serde_json::Error),
    /// The checkpoint is damaged, or another version wrote it.
    #[error("{} {why}", path.display())]
    Unusable {
        /// The checkpoint.
        path: PathBuf,
        /// Cause.
        why: Unusable,
    },
    /// The checkpoint belongs to another run.
    #[error("{} belongs to another run: its {name} is {theirs:?}, not {ours:?}", path.display())]
    Other {
        /// The checkpoint.
        path: PathBuf,
        /// Name of the first value that differs.
        name: String,
        /// Value in the checkpoint.
        theirs: String,
        /// Value in this run.
        ours: String,
    },
}

/// Head of a checkpoint: everything before its sums.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Head {
    /// Identity of the run.
    pub identity: Identity,
    /// Shape of the sums.
    pub shape: Shape,
    /// Time that the sums took (s).
    pub seconds: f64,
    /// Attributes for the header of the image's file.
    #[serde(default)]
    pub about: BTreeMap<String, String>,
    /// Names and sizes of the buffers that outlive a frame (bytes).
    #[serde(default)]
    state: Vec<(String, usize)>,
}

/// State from which a run resumes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checkpoint {
    /// Sums of its frames.
    pub sums: Accumulation,
    /// Time that the sums took.
    pub spent: Duration,
    /// Attributes for the header of the image's file.
    pub about: BTreeMap<String, String>,
    /// Buffers of the last frame that the next one reads, by name; see `Session::state`.
    pub state: Vec<(String, Vec<u8>)>,
}

/// Returns the path of the checkpoint of an output file.
pub fn path_of(output: &Path) -> PathBuf {
    let mut name = OsString::from(output.as_os_str());
    name.push(".checkpoint");
    PathBuf::from(name)
}

/// Writes a checkpoint. An older one is replaced in one step, or stays whole.
///
/// # Errors
///
/// If the checkpoint's folder cannot be written.
pub fn save(path: &Path, identity: &Identity, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
    let Checkpoint { sums, spent, about, state } = checkpoint;
    let head = Head {
        identity: identity.clone(),
        shape: sums.shape,
        seconds: spent.as_secs_f64(),
        about: about.clone(),
        state: state.iter().map(|(name, bytes)| (name.clone(), bytes.len())).collect(),
    };
    let target = Target::claim(path, true)?;
    Ok(target.finish_with(|file| {
        sealed::write(KIND, &head, file, |file| {
            for values in sums.parts().flat_map(|part| part.chunks(WRITTEN)) {
                let bits: Vec<u64> = values.iter().map(|value| value.to_bits().to_le()).collect();
                file.write_all(bytemuck::cast_slice(&bits))?;
            }
            state.iter().try_for_each(|(_, buffer)| file.write_all(buffer))
        })
    })?)
}

/// Difference of two runs' identities.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Name of the value.
    pub name: String,
    /// Value in the other run; empty where it has none.
    pub theirs: String,
    /// Value in this run.
    pub ours: String,
}

/// Returns the first difference by name.
pub fn difference(ours: &Identity, theirs: &Identity) -> Option<Difference> {
    let names: std::collections::BTreeSet<_> = ours.keys().chain(theirs.keys()).collect();
    let value = |identity: &Identity, name| identity.get(name).cloned().unwrap_or_default();
    let mut pairs = names.into_iter().map(|name| Difference {
        name: name.clone(),
        theirs: value(theirs, name),
        ours: value(ours, name),
    });
    pairs.find(|pair| pair.ours != pair.theirs)
}

/// Reads the head of a checkpoint. [`load`] checks the sums.
///
/// # Errors
///
/// If the file cannot be read, or is not a checkpoint of this version of the program.
pub fn head(path: &Path) -> Result<Head, CheckpointError> {
    let fail = |source| CheckpointError::Read { path: path.into(), source };
    let head = sealed::head(KIND, file::open(path).map_err(fail)?).map_err(fail)?;
    head.map_err(|why| CheckpointError::Unusable { path: path.into(), why })
}

/// Reads a checkpoint of the run with this identity. Its sums must have this shape, with any number of frames.
pub fn load(path: &Path, identity: &Identity, shape: Shape) -> Result<Checkpoint, CheckpointError> {
    let bytes = read_file(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => CheckpointError::Missing(path.into()),
        _ => CheckpointError::Read { path: path.into(), source },
    })?;
    parse(path, &bytes, identity, shape)
}

/// Reads a checkpoint from the bytes of a file, as [`load`] does.
pub fn parse(
    path: &Path,
    bytes: &[u8],
    identity: &Identity,
    shape: Shape,
) -> Result<Checkpoint, CheckpointError> {
    let unusable = |why| CheckpointError::Unusable { path: path.into(), why };
    let damaged = |what: &str| unusable(Unusable::damaged(what));
    // The sums are copied once more, as numbers.
    memory::check(bytes.len() as u64).map_err(|short| unusable(Unusable::Memory(short)))?;
    let (head, payload) = sealed::open::<Head>(KIND, bytes).map_err(unusable)?;
    if let Some(Difference { name, theirs, ours }) = difference(identity, &head.identity) {
        return Err(CheckpointError::Other { path: path.into(), name, theirs, ours });
    }
    let Head { shape: theirs, seconds, about, state: buffers, .. } = head;
    if theirs != (Shape { frames: theirs.frames, ..shape }) {
        return Err(damaged("its size is not that of its settings"));
    }
    let end = theirs.first.checked_add(theirs.frames);
    if theirs.frames == 0 || end.is_none_or(|end| end > MAX_FRAMES) || !(0.0..=MAX_SECONDS).contains(&seconds)
    {
        return Err(damaged("no run has its number of frames or seconds"));
    }
    // Split off the buffers from the end; the sums remain.
    let mut payload = payload;
    let mut state = Vec::with_capacity(buffers.len());
    for (name, size) in buffers.into_iter().rev() {
        let start =
            payload.len().checked_sub(size).ok_or_else(|| damaged(&format!("its {name} is cut off")))?;
        state.push((name, payload[start..].to_vec()));
        payload = &payload[..start];
    }
    state.reverse();
    let (values, rest) = payload.as_chunks::<8>();
    let values = values.iter().map(|value| f64::from_le_bytes(*value));
    if !values.clone().all(f64::is_finite) {
        return Err(damaged("its sums are not finite"));
    }
    let sums = Accumulation::from_values(theirs, values).filter(|_| rest.is_empty());
    let sums = sums.ok_or_else(|| damaged("its sums are too many or too few"))?;
    Ok(Checkpoint { sums, spent: Duration::from_secs_f64(seconds), about, state })
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_files::rendered_image::RenderedImage;
    use glam::Vec3;

    fn sums() -> Accumulation {
        let mut sums = Accumulation::default();
        let path = vec![Vec3::new(0.1, 0.2, 0.3); 6];
        sums.add(&RenderedImage { width: 3, height: 2, path, ..RenderedImage::default() });
        sums
    }

    fn identity(seed: &str) -> Identity {
        Identity::from([("seed".into(), seed.into())])
    }

    /// Shape of the sums, without their frames.
    const SHAPE: Shape =
        Shape { width: 3, height: 2, first: 0, frames: 0, gathers: false, batches: 0, auxiliary: false };

    #[test]
    fn loading_a_saved_checkpoint_returns_it_unchanged() {
        let folder = tempfile::tempdir().unwrap();
        let path = path_of(&folder.path().join("a.exr"));
        let state = vec![("map".to_string(), vec![1, 2, 3]), ("nothing".to_string(), vec![])];
        for state in [vec![], state] {
            let about = BTreeMap::from([("device".into(), "a CPU".into())]);
            let checkpoint = Checkpoint { sums: sums(), spent: Duration::from_secs(3), about, state };
            save(&path, &identity("1"), &checkpoint).unwrap();
            let head = head(&path).unwrap();
            assert_eq!((&head.about["device"][..], head.shape.frames), ("a CPU", 1));
            assert_eq!(load(&path, &identity("1"), SHAPE).unwrap(), checkpoint);
        }
        assert!(path.ends_with("a.exr.checkpoint"));
    }

    #[test]
    fn other_runs_and_damaged_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let error = || load(&path, &identity("1"), SHAPE).unwrap_err().to_string();
        assert!(error().contains("there is no"));
        let checkpoint = Checkpoint { sums: sums(), ..Checkpoint::default() };
        save(&path, &identity("2"), &checkpoint).unwrap();
        assert!(error().contains("its seed is \"2\", not \"1\""), "{}", error());
        save(&path, &identity("1"), &checkpoint).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for damaged in [&bytes[..0], &bytes[..10], &bytes[..bytes.len() - 1]] {
            std::fs::write(&path, damaged).unwrap();
            assert!(error().contains("is damaged"), "{}", error());
        }
    }

    /// The checksums of these files are right, and their heads are not.
    #[test]
    fn crafted_heads_are_refused() {
        let error = |shape: Shape, seconds: f64, values: usize| {
            let state = [("map".to_string(), 48), ("other".to_string(), usize::MAX)];
            let state = state[..values.saturating_sub(100)].to_vec();
            let values = if values > 100 { 42 } else { values };
            let head = Head { identity: identity("1"), shape, seconds, about: BTreeMap::new(), state };
            let bytes = sealed::seal(KIND, &head, |bytes| bytes.resize(bytes.len() + 8 * values, 0)).unwrap();
            parse(Path::new("a"), &bytes, &identity("1"), SHAPE).map(drop)
        };
        let fine = Shape { frames: 1, ..SHAPE };
        // Above 100 values, the head has one buffer of 48 bytes, or also one that no file can hold.
        assert!(error(fine, 1.0, 36).is_ok() && error(fine, 1.0, 101).is_ok());
        for (shape, seconds, values) in [
            (Shape { width: 2, height: 3, ..fine }, 1.0, 36),
            (Shape { width: 1, height: 6, ..fine }, 1.0, 36),
            (Shape { width: 0, height: 0, ..fine }, 1.0, 0),
            (Shape { width: 1 << 63, height: 1 << 62, ..fine }, 1.0, 0),
            (Shape { gathers: true, ..fine }, 1.0, 72),
            (Shape { frames: 0, ..fine }, 1.0, 36),
            (Shape { frames: u32::MAX, ..fine }, 1.0, 36),
            (Shape { first: 1, ..fine }, 1.0, 36),
            (fine, -1.0, 36),
            (fine, 1e300, 36),
            (fine, 1.0, 102),
            (fine, 1.0, 35),
            (fine, 1.0, 37),
        ] {
            assert!(
                error(shape, seconds, values).unwrap_err().to_string().contains("is damaged"),
                "{shape:?}"
            );
        }
        // Refuse sums that are not finite.
        for bits in
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(f64::to_bits).into_iter().chain([u64::MAX])
        {
            for at in [0, 17, 35] {
                let head = Head {
                    identity: identity("1"),
                    shape: fine,
                    seconds: 1.0,
                    about: BTreeMap::new(),
                    state: vec![],
                };
                let sums = (0..36).flat_map(|index| if index == at { bits } else { 0 }.to_le_bytes());
                let bytes = sealed::seal(KIND, &head, |bytes| bytes.extend(sums)).unwrap();
                let error = parse(Path::new("a"), &bytes, &identity("1"), SHAPE).unwrap_err().to_string();
                assert!(error.contains("its sums are not finite; remove it"), "{error}");
            }
        }
        let huge = Shape { width: 1 << 63, height: 1 << 62, ..fine };
        assert!(Accumulation::from_values(huge, std::iter::empty::<f64>()).is_none());
    }
}
