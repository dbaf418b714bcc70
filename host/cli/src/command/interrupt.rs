//! Ctrl-C: the run ends after the current frame, saves its results, and leaves no partial file. A second Ctrl-C ends it at
//! once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::Context;
use caustics::threads;

/// Catches Ctrl-C from now on; the returned function tells whether it came. Can be called once in a process.
pub fn watch() -> anyhow::Result<impl Fn() -> bool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    let handler = move || {
        if flag.swap(true, Ordering::SeqCst) {
            // A second Ctrl-C saves nothing. Outputs are either complete or absent.
            std::process::exit(130);
        }
        message!("interrupted: ends after the frame at hand; once more ends at once");
    };
    match threads::check(1) {
        Ok(()) => ctrlc::set_handler(handler).context("cannot catch Ctrl-C")?,
        // Catching signals takes a thread.
        Err(_) => {
            message!(
                "warning: Ctrl-C ends at once and saves nothing, for want of a thread that waits for it"
            );
        }
    }
    Ok(move || interrupted.load(Ordering::SeqCst))
}

/// Maximum time that a program with nothing to save may take to end.
const MAX_WAIT: Duration = Duration::from_secs(2);

/// Calls `end` on Ctrl-C or SIGTERM. A process that does not end by itself is ended after `MAX_WAIT`, or at once by a
/// second signal. Can be called once in a process.
pub fn end_on_signal(end: impl Fn() + Send + 'static) -> anyhow::Result<()> {
    let was_signalled = AtomicBool::new(false);
    let handler = move || {
        if was_signalled.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        let waits = thread::Builder::new().spawn(|| {
            thread::sleep(MAX_WAIT);
            std::process::exit(0);
        });
        if waits.is_err() {
            // The limit of threads is reached.
            std::process::exit(0);
        }
        end();
    };
    ctrlc::set_handler(handler).context("cannot catch Ctrl-C")
}

#[cfg(all(test, unix))]
mod tests {
    use std::io::{BufRead, BufReader};
    use std::os::unix::process::ExitStatusExt;
    use std::process::{Command, Stdio};
    use std::time::Instant;

    use super::*;

    /// Variable that is set in the process that hangs.
    const HANGS: &str = "CAUSTICS_TEST_HANGS";
    const NAME: &str = "command::interrupt::tests::a_process_that_hangs_ends_when_it_is_told";

    #[test]
    fn a_process_that_hangs_ends_when_it_is_told() {
        if std::env::var_os(HANGS).is_some() {
            end_on_signal(|| {
                loop {
                    thread::park();
                }
            })
            .unwrap();
            println!("ready");
            loop {
                thread::park();
            }
        }
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", NAME, "--nocapture"])
            .env(HANGS, "1")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().contains("ready")));
        Command::new("sh").args(["-c", &format!("kill -TERM {}", child.id())]).status().unwrap();
        let end = Instant::now() + Duration::from_secs(60);
        let status = loop {
            match child.try_wait().unwrap() {
                Some(status) => break status,
                None if Instant::now() > end => {
                    child.kill().unwrap();
                    break child.wait().unwrap();
                }
                None => thread::sleep(Duration::from_millis(20)),
            }
        };
        assert_eq!((status.code(), status.signal()), (Some(0), None));
    }
}
