//! Vertex colours: factors on the base colour (COLOR_0), as the materials and textures that the rest of the loader reads.
//!
//! One colour all over becomes a factor. Colours that vary become a texture of their own, four texels a triangle, where the
//! material has no other; else their mean is the factor.

use std::collections::HashMap;

use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};
use serde_json::{Value, json};

use super::atlas::{Atlas, BAKED};
use super::document::Document;
use super::{accessor, mesh, unsupported};
use crate::SceneError;

/// Texels of such images at most, all together.
const MAX_TEXELS: u64 = 1 << 25;
/// Colours that are as near to each other are one: half a step of a byte.
const SAME: f32 = 0.5 / 255.0;
/// Textures in whose place a texture of colours would stand, or by whose coordinates.
const TEXTURES: [&str; 4] = [
    "/pbrMetallicRoughness/baseColorTexture",
    "/pbrMetallicRoughness/metallicRoughnessTexture",
    "/emissiveTexture",
    "/normalTexture",
];

/// What has been made so far.
#[derive(Default)]
struct Baked {
    /// Copies of materials, by the original and the factor.
    known: HashMap<(Option<usize>, [u32; 4]), usize>,
    /// Texels of images.
    texels: u64,
    /// Memory that the colours of one primitive took at most, for a while (bytes).
    largest: u64,
}

/// Bytes that one colour takes while it is read.
const COLOR_BYTES: u64 = 32;
/// Bytes that one index takes while it is read.
const INDEX_BYTES: u64 = 16;

/// Makes materials of the vertex colours of every primitive.
pub fn bake(document: &mut Document) -> Result<(), SceneError> {
    let mut baked = Baked::default();
    for mesh in 0..document.root.meshes.len() {
        let name = document.root.meshes[mesh].name.as_deref();
        let label = unsupported::label("mesh", mesh, name);
        for id in 0..document.root.meshes[mesh].primitives.len() {
            let owner = format!("{label}, primitive {id}");
            let primitive = document.root.meshes[mesh].primitives[id].clone();
            let Some(colors) = read(document, &primitive, &owner, &mut baked.largest)? else { continue };
            let material = material(document, &primitive, &colors, &owner, &mut baked)?;
            document.root.meshes[mesh].primitives[id].material = material;
        }
    }
    Ok(())
}

/// Colours of a primitive's vertices, moved into 0 to 1; none where it has none.
fn read(
    document: &mut Document,
    primitive: &Primitive,
    owner: &str,
    largest: &mut u64,
) -> Result<Option<Vec<[f32; 4]>>, SceneError> {
    let attribute = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let (Some(colors), Some(positions)) = (attribute(Semantic::Colors(0)), attribute(Semantic::Positions))
    else {
        return Ok(None);
    };
    let count = accessor::count(document, colors, owner)?;
    let vertices = accessor::count(document, positions, owner)?;
    if count != vertices {
        let what = format!("has {count} colours, but {vertices} positions");
        let error = SceneError::Mesh { file: document.file.clone(), mesh: owner.into(), what: what.clone() };
        document.replace(owner, &what, "rendered without them", error)?;
        return Ok(None);
    }
    document.take_for_a_while(count.saturating_mul(COLOR_BYTES), largest, format_args!("{owner}"))?;
    let accessor = document.get(&document.root.accessors, colors, "accessor", owner)?;
    let mut read = match accessor.type_ {
        Checked::Valid(Type::Vec3) => {
            let colors = accessor::numbers::<3>(document, colors, owner)?;
            colors.into_iter().map(|[red, green, blue]| [red, green, blue, 1.0]).collect()
        }
        _ => accessor::numbers::<4>(document, colors, owner)?,
    };
    for share in read.as_flattened_mut() {
        *share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    }
    Ok(Some(read))
}

