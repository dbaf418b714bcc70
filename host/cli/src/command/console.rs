//! Lines to stdout and stderr, and the progress bar.

use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::{Arguments, Display};
use std::io::IsTerminal;
use std::io::Write;

use caustics::text::{cut, printable};

/// Maximum length of a message (characters), a few lines.
const MAX_CHARS: usize = 1200;

/// Writes a line to stdout. A reader that has closed the stream is not an error. The caller cuts long texts other than
/// JSON.
pub fn print(line: impl Display) -> std::io::Result<()> {
    match writeln!(std::io::stdout(), "{}", printable(&line.to_string())) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Writes a message to stderr, see `message!`.
pub fn print_message(message: Arguments<'_>) {
    let message = printable(&cut(&message.to_string(), MAX_CHARS));
    // Ignore a closed stderr: it is no reason to stop.
    let _ = writeln!(std::io::stderr(), "{message}");
}

/// Returns an error with its causes, without those that its text already contains.
pub fn error_chain(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |chain, cause| match cause.to_string() {
        cause if chain.is_empty() => cause,
        cause if chain.contains(&cause) => chain,
        cause => format!("{chain}: {cause}"),
    })
}

/// Returns a progress bar with the time left; it is visible on a terminal only.
pub fn bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {percent}%, {msg}, {eta} left");
    ProgressBar::new(10_000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
