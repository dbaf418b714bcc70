//! Mapping of texture coordinates.

use glam::Vec2;

use crate::gltf::document::sections::TextureInfo;

/// Mapping of a material's texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Set of coordinates: TEXCOORD_n.
    pub set: u32,
    /// Whether tangents are needed.
    pub has_normal_map: bool,
    offset: Vec2,
    rotation: f32,
    scale: Vec2,
}

impl Mapping {
    /// Mapping of a reference to a texture.
    pub fn from_info(info: &TextureInfo) -> Mapping {
        let transform = &info.extensions.transform;
        let pair = |pair: Option<[f64; 2]>, default: f32| {
            Vec2::from(pair.map_or([default; 2], |pair| pair.map(|number| number as f32)))
        };
        Mapping {
            set: transform.tex_coord.or(info.tex_coord).unwrap_or(0),
            has_normal_map: false,
            offset: pair(transform.offset, 0.0),
            rotation: transform.rotation.unwrap_or(0.0) as f32,
            scale: pair(transform.scale, 1.0),
        }
    }

    /// Transforms coordinates by KHR_texture_transform: scale, counter-clockwise rotation (v runs down), offset.
    pub fn transformed(&self, uv: Vec2) -> Vec2 {
        let (sin, cos) = self.rotation.sin_cos();
        let scaled = uv * self.scale;
        self.offset + Vec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn mapping(info: Value) -> Mapping {
        Mapping::from_info(&serde_json::from_value(info).unwrap())
    }

    #[test]
    fn texture_transforms_scale_rotate_and_move() {
        let turned = mapping(json!({ "texCoord": 1, "extensions": { "KHR_texture_transform": {
            "offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0],
        } } }));
        assert_eq!(turned.set, 1);
        // A quarter turn counter-clockwise, seen with v downwards: (x, y) becomes (y, -x).
        assert!((turned.transformed(Vec2::new(1.0, 1.0)) - Vec2::new(3.5, -1.75)).length() < 1e-6);
        assert_eq!(mapping(json!({})).transformed(Vec2::new(0.3, 0.7)), Vec2::new(0.3, 0.7));
    }
}
