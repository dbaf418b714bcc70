//! Attributes in the header of an EXR file. They are sorted by name, so that equal images give equal files. Texts are
//! UTF-8, as OpenEXR's own tools expect. One attribute holds a checksum of the file.

use std::collections::BTreeMap;
use std::io::Cursor;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, Text};

use super::EncodeError;

/// Offset of the attributes behind magic number and version (bytes).
const START: usize = 8;

/// Name of the attribute that holds the CRC-32 of the file, taken with zeros in its own value.
pub const CHECKSUM: &str = "crc32";
/// Placeholder of the checksum, with the same number of hexadecimal digits.
const UNKNOWN: &str = "00000000";

/// Returns a text as the value of an EXR attribute.
pub fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Decodes the text of an EXR attribute as UTF-8, or else as Latin-1.
pub fn decode(text: &Text) -> String {
    String::from_utf8(text.bytes().to_vec()).unwrap_or_else(|_| text.to_string())
}

/// Returns the attribute of the checksum with its placeholder: name and value.
pub fn unknown_checksum() -> (Text, AttributeValue) {
    (text(CHECKSUM), AttributeValue::Text(text(UNKNOWN)))
}

/// Writes the checksum into its attribute.
///
/// # Errors
///
/// If the header has no such attribute.
pub fn seal(mut bytes: Vec<u8>) -> Result<Vec<u8>, EncodeError> {
    let offset = checksum_at(&bytes).ok_or(EncodeError::Header("no attribute for a checksum"))?;
    let checksum = format!("{:08x}", crc32fast::hash(&bytes));
    bytes[offset..offset + UNKNOWN.len()].copy_from_slice(checksum.as_bytes());
    Ok(bytes)
}

/// Whether a file is unchanged since [`seal`], to the last bit. `None` for a file without a checksum.
pub fn is_whole(bytes: &[u8]) -> Option<bool> {
    let offset = checksum_at(bytes)?;
    let (head, rest) = bytes.split_at(offset);
    let (known, tail) = rest.split_at(UNKNOWN.len());
    let mut hasher = crc32fast::Hasher::new();
    for part in [head, UNKNOWN.as_bytes(), tail] {
        hasher.update(part);
    }
    Some(known == format!("{:08x}", hasher.finalize()).as_bytes())
}

/// Returns the offset of the checksum's value in a file of one part.
fn checksum_at(bytes: &[u8]) -> Option<usize> {
    let head = [CHECKSUM.as_bytes(), b"\0string\0", &(UNKNOWN.len() as u32).to_le_bytes()].concat();
    let mut at = START;
    while bytes.get(at).is_some_and(|&byte| byte != 0) {
        let end = end(bytes, at).filter(|&end| end <= bytes.len())?;
        if bytes[at..end].starts_with(&head) {
            return Some(at + head.len());
        }
        at = end;
    }
    None
}

/// Sorts the attributes of a file of one part by name and leaves all other bytes in place.
///
/// # Errors
///
/// If the attributes have no end.
pub fn sort(mut bytes: Vec<u8>) -> Result<Vec<u8>, EncodeError> {
    let mut attributes = Vec::new();
    let mut at = START;
    while bytes.get(at).is_some_and(|&byte| byte != 0) {
        let end = end(&bytes, at).filter(|&end| end < bytes.len());
        let end = end.ok_or(EncodeError::Header("no end"))?;
        attributes.push(bytes[at..end].to_vec());
        at = end;
    }
    attributes.sort();
    bytes[START..at].copy_from_slice(&attributes.concat());
    Ok(bytes)
}

/// Returns the end of the attribute at `at`: name, type, size of the value, value.
fn end(bytes: &[u8], at: usize) -> Option<usize> {
    let behind_text = |at: usize| Some(at + bytes.get(at..)?.iter().position(|&byte| byte == 0)? + 1);
    let size = behind_text(behind_text(at)?)?;
    let value = size + 4;
    let length = u32::from_le_bytes(bytes.get(size..value)?.try_into().ok()?);
    value.checked_add(length as usize)
}

/// Returns the texts in the header of a file.
///
/// # Errors
///
/// If the file has no readable header.
pub fn read(bytes: &[u8]) -> ::exr::error::Result<BTreeMap<String, String>> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)?;
    let headers = meta.headers.iter();
    let all = headers.flat_map(|head| head.own_attributes.other.iter().chain(&head.shared_attributes.other));
    Ok(all
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string(), decode(text))),
            _ => None,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::exr;
    use crate::rendered_image::RenderedImage;
    use glam::Vec3;

    #[test]
    fn equal_images_give_equal_files_and_their_attributes_are_read_back() {
        let image =
            RenderedImage { width: 2, height: 1, path: vec![Vec3::ONE; 2], ..RenderedImage::default() };
        // With 16 names, two hash maps almost never agree on their order: there are 16! orders.
        let attributes: BTreeMap<_, _> = (0..16).map(|i| (format!("name_{i}"), format!("κ {i}"))).collect();
        let files: Vec<_> = (0..4).map(|_| exr::encode(&image, None, &attributes).unwrap()).collect();
        assert!(files.iter().all(|file| *file == files[0]));

        let back = read(&files[0]).unwrap();
        assert!(attributes.iter().all(|(name, value)| back[name] == *value), "{back:?}");
        assert_eq!(decode(&Text::new_or_panic("bür")), "bür", "older files hold Latin-1");
        assert!(sort(b"12345678name\0type\0\xff\xff\xff\xffvalue".to_vec()).is_err());
    }

    #[test]
    fn every_flipped_bit_of_a_file_is_found() {
        let image =
            RenderedImage { width: 2, height: 1, path: vec![Vec3::ONE; 2], ..RenderedImage::default() };
        let file = exr::encode(&image, None, &BTreeMap::new()).unwrap();
        assert_eq!(is_whole(&file), Some(true));
        for bit in 0..8 * file.len() {
            let mut bytes = file.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(is_whole(&bytes), Some(true), "bit {bit}");
        }
        assert_eq!(is_whole(&file[..file.len() - 1]), Some(false));
    }
}
