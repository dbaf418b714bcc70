//! The attributes in the header of an EXR file: in the order of their names, so that equal pictures are equal files, and
//! read back without the pixels.

use std::collections::BTreeMap;
use std::path::Path;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::AttributeValue;
use anyhow::Context;

/// Where the attributes begin: behind magic number and version [bytes].
const START: usize = 8;

/// A text as an EXR attribute holds it: Latin-1, other characters escaped.
pub fn latin(text: &str) -> String {
    let latin = |c: char| if u32::from(c) < 256 { c.to_string() } else { c.escape_unicode().to_string() };
    text.chars().map(latin).collect()
}

/// Sorts the attributes of a file of one part; nothing else moves.
pub fn sort(mut bytes: Vec<u8>) -> anyhow::Result<Vec<u8>> {
    let mut attributes = Vec::new();
    let mut at = START;
    while bytes.get(at).is_some_and(|&byte| byte != 0) {
        let end = end(&bytes, at).filter(|&end| end < bytes.len()).context("an EXR header has no end")?;
        attributes.push(bytes[at..end].to_vec());
        at = end;
    }
    attributes.sort();
    bytes[START..at].copy_from_slice(&attributes.concat());
    Ok(bytes)
}

/// Where the attribute ends that begins here: name, type, size of the value, value.
fn end(bytes: &[u8], at: usize) -> Option<usize> {
    let behind_text = |at: usize| Some(at + bytes.get(at..)?.iter().position(|&byte| byte == 0)? + 1);
    let size = behind_text(behind_text(at)?)?;
    let value = size + 4;
    let length = u32::from_le_bytes(bytes.get(size..value)?.try_into().ok()?);
    value.checked_add(length as usize)
}

/// The texts in the header of a file.
pub fn read(path: &Path) -> anyhow::Result<BTreeMap<String, String>> {
    let meta = MetaData::read_from_file(path, false)
        .with_context(|| format!("{} cannot be read as EXR; give --force or another -o", path.display()))?;
    let headers = meta.headers.iter();
    let all = headers.flat_map(|head| head.own_attributes.other.iter().chain(&head.shared_attributes.other));
    Ok(all
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
            _ => None,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::exr;
    use crate::picture::Picture;
    use glam::Vec3;

    #[test]
    fn equal_pictures_are_equal_files_and_their_attributes_are_read_back() {
        let picture = Picture { width: 2, height: 1, path: vec![Vec3::ONE; 2], ..Picture::default() };
        // Enough names that two hash maps almost never agree on their order: 16! orders.
        let attributes: BTreeMap<_, _> = (0..16).map(|i| (format!("name_{i}"), format!("κ {i}"))).collect();
        let files: Vec<_> = (0..4).map(|_| exr::encode(&picture, None, &attributes).unwrap()).collect();
        assert!(files.iter().all(|file| *file == files[0]));

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, &files[0]).unwrap();
        let back = read(&path).unwrap();
        assert!(attributes.iter().all(|(name, value)| back[name] == latin(value)), "{back:?}");
        assert_eq!(back["name_3"], "\\u{3ba} 3");
        assert!(sort(b"12345678name\0type\0\xff\xff\xff\xffvalue".to_vec()).is_err());
    }
}
