//! Build of the program that uses this library. Files name it, and a run is resumed only by the build that began it. Imports nothing.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

/// Build of a program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Version of its package.
    pub version: String,
    /// Commit that it was built from.
    pub commit: String,
    /// Hash of the sources of its crates: a commit says nothing of changes that were not committed, and too much where only a
    /// document changed.
    pub sources: String,
}

static PROGRAM: OnceLock<Program> = OnceLock::new();

/// Declares this process's program, before it reads or writes files. The first declaration counts.
pub fn declare(program: Program) {
    PROGRAM.get_or_init(|| program);
}

/// Returns the declared program. Where none is declared, commit and sources are `unknown`, and all builds of a version
/// resume each other's runs.
pub fn program() -> &'static Program {
    PROGRAM.get_or_init(|| Program {
        version: env!("CARGO_PKG_VERSION").into(),
        commit: "unknown".into(),
        sources: "unknown".into(),
    })
}

impl Program {
    /// Name in messages.
    pub fn name(&self) -> String {
        format!("caustics {} (commit {}, sources {})", self.version, self.commit, self.sources)
    }
}
