//! Stage 1, the container: the JSON and the binary chunk of a .gltf or .glb file.

use crate::SceneError;

/// Parts of a file.
#[derive(Clone, Copy, Debug)]
pub struct Container<'a> {
    /// JSON, without a byte order mark.
    pub json: &'a [u8],
    /// First binary chunk of a .glb file.
    pub binary: Option<&'a [u8]>,
}

/// Chunk of a .glb file.
struct Chunk<'a> {
    kind: &'a [u8],
    /// Bytes of the chunk, if complete.
    bytes: Option<&'a [u8]>,
    /// Offset of the next chunk.
    end: usize,
}

impl<'a> Container<'a> {
    /// Splits a file. Chunks of other kinds, and bytes behind the last chunk, are ignored.
    pub fn split(file: &str, bytes: &'a [u8]) -> Result<Container<'a>, SceneError> {
        let Some(rest) = bytes.strip_prefix(b"glTF") else {
            return Ok(Container { json: without_mark(bytes), binary: None });
        };
        let wrong = |what: &str| SceneError::Container { file: file.into(), what: what.into() };

        // Header
        let (Some(version), Some(length)) = (word(rest, 0), word(rest, 4)) else {
            return Err(wrong("its header is cut off"));
        };
        if version == 1 {
            return Err(SceneError::OldVersion { file: file.into() });
        }
        if version != 2 {
            return Err(wrong(&format!("its version is {version}")));
        }
        if (length as usize) > bytes.len() {
            return Err(wrong(&format!("{} of {length} bytes are there", bytes.len())));
        }

        // JSON chunk
        let Some(Chunk { kind: b"JSON", bytes: json, mut end }) = chunk(rest, 8) else {
            return Err(wrong("its JSON chunk is missing"));
        };
        let json = json.ok_or_else(|| wrong("its JSON chunk is cut off"))?;

        // First binary chunk
        let mut binary = None;
        while let (None, Some(next)) = (binary, chunk(rest, end)) {
            if next.kind == b"BIN\0" {
                binary = Some(next.bytes.ok_or_else(|| wrong("its BIN chunk is cut off"))?);
            }
            end = next.end;
        }
        Ok(Container { json: without_mark(json), binary })
    }
}

/// Chunk at an offset.
fn chunk(bytes: &[u8], at: usize) -> Option<Chunk<'_>> {
    let (length, kind) = (word(bytes, at)? as usize, bytes.get(at + 4..at + 8)?);
    let end = (at + 8).saturating_add(length);
    Some(Chunk { kind, bytes: bytes.get(at + 8..end), end })
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let bytes = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}

/// Text without a byte order mark.
fn without_mark(json: &[u8]) -> &[u8] {
    json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json)
}
