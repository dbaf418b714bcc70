//! Sections of a document in the import's own types, where those of the crate gltf drop members or are too strict.
//!
//! The JSON was checked before: every member has the type that is declared here, or is null.

use std::collections::HashMap;

use serde_json::Value;

use super::extension::{self, Compression, DracoPrimitive, InstanceAttributes};
use super::members::list;

pub use self::animation::{JsonAnimation, JsonChannel, JsonKeys, JsonSkin};
pub use self::material::{JsonMaterial, TextureInfo};
pub use self::texture::{ImageContent, JsonImage, JsonSampler, JsonTexture};

mod animation;
mod material;
mod texture;

/// Sections, and extensions of the elements of others.
pub struct Sections {
    /// Animations.
    pub animations: Vec<JsonAnimation>,
    /// Skins.
    pub skins: Vec<JsonSkin>,
    /// Materials, for their textures.
    pub materials: Vec<JsonMaterial>,
    /// Textures.
    pub textures: Vec<JsonTexture>,
    /// Samplers of textures.
    pub samplers: Vec<JsonSampler>,
    /// Images.
    pub images: Vec<JsonImage>,
    /// Compression of each buffer view.
    pub compressions: Vec<Option<Compression>>,
    /// Compressed primitives.
    pub draco: Vec<DracoPrimitive>,
    /// Instances of the meshes of nodes, by the index of the node.
    pub instances: HashMap<usize, InstanceAttributes>,
}

impl Sections {
    /// Moves the sections that only the import reads out of a document, and reads the others.
    pub fn take(document: &mut Value) -> Result<Sections, serde_json::Error> {
        Ok(Sections {
            animations: list(document["animations"].take())?,
            skins: list(document["skins"].take())?,
            materials: material::read(document)?,
            textures: list(document["textures"].take())?,
            samplers: list(document["samplers"].take())?,
            images: list(document["images"].take())?,
            compressions: extension::compressions(document)?,
            draco: extension::draco_primitives(document)?,
            instances: extension::instances(document)?,
        })
    }
}
