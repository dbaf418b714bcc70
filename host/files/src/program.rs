//! Build of the program that uses this library. Output files name it, and only the build that began a run can resume it.
//! This module imports nothing else of the crate.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

/// Build of a program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Version of its package.
    pub version: String,
    /// Commit of its sources.
    pub commit: String,
    /// Hash of the sources of its crates. A commit misses uncommitted changes, and it also changes with documents.
    pub sources: String,
}

static PROGRAM: OnceLock<Program> = OnceLock::new();

/// Declares this process's program, before it reads or writes files. Only the first declaration has an effect.
pub fn declare(program: Program) {
    PROGRAM.get_or_init(|| program);
}

/// Returns the declared program. If none was declared, commit and sources are `unknown`, and all builds of a version resume
/// each other's runs.
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
