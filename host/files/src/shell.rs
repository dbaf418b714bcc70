//! Shell commands that a user can copy and paste, with names from files of unknown origin.
//!
//! A terminal acts on control characters before a shell sees quotes. Ctrl-C in single quotes ends the line, and the rest of
//! the name is the next command. In the locale `C`, Readline reads bytes above 127 as Alt and a key, and edits the line.
//! Bidirectional and invisible characters display another command than the one that runs. Therefore a command consists of
//! printable ASCII without a line feed.
//!
//! All other bytes become octal escapes in `$'...'` [POSIX 2024, 2.2.4], which bash, zsh, ksh and busybox read. Other
//! shells run no wrong command.
//! In dash `$'\003'` is `$` and a text in single quotes, which names no file; fish and csh refuse the line. This holds
//! because quotes and backslashes inside of quotes are always escaped.

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

#[cfg(all(test, unix))]
mod tests;

/// Quotes a word of a command. `None` if it has a NUL, which no argument of a program can hold.
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

/// Quotes a path as a word of a command. A path that begins with a dash is not taken for an option.
pub fn path(path: impl AsRef<Path>) -> Option<String> {
    let path = path.as_ref();
    match path.as_os_str().as_encoded_bytes() {
        [b'-', ..] => quoted(Path::new(".").join(path)),
        _ => quoted(path),
    }
}

/// Quotes a long option with its value. A value that begins with a dash is not taken for an option.
pub fn option(name: &str, value: impl AsRef<OsStr>) -> Option<String> {
    let value = value.as_ref();
    let separator = if value.as_encoded_bytes().starts_with(b"-") { '=' } else { ' ' };
    Some(format!("--{name}{separator}{}", quoted(value)?))
}

/// Checks the hash of a commit for `git checkout`. `None` if the text is not 7 to 64 hexadecimal digits.
pub fn commit(text: &str) -> Option<&str> {
    let is_hash = (7..=64).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_hash.then_some(text)
}

/// Kind of quotes that a word needs, in ascending order of strength.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Quotes {
    None,
    Single,
    Double,
    Escapes,
}

impl Quotes {
    fn needed(bytes: &[u8]) -> Quotes {
        // An empty word needs quotes. zsh replaces `=name` by the path of a program.
        let is_bare = bytes.first().is_some_and(|first| !b"=+".contains(first));
        let min_quotes = if is_bare { Quotes::None } else { Quotes::Single };
        let needed = bytes.iter().map(Quotes::for_byte).fold(min_quotes, Quotes::max);
        // Double quotes expand these.
        let expands = || bytes.iter().any(|byte| b"\"$`".contains(byte));
        if needed == Quotes::Double && expands() { Quotes::Escapes } else { needed }
    }

    fn for_byte(byte: &u8) -> Quotes {
        match byte {
            b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => Quotes::None,
            b'-' | b'_' | b'.' | b'/' | b',' | b':' | b'=' | b'+' | b'@' | b'%' => Quotes::None,
            b'\'' => Quotes::Double,
            // In fish a backslash escapes a quote. In csh and in double quotes `!` recalls the history.
            b'\\' | b'!' => Quotes::Escapes,
            b' '..=b'~' => Quotes::Single,
            _ => Quotes::Escapes,
        }
    }
}

/// Puts a word in quotes, with escapes for bytes that the quotes do not protect.
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
            // Always write three digits, so that a digit behind the escape does not belong to it. Writing to a String
            // cannot fail.
            false => _ = write!(text, "\\{byte:03o}"),
        }
    }
    text.push_str(close);
    text
}
