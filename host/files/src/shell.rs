//! Commands that a person copies and pastes into a shell, made of names from files of others.
//!
//! A terminal acts on control characters before a shell sees quotes: Ctrl-C in single quotes ends the line, and the rest of the name
//! is the next command. Readline takes bytes above 127 for Alt and a key in the locale `C`, and so edits the line; bidirectional and
//! invisible characters show another command than the one that runs. So a command is of printable ASCII, without a line feed.
//!
//! Everything else is written as octal escapes in `$'...'` [POSIX 2024, 2.2.4], which bash, zsh, ksh and busybox read. Other shells
//! get no wrong command of it: dash takes `$'\003'` for `$` and a text in single quotes, which names nothing; fish and csh refuse the
//! line. That holds since no quote and no backslash stands inside of quotes as itself.

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

#[cfg(all(test, unix))]
mod tests;

/// A word of a command; none if it has a NUL, which no argument of a program can hold.
pub fn quoted(word: impl AsRef<OsStr>) -> Option<String> {
    let bytes = word.as_ref().as_encoded_bytes();
    if bytes.contains(&0) {
        return None;
    }
    Some(match Quotes::needed(bytes) {
        Quotes::None => enclosed("", bytes, ""),
        Quotes::Single => enclosed("'", bytes, "'"),
        Quotes::Double => enclosed("\"", bytes, "\""),
        Quotes::Escapes => enclosed("$'", bytes, "'"),
    })
}

/// A path as a word of a command: no option, whatever it begins with.
pub fn path(path: impl AsRef<Path>) -> Option<String> {
    let path = path.as_ref();
    match path.as_os_str().as_encoded_bytes() {
        [b'-', ..] => quoted(Path::new(".").join(path)),
        _ => quoted(path),
    }
}

/// A long option with its value, which is no option, whatever it begins with.
pub fn option(name: &str, value: impl AsRef<OsStr>) -> Option<String> {
    let value = value.as_ref();
    let separator = if value.as_encoded_bytes().starts_with(b"-") { '=' } else { ' ' };
    Some(format!("--{name}{separator}{}", quoted(value)?))
}

/// The hash of a commit that `git checkout` can be given; none if the text is none.
pub fn commit(text: &str) -> Option<&str> {
    let is_hash = (7..=64).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_hash.then_some(text)
}

/// Quotes that a word needs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Quotes {
    None,
    Single,
    Double,
    Escapes,
}

impl Quotes {
    fn needed(bytes: &[u8]) -> Quotes {
        // An empty word needs some; zsh takes `=name` for the path of a program.
        let is_bare = bytes.first().is_some_and(|first| !b"=+".contains(first));
        let min_quotes = if is_bare { Quotes::None } else { Quotes::Single };
        let needed = bytes.iter().map(Quotes::for_byte).fold(min_quotes, Quotes::max);
        // Expanded in double quotes.
        let expands = || bytes.iter().any(|byte| b"\"$`".contains(byte));
        if needed == Quotes::Double && expands() { Quotes::Escapes } else { needed }
    }

    fn for_byte(byte: &u8) -> Quotes {
        match byte {
            b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => Quotes::None,
            b'-' | b'_' | b'.' | b'/' | b',' | b':' | b'=' | b'+' | b'@' | b'%' => Quotes::None,
            b'\'' => Quotes::Double,
            // A backslash escapes a quote in fish, `!` calls the history in csh and in double quotes.
            b'\\' | b'!' => Quotes::Escapes,
            b' '..=b'~' => Quotes::Single,
            _ => Quotes::Escapes,
        }
    }
}

/// A word in quotes; what does not stand in them as itself is escaped.
fn enclosed(open: &str, bytes: &[u8], close: &str) -> String {
    let mut text = String::with_capacity(bytes.len() + 3);
    text.push_str(open);
    for byte in bytes {
        let is_itself = match open {
            "$'" => Quotes::for_byte(byte) <= Quotes::Single,
            _ => true,
        };
        match is_itself {
            true => text.push(char::from(*byte)),
            // Three digits: one that follows is not taken for a fourth. A String is always written to.
            false => _ = write!(text, "\\{byte:03o}"),
        }
    }
    text.push_str(close);
    text
}
