//! The document: container, JSON, required extensions, buffers.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use gltf::json::{Index, Root};
use serde_json::Value;

use super::atlas::Atlas;
use super::extension::Compressed;
use super::options::LoadOptions;
use super::warning::Warnings;
use super::{buffer, extension, shape, translate, unsupported};
use crate::memory::{Budget, Short};
use crate::scene::SceneError;
use crate::scene::texture::Image;
use crate::text::cut;

/// A parsed document with its buffers and what it asks for in vain.
pub struct Document {
    /// Path of the file, for messages.
    pub file: String,
    /// The document.
    pub root: Root,
    /// Contents of its buffers.
    pub buffers: Vec<Vec<u8>>,
    /// What is not rendered.
    pub warnings: Warnings,
    /// Folder of the file, where others are looked for.
    pub folder: PathBuf,
    /// Sections that are read as plain JSON.
    pub sections: Sections,
    /// `extras.background` of the default scene.
    pub background: Vec3,
    /// `extras.environment` of the default scene.
    pub environment: Value,
    /// The light of EXT_lights_image_based that the default scene refers to, or what is wrong with its reference.
    pub image_based: Option<Result<Value, String>>,
    /// How it is read.
    pub options: LoadOptions,
    /// Images that are made of vertex colours.
    pub baked: Vec<Image>,
    /// Where the triangles of a material lie on such an image, by its index.
    pub atlases: HashMap<usize, Atlas>,
    /// Primitives that are compressed.
    pub compressed: Vec<Compressed>,
    /// Memory for what is yet to be read.
    budget: Budget,
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
    /// Attributes of instances, by the node whose mesh they place.
    pub instancing: HashMap<usize, Value>,
}

impl Document {
    /// Parses a .gltf or .glb file and loads its buffers.
    pub fn read(
        file: &str,
        bytes: &[u8],
        folder: &Path,
        options: &LoadOptions,
    ) -> Result<Document, SceneError> {
        let wrong = |what: String| SceneError::Document { file: file.into(), what };
        let (json, binary) = split(file, bytes)?;
        let mut budget = Budget::new();
        let mut take = |bytes, what: &str| budget.take(bytes).map_err(|short| too_much(file, what, short));
        take(parsed_bytes(json), "its JSON")?;
        let mut value = parse(json).map_err(|error| wrong(error.to_string()))?;

        let version = value["asset"]["version"].as_str().unwrap_or_default();
        if !version.starts_with("2.") {
            return Err(wrong(format!("asset.version is {version:?} and should be \"2.0\"")));
        }
        if let Some(least) = value["asset"]["minVersion"].as_str().filter(|least| *least != "2.0") {
            return Err(wrong(format!("asset.minVersion is {least:?}, but only \"2.0\" is read")));
        }
        shape::check(&value).map_err(wrong)?;
        for extension in value["extensionsRequired"].as_array().into_iter().flatten() {
            let extension = extension.as_str().unwrap_or_default();
            if !unsupported::EXTENSIONS.contains(&extension) {
                let remedy = unsupported::remedy(extension);
                let (file, extension) = (file.into(), cut(extension, 80));
                return Err(SceneError::RequiredExtension { file, extension, remedy });
            }
        }
        let mut warnings = Warnings::default();
        translate::translate(file, &mut value, options, &mut warnings)?;
        unsupported::list(&value, &mut warnings);
        let section = |name: &str| value[name].as_array().cloned().unwrap_or_default();
        let sections = Sections {
            animations: section("animations"),
            materials: section("materials"),
            textures: section("textures"),
            samplers: section("samplers"),
            images: section("images"),
            buffer_views: section("bufferViews"),
            instancing: extension::instances(&value),
        };
        let background = background(&value).map_err(wrong)?;
        let environment = scene_extras(&value)["environment"].clone();
        let image_based = extension::image_based(&value, default_scene(&value));
        let is_fallback: Vec<bool> = section("buffers").iter().map(extension::is_fallback).collect();
        let compressed = extension::compressed_primitives(&value);

        // Take out what the document types cannot parse or what nothing reads.
        if let Some(object) = value.as_object_mut() {
            for section in ["animations", "extensionsRequired", "images", "samplers", "skins", "textures"] {
                object.remove(section);
            }
        }
        remove_extras(&mut value);
        let root: Root = serde_json::to_vec(&value)
            .and_then(|json| serde_json::from_slice(&json))
            .map_err(|error| wrong(error.to_string()))?;
        let buffers = root.buffers.iter().zip(&is_fallback).filter(|(_, is_fallback)| !**is_fallback);
        let lengths = buffers.map(|(buffer, _)| buffer.byte_length.0);
        take(lengths.fold(0, u64::saturating_add), "its buffers")?;
        let buffers = buffer::load(file, &root, &is_fallback, binary, folder)?;
        let (file, folder, options) = (file.into(), folder.into(), options.clone());
        Ok(Document {
            file,
            root,
            buffers,
            warnings,
            folder,
            sections,
            background,
            environment,
            image_based,
            options,
            baked: Vec::new(),
            atlases: HashMap::new(),
            compressed,
            budget,
        })
    }

