//! Passes the commit that the program is built from, and a hash of its crates' sources, to the program.

#[path = "../../kernels/builder/src/fingerprint.rs"]
#[allow(dead_code)]
mod fingerprint;
#[path = "sources.rs"]
mod sources;

use std::path::Path;
use std::process::Command;

/// Output of a git command, if it succeeds.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_string())
}

fn main() {
    let root = Path::new("../..");
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".into());
    let hash = fingerprint::fingerprint(root, &sources::SOURCES).unwrap_or_else(|_| commit.clone());
    println!("cargo::rustc-env=CAUSTICS_COMMIT={commit}");
    println!("cargo::rustc-env=CAUSTICS_SOURCES_HASH={hash}");
    println!("cargo::rerun-if-changed=sources.rs");
    for folder in sources::SOURCES {
        println!("cargo::rerun-if-changed={}", root.join(folder).display());
    }
    // Ask git for these paths: in a worktree `.git` is a file.
    for watched in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", watched]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}
