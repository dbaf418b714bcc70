//! What a person changes of a scene: the camera, and where nodes stand; kept in a small TOML file.
//!
//! An edit is a channel of keys that comes after those of the file's animations; one that stands still has a single key.

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

/// Largest file that is read (bytes): hours of a drag at 60 keys a second.
const MAX_BYTES: u64 = 1 << 26;

/// What a person changes of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edits {
    /// The camera; none: whichever is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraEdit>,
    /// Where nodes stand.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeEdit>,
    /// How camera and nodes move, with ascending times. Of what keys set, they alone count: linear between two, rotations on the
    /// shorter arc; before the first and after the last as there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keys: Vec<Keyframe>,
}

/// A camera that is placed, in the file's coordinates (m).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraEdit {
    /// The eye (m).
    #[serde(deserialize_with = "exact::array")]
    pub from: [f64; 3],
    /// What it looks at (m).
    #[serde(deserialize_with = "exact::array")]
    pub look_at: [f64; 3],
    /// Vertical field of view (degrees).
    pub fov: f64,
}

/// Parts of a node's own transform, each in place of the file's and of its animations.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeEdit {
    /// Its index among the file's nodes.
    pub node: usize,
    /// Its name; if it has another, the edits are of another file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Translation in its parent's space (m).
    #[serde(default, deserialize_with = "exact::optional", skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f64; 3]>,
    /// Rotation, a quaternion x, y, z, w of any length above 1e-6.
    #[serde(default, deserialize_with = "exact::optional", skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f64; 4]>,
    /// Scale; zero hides a mesh.
    #[serde(default, deserialize_with = "exact::optional", skip_serializing_if = "Option::is_none")]
    pub scale: Option<[f64; 3]>,
}

/// What is set at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// When (s), on the clock of the file's animations.
    pub time: f64,
    /// The camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraEdit>,
    /// Nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeEdit>,
}

/// Why edits are none.
#[derive(Debug, thiserror::Error)]
pub enum EditsError {
    /// The text is no TOML of edits.
    #[error("{0}")]
    Read(#[from] toml::de::Error),
    /// They cannot be written as TOML.
    #[error("{0}")]
    Write(#[from] toml::ser::Error),
    /// It takes more memory than there is.
    #[error("it would take {0}; edit fewer nodes, at fewer times")]
    Memory(#[from] Short),
    /// A value cannot be used.
    #[error("{path} {what}")]
    Value {
        /// Where it stands.
        path: String,
        /// What is wrong.
        what: &'static str,
    },
}

impl Edits {
    /// Edits of the text of a file.
    ///
    /// # Errors
    ///
    /// If it is no TOML of edits, has values that cannot be used, or would not fit into memory.
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
    /// If it cannot be read, or holds no edits; the error names it.
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

    /// The text of a file that [`Edits::parse`] makes the same of, to the bit.
    ///
    /// # Errors
    ///
    /// If a value cannot be used.
    pub fn to_toml(&self) -> Result<String, EditsError> {
        self.check()?;
        self.clone().into_toml().collect()
    }

    /// The same text in parts, a key each, so that never all of it is in memory. Values are not checked.
    pub fn into_toml(self) -> impl Iterator<Item = Result<String, EditsError>> {
        let Edits { camera, nodes, keys } = self;
        let head = Edits { camera, nodes, keys: Vec::new() };
        let of_key = |key| Edits { keys: vec![key], ..Edits::default() };
        let parts = std::iter::once(head).chain(keys.into_iter().map(of_key));
        let text = |part: Edits| toml::to_string(&part).map(|text| text + "\n").map_err(EditsError::from);
        parts.filter(|part| *part != Edits::default()).map(text)
    }

    /// Indices of the file's nodes that they place: those that a scene must be loaded with as
    /// [`LoadOptions::grabbed`](super::LoadOptions::grabbed).
    pub fn grabbed(&self) -> BTreeSet<usize> {
        let keyed = self.keys.iter().flat_map(|key| &key.nodes);
        self.nodes.iter().chain(keyed).map(|edit| edit.node).collect()
    }

    /// Whether they say where the camera is.
    pub fn has_camera(&self) -> bool {
        self.camera.is_some() || self.keys.iter().any(|key| key.camera.is_some())
    }

    /// A hash of all of them.
    pub fn fingerprint(&self) -> String {
        digest(&format!("{self:?}"))
    }
}

impl CameraEdit {
    /// As [`Scene::place_camera`](super::Scene::place_camera) takes it.
    pub fn viewpoint(&self) -> Viewpoint {
        let viewpoint::Whole { from, look_at, field } = self.whole();
        Viewpoint { eye: Some(Eye::At(from)), look_at: Some(look_at), field: Some(field) }
    }

    fn whole(&self) -> viewpoint::Whole {
        let [from, look_at] = [self.from, self.look_at].map(|position| Position(position.into()));
        viewpoint::Whole { from, look_at, field: self.fov }
    }
}
