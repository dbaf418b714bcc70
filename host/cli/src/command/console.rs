//! Lines to stdout and stderr, and the progress bar.

use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::{Arguments, Display};
use std::io::IsTerminal;
use std::io::Write;

use caustics::text::{cut, printable};

/// Characters of a message at most: a few lines.
const MAX_CHARS: usize = 1200;

/// Writes a line to stdout; a reader that has seen enough is no failure. What is no JSON must be cut before.
pub fn print(line: impl Display) -> std::io::Result<()> {
    match writeln!(std::io::stdout(), "{}", printable(&line.to_string())) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Writes a message to stderr, see `message!`.
pub fn print_message(message: Arguments<'_>) {
    let message = printable(&cut(&message.to_string(), MAX_CHARS));
    // Nobody may be there to read it; that is no reason to stop.
    let _ = writeln!(std::io::stderr(), "{message}");
}

/// Returns an error with its causes, those left out that its text contains already.
pub fn error_chain(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |chain, cause| match cause.to_string() {
        cause if chain.is_empty() => cause,
        cause if chain.contains(&cause) => chain,
        cause => format!("{chain}: {cause}"),
    })
}

/// A bar with the time left, on a terminal only.
pub fn bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {percent}%, {msg}, {eta} left");
    ProgressBar::new(10_000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
