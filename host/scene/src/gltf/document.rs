//! Stage 2, the result: a document with the types of glTF, and its buffers.

use glam::Vec3;
use gltf::json::Root;
use serde_json::Value;

use self::extension::ImageBasedLight;
use self::sections::Sections;
use super::checked_json::CheckedJson;
use super::context::ImportContext;
use super::json::remove_extras;
use crate::{Radiance, SceneError};

pub mod buffer;
pub mod extension;
mod members;
pub mod sections;

/// Sections that the crate gltf cannot parse, or that are not read from its types.
const LEFT_OUT: [&str; 6] = ["animations", "extensionsRequired", "images", "samplers", "skins", "textures"];

/// A document with typed JSON and loaded buffers.
pub struct Document {
    /// Sections in the types of the crate gltf.
    pub root: Root,
    /// Sections in the import's own types.
    pub sections: Sections,
    /// Contents of the buffers.
    pub buffers: Vec<Vec<u8>>,
    /// Number of buffer views of the file; decoding appends others.
    pub view_count: usize,
    /// Length of the JSON and the buffers (bytes).
    pub bytes: u64,
    /// `extras.background` of the default scene.
    pub background: Vec3,
    /// `extras.environment` of the default scene.
    pub environment: Value,
    /// Light of EXT_lights_image_based that the default scene refers to, or the fault of its reference.
    pub image_based: Option<Result<ImageBasedLight, String>>,
}

impl Document {
    /// Gives checked JSON its types, and loads its buffers.
    pub fn load(
        json: CheckedJson,
        binary: Option<&[u8]>,
        context: &mut ImportContext<'_>,
    ) -> Result<Document, SceneError> {
        let CheckedJson { mut value, bytes: json_bytes } = json;
        let background = background(&value).map_err(|what| context.document_error(what))?;
        let environment = scene_extras(&value)["environment"].clone();
        let image_based = extension::image_based(&value, default_scene(&value));
        let is_fallback = extension::fallbacks(&value, binary.is_some());
        let sections = Sections::take(&mut value).map_err(|error| context.document_error(error))?;
        let root = typed(value).map_err(|error| context.document_error(error))?;

        // Reserve memory for the buffers, then load them
        let buffers = root.buffers.iter().zip(&is_fallback).filter(|(_, is_fallback)| !**is_fallback);
        let lengths = buffers.map(|(buffer, _)| buffer.byte_length.0);
        context.take(lengths.fold(0, u64::saturating_add), "its buffers")?;
        let buffers = buffer::load(&root, &is_fallback, binary, context)?;
        let bytes = json_bytes + buffers.iter().map(|buffer| buffer.len() as u64).sum::<u64>();
        let view_count = root.buffer_views.len();
        Ok(Document { root, sections, buffers, view_count, bytes, background, environment, image_based })
    }

    /// Bytes of a buffer view of the file. An error describes the fault of the reference.
    pub fn view_bytes(&self, index: usize) -> Result<&[u8], String> {
        let views = &self.root.buffer_views[..self.view_count];
        let view = views
            .get(index)
            .ok_or_else(|| format!("refers to buffer view {index}, but there are {}", views.len()))?;
        let start = view.byte_offset.unwrap_or_default().0;
        self.buffer_bytes(view.buffer.value(), start, view.byte_length.0)
    }

    /// Bytes of a part of a buffer. An error describes the fault of the reference.
    pub fn buffer_bytes(&self, buffer: usize, start: u64, length: u64) -> Result<&[u8], String> {
        let count = self.buffers.len();
        let bytes = self
            .buffers
            .get(buffer)
            .ok_or_else(|| format!("refers to buffer {buffer}, but there are {count}"))?;
        let end = start.saturating_add(length);
        if end > bytes.len() as u64 {
            return Err(format!("needs {end} bytes of a buffer of {}", bytes.len()));
        }
        Ok(&bytes[start as usize..end as usize])
    }
}

/// Parses JSON into the types of the crate gltf, without the parts that they do not support.
fn typed(mut value: Value) -> Result<Root, serde_json::Error> {
    if let Some(members) = value.as_object_mut() {
        LEFT_OUT.iter().for_each(|section| drop(members.remove(*section)));
    }
    remove_extras(&mut value);
    let json = serde_json::to_vec(&value)?;
    drop(value);
    serde_json::from_slice(&json)
}

/// Background radiance: `extras.background` of the default scene, or black.
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

/// Default scene.
fn default_scene(document: &Value) -> &Value {
    let scene = document["scene"].as_u64().unwrap_or(0);
    &document["scenes"][scene as usize]
}

/// Radiance of three channels.
pub fn radiance(value: &Value) -> Option<Vec3> {
    let channels: Option<Vec<f32>> = value
        .as_array()
        .and_then(|channels| channels.iter().map(|channel| channel.as_f64().map(|c| c as f32)).collect());
    Radiance::new(&channels?).map(|Radiance(radiance)| radiance)
}
