//! Vertex colours (COLOR_0), which multiply the base colour, become materials and textures.
//!
//! A constant colour becomes a factor. Varying colours become a texture of four texels a triangle if the material has no texture;
//! otherwise their mean becomes a factor.

use std::collections::HashMap;

use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};

use super::atlas::Atlas;
use super::model::Model;
use crate::SceneError;
use crate::gltf::accessor::AccessorReader;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::primitive::{self, attribute, triangle_mode};

mod material_copies;

/// Maximum number of texels of all these images together.
const MAX_TEXELS: u64 = 1 << 25;
/// Maximum difference of colours that count as equal: half a step of a byte.
const SAME: f32 = 0.5 / 255.0;

/// Temporary memory of a colour while it is read (bytes).
const COLOR_BYTES: u64 = 32;
/// Temporary memory of an index while it is read (bytes).
const INDEX_BYTES: u64 = 16;

/// Index of a material; `None` is the default material.
type MaterialIndex = Option<Index<json::Material>>;

/// Makes materials from vertex colours.
struct Baker<'a, 'b> {
    model: &'a mut Model,
    context: &'a mut ImportContext<'b>,
    /// Indices of copied materials, by the original and the factor.
    copies: HashMap<(Option<usize>, [u32; 4]), usize>,
    /// Number of texels of all images so far.
    texels: u64,
    /// Largest temporary memory of a primitive's colours so far (bytes).
    largest: u64,
}

/// Makes materials from the vertex colours of every primitive.
pub fn bake(model: &mut Model, context: &mut ImportContext<'_>) -> Result<(), SceneError> {
    let mut baker = Baker { model, context, copies: HashMap::new(), texels: 0, largest: 0 };
    for mesh in 0..baker.model.root.meshes.len() {
        let label = label("mesh", mesh, baker.model.root.meshes[mesh].name.as_deref());
        for id in 0..baker.model.root.meshes[mesh].primitives.len() {
            let owner = format!("{label}, primitive {id}");
            let primitive = baker.model.root.meshes[mesh].primitives[id].clone();
            let Some(colors) = baker.read(&primitive, &owner)? else { continue };
            let material = baker.material(&primitive, &colors, &owner)?;
            baker.model.document.root.meshes[mesh].primitives[id].material = material;
        }
    }
    Ok(())
}

impl Baker<'_, '_> {
    /// Reads the colours of a primitive's vertices, clamped to 0 to 1; `None` if it has none.
    fn read(&mut self, primitive: &Primitive, owner: &str) -> Result<Option<Vec<[f32; 4]>>, SceneError> {
        let colors = attribute(primitive, Semantic::Colors(0));
        let (Some(colors), Some(positions)) = (colors, attribute(primitive, Semantic::Positions)) else {
            return Ok(None);
        };
        let accessors = AccessorReader::new(self.model, self.context, owner);
        let (count, vertices) = (accessors.count(colors)?, accessors.count(positions)?);
        if count != vertices {
            let what = format!("has {count} colours, but {vertices} positions");
            let error = self.context.mesh_error(owner, &what);
            self.context.replace(owner, &what, "rendered without them", error)?;
            return Ok(None);
        }
        let bytes = count.saturating_mul(COLOR_BYTES);
        self.context.take_for_a_while(bytes, &mut self.largest, format_args!("{owner}"))?;
        let mut read = match self.model.root.accessors[colors.value()].type_ {
            Checked::Valid(Type::Vec3) => {
                let colors = accessors.numbers::<3>(colors)?;
                colors.into_iter().map(|[red, green, blue]| [red, green, blue, 1.0]).collect()
            }
            _ => accessors.numbers::<4>(colors)?,
        };
        for share in read.as_flattened_mut() {
            *share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
        }
        Ok(Some(read))
    }

    /// Material of a primitive with these colours.
    fn material(
        &mut self,
        primitive: &Primitive,
        colors: &[[f32; 4]],
        owner: &str,
    ) -> Result<MaterialIndex, SceneError> {
        let Some(&first) = colors.first() else { return Ok(primitive.material) };
        // Constant colour
        if colors.iter().all(|color| is_near(color, &first)) {
            if is_near(&first, &[1.0; 4]) {
                return Ok(primitive.material);
            }
            return self.factored(primitive.material, first).map(Some);
        }
        // Texture of colours
        let Some(mode) = triangle_mode(primitive) else { return Ok(primitive.material) };
        if !self.is_textured(primitive.material)
            && let Some(material) = self.painted(primitive, mode, colors, owner)?
        {
            return Ok(Some(material));
        }
        // Mean colour
        let what = "vertex colours that vary are not supported beside textures; rendered by their mean";
        self.context.warn(owner, what);
        self.factored(primitive.material, mean(colors)).map(Some)
    }

    /// Whether a material has textures, which a texture of colours would replace, or whose coordinates it would change.
    fn is_textured(&self, material: MaterialIndex) -> bool {
        let materials = &self.model.sections.materials;
        material.and_then(|material| materials.get(material.value())).is_some_and(|material| {
            let pbr = &material.pbr_metallic_roughness;
            [
                &pbr.base_color_texture,
                &pbr.metallic_roughness_texture,
                &material.emissive_texture,
                &material.normal_texture,
            ]
            .iter()
            .any(|texture| texture.is_some())
        })
    }

    /// Material with a texture of colours; `None` if the texture would be too large.
    fn painted(
        &mut self,
        primitive: &Primitive,
        mode: Mode,
        colors: &[[f32; 4]],
        owner: &str,
    ) -> Result<MaterialIndex, SceneError> {
        let corners = match primitive.indices {
            Some(indices) => AccessorReader::new(self.model, self.context, owner).integer_count(indices)?,
            None => colors.len() as u64,
        };
        let bytes = corners.saturating_mul(INDEX_BYTES).saturating_add(COLOR_BYTES * colors.len() as u64);
        self.context.take_for_a_while(bytes, &mut self.largest, format_args!("the indices of {owner}"))?;
        let indices = primitive::indices(self.model, self.context, primitive, colors.len(), owner)?;
        let faces: Vec<[u32; 3]> = primitive::faces(&indices, mode).collect();
        let atlas = Atlas::for_triangles(faces.len());
        let Some(atlas) = atlas.filter(|atlas| self.texels + atlas.texels() <= MAX_TEXELS) else {
            return Ok(None);
        };
        self.texels += atlas.texels();
        self.context.take(8 * atlas.texels(), format_args!("the colours of {owner}"))?;
        self.textured(primitive.material, atlas, atlas.image(&faces, colors)).map(Some)
    }
}

fn is_near(a: &[f32; 4], b: &[f32; 4]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < SAME)
}

/// Mean colour.
fn mean(colors: &[[f32; 4]]) -> [f32; 4] {
    let mut sums = [0.0_f64; 4];
    for color in colors {
        sums.iter_mut().zip(color).for_each(|(sum, &share)| *sum += f64::from(share));
    }
    sums.map(|sum| (sum / colors.len() as f64) as f32)
}
