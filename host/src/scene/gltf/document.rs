//! The document: container, JSON, required extensions, buffers.

use std::path::{Path, PathBuf};

use glam::Vec3;
use gltf::json::{Index, Root};
use serde_json::Value;

use super::{buffer, unsupported};
use crate::scene::SceneError;

/// A parsed document with its buffers and what it asks for in vain.
pub struct Document {
    /// Path of the file, for messages.
    pub file: String,
    /// The document.
    pub root: Root,
    /// Contents of its buffers.
    pub buffers: Vec<Vec<u8>>,
    /// What is not rendered, each once.
    pub warnings: Vec<String>,
    /// Folder of the file, where others are looked for.
    pub folder: PathBuf,
    /// Sections that are read as plain JSON.
    pub sections: Sections,
    /// `extras.background` of the default scene.
    pub background: Vec3,
}

/// Sections of the document, for what its types drop or take too literally.
#[derive(Default)]
pub struct Sections {
    /// Animations.
    pub animations: Vec<Value>,
    /// Materials.
    pub materials: Vec<Value>,
    /// Textures.
    pub textures: Vec<Value>,
    /// Samplers.
    pub samplers: Vec<Value>,
    /// Images.
    pub images: Vec<Value>,
    /// Buffer views.
    pub buffer_views: Vec<Value>,
}

impl Document {
    /// Parses a .gltf or .glb file and loads its buffers.
    pub fn read(file: &str, bytes: &[u8], folder: &Path) -> Result<Document, SceneError> {
        let wrong = |what: String| SceneError::Document { file: file.into(), what };
        let (json, binary) = split(file, bytes)?;
        let mut value: Value = serde_json::from_slice(json).map_err(|error| wrong(error.to_string()))?;

        let version = value["asset"]["version"].as_str().unwrap_or_default();
        if !version.starts_with("2.") {
            return Err(wrong(format!("asset.version is {version:?} and should be \"2.0\"")));
        }
        for extension in value["extensionsRequired"].as_array().into_iter().flatten() {
            let extension = extension.as_str().unwrap_or_default();
            if !unsupported::EXTENSIONS.contains(&extension) {
                return Err(SceneError::RequiredExtension { file: file.into(), extension: extension.into() });
            }
        }
        let warnings = unsupported::list(&value);
        let section = |name: &str| value[name].as_array().cloned().unwrap_or_default();
        let sections = Sections {
            animations: section("animations"),
            materials: section("materials"),
            textures: section("textures"),
            samplers: section("samplers"),
            images: section("images"),
            buffer_views: section("bufferViews"),
        };
        let background = background(&value).map_err(wrong)?;

        // Take out what the document types cannot parse or what nothing reads.
        if let Some(object) = value.as_object_mut() {
            for section in ["animations", "extensionsRequired", "images", "samplers", "skins", "textures"] {
                object.remove(section);
            }
        }
        let root: Root = serde_json::to_vec(&value)
            .and_then(|json| serde_json::from_slice(&json))
            .map_err(|error| wrong(error.to_string()))?;
        let buffers = buffer::load(file, &root, binary, folder)?;
        let mut document = Document {
            file: file.into(),
            root,
            buffers,
            warnings: Vec::new(),
            folder: folder.into(),
            sections,
            background,
        };
        warnings.into_iter().for_each(|warning| document.warn(warning));
        Ok(document)
    }

    /// Notes what is not rendered, once.
    pub fn warn(&mut self, what: impl std::fmt::Display) {
        let warning = format!("{}: {what}", self.file);
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Looks an index up in a list of the document.
    pub fn get<'a, T>(
        &self,
        list: &'a [T],
        index: Index<T>,
        kind: &'static str,
        owner: &str,
    ) -> Result<&'a T, SceneError> {
        list.get(index.value()).ok_or_else(|| SceneError::Index {
            file: self.file.clone(),
            owner: owner.into(),
            kind,
            index: index.value(),
            count: list.len(),
        })
    }
}

/// Radiance behind everything: `extras.background` of the default scene, else black.
fn background(document: &Value) -> Result<Vec3, String> {
    let scene = document["scene"].as_u64().unwrap_or(0);
    let background = &document["scenes"][scene as usize]["extras"]["background"];
    if background.is_null() {
        return Ok(Vec3::ZERO);
    }
    let channels: Option<Vec<f32>> = background
        .as_array()
        .and_then(|channels| channels.iter().map(|channel| channel.as_f64().map(|c| c as f32)).collect());
    match channels.as_deref() {
        Some(&[red, green, blue]) if [red, green, blue].iter().all(|c| (0.0..=1e30).contains(c)) => {
            Ok(Vec3::new(red, green, blue))
        }
        _ => Err(format!("the scene's extras.background is {background} and should be three radiances")),
    }
}

/// The JSON and, in a binary container, the first binary chunk.
pub fn split<'a>(file: &str, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else {
        return Ok((bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), None));
    };
    let wrong = |what: String| SceneError::Container { file: file.into(), what };
    let word = |at: usize| -> Option<u32> {
        let bytes = rest.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(0), word(4)) else {
        return Err(wrong("its header is cut off".into()));
    };
    if version != 2 {
        return Err(wrong(format!("its version is {version}")));
    }
    if (length as usize) > bytes.len() {
        return Err(wrong(format!("{} of {length} bytes are there", bytes.len())));
    }
    let chunk = |at: usize, kind: &[u8; 4]| -> Result<&'a [u8], SceneError> {
        let name = String::from_utf8_lossy(kind).trim_end_matches('\0').to_string();
        let length = word(at).ok_or_else(|| wrong(format!("its {name} chunk is missing")))? as usize;
        if rest.get(at + 4..at + 8) != Some(kind) {
            return Err(wrong(format!("its {name} chunk is missing")));
        }
        at.checked_add(8)
            .and_then(|start| rest.get(start..start.checked_add(length)?))
            .ok_or_else(|| wrong(format!("its {name} chunk is cut off")))
    };
    let json = chunk(8, b"JSON")?;
    let end = 16 + json.len();
    let binary = if rest.len() > end { Some(chunk(end, b"BIN\0")?) } else { None };
    Ok((json, binary))
}
