//! Conversion of specular-glossiness to metallic-roughness [Khronos, glTF repository,
//! extensions/2.0/Archived/KHR_materials_pbrSpecularGlossiness/examples].

use glam::Vec3;

/// Reflectance of a dielectric at normal incidence.
const DIELECTRIC: f32 = 0.04;

/// Factors of metallic-roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converted {
    /// Base colour.
    pub base_color: Vec3,
    /// Metallic factor.
    pub metallic: f32,
}

/// Converts a diffuse and a specular colour.
pub fn convert(diffuse: Vec3, specular: Vec3) -> Converted {
    let strength_left = 1.0 - specular.max_element();
    let brightness = |color: Vec3| (color * color).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt();
    let metallic = metallic(brightness(diffuse), brightness(specular), strength_left);
    let of_diffuse = diffuse * (strength_left / (1.0 - DIELECTRIC) / (1.0 - metallic).max(1e-6));
    let of_specular = (specular - DIELECTRIC * (1.0 - metallic)) / metallic.max(1e-6);
    let base_color = of_diffuse.lerp(of_specular, metallic * metallic).clamp(Vec3::ZERO, Vec3::ONE);
    Converted { base_color, metallic }
}

/// Metallic factor that gives both brightnesses: a root of a quadratic equation.
fn metallic(diffuse: f32, specular: f32, strength_left: f32) -> f32 {
    if specular < DIELECTRIC {
        return 0.0;
    }
    let b = diffuse * strength_left / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - specular;
    let root = (b * b - 4.0 * DIELECTRIC * c).max(0.0).sqrt();
    ((root - b) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_without_diffuse_become_metals_and_those_with_specular_0_04_dielectrics() {
        // Without diffuse colour the material is a metal of the specular colour.
        let gold = Vec3::new(1.0, 0.77, 0.34);
        let converted = convert(Vec3::ZERO, gold);
        assert!(
            (converted.base_color - gold).length() < 1e-5 && converted.metallic > 0.99999,
            "{converted:?}"
        );
        // A specular colour of 0.04 is a dielectric of the diffuse colour.
        let red = Vec3::new(0.8, 0.1, 0.1);
        let converted = convert(red, Vec3::splat(DIELECTRIC));
        assert!((converted.base_color - red).length() < 1e-5 && converted.metallic < 1e-6, "{converted:?}");
    }

    #[test]
    fn grey_keeps_its_reflectance_at_normal_incidence_and_its_albedo() {
        // For grey, one metallic factor serves all channels: F0 and the diffuse albedo match the input.
        for (diffuse, specular) in [(0.5, 0.04), (0.3, 0.2), (0.1, 0.5), (0.9, 0.1)] {
            let Converted { base_color, metallic } = convert(Vec3::splat(diffuse), Vec3::splat(specular));
            let f0 = DIELECTRIC * (1.0 - metallic) + base_color.x * metallic;
            let albedo = base_color.x * (1.0 - metallic) * (1.0 - DIELECTRIC);
            // The conversion blends both colours by metallic^2, which is exact only at the ends of its range.
            assert!((f0 - specular).abs() < 0.05, "{diffuse} {specular}: F0 {f0}");
            assert!(
                (albedo - diffuse * (1.0 - specular)).abs() < 0.05,
                "{diffuse} {specular}: albedo {albedo}"
            );
        }
    }
}
