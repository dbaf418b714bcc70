//! Keys of lights: their order in the light table and in the light pyramids of guided emission.

use caustics_kernels::interface::guide::LightGroups;
use glam::Vec3;

use crate::{PunctualLight, Scene};

/// Number of keys: one for each emitter, each punctual light, and the environment.
pub fn key_count(scene: &Scene, punctual_lights: &[PunctualLight]) -> usize {
    scene.emitters.len() + punctual_lights.len() + usize::from(scene.environment.light().is_some())
}

/// Keys of the emitters, the punctual lights and the environment. Few lights keep this order. Where there are more, lights of one
/// block of 2^n keys, for any n, lie close to each other. Directional lights have no place: they follow, and the environment is last.
pub fn keys(scene: &Scene, punctual_lights: &[PunctualLight]) -> Vec<u32> {
    let count = key_count(scene, punctual_lights);
    if count <= LightGroups::max_count(0) as usize {
        return (0..count as u32).collect();
    }
    let of_emitters = scene.emitters.iter().map(|emitter| {
        let triangle = scene.world_triangle(emitter.instance, emitter.triangle);
        Some((triangle.a + triangle.b + triangle.c) / 3.0)
    });
    let of_punctual = punctual_lights.iter().map(|light| (!light.is_directional()).then_some(light.position));
    let places: Vec<Option<Vec3>> = of_emitters.chain(of_punctual).collect();
    let (mut order, without): (Vec<_>, Vec<_>) =
        (0..places.len() as u32).partition(|&light| places[light as usize].is_some());
    let place = |light: u32| places[light as usize].unwrap_or_default();
    divide(&mut order, &place);
    let mut keys = vec![0; count];
    let environment = places.len() as u32..count as u32;
    for (key, light) in (0..).zip(order.into_iter().chain(without).chain(environment)) {
        keys[light as usize] = key;
    }
    keys
}

/// Divides lights in two along the longest side of the box around them, so that the first part has 2^n lights, and so on.
fn divide(lights: &mut [u32], place: &impl Fn(u32) -> Vec3) {
    if lights.len() < 2 {
        return;
    }
    let places = || lights.iter().map(|&light| place(light));
    let low = places().fold(Vec3::INFINITY, Vec3::min);
    let high = places().fold(Vec3::NEG_INFINITY, Vec3::max);
    let axis = (high - low).max_position();
    let first = lights.len().next_power_of_two() / 2;
    lights.select_nth_unstable_by(first, |&a, &b| place(a)[axis].total_cmp(&place(b)[axis]).then(a.cmp(&b)));
    let (first, second) = lights.split_at_mut(first);
    divide(first, place);
    divide(second, place);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::punctual::LightShape;

    /// A row of lights in the order of a hash: pairs, fours and eights of keys are neighbours.
    #[test]
    fn blocks_of_keys_are_neighbours() {
        let count = 200;
        let at = |id: u32| Vec3::new(f32::from((id * 77 % count) as u16), 0.0, 1.0);
        let mut lights: Vec<_> = (0..count).map(|id| PunctualLight::point(at(id), Vec3::ONE)).collect();
        lights[3].shape = LightShape::Directional { direction: Vec3::NEG_Y };
        let keys = keys(&Scene::default(), &lights);
        assert_eq!(keys[3], 199);
        let mut sorted = keys.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..count));
        for block in [2, 4, 8, 16] {
            for first in (0..192).step_by(block as usize) {
                let of_block = (0..count).filter(|&id| (first..first + block).contains(&keys[id as usize]));
                let along: Vec<f32> = of_block.map(|id| at(id).x).collect();
                let extent = along.iter().fold(0.0_f32, |extent, x| extent.max((x - along[0]).abs()));
                assert!(extent <= block as f32, "{block} {first}: {along:?}");
            }
        }
    }

    #[test]
    fn few_lights_keep_their_order() {
        let lights = vec![PunctualLight::point(Vec3::ONE, Vec3::ONE); 32];
        assert!(keys(&Scene::default(), &lights).into_iter().eq(0..32));
    }
}
