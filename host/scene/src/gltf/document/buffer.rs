//! Buffers: files beside the document, data URIs, and the binary chunk.

use std::path::{Path, PathBuf};

use gltf::json::Root;

use crate::SceneError;
use crate::gltf::context::ImportContext;
use caustics_files::file::read_head;
use caustics_files::text::cut;

/// Loads every buffer of a document, each with its declared length. Fallback buffers stay empty.
pub fn load(
    root: &Root,
    is_fallback: &[bool],
    binary: Option<&[u8]>,
    context: &ImportContext<'_>,
) -> Result<Vec<Vec<u8>>, SceneError> {
    let load_one = |(index, buffer): (usize, &gltf::json::Buffer)| {
        let wrong = |what: String| SceneError::Buffer { file: context.file.into(), buffer: index, what };
        if is_fallback.get(index) == Some(&true) {
            return Ok(Vec::new());
        }
        let length = buffer.byte_length.0;
        let mut bytes = match (&buffer.uri, binary) {
            (None, Some(binary)) if index == 0 => {
                binary[..binary.len().min(usize::try_from(length).unwrap_or(usize::MAX))].to_vec()
            }
            (None, _) => return Err(wrong("has neither a uri nor a binary chunk".into())),
            (Some(uri), _) => fetch(uri, context.folder, length).map_err(wrong)?,
        };
        if (bytes.len() as u64) < length {
            return Err(wrong(format!("is cut off: {} of {length} bytes are there", bytes.len())));
        }
        bytes.truncate(length as usize);
        Ok(bytes)
    };
    root.buffers.iter().enumerate().map(load_one).collect()
}

/// Returns the bytes of a URI; a file gives no more than `max_bytes`.
pub fn fetch(uri: &str, folder: &Path, max_bytes: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data.split_once(',').ok_or("holds data without a comma before it")?;
        let data = percent_decoded(data);
        return match kind.to_ascii_lowercase().ends_with(";base64") {
            true => decode_base64(&data).ok_or_else(|| "holds damaged base64 data".into()),
            false => Ok(data),
        };
    }
    if uri.contains("://") {
        return Err(format!("is at {:?}, which is no file", cut(uri, 200)));
    }
    let path = path_of(uri, folder);
    read_head(&path, max_bytes)
        .map_err(|error| format!("({:?}) cannot be read: {error}", cut(&path.display().to_string(), 200)))
}

/// File that a URI names, beside the document. Some exporters do not escape names, and some write the separators of Windows.
/// These forms are tried if no file has the name that glTF demands.
pub fn path_of(uri: &str, folder: &Path) -> PathBuf {
    let decoded = decode_percent(uri);
    let other = [uri.to_string(), decoded.replace('\\', "/"), uri.replace('\\', "/")];
    let wanted = folder.join(decoded);
    if wanted.exists() {
        return wanted;
    }
    other.iter().map(|name| folder.join(name)).find(|path| path.is_file()).unwrap_or(wanted)
}

/// Decodes the name in a URI.
fn decode_percent(uri: &str) -> String {
    String::from_utf8_lossy(&percent_decoded(uri)).into_owned()
}

/// Decodes the bytes of a part of a URI.
fn percent_decoded(uri: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = tail.get(..2).filter(|_| *first == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        let decoded = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(decoded.unwrap_or(*first));
        rest = if decoded.is_some() { &tail[2..] } else { tail };
    }
    bytes
}

/// Decodes base64 of either alphabet; white space is ignored.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    let symbols = text.iter().filter(|symbol| !symbol.is_ascii_whitespace());
    let mut is_at_end = false;
    for &symbol in symbols {
        let value = match symbol {
            b'=' => {
                is_at_end = true;
                continue;
            }
            _ if is_at_end => return None,
            b'A'..=b'Z' => symbol - b'A',
            b'a'..=b'z' => symbol - b'a' + 26,
            b'0'..=b'9' => symbol - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_percent_encodings_decode() {
        assert_eq!(decode_base64(b"Y2F1c3RpY3M=").unwrap(), b"caustics");
        assert_eq!(decode_base64(b"Y2F1\r\n c3RpYw==\n").unwrap(), b"caustic");
        assert_eq!(decode_base64(b"-_-_").unwrap(), decode_base64(b"+/+/").unwrap());
        assert!(decode_base64(b"a*b").is_none() && decode_base64(b"Y2F1=c3Rp").is_none());
        assert_eq!(decode_percent("a%20b%C3%A9%"), "a b\u{e9}%");
    }

    #[test]
    fn data_uris_of_every_form_are_read() {
        let bytes = |uri: &str| fetch(uri, Path::new("/no folder"), 9);
        for uri in [
            "data:application/octet-stream;base64,YSBi",
            "data:;base64,YSBi",
            "data:application/gltf-buffer;charset=utf-8;BASE64,YSBi",
            "data:application/octet-stream,a%20b",
            "data:,a b",
            "data:image/x-odd;base64,YSB%69",
        ] {
            assert_eq!(bytes(uri).as_deref(), Ok(&b"a b"[..]), "{uri}");
        }
        assert!(bytes("data:nothing").unwrap_err().contains("comma"));
    }

    #[test]
    fn files_are_found_under_the_names_that_exporters_write() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, name).unwrap();
            path
        };
        let (spaced, encoded, below) = (file("a b.bin"), file("100%25.bin"), file("maps/\u{e9} 1.png"));
        for (uri, path) in [
            ("a%20b.bin", &spaced),
            ("a b.bin", &spaced),
            ("100%25.bin", &encoded),
            ("100%2525.bin", &encoded),
            ("maps\\\u{e9} 1.png", &below),
            ("./maps/%C3%A9%201.png", &folder.path().join("./maps/\u{e9} 1.png")),
        ] {
            assert_eq!(&path_of(uri, folder.path()), path, "{uri}");
        }
        assert_eq!(path_of("no%20such", folder.path()), folder.path().join("no such"));
    }
}
