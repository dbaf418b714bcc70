//! Animations and skins.

use serde::Deserialize;

use crate::gltf::document::members::or_default;

/// Animation.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct JsonAnimation {
    /// Name.
    pub name: Option<String>,
    /// Channels, each of one member of a node.
    #[serde(deserialize_with = "or_default")]
    pub channels: Vec<JsonChannel>,
    /// Keys.
    #[serde(deserialize_with = "or_default")]
    pub samplers: Vec<JsonKeys>,
}

/// Channel of an animation.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct JsonChannel {
    /// Index of the sampler.
    pub sampler: Option<usize>,
    /// Member of a node that it sets.
    #[serde(deserialize_with = "or_default")]
    pub target: JsonTarget,
}

/// Target of a channel.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct JsonTarget {
    /// Index of the node.
    pub node: Option<usize>,
    /// Member of the node.
    pub path: Option<String>,
}

/// Sampler of an animation: its accessors.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct JsonKeys {
    /// Times.
    pub input: Option<u32>,
    /// Values.
    pub output: Option<u32>,
    /// Name of the interpolation.
    pub interpolation: Option<String>,
}

/// Skin.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct JsonSkin {
    /// Name.
    pub name: Option<String>,
    /// Indices of the joints' nodes.
    #[serde(deserialize_with = "or_default")]
    pub joints: Vec<usize>,
    /// Accessor of an inverse bind matrix for each joint.
    pub inverse_bind_matrices: Option<u32>,
}
