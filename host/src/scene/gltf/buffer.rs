//! Buffers: files beside the document, data in the document, the binary chunk.

use std::path::Path;

use gltf::json::Root;
use serde_json::Value;

use crate::file::read_head;
use crate::scene::SceneError;
use crate::text::cut;

/// Loads every buffer of a document, each of the length that the document says; none of what only stands in for others.
pub fn load(
    file: &str,
    root: &Root,
    is_fallback: &[bool],
    binary: Option<&[u8]>,
    folder: &Path,
) -> Result<Vec<Vec<u8>>, SceneError> {
    let load_one = |(index, buffer): (usize, &gltf::json::Buffer)| {
        let wrong = |what: String| SceneError::Buffer { file: file.into(), buffer: index, what };
        if is_fallback.get(index) == Some(&true) {
            return Ok(Vec::new());
        }
        let length = buffer.byte_length.0;
        let mut bytes = match (&buffer.uri, binary) {
            (None, Some(binary)) if index == 0 => {
                binary[..binary.len().min(usize::try_from(length).unwrap_or(usize::MAX))].to_vec()
            }
            (None, _) => return Err(wrong("has neither a uri nor a binary chunk".into())),
            (Some(uri), _) => fetch(uri, folder, length).map_err(wrong)?,
        };
        if (bytes.len() as u64) < length {
            return Err(wrong(format!("is cut off: {} of {length} bytes are there", bytes.len())));
        }
        bytes.truncate(length as usize);
        Ok(bytes)
    };
    root.buffers.iter().enumerate().map(load_one).collect()
}

/// Bytes of a uri; of a file no more than `most`.
pub fn fetch(uri: &str, folder: &Path, most: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, encoded) = data.split_once(";base64,").ok_or("holds data that is not base64")?;
        return decode_base64(encoded).ok_or_else(|| "holds damaged base64 data".into());
    }
    if uri.contains("://") {
        return Err(format!("is at {:?}, which is no file", cut(uri, 200)));
    }
    let path = folder.join(decode_percent(uri));
    read_head(&path, most)
        .map_err(|error| format!("({:?}) cannot be read: {error}", cut(&path.display().to_string(), 200)))
}

/// Bytes of a buffer view.
pub fn view_bytes<'a>(index: u64, views: &[Value], buffers: &'a [Vec<u8>]) -> Result<&'a [u8], String> {
    let view = views
        .get(index as usize)
        .ok_or_else(|| format!("refers to buffer view {index}, but there are {}", views.len()))?;
    let number = |key: &str| view[key].as_u64().unwrap_or(0);
    let buffer = buffers
        .get(number("buffer") as usize)
        .ok_or_else(|| format!("refers to buffer {}, but there are {}", number("buffer"), buffers.len()))?;
    let start = number("byteOffset");
    let end = start.saturating_add(number("byteLength"));
    if end > buffer.len() as u64 {
        return Err(format!("needs {end} bytes of a buffer of {}", buffer.len()));
    }
    Ok(&buffer[start as usize..end as usize])
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
