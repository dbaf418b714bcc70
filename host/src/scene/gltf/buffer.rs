//! Buffers: files beside the document, data in the document, the binary chunk.

use std::io;
use std::path::Path;

use gltf::json::Root;

use crate::scene::SceneError;

/// Reads a regular file; pipes and devices may never end.
pub fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a file"));
    }
    std::fs::read(path)
}

/// Loads every buffer of a document, each of the length that the document says.
pub fn load(
    file: &str,
    root: &Root,
    binary: Option<&[u8]>,
    folder: &Path,
) -> Result<Vec<Vec<u8>>, SceneError> {
    let load_one = |(index, buffer): (usize, &gltf::json::Buffer)| {
        let wrong = |what: String| SceneError::Buffer { file: file.into(), buffer: index, what };
        let mut bytes = match (&buffer.uri, binary) {
            (None, Some(binary)) if index == 0 => binary.to_vec(),
            (None, _) => return Err(wrong("has neither a uri nor a binary chunk".into())),
            (Some(uri), _) => fetch(uri, folder).map_err(wrong)?,
        };
        let length = buffer.byte_length.0;
        if (bytes.len() as u64) < length {
            return Err(wrong(format!("is cut off: {} of {length} bytes are there", bytes.len())));
        }
        bytes.truncate(length as usize);
        Ok(bytes)
    };
    root.buffers.iter().enumerate().map(load_one).collect()
}

/// Bytes of a uri.
pub fn fetch(uri: &str, folder: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, encoded) = data.split_once(";base64,").ok_or("holds data that is not base64")?;
        return decode_base64(encoded).ok_or_else(|| "holds damaged base64 data".into());
    }
    if uri.contains("://") {
        return Err(format!("is at {uri:?}, which is no file"));
    }
    let path = folder.join(decode_percent(uri));
    read_file(&path).map_err(|error| format!("({}) cannot be read: {error}", path.display()))
}

/// A uri as the path that it stands for.
pub fn decode_percent(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = tail.get(..2).filter(|_| *first == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        let decoded = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(decoded.unwrap_or(*first));
        rest = if decoded.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    for symbol in text.trim_end_matches('=').bytes() {
        let value = match symbol {
            b'A'..=b'Z' => symbol - b'A',
            b'a'..=b'z' => symbol - b'a' + 26,
            b'0'..=b'9' => symbol - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
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
    fn text_decodes() {
        assert_eq!(decode_base64("Y2F1c3RpY3M=").unwrap(), b"caustics");
        assert_eq!(decode_base64("Y2F1c3RpYw==").unwrap(), b"caustic");
        assert!(decode_base64("a*b").is_none());
        assert_eq!(decode_percent("a%20b%C3%A9%"), "a b\u{e9}%");
    }
}
