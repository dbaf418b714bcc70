//! Textures of materials: which images, how wrapped, and by which coordinates. Reads plain JSON by checked look-ups.

use std::collections::{HashMap, HashSet};

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::texture::{MaterialTextures, WRAP_CLAMP, WRAP_MIRRORED, WRAP_REPEAT};
use glam::Vec2;
use serde_json::Value;

use super::atlas::BAKED;
use super::document::Document;
use super::{image, unsupported};
use crate::SceneError;
use crate::texture::{self, Image, ImageTexture, Role, TextureParts};

/// What is rendered where a texture is missing.
const FLAT: &str = "its factor alone is rendered";

/// Textures that a material can have: where, what they are, and what they are called.
const SLOTS: [(&str, Role, &str); 4] = [
    ("/pbrMetallicRoughness/baseColorTexture", Role::Color, "baseColorTexture"),
    ("/pbrMetallicRoughness/metallicRoughnessTexture", Role::Data, "metallicRoughnessTexture"),
    ("/emissiveTexture", Role::Color, "emissiveTexture"),
    ("/normalTexture", Role::Normal, "normalTexture"),
];

/// Which coordinates a material's textures have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Set of coordinates: TEXCOORD_n.
    pub set: u32,
    /// Whether tangents matter.
    pub has_normal_map: bool,
    offset: Vec2,
    rotation: f32,
    scale: Vec2,
}

impl Mapping {
    /// KHR_texture_transform: scaled, turned counter-clockwise (v runs down), moved.
    pub fn transformed(&self, uv: Vec2) -> Vec2 {
        let (sin, cos) = self.rotation.sin_cos();
        let scaled = uv * self.scale;
        self.offset + Vec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x)
    }

    fn from_info(info: &Value) -> Mapping {
        let transform = &info["extensions"]["KHR_texture_transform"];
        let number = |value: &Value, default: f32| value.as_f64().map_or(default, |value| value as f32);
        let pair = |key: &str, default: f32| {
            Vec2::new(number(&transform[key][0], default), number(&transform[key][1], default))
        };
        let set = transform["texCoord"].as_u64().or(info["texCoord"].as_u64()).unwrap_or(0);
        Mapping {
            set: u32::try_from(set).unwrap_or(u32::MAX),
            has_normal_map: false,
            offset: pair("offset", 0.0),
            rotation: number(&transform["rotation"], 0.0),
            scale: pair("scale", 1.0),
        }
    }
}

/// The textures of all materials, without any triangle's coordinates yet.
pub struct Read {
    /// Images, textures and rows of materials; the last row is the default material's.
    pub parts: TextureParts,
    /// How each material is mapped; none where it has no texture.
    pub mappings: Vec<Option<Mapping>>,
}

/// Reads the textures of all materials and loads their images.
pub fn read(document: &mut Document) -> Result<Read, SceneError> {
    let mut reader = Reader {
        document,
        parts: TextureParts::default(),
        sources: Vec::new(),
        known: HashMap::new(),
        missing: HashSet::new(),
    };
    let materials = std::mem::take(&mut reader.document.sections.materials);
    let mut mappings = Vec::with_capacity(materials.len() + 1);
    for (index, material) in materials.iter().enumerate() {
        let owner = unsupported::label("material", index, material["name"].as_str());
        let mapping = reader.material(material, &owner)?;
        mappings.push(mapping);
    }
    mappings.push(None);
    reader.document.sections.materials = materials;
    let mut parts = reader.load()?;
    parts.materials.push(MaterialTextures::default());
    let is_plain = |record: &MaterialTextures| *record == MaterialTextures::default();
    if parts.materials.iter().all(is_plain) {
        parts.materials.clear();
    }
    Ok(Read { parts, mappings })
}

struct Reader<'a> {
    document: &'a mut Document,
    parts: TextureParts,
    /// Index in the document of each image of the parts.
    sources: Vec<u64>,
    known: HashMap<(u64, Role), u32>,
    /// Images of the parts that cannot be had.
    missing: HashSet<usize>,
}

