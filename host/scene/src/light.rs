//! Light table: emitters with probabilities proportional to power, and an alias table that samples in constant time.

use std::f64::consts::PI;

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::material::FLAG_EMIT_BOTH_SIDES;
use caustics_kernels::math::face::Face;
use glam::{DVec3, Vec3};

use super::{PunctualLight, Scene, SceneError, geometry};

pub mod bvh;
mod emission;
mod keys;

pub use keys::{key_count, keys};

/// Refuses punctual lights that no kernel can use.
pub fn check(file: &str, lights: &[PunctualLight]) -> Result<(), SceneError> {
    for (id, light) in lights.iter().enumerate() {
        if let Some(what) = light.fault() {
            let what = format!("punctual light {id} has {what}");
            return Err(SceneError::Tables { file: file.into(), what });
        }
    }
    Ok(())
}

/// An emissive triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Id of the triangle.
    pub triangle: u32,
    /// Index of the instance.
    pub instance: u32,
    /// Mean radiance (W m^-2 sr^-1).
    pub mean: DVec3,
}

/// Finds all emissive triangles, and samples their textures. Motion changes only their areas.
pub fn emitters(scene: &Scene) -> Vec<Emitter> {
    let tables = scene.tables();
    let of_instance = |instance: usize| {
        let triangles = scene.instanced.triangle_ids(instance).map(|triangle| triangle as u32);
        let emitters = triangles.map(move |triangle| Emitter {
            triangle,
            instance: instance as u32,
            mean: emission::mean(tables, triangle),
        });
        emitters.filter(|emitter| emitter.mean.element_sum() > 0.0)
    };
    // A mesh with several instances does not emit.
    let (uses, instances) = (scene.instanced.uses(), &scene.instanced.instances);
    let alone = (1..)
        .zip(instances)
        .filter(|(_, instance)| uses[instance.mesh] == 1)
        .map(|(instance_id, _)| instance_id);
    std::iter::once(0).chain(alone).flat_map(of_instance).collect()
}

/// Light table with its alias table, and the emitted flux of each channel (W). Emitters of positive power come in the order of
/// their keys. The scene lies within the hull of `hull` (m).
pub fn table(
    scene: &Scene,
    hull: &[DVec3],
    punctual_lights: &[PunctualLight],
    environment: Option<(Light, DVec3)>,
) -> (Vec<Light>, Vec3) {
    let tables = scene.tables();
    let of_triangles = scene.emitters.iter().map(|&Emitter { triangle, instance, mean }| {
        let material = &scene.materials[scene.surfaces[triangle as usize].material as usize];
        let sides = 1 + u32::from(material.flags & FLAG_EMIT_BOTH_SIDES != 0);
        let area = geometry::area(&scene.world_triangle(instance, triangle));
        let face = Face::new(tables, Features::INSTANCES, instance, triangle);
        let light = Light {
            triangle,
            instance,
            emission: material.emission,
            area: area as f32,
            sides,
            direction: face.outward().normalize(),
            clearance: face.clearance,
            kind: Features::AREA_LIGHTS.0,
            ..Light::default()
        };
        (light, mean * PI * area * f64::from(sides))
    });
    let of_punctual = punctual_lights.iter().map(|light| light.record(hull));

    // Drop emitters without power, and those whose probability underflows in f32.
    let power = |flux: DVec3| flux.element_sum() / 3.0;
    let all = of_triangles.chain(of_punctual).chain(environment).zip(&scene.light_keys);
    let mut all: Vec<_> = all
        .map(|((light, flux), &key)| (Light { key, ..light }, flux))
        .filter(|&(_, flux)| power(flux) > 0.0)
        .collect();
    all.sort_by_key(|(light, _)| light.key);
    let total: f64 = all.iter().map(|&(_, flux)| power(flux)).sum();
    let (mut lights, fluxes): (Vec<_>, Vec<_>) =
        all.into_iter().filter(|&(_, flux)| power(flux) >= 1e-30 * total).unzip();
    choose_by_power(&mut lights, &fluxes.iter().map(|&flux| power(flux)).collect::<Vec<_>>());
    (lights, fluxes.into_iter().sum::<DVec3>().as_vec3())
}

/// Fills the alias table [Vose 1991]: a uniformly sampled record keeps its light below the threshold, and takes its alias above.
fn choose_by_power(lights: &mut [Light], powers: &[f64]) {
    let total: f64 = powers.iter().sum();
    let count = lights.len() as f64;
    let mut below = 0.0;
    let mut heights: Vec<f64> = powers.iter().map(|power| power / total * count).collect();
    for (id, light) in lights.iter_mut().enumerate() {
        light.pdf_light_choice = (powers[id] / total) as f32;
        light.power_below = (below / total) as f32;
        below += powers[id];
        (light.threshold, light.alias) = (1.0, id as u32);
    }

    // Fill each low record with the excess of a high record.
    let (mut low, mut high): (Vec<usize>, Vec<usize>) = (0..lights.len()).partition(|&id| heights[id] < 1.0);
    while let (Some(&short), Some(&tall)) = (low.last(), high.last()) {
        low.pop();
        lights[short].threshold = heights[short] as f32;
        lights[short].alias = tall as u32;
        heights[tall] -= 1.0 - heights[short];
        if heights[tall] < 1.0 {
            high.pop();
            low.push(tall);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alias_table_chooses_in_proportion_to_power() {
        for count in [1_usize, 2, 3, 100, 1000] {
            let powers: Vec<f64> = (0..count).map(|id| 1.0 + (id * id % 37) as f64 * 10.0).collect();
            let total: f64 = powers.iter().sum();
            let mut lights = vec![Light::default(); count];
            choose_by_power(&mut lights, &powers);

            let mut probabilities = vec![0.0; count];
            for (light_id, light) in lights.iter().enumerate() {
                let keep = f64::from(light.threshold);
                probabilities[light_id] += keep / count as f64;
                probabilities[light.alias as usize] += (1.0 - keep) / count as f64;
            }
            for (id, probability) in probabilities.into_iter().enumerate() {
                assert!((probability - powers[id] / total).abs() < 1e-6);
                assert!((f64::from(lights[id].pdf_light_choice) - powers[id] / total).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn dark_lights_are_left_out() {
        let point = |intensity| PunctualLight::point(Vec3::ZERO, intensity);
        let empty = Scene { light_keys: vec![0, 1], ..Scene::default() };
        let (lights, flux) = table(&empty, &[], &[point(Vec3::ZERO), point(Vec3::ONE)], None);
        assert_eq!((lights.len(), lights[0].key), (1, 1));
        assert!((flux.x - 12.566_371).abs() < 1e-5);
        assert!(table(&empty, &[], &[point(Vec3::ZERO)], None).0.is_empty());
    }
}
