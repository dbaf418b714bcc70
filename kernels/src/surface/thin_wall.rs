//! Thin walls that light passes without a scattering event: smooth glass without a volume refracts nothing. Light samples multiply
//! by the share that passes. Paths sample whether they pass, and keep everything that a scattering event would change: number
//! of bounces, direction and its density, ray cone.
//!
//! Whether a wall can be passed depends on its material alone, so that camera paths, light paths and light samples agree. A wall
//! with a normal map or a texture of roughness cannot: paths would see other levels of the texture than light samples.

use crate::interface::choice::ThinWalls;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::material::{FLAG_NORMAL_MAP, FLAG_ROUGHNESS_TEXTURE, FLAG_THIN, Material};
use crate::surface::{dielectric, ggx};
use spirv_std::glam::Vec3;

/// Largest number of walls that a segment passes; the next one is a scattering event. It only bounds loops.
pub const MAX_PASSED: u32 = 256;

/// Whether a material is a thin smooth wall.
#[inline]
pub fn is_thin_wall(material: &Material) -> bool {
    let textured = FLAG_NORMAL_MAP | FLAG_ROUGHNESS_TEXTURE;
    material.transmits()
        && material.flags & FLAG_THIN != 0
        && material.flags & textured == 0
        && material.roughness < ggx::DELTA_ROUGHNESS
}

/// Whether paths pass surfaces of a material without a scattering event.
#[inline(always)]
pub fn is_passed(material: &Material, params: &FrameParams, features: Features) -> bool {
    features.has(Features::THIN_WALLS)
        && params.thin_walls == ThinWalls::Passed as u32
        && is_thin_wall(material)
}

/// Share of the light that passes a thin wall at a cosine to its shading normal. With the reflectance r of one face, it is
/// (1 - metallic) transmission color (1 - 2 r / (1 + r)).
#[inline(always)]
pub fn transmittance(material: &Material, cos: f32) -> Vec3 {
    let passed = 1.0 - dielectric::reflectance(material, cos, 1.0);
    material.base_color * ((1.0 - material.metallic) * material.transmission * passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PANE: Material = Material {
        base_color: Vec3::ONE,
        roughness: 0.0,
        ior: 1.5,
        transmission: 1.0,
        specular: 1.0,
        flags: FLAG_THIN,
        emission: Vec3::ZERO,
        metallic: 0.0,
        absorption: Vec3::ZERO,
        priority: 0,
        dispersion: 0.0,
        medium: 0,
    };

    #[test]
    fn a_pane_transmits_its_closed_form_at_normal_incidence() {
        let r: f32 = 0.04;
        assert!((transmittance(&PANE, 1.0) - (1.0 - r) / (1.0 + r)).length() < 1e-6);
        let tinted = Material { base_color: Vec3::new(0.5, 1.0, 0.0), transmission: 0.5, ..PANE };
        let expected = Vec3::new(0.25, 0.5, 0.0) * ((1.0 - r) / (1.0 + r));
        assert!((transmittance(&tinted, 1.0) - expected).length() < 1e-6);
    }

    #[test]
    fn rough_solid_opaque_and_textured_surfaces_are_not_passed() {
        assert!(is_thin_wall(&PANE));
        for other in [
            Material { roughness: 0.2, ..PANE },
            Material { flags: 0, ..PANE },
            Material { transmission: 0.0, ..PANE },
            Material { metallic: 1.0, ..PANE },
            Material { flags: FLAG_THIN | FLAG_NORMAL_MAP, ..PANE },
            Material { flags: FLAG_THIN | FLAG_ROUGHNESS_TEXTURE, ..PANE },
        ] {
            assert!(!is_thin_wall(&other), "{other:?}");
        }
    }

    #[test]
    fn a_setting_and_a_feature_switch_passing_off() {
        let passed = FrameParams { thin_walls: ThinWalls::Passed as u32, ..FrameParams::default() };
        let event = FrameParams { thin_walls: ThinWalls::Event as u32, ..passed };
        assert!(is_passed(&PANE, &passed, Features::ALL));
        assert!(!is_passed(&PANE, &event, Features::ALL) && !is_passed(&PANE, &passed, Features(0)));
    }
}
