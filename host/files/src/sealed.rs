//! Sealed files, from which a run resumes. Each has a line that names its kind, a line of JSON, a payload and a checksum
//! over all of it. The JSON holds the program that wrote the file, and a head.
//!
//! The checksum is CRC-32 (IEEE). It finds any one or two flipped bits of a file up to 512 MB and any damage within 32
//! consecutive bits. Of all other damage it misses one case in 2^32.
//! The crate computes it at the speed of memory. It guards against accidents, not against attackers.

use std::io::{BufRead, BufReader, Read, Write};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::memory::{self, Short};
use crate::program::{Program, program};

/// Size of the checksum at the end of the file, little-endian (bytes).
const CHECKSUM_BYTES: usize = 4;
/// Maximum size of the first two lines that [`head`] reads (bytes).
const MAX_HEAD_BYTES: u64 = 1 << 24;

/// Error of a sealed file that no run can use.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Unusable {
    /// Its bytes differ from those that were written.
    #[error("is damaged: {0}; remove it and begin anew")]
    Damaged(String),
    /// Reading it takes more memory than is available.
    #[error("would take {0}")]
    Memory(Short),
    /// Another version of the program wrote it. That version may compute other bits.
    #[error("was written by {theirs}, and this is {ours}; go on with that one, or remove it and begin anew")]
    Version {
        /// The program that wrote the file.
        theirs: String,
        /// This program.
        ours: String,
    },
}

impl Unusable {
    /// Error for a file with this damage.
    pub fn damaged(what: impl ToString) -> Unusable {
        Unusable::Damaged(what.to_string())
    }
}

#[derive(Serialize, Deserialize)]
struct Line<H> {
    program: Program,
    head: H,
}

/// Returns the bytes of a file of this kind. `payload` appends the bytes behind the head.
pub fn seal<H: Serialize>(
    kind: &str,
    head: &H,
    payload: impl FnOnce(&mut Vec<u8>),
) -> std::io::Result<Vec<u8>> {
    let (mut content, mut bytes) = (Vec::new(), Vec::new());
    payload(&mut content);
    write(kind, head, &mut bytes, |file| file.write_all(&content))?;
    Ok(bytes)
}

/// Writes a file of this kind; `payload` writes the bytes behind the head.
pub fn write<H: Serialize, W: Write>(
    kind: &str,
    head: &H,
    file: W,
    payload: impl FnOnce(&mut Summed<W>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut summed = Summed { file, checksum: crc32fast::Hasher::new() };
    summed.write_all(first_line(kind).as_bytes())?;
    serde_json::to_writer(&mut summed, &Line { program: program().clone(), head })?;
    summed.write_all(b"\n")?;
    payload(&mut summed)?;
    let Summed { mut file, checksum } = summed;
    file.write_all(&checksum.finalize().to_le_bytes())
}

/// Writer that updates the checksum of all written bytes.
pub struct Summed<W> {
    file: W,
    checksum: crc32fast::Hasher,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.checksum.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

/// Returns head and payload of a file of this kind, if this program wrote it and it is undamaged.
pub fn open<'a, H: DeserializeOwned>(kind: &str, bytes: &'a [u8]) -> Result<(H, &'a [u8]), Unusable> {
    // Recognise files without a checksum. A few flipped bits cannot turn the first line into these two bytes.
    if bytes.starts_with(b"{\"") {
        let theirs = "an older version that wrote no checksum".into();
        return Err(Unusable::Version { theirs, ours: program().name() });
    }
    let (content, checksum) =
        bytes.split_last_chunk::<CHECKSUM_BYTES>().ok_or_else(|| Unusable::damaged("it is cut off"))?;
    if crc32fast::hash(content) != u32::from_le_bytes(*checksum) {
        return Err(Unusable::damaged("its checksum is another"));
    }
    let content = content.strip_prefix(first_line(kind).as_bytes()).ok_or_else(|| no(kind))?;
    let end = content.iter().position(|&byte| byte == b'\n');
    let (line, payload) = content.split_at(end.ok_or_else(|| Unusable::damaged("it has no head"))?);
    Ok((parse(line)?, &payload[1..]))
}

/// Reads only the head of a file of this kind. [`open`] checks the rest.
pub fn head<H: DeserializeOwned>(kind: &str, file: impl Read) -> std::io::Result<Result<H, Unusable>> {
    let (mut first, mut line) = (Vec::new(), Vec::new());
    let mut file = BufReader::new(file.take(MAX_HEAD_BYTES));
    file.read_until(b'\n', &mut first)?;
    if first != first_line(kind).as_bytes() {
        return Ok(Err(no(kind)));
    }
    file.read_until(b'\n', &mut line)?;
    Ok(parse(&line))
}

/// Returns the line that names the kind of a file.
fn first_line(kind: &str) -> String {
    format!("caustics {kind}\n")
}

fn no(kind: &str) -> Unusable {
    Unusable::damaged(format!("it is no {kind}"))
}

/// Parses the head, if this program wrote it.
fn parse<H: DeserializeOwned>(line: &[u8]) -> Result<H, Unusable> {
    memory::check(memory::json_tree_bytes(line)).map_err(Unusable::Memory)?;
    let line: Line<serde_json::Value> = serde_json::from_slice(line).map_err(Unusable::damaged)?;
    let ours = program();
    if (&line.program.version, &line.program.sources) != (&ours.version, &ours.sources) {
        return Err(Unusable::Version { theirs: line.program.name(), ours: ours.name() });
    }
    serde_json::from_value(line.head).map_err(Unusable::damaged)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> Vec<u8> {
        seal("note", &("head", 7), |bytes| bytes.extend(b"pay\nload")).unwrap()
    }

    #[test]
    fn opening_a_sealed_file_returns_its_head_and_payload() {
        assert_eq!(open::<(String, u32)>("note", &file()), Ok((("head".into(), 7), &b"pay\nload"[..])));
        assert!(matches!(open::<(String, u32)>("song", &file()), Err(Unusable::Damaged(_))));
        assert!(matches!(open::<u32>("note", &file()), Err(Unusable::Damaged(_))));
        // The head is read from a file that is cut off behind it.
        let head = |kind: &str, bytes: &[u8]| head::<(String, u32)>(kind, bytes).unwrap();
        let end = file().len() - 8;
        assert_eq!(head("note", &file()[..end]), Ok(("head".into(), 7)));
        for (kind, bytes) in [("song", &file()[..]), ("note", &file()[..20]), ("note", &[])] {
            assert!(matches!(head(kind, bytes), Err(Unusable::Damaged(_))));
        }
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_found() {
        let whole = file();
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(matches!(open::<(String, u32)>("note", &bytes), Err(Unusable::Damaged(_))), "bit {bit}");
        }
        for length in 0..whole.len() {
            assert!(matches!(open::<(String, u32)>("note", &whole[..length]), Err(Unusable::Damaged(_))));
        }
    }

    #[test]
    fn errors_of_files_of_other_versions_name_the_version() {
        let mut other = file();
        other.truncate(other.len() - CHECKSUM_BYTES);
        let text = String::from_utf8(other).unwrap();
        let other = text.replace(&program().sources, "0123456789abcdef").into_bytes();
        let other = [&other[..], &crc32fast::hash(&other).to_le_bytes()].concat();
        let error = open::<(String, u32)>("note", &other).unwrap_err();
        assert!(error.to_string().contains("sources 0123456789abcdef"), "{error}");
        let old = open::<(String, u32)>("note", b"{\"identity\":{}}\nxx").unwrap_err();
        assert!(old.to_string().contains("older version"), "{old}");
    }
}
