//! Groups messages on different files by cause.

use std::path::Path;

/// Returns a message without the leading file name and the trailing advice.
pub fn cause(message: &str, file: &Path) -> String {
    let of_file = format!("{}: ", file.display());
    // Search for the path: a warning names it as it was given to the process.
    let rest = match message.find(&of_file) {
        Some(at) => &message[at + of_file.len()..],
        None => message,
    };
    let end = [
        "; give ",
        "; export ",
        "; repair ",
        "; check ",
        "; restore ",
        "; make ",
        "; add ",
        "; set ",
        "; convert ",
    ]
    .into_iter()
    .filter_map(|advice| rest.rfind(advice))
    .min();
    rest[..end.unwrap_or(rest.len())].into()
}

/// Returns a cause without numbers and names, so that equal causes can be counted. The names of extensions stay.
pub fn kind(cause: &str) -> String {
    // Cut off the owner: "node \"a\" and 3 more: its skin is left out".
    let owned =
        ["node ", "mesh ", "material ", "texture ", "image ", "camera ", "animation ", "skin ", "scene "];
    let cause = match cause.rsplit_once(": ") {
        Some((owner, what)) if owned.iter().any(|kind| owner.starts_with(kind)) => what,
        _ => cause,
    };
    let mut kind = String::new();
    let mut quoted = false;
    for (at, piece) in cause.split('"').enumerate() {
        if at > 0 {
            kind.push('"');
        }
        quoted = at % 2 == 1;
        match quoted && !kind.ends_with("extension \"") {
            true => kind.push_str("..."),
            false if quoted => kind.push_str(piece),
            false => kind.push_str(&without_numbers(piece)),
        }
    }
    if quoted { cause.into() } else { kind }
}

/// Replaces each number of a text by N; digits within words stay.
fn without_numbers(text: &str) -> String {
    let mut out = String::new();
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    for (at, word) in text.split_inclusive(|c: char| !c.is_alphanumeric() && c != '.' && c != '_').enumerate()
    {
        let number = word.trim_end_matches(|c: char| !c.is_alphanumeric());
        let is_bare = !number.is_empty()
            && number.chars().all(is_number)
            && number.starts_with(|c: char| c.is_ascii_digit());
        // "glTF 2.0" is not a number of the file.
        let is_version = at > 0 && out.ends_with("glTF ");
        match is_bare && !is_version {
            true => {
                out.push('N');
                out.push_str(&word[number.len()..]);
            }
            false => out.push_str(word),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_one_kind_are_grouped() {
        let path = Path::new("a/b 2.glb");
        for (message, expected) in [
            (
                "a/b 2.glb: requires the extension \"KHR_draco_mesh_compression\", which is not supported; export the scene without it",
                "requires the extension \"KHR_draco_mesh_compression\", which is not supported",
            ),
            (
                "a/b 2.glb: accessor 12 (mesh \"x y\", primitive 0) reads 4.5 bytes; export the scene again",
                "accessor N (mesh \"...\", primitive N) reads N bytes",
            ),
            ("a/b 2.glb: node 4 and 17 more: its skin is left out", "its skin is left out"),
            (
                "a/b 2.glb: not a whole binary glTF 2.0 file (12 of 40 bytes are there); export or download it again",
                "not a whole binary glTF 2.0 file (N of N bytes are there)",
            ),
            ("its image is black", "its image is black"),
        ] {
            assert_eq!(kind(&cause(message, path)), expected);
        }
    }
}
