//! Runs the program on a file in a process of its own, so that the survey survives whatever happens there.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Interval between checks whether a process has ended.
const PATIENCE: Duration = Duration::from_millis(5);

/// Result of a process.
pub struct Ended {
    /// Exit status; none where the time limit ended the process.
    status: Option<ExitStatus>,
    limit: Duration,
    /// Output on stdout.
    pub stdout: Vec<u8>,
    stderr: String,
}

impl Ended {
    /// Returns why the process failed, if it did.
    pub fn fault(&self) -> Option<String> {
        let last_lines = || self.stderr.lines().rev();
        match self.status {
            None => Some(format!("takes more than {:.0} s", self.limit.as_secs_f64())),
            Some(status) if status.success() => None,
            Some(status) if status.code().is_none() => {
                Some(format!("its process was killed ({status}), perhaps for its memory"))
            }
            Some(status) => {
                let panic = last_lines().find(|line| line.contains("panicked at"));
                let error = last_lines().find_map(|line| line.strip_prefix("error: "));
                Some(panic.or(error).map_or_else(|| format!("ends with {status}"), Into::into))
            }
        }
    }
}

/// Runs this program on a file, up to a time limit. Output goes to files, so that no process waits for a reader.
pub fn run_alone(program: &Path, arguments: &[&str], file: &Path, limit: Duration) -> Result<Ended, String> {
    let run = || -> std::io::Result<Ended> {
        let (stdout, stderr) = (tempfile::tempfile()?, tempfile::tempfile()?);
        let mut child = Command::new(program)
            .args(arguments)
            .arg(file)
            .stdin(Stdio::null())
            .stdout(stdout.try_clone()?)
            .stderr(stderr.try_clone()?)
            .spawn()?;
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break Some(status);
            }
            if start.elapsed() >= limit {
                child.kill()?;
                child.wait()?;
                break None;
            }
            std::thread::sleep(PATIENCE);
        };
        let stderr = String::from_utf8_lossy(&whole(stderr)?).into_owned();
        Ok(Ended { status, limit, stdout: whole(stdout)?, stderr })
    };
    run().map_err(|error| format!("{}: {error}", program.display()))
}

fn whole(mut file: File) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    /// Runs a line of shell, which gets the file as `$0`.
    fn shell(line: &str, limit: f64) -> Ended {
        let limit = Duration::from_secs_f64(limit);
        run_alone(Path::new("/bin/sh"), &["-c", line], Path::new("some.glb"), limit).unwrap()
    }

    #[test]
    fn every_end_of_a_process_is_reported() {
        assert_eq!(shell("echo $0", 60.0).fault(), None);
        assert_eq!(shell("echo $0", 60.0).stdout, b"some.glb\n");
        for (line, word) in [
            ("echo talk >&2; echo 'error: some.glb: broken' >&2; exit 1", "some.glb: broken"),
            ("echo \"thread 'main' panicked at a.rs:1\" >&2; echo note >&2; exit 101", "panicked at a.rs:1"),
            ("kill -KILL $$", "killed"),
            ("exit 3", "ends with"),
        ] {
            let fault = shell(line, 60.0).fault().unwrap();
            assert!(fault.contains(word), "{line}: {fault}");
        }
        let start = Instant::now();
        assert!(shell("exec sleep 60", 0.05).fault().unwrap().contains("more than"));
        assert!(start.elapsed() < Duration::from_secs(30));
        assert!(run_alone(Path::new("/no/such"), &[], Path::new("a"), PATIENCE).is_err());
    }
}