/// The material of a primitive with these colours.
fn material(
    document: &mut Document,
    primitive: &Primitive,
    colors: &[[f32; 4]],
    owner: &str,
    baked: &mut Baked,
) -> Result<Option<Index<json::Material>>, SceneError> {
    let Some(&first) = colors.first() else { return Ok(primitive.material) };
    let is_near = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < SAME);
    if colors.iter().all(|color| is_near(color, &first)) {
        if is_near(&first, &[1.0; 4]) {
            return Ok(primitive.material);
        }
        return factored(document, primitive.material, first, &mut baked.known);
    }
    let material = primitive.material.and_then(|material| document.sections.materials.get(material.value()));
    let is_textured = material
        .is_some_and(|material| TEXTURES.iter().any(|at| material.pointer(at).is_some_and(|t| !t.is_null())));
    let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) = primitive.mode
    else {
        return Ok(primitive.material);
    };
    if !is_textured {
        let corners = match primitive.indices {
            Some(indices) => accessor::integer_count(document, indices, owner)?,
            None => colors.len() as u64,
        };
        let bytes = corners.saturating_mul(INDEX_BYTES).saturating_add(COLOR_BYTES * colors.len() as u64);
        document.take_for_a_while(bytes, &mut baked.largest, format_args!("the indices of {owner}"))?;
        let indices = mesh::indices(document, primitive, colors.len(), owner)?;
        let faces: Vec<[u32; 3]> = mesh::faces(&indices, mode).collect();
        if let Some(atlas) =
            Atlas::for_triangles(faces.len()).filter(|atlas| baked.texels + atlas.texels() <= MAX_TEXELS)
        {
            baked.texels += atlas.texels();
            document.take(8 * atlas.texels(), format_args!("the colours of {owner}"))?;
            return textured(document, primitive.material, atlas, atlas.image(&faces, colors)).map(Some);
        }
    }
    let what = "vertex colours that vary are not supported beside textures; rendered by their mean";
    document.warn(owner, what);
    let mut mean = [0.0_f64; 4];
    for color in colors {
        mean.iter_mut().zip(color).for_each(|(mean, &share)| *mean += f64::from(share));
    }
    let mean = mean.map(|sum| (sum / colors.len() as f64) as f32);
    factored(document, primitive.material, mean, &mut baked.known)
}

/// A copy of a material with a factor on its base colour; the same for the same factor.
fn factored(
    document: &mut Document,
    material: Option<Index<json::Material>>,
    factor: [f32; 4],
    known: &mut HashMap<(Option<usize>, [u32; 4]), usize>,
) -> Result<Option<Index<json::Material>>, SceneError> {
    let key = (material.map(|material| material.value()), factor.map(f32::to_bits));
    let copy = match known.get(&key) {
        Some(&copy) => copy,
        None => copy(document, material, factor)?,
    };
    known.insert(key, copy);
    Ok(Some(Index::new(copy as u32)))
}

/// A copy of a material that shows an image of colours.
fn textured(
    document: &mut Document,
    material: Option<Index<json::Material>>,
    atlas: Atlas,
    image: crate::texture::Image,
) -> Result<Index<json::Material>, SceneError> {
    let copy = copy(document, material, [1.0; 4])?;
    let sections = &mut document.sections;
    sections.images.push(json!({ BAKED: document.baked.len() }));
    document.baked.push(image);
    sections.samplers.push(json!({ "wrapS": 33071, "wrapT": 33071 }));
    let (image, sampler) = (sections.images.len() - 1, sections.samplers.len() - 1);
    sections.textures.push(json!({ "source": image, "sampler": sampler }));
    let texture = sections.textures.len() - 1;
    sections.materials[copy]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    document.atlases.insert(copy, atlas);
    Ok(Index::new(copy as u32))
}

/// A copy of a material, or of the default one, with a factor on its base colour; its index.
fn copy(
    document: &mut Document,
    material: Option<Index<json::Material>>,
    factor: [f32; 4],
) -> Result<usize, SceneError> {
    let (mut typed, mut plain) = (json::Material::default(), json!({}));
    if let Some(index) = material {
        typed = document.get(&document.root.materials, index, "material", "a primitive")?.clone();
        plain = document.sections.materials[index.value()].clone();
        // A text of JSON takes up to about so many times its length.
        let bytes = 64 * plain.to_string().len() as u64;
        document.take(bytes, "copies of materials with vertex colours")?;
    }
    let color = &mut typed.pbr_metallic_roughness.base_color_factor.0;
    color.iter_mut().zip(factor).for_each(|(color, factor)| *color *= factor);
    if !plain["pbrMetallicRoughness"].is_object() {
        plain["pbrMetallicRoughness"] = Value::Object(serde_json::Map::new());
    }
    plain["pbrMetallicRoughness"]["baseColorFactor"] = json!(*color);
    document.root.materials.push(typed);
    document.sections.materials.push(plain);
    Ok(document.sections.materials.len() - 1)
}
