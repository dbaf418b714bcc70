//! Text of unknown origin in messages: it must not control the terminal or fill the screen.

/// Escapes control characters except line feed and tab, and characters that change the direction of writing. The escapes
/// are those of JSON, so that a JSON document keeps its meaning.
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if is_active(character) {
            shown.push_str(&format!("\\u{:04x}", u32::from(character)));
        } else {
            shown.push(character);
        }
    }
    shown
}

/// Whether a terminal acts on a character instead of showing it. All such characters have at most four hexadecimal digits.
fn is_active(character: char) -> bool {
    match character {
        '\n' | '\t' => false,
        // Direction marks and overrides; separators of lines and paragraphs.
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        // C0 controls, delete and C1 controls.
        _ => character.is_control(),
    }
}

/// Cuts the middle out of a text of more than `max_chars` characters and leaves a note there. In a message, the beginning
/// names the object and the end gives the remedy.
pub fn cut(text: &str, max_chars: usize) -> String {
    // A text has at most one character a byte.
    if text.len() <= max_chars {
        return text.into();
    }
    let count = text.chars().count();
    if count <= max_chars {
        return text.into();
    }
    let tail = max_chars / 3;
    let head: String = text.chars().take(max_chars - tail).collect();
    let rest: String = text.chars().skip(count - tail).collect();
    format!("{head} [{} characters left out] {rest}", count - max_chars)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_control_characters_are_escaped_as_in_json() {
        assert_eq!(printable("a\nb\tc d\u{e9}\u{4e16}"), "a\nb\tc d\u{e9}\u{4e16}");
        let active = "\x1b]0;owned\x07\x1b[2J\r\x08\x7f\u{9b}31m\u{202e}\u{2066}\u{2028}";
        let shown = printable(active);
        assert_eq!(
            shown,
            "\\u001b]0;owned\\u0007\\u001b[2J\\u000d\\u0008\\u007f\\u009b31m\\u202e\\u2066\\u2028"
        );
        // A JSON document keeps its meaning.
        let json = serde_json::to_string(active).unwrap();
        let back: String = serde_json::from_str(&printable(&json)).unwrap();
        assert_eq!(back, active);
    }

    #[test]
    fn long_text_loses_its_middle() {
        assert_eq!(cut("abc", 3), "abc");
        assert_eq!(cut("\u{e9}\u{e9}\u{e9}", 3), "\u{e9}\u{e9}\u{e9}");
        assert_eq!(cut("abcdefghij", 6), "abcd [4 characters left out] ij");
    }
}
