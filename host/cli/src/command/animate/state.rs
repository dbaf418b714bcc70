//! State that a history keeps from frame to frame, on disk. A run resumes from it to the same bits.
//!
//! Sealed file: the run's identity, the frame, names and sizes of buffers, then the buffers.

use std::io::Write;
use std::path::Path;

use anyhow::Context;
use caustics::checkpoint::Identity;
use caustics::file::read_file;
use caustics::memory;
use caustics::output::target::Target;
use caustics::sealed::{self, Unusable};
use caustics::session::SessionError;
use serde::{Deserialize, Serialize};

use crate::cli::Usage;

/// Kind of the file.
const KIND: &str = "animation";

#[derive(Serialize, Deserialize)]
struct Head {
    identity: Identity,
    frame: u32,
    buffers: Vec<(String, usize)>,
}

/// State after a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnimationState {
    /// Everything that decides its bits.
    pub identity: Identity,
    /// Last frame in it.
    pub frame: u32,
    /// Buffers by name.
    pub buffers: Vec<(String, Vec<u8>)>,
}

impl AnimationState {
    /// Writes the state; an older one is replaced at once, or stays whole.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let buffers = self.buffers.iter().map(|(name, bytes)| (name.clone(), bytes.len())).collect();
        let head = Head { identity: self.identity.clone(), frame: self.frame, buffers };
        let target = Target::claim(path, true)?;
        Ok(target.finish_with(|file| {
            sealed::write(KIND, &head, file, |file| {
                self.buffers.iter().try_for_each(|(_, bytes)| file.write_all(bytes))
            })
        })?)
    }

    /// Reads the state; none where the file does not exist.
    pub fn load(path: &Path) -> anyhow::Result<Option<AnimationState>> {
        if !path.exists() {
            return Ok(None);
        }
        let file = read_file(path).with_context(|| format!("cannot read {}", path.display()))?;
        let state = AnimationState::parse(&file);
        Ok(Some(state.map_err(|why| Usage(format!("{}: the state {why}", path.display())))?))
    }

    /// Parses the bytes of a file.
    fn parse(file: &[u8]) -> Result<AnimationState, Unusable> {
        // The buffers are in memory twice for a while.
        memory::check(file.len() as u64).map_err(Unusable::Memory)?;
        let (head, mut rest) = sealed::open::<Head>(KIND, file)?;
        let mut buffers = Vec::with_capacity(head.buffers.len());
        for (name, size) in head.buffers {
            let split = rest.split_at_checked(size);
            let (bytes, behind) = split.ok_or_else(|| Unusable::damaged(format!("{name} is cut off")))?;
            buffers.push((name, bytes.to_vec()));
            rest = behind;
        }
        if !rest.is_empty() {
            return Err(Unusable::damaged("there is more behind its buffers"));
        }
        Ok(AnimationState { identity: head.identity, frame: head.frame, buffers })
    }
}

/// Turns a state that a run cannot resume from into an error of its file.
pub fn damaged(path: &Path, error: SessionError) -> anyhow::Error {
    match error {
        SessionError::State { .. } | SessionError::NotFinite { .. } => {
            Usage(format!("{}: the state {}", path.display(), Unusable::damaged(error))).into()
        }
        error => error.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saved_states_load_and_damaged_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.state");
        assert_eq!(AnimationState::load(&path).unwrap(), None);
        let buffers = vec![("reprojected".to_string(), vec![1, 10, 3]), ("mean".to_string(), vec![0; 5])];
        let state =
            AnimationState { identity: Identity::from([("fps".into(), "24".into())]), frame: 7, buffers };
        state.save(&path).unwrap();
        assert_eq!(AnimationState::load(&path).unwrap(), Some(state));
        let whole = std::fs::read(&path).unwrap();
        let long = [&whole[..], b"x"].concat();
        let mut flipped = whole.clone();
        flipped[whole.len() - 5] ^= 1;
        for file in [&whole[..whole.len() - 1], &whole[..10], &long, &flipped] {
            std::fs::write(&path, file).unwrap();
            let error = AnimationState::load(&path).unwrap_err().to_string();
            assert!(error.contains("a.state: the state is damaged"), "{error}");
        }
        // The checksum is right, but the sizes are wrong.
        for size in [0, 9, usize::MAX] {
            let head =
                Head { identity: Identity::new(), frame: 0, buffers: vec![("reprojected".into(), size)] };
            let file = sealed::seal(KIND, &head, |bytes| bytes.extend([0; 8])).unwrap();
            assert!(matches!(AnimationState::parse(&file), Err(Unusable::Damaged(_))), "{size}");
        }
    }
}
