//! User edits of a scene: the camera and transforms of nodes, stored in a small TOML file.
//!
//! An edit is a channel of keys that overrides the file's animations; an edit without keyframes has a single key.

use std::collections::BTreeSet;
use std::io::{Error, ErrorKind};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::viewpoint::{Eye, Position, Viewpoint};
use super::{SceneError, viewpoint};
use caustics_files::exact;
use caustics_files::file::read_head;
use caustics_files::hash::digest;
use caustics_files::memory::{self, Short};

mod apply;
mod camera;
mod check;
#[cfg(test)]
mod tests;

/// Maximum size of a file (bytes): hours of a drag at 60 keys a second.
const MAX_BYTES: u64 = 1 << 26;

/// User edits of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edits {
    /// The camera; `None`: the requested camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraEdit>,
    /// Transforms of nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeEdit>,
    /// Keyframes of camera and nodes, at ascending times. Keys override the values above. Interpolation is linear, for rotations
    /// on the shorter arc. Before the first key and after the last, that key holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keys: Vec<Keyframe>,
}

/// A placed camera, in the file's coordinates (m).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraEdit {
    /// Eye position (m).
    #[serde(deserialize_with = "exact::array")]
    pub from: [f64; 3],
    /// Point that the camera looks at (m).
    #[serde(deserialize_with = "exact::array")]
    pub look_at: [f64; 3],
    /// Vertical field of view (degrees).
    pub fov: f64,
}

/// Parts of a node's local transform. Each overrides the file's and its animations.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeEdit {
    /// Index among the file's nodes.
    pub node: usize,
    /// Name of the node. If the file's node has another name, the edits are of another file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Translation in the parent's space (m).
    #[serde(default, deserialize_with = "exact::optional", skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f64; 3]>,
    /// Rotation, a quaternion x, y, z, w of any length above 1e-6.
    #[serde(default, deserialize_with = "exact::optional", skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f64; 4]>,
    /// Scale; zero hides a mesh.
    #[serde(default, deserialize_with = "exact::optional", skip_serializing_if = "Option::is_none")]
    pub scale: Option<[f64; 3]>,
}

/// Values that are set at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Time (s), on the clock of the file's animations.
    pub time: f64,
    /// The camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraEdit>,
    /// Nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeEdit>,
}

/// Error of edits that cannot be read, written or used.
#[derive(Debug, thiserror::Error)]
pub enum EditsError {
    /// The text is no TOML of edits.
    #[error("{0}")]
    Read(#[from] toml::de::Error),
    /// The edits cannot be written as TOML.
    #[error("{0}")]
    Write(#[from] toml::ser::Error),
    /// The edits take more memory than is available.
    #[error("it would take {0}; edit fewer nodes, at fewer times")]
    Memory(#[from] Short),
    /// A value is out of range.
    #[error("{path} {what}")]
    Value {
        /// Path of the value.
        path: String,
        /// Description of the error.
        what: &'static str,
    },
}

impl Edits {
    /// Parses the text of a file.
    ///
    /// # Errors
    ///
    /// If it is no TOML of edits, has values out of range, or would not fit into memory.
    pub fn parse(text: &str) -> Result<Edits, EditsError> {
        memory::check(memory::toml_parse_bytes(text))?;
        let edits: Edits = toml::from_str(text)?;
        edits.check()?;
        Ok(edits)
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// If the file cannot be read or holds no edits. The error names the file.
    pub fn load(path: &Path) -> Result<Edits, SceneError> {
        let file = path.display().to_string();
        let bytes = read_head(path, MAX_BYTES + 1).and_then(|bytes| match bytes.len() as u64 {
            0..=MAX_BYTES => Ok(bytes),
            _ => Err(Error::new(ErrorKind::InvalidData, format!("it has more than {MAX_BYTES} bytes"))),
        });
        let bytes = bytes.map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
        let wrong = |what: String| SceneError::Edits { file, what: format!("no edits of a scene: {what}") };
        match std::str::from_utf8(&bytes).map(Edits::parse) {
            Ok(Ok(edits)) => Ok(edits),
            Ok(Err(error)) => Err(wrong(error.to_string().trim_end().into())),
            Err(_) => Err(wrong("it is no UTF-8 text".into())),
        }
    }

    /// Writes the text of a file. [`Edits::parse`] reads equal edits from it, to the bit.
    ///
    /// # Errors
    ///
    /// If a value is out of range.
    pub fn to_toml(&self) -> Result<String, EditsError> {
        self.check()?;
        self.clone().into_toml().collect()
    }

    /// Writes the text in parts, one keyframe each, so that it is never in memory as a whole. Values are not checked.
    pub fn into_toml(self) -> impl Iterator<Item = Result<String, EditsError>> {
        let Edits { camera, nodes, keys } = self;
        let head = Edits { camera, nodes, keys: Vec::new() };
        let of_key = |key| Edits { keys: vec![key], ..Edits::default() };
        let parts = std::iter::once(head).chain(keys.into_iter().map(of_key));
        let text = |part: Edits| toml::to_string(&part).map(|text| text + "\n").map_err(EditsError::from);
        parts.filter(|part| *part != Edits::default()).map(text)
    }

    /// Indices of the file's nodes that the edits set. A scene must be loaded with them as
    /// [`LoadOptions::grabbed`](super::LoadOptions::grabbed).
    pub fn grabbed(&self) -> BTreeSet<usize> {
        let keyed = self.keys.iter().flat_map(|key| &key.nodes);
        self.nodes.iter().chain(keyed).map(|edit| edit.node).collect()
    }

    /// Whether the edits set the camera.
    pub fn has_camera(&self) -> bool {
        self.camera.is_some() || self.keys.iter().any(|key| key.camera.is_some())
    }

    /// Hash of all edits.
    pub fn fingerprint(&self) -> String {
        digest(&format!("{self:?}"))
    }
}

impl CameraEdit {
    /// Converts it for [`Scene::place_camera`](super::Scene::place_camera).
    pub fn viewpoint(&self) -> Viewpoint {
        let viewpoint::Whole { from, look_at, field } = self.whole();
        Viewpoint { eye: Some(Eye::At(from)), look_at: Some(look_at), field: Some(field) }
    }

    fn whole(&self) -> viewpoint::Whole {
        let [from, look_at] = [self.from, self.look_at].map(|position| Position(position.into()));
        viewpoint::Whole { from, look_at, field: self.fov }
    }
}
