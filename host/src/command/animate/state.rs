//! What a history keeps from frame to frame, on disk: a run goes on from it to the same bits.
//!
//! A line of JSON (what the run is, the frame, names and sizes of buffers), then the buffers.

use std::path::Path;

use anyhow::Context;
use caustics::checkpoint::Identity;
use caustics::output::target::Target;
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
struct Head {
    identity: Identity,
    frame: u32,
    buffers: Vec<(String, usize)>,
}

/// What frames up to one leave to the next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// All that decides its bits.
    pub identity: Identity,
    /// The last frame in it.
    pub frame: u32,
    /// Buffers by name.
    pub buffers: Vec<(String, Vec<u8>)>,
}

impl State {
    /// Writes it; an older one is replaced at once, or stays whole.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let buffers = self.buffers.iter().map(|(name, bytes)| (name.clone(), bytes.len())).collect();
        let head = Head { identity: self.identity.clone(), frame: self.frame, buffers };
        let mut file = serde_json::to_vec(&head)?;
        file.push(b'\n');
        file.extend(self.buffers.iter().flat_map(|(_, bytes)| bytes));
        Ok(Target::claim(path, true)?.finish(&file)?)
    }

    /// Reads it; none where there is none.
    pub fn load(path: &Path) -> anyhow::Result<Option<State>> {
        if !path.exists() {
            return Ok(None);
        }
        let damaged = || format!("{} is no whole state of an animation; remove it", path.display());
        let file = std::fs::read(path).with_context(damaged)?;
        let end = file.iter().position(|&byte| byte == b'\n').with_context(damaged)?;
        let head: Head = serde_json::from_slice(&file[..end]).with_context(damaged)?;
        let mut rest = &file[end + 1..];
        let mut buffers = Vec::with_capacity(head.buffers.len());
        for (name, size) in head.buffers {
            let (bytes, behind) = rest.split_at_checked(size).with_context(damaged)?;
            buffers.push((name, bytes.to_vec()));
            rest = behind;
        }
        anyhow::ensure!(rest.is_empty(), damaged());
        Ok(Some(State { identity: head.identity, frame: head.frame, buffers }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_saved_is_loaded_and_damaged_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.state");
        assert_eq!(State::load(&path).unwrap(), None);
        let buffers = vec![("lent".to_string(), vec![1, 10, 3]), ("mean".to_string(), vec![0; 5])];
        let state = State { identity: Identity::from([("fps".into(), "24".into())]), frame: 7, buffers };
        state.save(&path).unwrap();
        assert_eq!(State::load(&path).unwrap(), Some(state));
        let whole = std::fs::read(&path).unwrap();
        let long = [&whole[..], b"x"].concat();
        for file in [&whole[..whole.len() - 1], &whole[..10], &long] {
            std::fs::write(&path, file).unwrap();
            assert!(State::load(&path).unwrap_err().to_string().contains("no whole state"));
        }
    }
}
