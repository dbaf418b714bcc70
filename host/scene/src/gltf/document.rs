//! The document: container, JSON, required extensions, buffers.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use gltf::json::{Index, Root};
use serde_json::Value;

use super::atlas::Atlas;
use super::extension::Compressed;
use super::options::LoadOptions;
use super::required::{Lack, without};
use super::warning::Warnings;
use super::{buffer, extension, shape, translate, unsupported, version};
use crate::texture::Image;
use crate::{Radiance, SceneError};
use caustics_files::memory::{Budget, Short, json_tree_bytes};

/// A parsed document with its buffers and what it asks for in vain.
pub struct Document {
    /// Path of the file, for messages.
    pub file: String,
    /// The document.
    pub root: Root,
    /// Contents of its buffers.
    pub buffers: Vec<Vec<u8>>,
    /// Bytes of its JSON and of its buffers, as they were read.
    pub bytes: u64,
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
    /// What it requires and is read without.
    pub lack: Option<Lack>,
    /// Memory for what is yet to be read.
    budget: Budget,
}

/// Sections of the document, for what its types drop or take too literally.
#[derive(Default)]
pub struct Sections {
    /// Animations.
    pub animations: Vec<Value>,
    /// Skins.
    pub skins: Vec<Value>,
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
        // Sections are there twice, and so is the text.
        budget.take(2 * json_tree_bytes(json)).map_err(|short| too_much(file, "its JSON", short))?;
        let mut value = parse(json).map_err(|error| wrong(error.to_string()))?;
        make_whole(&mut value);

        let mut warnings = Warnings::default();
        version::check(file, &value, options, &mut warnings)?;
        shape::check(&value).map_err(wrong)?;
        let lack = Lack::find(file, &value, options, &mut warnings)?;
        let json_bytes = json.len() as u64;
        let parsed = Parsed { value, json_bytes, binary, folder, budget, warnings, lack: lack.clone() };
        parsed.document(file, options).map_err(|error| without(lack, error))
    }
}

/// A document whose JSON has the right types.
struct Parsed<'a> {
    value: Value,
    json_bytes: u64,
    binary: Option<&'a [u8]>,
    folder: &'a Path,
    budget: Budget,
    warnings: Warnings,
    lack: Option<Lack>,
}

impl Parsed<'_> {
    /// What its types say, with its buffers.
    fn document(self, file: &str, options: &LoadOptions) -> Result<Document, SceneError> {
        let Parsed { mut value, json_bytes, binary, folder, mut budget, mut warnings, lack } = self;
        let wrong = |what: String| SceneError::Document { file: file.into(), what };
        translate::translate(file, &mut value, options, &mut warnings)?;
        unsupported::list(&value, &mut warnings);
        let section = |name: &str| value[name].as_array().cloned().unwrap_or_default();
        let sections = Sections {
            animations: section("animations"),
            skins: section("skins"),
            materials: section("materials"),
            textures: section("textures"),
            samplers: section("samplers"),
            images: section("images"),
            buffer_views: section("bufferViews"),
            instancing: extension::instances(&value),
        };
        let background = background(&value).map_err(wrong)?;
        let environment = scene_extras(&value)["environment"].clone();
        let is_fallback = extension::fallbacks(&value, binary.is_some());
        let image_based = extension::image_based(&value, default_scene(&value));
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
        let bytes = lengths.fold(0, u64::saturating_add);
        budget.take(bytes).map_err(|short| too_much(file, "its buffers", short))?;
        let buffers = buffer::load(file, &root, &is_fallback, binary, folder)?;
        let bytes = json_bytes + buffers.iter().map(|buffer| buffer.len() as u64).sum::<u64>();
        let (file, folder, options) = (file.into(), folder.into(), options.clone());
        Ok(Document {
            file,
            root,
            buffers,
            bytes,
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
            lack,
            budget,
        })
    }
}

impl Document {
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

    /// Takes memory for what is there for a while, after other such things that are not any more: the growth of the `largest`
    /// [bytes].
    pub fn take_for_a_while(
        &mut self,
        bytes: u64,
        largest: &mut u64,
        what: impl std::fmt::Display,
    ) -> Result<(), SceneError> {
        self.take(bytes.saturating_sub(*largest), what)?;
        *largest = bytes.max(*largest);
        Ok(())
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

/// Writes whole numbers without a fraction: 3.0 may stand where glTF wants an integer.
fn make_whole(value: &mut Value) {
    match value {
        Value::Array(elements) => elements.iter_mut().for_each(make_whole),
        Value::Object(members) => members.values_mut().for_each(make_whole),
        Value::Number(number) if number.is_f64() => {
            let exact = number.as_f64().filter(|x| x.fract() == 0.0 && x.abs() <= (1_u64 << 53) as f64);
            if let Some(whole) = exact.filter(|x| *x != 0.0 || x.is_sign_positive()) {
                *value = (whole as i64).into();
            }
        }
        _ => {}
    }
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
    Radiance::new(&channels?).map(|Radiance(radiance)| radiance)
}

/// The JSON and, in a binary container, the first binary chunk. Chunks of other kinds, and what is left behind the last, are
/// skipped.
pub fn split<'a>(file: &str, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), SceneError> {
    let without_mark = |json: &'a [u8]| json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
    let Some(rest) = bytes.strip_prefix(b"glTF") else {
        return Ok((without_mark(bytes), None));
    };
    let wrong = |what: String| SceneError::Container { file: file.into(), what };
    let word = |at: usize| -> Option<u32> {
        let bytes = rest.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(0), word(4)) else {
        return Err(wrong("its header is cut off".into()));
    };
    if version == 1 {
        return Err(SceneError::OldVersion { file: file.into() });
    }
    if version != 2 {
        return Err(wrong(format!("its version is {version}")));
    }
    if (length as usize) > bytes.len() {
        return Err(wrong(format!("{} of {length} bytes are there", bytes.len())));
    }
    // A chunk's kind, its bytes if they are there, and where the next begins.
    let chunk = |at: usize| {
        let (length, kind) = (word(at)? as usize, rest.get(at + 4..at + 8)?);
        let end = (at + 8).saturating_add(length);
        Some((kind, rest.get(at + 8..end), end))
    };
    let Some((b"JSON", json, mut at)) = chunk(8) else {
        return Err(wrong("its JSON chunk is missing".into()));
    };
    let json = json.ok_or_else(|| wrong("its JSON chunk is cut off".into()))?;
    let mut binary = None;
    while let (None, Some((kind, bytes, end))) = (binary, chunk(at)) {
        if kind == b"BIN\0" {
            binary = Some(bytes.ok_or_else(|| wrong("its BIN chunk is cut off".into()))?);
        }
        at = end;
    }
    Ok((without_mark(json), binary))
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