    /// Notes that `owner` asks for what is not rendered, or not as it is asked for.
    pub fn warn(&mut self, owner: &str, what: impl std::fmt::Display) {
        self.warnings.note(owner, what);
    }

    /// Notes that `instead` is rendered of what is wrong; an error where the file is read strictly.
    pub fn replace(
        &mut self,
        owner: &str,
        what: &str,
        instead: &str,
        error: SceneError,
    ) -> Result<(), SceneError> {
        if self.options.strict {
            return Err(error);
        }
        self.warn(owner, format_args!("{what}; {instead}"));
        Ok(())
    }

    /// Takes memory for what is about to be read [bytes, by an estimate].
    pub fn take(&mut self, bytes: u64, what: impl std::fmt::Display) -> Result<(), SceneError> {
        self.budget.take(bytes).map_err(|short| too_much(&self.file, what, short))
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

fn too_much(file: &str, what: impl std::fmt::Display, short: Short) -> SceneError {
    let Short { needed, available } = short;
    SceneError::Memory { file: file.into(), what: what.to_string(), needed, available }
}

/// Memory that a parsed document takes, at most about (bytes): the least node of the tree that holds an object's members has
/// 632, any value 32; sections are there twice, and so is the text.
fn parsed_bytes(json: &[u8]) -> u64 {
    let (mut objects, mut values) = (0, 0);
    for byte in json {
        objects += u64::from(*byte == b'{');
        values += u64::from(matches!(byte, b',' | b'['));
    }
    2 * (700 * objects + 64 * values + json.len() as u64)
}

/// Brackets that stand around each other in what is read; the parser of JSON ends at 128, and glTF needs a dozen.
const MAX_DEPTH: usize = 100;

/// The JSON. `extras` and unknown extensions may nest as deep as they like and hold any number; what nobody reads is left
/// out then.
fn parse(json: &[u8]) -> Result<Value, serde_json::Error> {
    serde_json::from_slice(json).or_else(|_| {
        // Without recursion and values: whether it is JSON all through.
        serde_json::from_slice::<serde::de::IgnoredAny>(json)?;
        serde_json::from_slice(&tamed(json))
    })
}

/// A document with numbers that f64 holds, those beyond being very large ones, and with empty lists and objects where
/// they stand in as many others as are read.
fn tamed(json: &[u8]) -> Vec<u8> {
    let mut depth = 0_usize;
    let mut kept = Vec::with_capacity(json.len());
    for token in tokens(json) {
        if matches!(token, b"]" | b"}") {
            depth = depth.saturating_sub(1);
        }
        if depth < MAX_DEPTH {
            let number = std::str::from_utf8(token).ok().and_then(|token| token.parse::<f64>().ok());
            kept.extend_from_slice(match number {
                Some(f64::INFINITY) => b"1e308",
                Some(f64::NEG_INFINITY) => b"-1e308",
                _ => token,
            });
        }
        if matches!(token, b"[" | b"{") {
            depth += 1;
        }
    }
    kept
}

/// The JSON in pieces: texts with their quotes, numbers, and single bytes.
fn tokens(json: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = json;
    std::iter::from_fn(move || {
        let length = match *rest.first()? {
            b'"' => {
                let mut is_escaped = false;
                let is_end = |&byte: &u8| {
                    let is_end = byte == b'"' && !is_escaped;
                    is_escaped = byte == b'\\' && !is_escaped;
                    is_end
                };
                rest[1..].iter().position(is_end).map_or(rest.len(), |at| at + 2)
            }
            _ => {
                let is_of_number =
                    |byte: &&u8| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E');
                rest.iter().take_while(is_of_number).count().max(1)
            }
        };
        let (token, behind) = rest.split_at(length);
        rest = behind;
        Some(token)
    })
}

/// Removes all `extras`: they may be any JSON, which the document types do not know.
fn remove_extras(value: &mut Value) {
    match value {
        Value::Array(elements) => elements.iter_mut().for_each(remove_extras),
        Value::Object(members) => {
            members.remove("extras");
            members.values_mut().for_each(remove_extras);
        }
        _ => {}
    }
}

/// Radiance behind everything: `extras.background` of the default scene, else black.
fn background(document: &Value) -> Result<Vec3, String> {
    let background = &scene_extras(document)["background"];
    if background.is_null() {
        return Ok(Vec3::ZERO);
    }
    radiance(background)
        .ok_or_else(|| format!("the scene's extras.background is {background} and should be three radiances"))
}

/// `extras` of the default scene.
pub fn scene_extras(document: &Value) -> &Value {
    &default_scene(document)["extras"]
}

/// The default scene.
fn default_scene(document: &Value) -> &Value {
    let scene = document["scene"].as_u64().unwrap_or(0);
    &document["scenes"][scene as usize]
}

/// Three radiances.
pub fn radiance(value: &Value) -> Option<Vec3> {
    let channels: Option<Vec<f32>> = value
        .as_array()
        .and_then(|channels| channels.iter().map(|channel| channel.as_f64().map(|c| c as f32)).collect());
    match channels.as_deref() {
        Some(&[red, green, blue]) if [red, green, blue].iter().all(|c| (0.0..=1e30).contains(c)) => {
            Some(Vec3::new(red, green, blue))
        }
        _ => None,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nests_too_deep_is_emptied_and_nothing_else() {
        let deep = |depth: usize| format!("{}1{}", "[".repeat(depth), "]".repeat(depth));
        let text = |depth: usize| format!(r#"{{"a":{},"b":"[\\\"[","c":[[2]]}}"#, deep(depth));
        let (near, far) = (text(MAX_DEPTH - 2), text(100_000));
        assert_eq!(tamed(near.as_bytes()), near.as_bytes());
        let read = parse(far.as_bytes()).unwrap();
        assert_eq!((&read["b"], &read["c"][0][0]), (&"[\\\"[".into(), &2.into()));
        let mut depth = 0;
        let mut at = &read["a"];
        while let Some(inner) = at.as_array() {
            (depth, at) = (depth + 1, inner.first().unwrap_or(&Value::Null));
        }
        assert_eq!(depth, MAX_DEPTH - 1);
        for broken in ["[".repeat(100_000), format!("{}}}", deep(300)), deep(300).replacen(']', "}", 1)] {
            assert!(parse(broken.as_bytes()).is_err());
        }
    }

    #[test]
    fn numbers_beyond_all_bounds_are_very_large_ones() {
        let text =
            r#"{"1e999":["1e999\\\"1e999",1e999,-1e999,{"a":123456789e400}],"b":[true,false,1.5e3,-0]}"#;
        let read = parse(text.as_bytes()).unwrap();
        assert_eq!(read["1e999"], serde_json::json!(["1e999\\\"1e999", 1e308, -1e308, { "a": 1e308 }]));
        assert_eq!(read["b"], serde_json::json!([true, false, 1500.0, -0.0]));
        assert!(parse(b"[1e999,1e]").is_err() && parse(b"[1e999").is_err());
    }
}