impl Reader<'_> {
    fn material(&mut self, material: &Value, owner: &str) -> Result<Option<Mapping>, SceneError> {
        let mut record = MaterialTextures::default();
        let mut mapping: Option<(Mapping, &str)> = None;
        for (pointer, role, name) in SLOTS {
            let Some(info) = material.pointer(pointer).filter(|info| !info.is_null()) else { continue };
            let texture = match self.texture(info["index"].as_u64().unwrap_or(u64::MAX), role, owner) {
                Ok(texture) => texture,
                Err(error) => {
                    let what = match &error {
                        SceneError::Index { kind, index, .. } => {
                            format!("{name} refers to {kind} {index}, which is not there")
                        }
                        _ => format!("{name} has no image of a format that is read"),
                    };
                    self.document.replace(owner, &what, FLAT, error)?;
                    continue;
                }
            };
            match name {
                "baseColorTexture" => record.base_color = texture,
                "metallicRoughnessTexture" => record.metallic_roughness = texture,
                "emissiveTexture" => record.emissive = texture,
                _ => {
                    record.normal = texture;
                    record.normal_scale = info["scale"].as_f64().map_or(1.0, |scale| scale as f32);
                }
            }
            let found = Mapping::from_info(info);
            match mapping {
                Some((first, other)) if first != found => {
                    let what = format!("{name} has other coordinates than {other}, which is not supported");
                    self.document.warn(owner, what + "; it is rendered by those");
                }
                Some(_) => {}
                None => mapping = Some((found, name)),
            }
        }

        let alpha = material["pbrMetallicRoughness"]["baseColorFactor"][3].as_f64();
        record.alpha = alpha.map_or(1.0, |alpha| alpha as f32);
        match material["alphaMode"].as_str() {
            Some("MASK") => {
                record.alpha_cutoff = material["alphaCutoff"].as_f64().map_or(0.5, |cutoff| cutoff as f32);
            }
            Some("BLEND") => record.blends = 1,
            // Alpha means nothing else.
            _ => record.alpha = 1.0,
        }
        self.tame(&mut record, owner, material["name"].as_str().unwrap_or(owner))?;
        let has_normal_map = record.normal != MaterialTextures::default().normal;
        self.parts.materials.push(record);
        Ok(mapping.map(|(mapping, _)| Mapping { has_normal_map, ..mapping }))
    }

    /// Moves factors that are out of range to its nearer end.
    fn tame(&mut self, record: &mut MaterialTextures, owner: &str, name: &str) -> Result<(), SceneError> {
        for (member, factor, min, max) in [
            ("baseColorFactor[3]", &mut record.alpha, 0.0, 1.0),
            ("alphaCutoff", &mut record.alpha_cutoff, 0.0, f32::MAX),
            ("normalTexture.scale", &mut record.normal_scale, f32::MIN, f32::MAX),
        ] {
            if (min..=max).contains(factor) {
                continue;
            }
            let what = format!("{member} {factor} out of its range");
            *factor = factor.clamp(min, max);
            let (file, material) = (self.document.file.clone(), name.into());
            let error = SceneError::Material { file, material, what: what.clone() };
            self.document.replace(owner, &what, &format!("taken as {factor}"), error)?;
        }
        Ok(())
    }

    /// Loads the images. Their headers say first how much memory they take.
    fn load(mut self) -> Result<TextureParts, SceneError> {
        let mut sizes = self.each_image(image::size)?;
        self.missing.iter().for_each(|&image| sizes[image] = (1, 1));
        let used: HashSet<_> =
            self.parts.textures.iter().map(|texture| (texture.image, texture.role)).collect();
        let used = used.into_iter().map(|(image, _)| sizes[image]);
        let count = texture::check_texels(&self.document.file, used)?;
        // Four bytes a texel, in the images, in the table and in the runner; the largest image is decoded from eight a texel
        // to four, and its levels are made of floats.
        let areas = || sizes.iter().map(|&(width, height)| u64::from(width) * u64::from(height));
        let bytes = 4 * areas().sum::<u64>() + 8 * count + 12 * areas().max().unwrap_or(0);
        self.document.take(bytes, format_args!("its {} images", sizes.len()))?;
        self.parts.images = self.each_image(image::read)?;
        self.flatten();
        Ok(self.parts)
    }

    /// Reads something of every image; of one that cannot be had there is nothing.
    fn each_image<T: Default>(
        &mut self,
        read: impl Fn(&Document, u64) -> Result<T, String>,
    ) -> Result<Vec<T>, SceneError> {
        let mut all = Vec::with_capacity(self.sources.len());
        for (image, &source) in self.sources.iter().enumerate() {
            let found = match self.missing.contains(&image) {
                true => Ok(T::default()),
                false => read(self.document, source),
            };
            all.push(match found {
                Ok(found) => found,
                Err(what) => {
                    let name = self.document.sections.images[source as usize]["name"].as_str();
                    let owner = unsupported::label("image", source as usize, name);
                    let (file, image_id) = (self.document.file.clone(), source as usize);
                    let error = SceneError::Image { file, image: image_id, what: what.clone() };
                    self.document.replace(&owner, &what, FLAT, error)?;
                    self.missing.insert(image);
                    T::default()
                }
            });
        }
        Ok(all)
    }

    /// Leaves factors alone where an image cannot be had. A single texel stands in its place, which nobody looks at.
    fn flatten(&mut self) {
        for &image in &self.missing {
            self.parts.images[image] = Image { width: 1, height: 1, texels: vec![[255; 4]] };
        }
        let is_missing = |texture: u32| {
            self.parts.textures.get(texture as usize).is_some_and(|t| self.missing.contains(&t.image))
        };
        for record in &mut self.parts.materials {
            let slots = [
                &mut record.base_color,
                &mut record.metallic_roughness,
                &mut record.emissive,
                &mut record.normal,
            ];
            for slot in slots.into_iter().filter(|slot| is_missing(**slot)) {
                *slot = NONE;
            }
        }
    }

    /// Index in the parts of a texture in a role.
    fn texture(&mut self, index: u64, role: Role, owner: &str) -> Result<u32, SceneError> {
        if let Some(&known) = self.known.get(&(index, role)) {
            return Ok(known);
        }
        let sections = &self.document.sections;
        let missing = |owner: &str, kind, index: u64, count| SceneError::Index {
            file: self.document.file.clone(),
            owner: owner.into(),
            kind,
            index: index as usize,
            count,
        };
        let texture = sections
            .textures
            .get(index as usize)
            .ok_or_else(|| missing(owner, "texture", index, sections.textures.len()))?;
        let owner = format!("texture {index}");
        let source = texture["source"].as_u64().ok_or_else(|| SceneError::Document {
            file: self.document.file.clone(),
            what: format!("{owner} has no image as its source"),
        })?;
        if source >= sections.images.len() as u64 {
            return Err(missing(&owner, "image", source, sections.images.len()));
        }
        let sampler = match texture["sampler"].as_u64() {
            Some(sampler) => sections
                .samplers
                .get(sampler as usize)
                .ok_or_else(|| missing(&owner, "sampler", sampler, sections.samplers.len()))?,
            None => &Value::Null,
        };
        let wrap = ["wrapS", "wrapT"].map(|key| match sampler[key].as_u64() {
            Some(33071) => WRAP_CLAMP,
            Some(33648) => WRAP_MIRRORED,
            _ => WRAP_REPEAT,
        });
        let nearest = sampler["magFilter"].as_u64() == Some(9728);

        let known = self.sources.iter().position(|&known| known == source);
        let image = known.unwrap_or_else(|| {
            self.sources.push(source);
            self.sources.len() - 1
        });
        // Triangles lie side by side on images of vertex colours, whatever they are beside on the surface.
        let finest = !sections.images[source as usize][BAKED].is_null();
        self.parts.textures.push(ImageTexture { image, role, wrap, nearest, finest });
        let id = self.parts.textures.len() as u32 - 1;
        self.known.insert((index, role), id);
        Ok(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn transforms_scale_turn_and_move() {
        let info = json!({ "texCoord": 1, "extensions": { "KHR_texture_transform": {
            "offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0],
        } } });
        let mapping = Mapping::from_info(&info);
        assert_eq!(mapping.set, 1);
        // A quarter turn counter-clockwise, seen with v downwards: (x, y) becomes (y, -x).
        assert!((mapping.transformed(Vec2::new(1.0, 1.0)) - Vec2::new(3.5, -1.75)).length() < 1e-6);
        assert_eq!(Mapping::from_info(&json!({})).transformed(Vec2::new(0.3, 0.7)), Vec2::new(0.3, 0.7));
    }
}
