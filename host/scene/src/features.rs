//! Kernel features that a scene needs.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::material::{
    FLAG_BLEND, FLAG_COLOR_TEXTURE, FLAG_CUT_OUT, FLAG_EMISSIVE_TEXTURE, FLAG_NORMAL_MAP,
    FLAG_ROUGHNESS_TEXTURE, Material,
};
use caustics_kernels::interface::packed::{from_byte, to_byte};
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::math::offset;
use caustics_kernels::surface;
use caustics_kernels::surface::media::MediaStack;
use caustics_kernels::surface::thin_wall::is_thin_wall;
use caustics_kernels::trace::initial_media::initial_media_stack;
use glam::Vec3;

use super::Scene;

/// Textures that change factors of a material.
const FLAGS_TEXTURES: u32 = FLAG_COLOR_TEXTURE | FLAG_ROUGHNESS_TEXTURE | FLAG_EMISSIVE_TEXTURE;

impl Scene {
    /// Features of the scene's triangles and lights. Reflection lobes up to `specular_roughness` are specular.
    pub fn features(&self, specular_roughness: f32) -> Features {
        let mut used = vec![false; self.materials.len()];
        for surface in &self.surfaces {
            used[surface.material as usize] = true;
        }
        let mut features = Features(0);
        for (id, _) in used.into_iter().enumerate().filter(|&(_, used)| used) {
            features = features | self.features_of(id, specular_roughness);
        }
        for light in &self.lights {
            features = features | Features(light.kind);
            if light.kind == Features::ENVIRONMENT.0 {
                // Emission of an environment is sampled as parallel light.
                features = features | Features::DIRECTIONAL_LIGHTS;
            }
        }
        if self.surfaces.iter().any(|surface| surface.normal_a != Vec3::ZERO) {
            features = features | Features::SMOOTH_NORMALS;
        }
        if !self.instanced.instances.is_empty() {
            features = features | Features::INSTANCES;
        }
        if let Some(motion) = &self.motion {
            features = features | motion.lights();
            if !self.emitters.is_empty() {
                features = features | Features::AREA_LIGHTS;
            }
        }
        if features.has(Features::DIELECTRIC) && self.has_nested_media {
            features = features | Features::NESTED;
        }
        // In an animated scene the eye or a light may be inside of glass at some time.
        if features.has(Features::DIELECTRIC) && (self.is_animated() || self.starts_inside(features)) {
            features = features | Features::STARTS_IN_MEDIUM;
        }
        features
    }

    /// Features of a material's lobes and textures, over the whole range of its textures.
    pub(super) fn features_of(&self, material: usize, specular_roughness: f32) -> Features {
        let extremes = self.extremes(material);
        extremes
            .iter()
            .fold(Features(0), |all, material| all | material_features(material, specular_roughness))
    }

    /// Whether a camera or a light stands inside of a medium.
    fn starts_inside(&self, features: Features) -> bool {
        let tables = self.tables();
        let mut tracer = self.tracer(features);
        let mut is_inside = |position: Vec3| {
            initial_media_stack(position, features, tables, &mut tracer) != MediaStack::VACUUM
        };
        let beside = |light: &Light| {
            if light.triangle == NONE {
                return [light.position; 2];
            }
            let Triangle { a, b, c } = self.world_triangle(light.instance, light.triangle);
            // Offset the centre to both sides. A light that emits from its front only counts with its front.
            let (normal, middle) = ((b - a).cross(c - a).normalize(), (a + b + c) / 3.0);
            let away = normal * offset::clearance(offset::magnitude(a, b, c));
            [middle + away, if light.sides == 2 { middle - away } else { middle + away }]
        };
        let at_lights = self.lights.iter().filter(|light| !light.is_endless()).flat_map(beside);
        let at_cameras = self.cameras.iter().map(|camera| camera.position);
        at_cameras.chain(at_lights).any(&mut is_inside)
    }

    /// A material at the extremes of its texture's roughness and metallic; unchanged without that texture.
    fn extremes(&self, id: usize) -> Vec<Material> {
        let material = self.materials[id];
        if material.flags & FLAG_ROUGHNESS_TEXTURE == 0 {
            return vec![material];
        }
        let record = self.textures.materials[id];
        let range = |channel| self.textures.range(record.metallic_roughness, channel);
        let rounded = |factor: f32, byte: u8| from_byte(to_byte(factor * from_byte(byte.into())));
        let mut extremes = Vec::new();
        for roughness in range(1).map(|byte| rounded(material.roughness, byte)) {
            for metallic in range(2).map(|byte| rounded(material.metallic, byte)) {
                extremes.push(Material { roughness, metallic, ..material });
            }
        }
        extremes
    }
}

fn material_features(material: &Material, specular_roughness: f32) -> Features {
    let bits = [
        (material.flags & FLAGS_TEXTURES != 0, Features::TEXTURES),
        (material.flags & FLAG_NORMAL_MAP != 0, Features::NORMAL_MAPS),
        (material.flags & FLAG_CUT_OUT != 0, Features::CUT_OUTS),
        (material.flags & FLAG_BLEND != 0, Features::BLENDS),
        (is_thin_wall(material), Features::THIN_WALLS),
    ];
    let lobes = surface::features_of(material, specular_roughness);
    bits.into_iter().filter(|&(set, _)| set).fold(lobes, |all, (_, need)| all | need)
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_kernels::interface::material::FLAG_THIN;

    #[test]
    fn materials_need_the_features_of_their_lobes_only() {
        let lambert = Material { base_color: Vec3::ONE, roughness: 1.0, ior: 1.5, ..Material::default() };
        let coated = Material { specular: 1.0, roughness: 0.2, ..lambert };
        let mirror = Material { metallic: 1.0, roughness: 0.0, ..lambert };
        let rough_metal = Material { roughness: 0.5, ..mirror };
        let absorption = Vec3::X;
        let glass = Material { transmission: 1.0, specular: 1.0, roughness: 0.0, absorption, ..lambert };
        let frosted =
            Features::DIELECTRIC | Features::ROUGH_DIELECTRIC | Features::ABSORPTION | Features::CASTERS;
        let cases = [
            (lambert, Features::RECEIVERS),
            (coated, Features::COAT | Features::RECEIVERS | Features::CASTERS),
            (Material { roughness: 0.3, ..coated }, Features::COAT | Features::RECEIVERS),
            (mirror, Features::MIRROR | Features::CASTERS),
            (rough_metal, Features::METAL | Features::RECEIVERS),
            (glass, Features::DIELECTRIC | Features::ABSORPTION | Features::CASTERS),
            (
                Material { flags: FLAG_THIN, ..glass },
                Features::DIELECTRIC | Features::CASTERS | Features::THIN_WALLS,
            ),
            (Material { roughness: 0.2, ..glass }, frosted),
            (Material { roughness: 0.3, ..glass }, frosted | Features::RECEIVERS),
            (
                Material { dispersion: 0.3, absorption: Vec3::ZERO, ..glass },
                Features::DIELECTRIC | Features::CASTERS | Features::DISPERSION,
            ),
            // Thin walls do not refract.
            (
                Material { dispersion: 0.3, flags: FLAG_THIN, ..glass },
                Features::DIELECTRIC | Features::CASTERS | Features::THIN_WALLS,
            ),
        ];
        for (material, features) in cases {
            assert_eq!(material_features(&material, 0.25), features, "{material:?}");
        }
    }
}
