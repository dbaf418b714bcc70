//! Lines to stdout.

use std::fmt::Display;
use std::io::Write;

/// Writes a line to stdout; a reader that has seen enough is no failure.
pub fn say(line: impl Display) -> std::io::Result<()> {
    match writeln!(std::io::stdout(), "{line}") {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}
