//! What a scene needs of the kernels.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::light::{LIGHT_DIRECTIONAL, LIGHT_SPOT, Light};
use caustics_kernels::interface::material::{
    FLAG_COLOR_TEXTURE, FLAG_CUT_OUT, FLAG_EMISSIVE_TEXTURE, FLAG_NORMAL_MAP, FLAG_ROUGHNESS_TEXTURE,
    FLAG_SHEET, FLAG_THIN, Material,
};
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::interface::packed::{from_byte, to_byte};
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::math::offset;
use caustics_kernels::surface::class::{self, Classes};
use caustics_kernels::surface::ggx::DELTA_ROUGHNESS;
use caustics_kernels::surface::media::MediaStack;
use caustics_kernels::trace::enclosing::enclosing;
use glam::Vec3;

use super::Scene;

/// Textures that change a material's factors.
const FLAGS_TEXTURES: u32 = FLAG_COLOR_TEXTURE | FLAG_ROUGHNESS_TEXTURE | FLAG_EMISSIVE_TEXTURE;

impl Scene {
    /// What the scene's triangles and lights need, with reflection lobes up to `specular_roughness` specular.
    pub fn needs(&self, specular_roughness: f32) -> Needs {
        let mut used = vec![false; self.materials.len()];
        for surface in &self.surfaces {
            used[surface.material as usize] = true;
        }
        let mut needs = Needs(0);
        for (id, _) in used.into_iter().enumerate().filter(|&(_, used)| used) {
            for material in self.extremes(id) {
                needs = needs | of_material(&material, specular_roughness);
            }
        }
        for light in &self.lights {
            needs = needs
                | match light.kind {
                    _ if light.triangle != NONE => Needs::AREA_LIGHTS,
                    LIGHT_SPOT => Needs::SPOT_LIGHTS,
                    LIGHT_DIRECTIONAL => Needs::DIRECTIONAL_LIGHTS,
                    _ => Needs::POINT_LIGHTS,
                };
        }
        if self.surfaces.iter().any(|surface| surface.normal_a != Vec3::ZERO) {
            needs = needs | Needs::SMOOTH_NORMALS;
        }
        // Where things move, somebody may be inside of glass at some time.
        needs = self.motion.as_ref().map_or(needs, |motion| needs | motion.needs());
        if needs.has(Needs::GLASS) && self.has_nested_media {
            needs = needs | Needs::NESTED;
        }
        if needs.has(Needs::GLASS) && (self.is_animated() || self.starts_inside(needs)) {
            needs = needs | Needs::ENCLOSED;
        }
        needs
    }

    /// Whether a camera or a light stands inside of a medium.
    fn starts_inside(&self, needs: Needs) -> bool {
        let tables = self.tables();
        let mut tracer = self.tracer(needs);
        let mut is_inside =
            |position: Vec3| enclosing(position, needs, tables, &mut tracer) != MediaStack::VACUUM;
        let beside = |light: &Light| {
            let Some(Triangle { a, b, c }) = self.triangles.get(light.triangle as usize) else {
                return [light.position; 2];
            };
            // Off the middle of both faces; the back of one that emits from its front only does not count.
            let (normal, middle) = ((b - a).cross(c - a).normalize(), (*a + *b + *c) / 3.0);
            let away = normal * offset::clearance(offset::magnitude(*a, *b, *c));
            [middle + away, if light.sides == 2 { middle - away } else { middle + away }]
        };
        let at_lights = self.lights.iter().filter(|light| light.kind != LIGHT_DIRECTIONAL).flat_map(beside);
        let at_cameras = self.cameras.iter().map(|camera| camera.position);
        at_cameras.chain(at_lights).any(&mut is_inside)
    }

    /// A material at the ends of what its texture makes of roughness and metallic; itself without one.
    fn extremes(&self, id: usize) -> Vec<Material> {
        let material = self.materials[id];
        if material.flags & FLAG_ROUGHNESS_TEXTURE == 0 {
            return vec![material];
        }
        let row = self.textures.materials[id];
        let range = |channel| self.textures.range(row.metallic_roughness, channel);
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

fn of_material(material: &Material, specular_roughness: f32) -> Needs {
    let dielectric = material.metallic < 1.0;
    let metal = material.metallic > 0.0;
    let glass = dielectric && material.transmission > 0.0;
    let coat = dielectric && material.transmission < 1.0 && material.specular > 0.0;
    let diffuse = dielectric && material.transmission < 1.0 && material.base_color.max_element() > 0.0;
    let reflects = metal || coat;
    let is_specular = class::reflection(material.roughness, specular_roughness) == Classes::SPECULAR;

    let bits = [
        (metal && material.roughness >= DELTA_ROUGHNESS, Needs::METAL),
        (metal && material.roughness < DELTA_ROUGHNESS, Needs::MIRROR),
        (coat, Needs::COAT),
        (glass, Needs::GLASS),
        (glass && material.roughness >= DELTA_ROUGHNESS, Needs::ROUGH_GLASS),
        (
            glass && material.flags & FLAG_THIN == 0 && material.absorption.max_element() > 0.0,
            Needs::ABSORPTION,
        ),
        (material.flags & FLAGS_TEXTURES != 0, Needs::TEXTURES),
        (material.flags & FLAG_NORMAL_MAP != 0, Needs::NORMAL_MAPS),
        (material.flags & FLAG_CUT_OUT != 0, Needs::CUT_OUTS),
        (glass && material.flags & FLAG_SHEET != 0, Needs::SHEETS),
        (glass || (reflects && is_specular), Needs::CASTERS),
        (diffuse || ((reflects || glass) && !is_specular), Needs::RECEIVERS),
    ];
    bits.into_iter().filter(|&(set, _)| set).fold(Needs(0), |all, (_, need)| all | need)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_need_their_lobes_only() {
        let lambert = Material { base_color: Vec3::ONE, roughness: 1.0, ior: 1.5, ..Material::default() };
        let coated = Material { specular: 1.0, roughness: 0.2, ..lambert };
        let mirror = Material { metallic: 1.0, roughness: 0.0, ..lambert };
        let rough_metal = Material { roughness: 0.5, ..mirror };
        let absorption = Vec3::X;
        let glass = Material { transmission: 1.0, specular: 1.0, roughness: 0.0, absorption, ..lambert };
        let frosted = Needs::GLASS | Needs::ROUGH_GLASS | Needs::ABSORPTION | Needs::CASTERS;
        let cases = [
            (lambert, Needs::RECEIVERS),
            (coated, Needs::COAT | Needs::RECEIVERS | Needs::CASTERS),
            (Material { roughness: 0.3, ..coated }, Needs::COAT | Needs::RECEIVERS),
            (mirror, Needs::MIRROR | Needs::CASTERS),
            (rough_metal, Needs::METAL | Needs::RECEIVERS),
            (glass, Needs::GLASS | Needs::ABSORPTION | Needs::CASTERS),
            (Material { flags: FLAG_THIN, ..glass }, Needs::GLASS | Needs::CASTERS),
            (Material { roughness: 0.2, ..glass }, frosted),
            (Material { roughness: 0.3, ..glass }, frosted | Needs::RECEIVERS),
        ];
        for (material, needs) in cases {
            assert_eq!(of_material(&material, 0.25), needs, "{material:?}");
        }
    }
}
