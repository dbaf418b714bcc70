//! Builds the light BVH over the light table.

use std::f64::consts::PI;

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::light_bvh::LightBvhNode;
use caustics_kernels::light::light_bvh;
use caustics_kernels::light::light_sampling::FEW_LIGHTS;
use glam::{Vec3, Vec4};

use super::Scene;

/// Angle (rad) by which bounds of directions are wider than they must be, against rounding.
const MARGIN: f64 = 1e-4;
/// Largest error of a cosine to the axis of a spot, from f32 dot products and roots.
const ROUNDING: f32 = 1e-6;

/// Number of nodes of the light BVH over this number of lights: none where they are few, so that vertices sample all of them.
pub fn node_count(lights: usize) -> usize {
    if lights > FEW_LIGHTS as usize {
        light_bvh::node_count(light_bvh::levels(lights as u32)) as usize
    } else {
        0
    }
}

/// Share of the candidates of light samples that the light BVH samples; 0 where vertices sample all lights, or no light has a place.
/// Power samples the rest, so that every light keeps some density. Lights without a place are only sampled by power.
pub fn share(lights: &[Light]) -> f32 {
    if lights.len() <= FEW_LIGHTS as usize || lights.iter().all(Light::is_endless) {
        0.0
    } else if lights.iter().any(Light::is_endless) {
        0.5
    } else {
        63.0 / 64.0
    }
}

/// Nodes of the light BVH over the scene's light table, whose lights emit this flux together (W). The lights come in the order of
/// their keys, so that neighbours in the table stand near each other.
pub fn nodes(scene: &Scene, lights: &[Light], flux: f64) -> Vec<LightBvhNode> {
    let mut nodes = vec![LightBvhNode::default(); node_count(lights.len())];
    let mut bounds = vec![Bounds::default(); 4 * nodes.len() + 1];
    let of_lights = bounds.iter_mut().skip(nodes.len());
    for (bounds, light) in of_lights.zip(lights) {
        *bounds = leaf(scene, light, flux);
    }
    for (id, node) in nodes.iter_mut().enumerate().rev() {
        let children: [Bounds; 4] = std::array::from_fn(|child| bounds[4 * id + 1 + child]);
        *node = node_of(&children);
        bounds[id] = union(&union(&children[0], &children[1]), &union(&children[2], &children[3]));
    }
    nodes
}

/// Bounds of some lights.
#[derive(Clone, Copy, Debug, Default)]
struct Bounds {
    /// Lower corner of the box around the lights (m).
    low: Vec3,
    /// Upper corner of the box (m).
    high: Vec3,
    /// Unit vector in the middle of the lights' axes.
    axis: Vec3,
    /// Cosine of the largest angle between `axis` and the axis of a light.
    cos_spread: f32,
    /// Cosine of the largest angle between the axis of a light and a direction in which it shines.
    cos_emission: f32,
    /// Sum of the lights' largest intensities over the flux of all lights (sr^-1); 0 without lights.
    intensity: f32,
}

/// Node of four children.
fn node_of(children: &[Bounds; 4]) -> LightBvhNode {
    let lanes = |value: fn(&Bounds) -> f32| Vec4::from_array(children.each_ref().map(value));
    LightBvhNode {
        center_x: lanes(|bounds| 0.5 * (bounds.low.x + bounds.high.x)),
        center_y: lanes(|bounds| 0.5 * (bounds.low.y + bounds.high.y)),
        center_z: lanes(|bounds| 0.5 * (bounds.low.z + bounds.high.z)),
        radius: lanes(|bounds| 0.5 * bounds.low.distance(bounds.high)),
        axis_x: lanes(|bounds| bounds.axis.x),
        axis_y: lanes(|bounds| bounds.axis.y),
        axis_z: lanes(|bounds| bounds.axis.z),
        cos_spread: lanes(|bounds| bounds.cos_spread),
        sin_spread: lanes(|bounds| (1.0 - bounds.cos_spread * bounds.cos_spread).max(0.0).sqrt()),
        cos_emission: lanes(|bounds| bounds.cos_emission),
        intensity: lanes(|bounds| bounds.intensity),
        padding: Vec4::ZERO,
    }
}

/// Bounds of one light; without intensity for a light that has no place.
fn leaf(scene: &Scene, light: &Light, flux: f64) -> Bounds {
    let kind = Features(light.kind);
    if light.is_endless() {
        return Bounds::default();
    }
    // A point shines in all directions.
    let mut bounds = Bounds {
        low: light.position,
        high: light.position,
        intensity: (f64::from(light.emission.element_sum()) / 3.0 / flux) as f32,
        axis: Vec3::Y,
        cos_spread: -1.0,
        cos_emission: 0.0,
    };
    if kind == Features::SPOT_LIGHTS {
        // Cosines of directions in a narrow cone are rounded out of it
        let cos_emission = 1.0 - light.cone - ROUNDING;
        (bounds.axis, bounds.cos_spread, bounds.cos_emission) = (light.direction, 1.0, cos_emission);
    }
    if kind == Features::AREA_LIGHTS {
        let triangle = scene.world_triangle(light.instance, light.triangle);
        bounds.low = triangle.a.min(triangle.b).min(triangle.c);
        bounds.high = triangle.a.max(triangle.b).max(triangle.c);
        bounds.intensity = light.pdf_light_choice / (PI as f32 * light.sides as f32);
        if light.sides == 1 {
            (bounds.axis, bounds.cos_spread) = (light.direction, 1.0);
        }
    }
    bounds
}

/// Bounds of the lights of two nodes.
fn union(a: &Bounds, b: &Bounds) -> Bounds {
    if a.intensity == 0.0 {
        return *b;
    }
    if b.intensity == 0.0 {
        return *a;
    }
    let (axis, cos_spread) = union_of_cones((a.axis, a.cos_spread), (b.axis, b.cos_spread));
    Bounds {
        low: a.low.min(b.low),
        high: a.high.max(b.high),
        intensity: a.intensity + b.intensity,
        axis,
        cos_spread,
        cos_emission: a.cos_emission.min(b.cos_emission),
    }
}

/// Axis and cosine of half the angle of a cone around two others.
fn union_of_cones(a: (Vec3, f32), b: (Vec3, f32)) -> (Vec3, f32) {
    let half_angle = |cos: f32| f64::from(cos).clamp(-1.0, 1.0).acos();
    let (half_a, half_b) = (half_angle(a.1), half_angle(b.1));
    let (axis_a, axis_b) = (a.0.as_dvec3(), b.0.as_dvec3());
    let between = axis_a.angle_between(axis_b);
    if between + half_b <= half_a {
        return a;
    }
    if between + half_a <= half_b {
        return b;
    }
    let half = (half_a + between + half_b) / 2.0 + MARGIN;
    if half >= PI {
        return (a.0, -1.0);
    }
    // Turn opposite axes anywhere
    let across = (axis_b - axis_a * axis_a.dot(axis_b)).try_normalize();
    let across = across.unwrap_or_else(|| axis_a.any_orthonormal_vector());
    let turn = half - MARGIN - half_a;
    ((axis_a * turn.cos() + across * turn.sin()).as_vec3(), half.cos() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PunctualLight;
    use crate::light::{keys, table};
    use crate::punctual::LightShape;
    use glam::DVec3;

    /// A cone around two holds both.
    #[test]
    fn a_cone_around_two_cones_holds_both() {
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, -0.6, 0.8)];
        for a in axes {
            for b in axes {
                for (cos_a, cos_b) in [(1.0, 1.0), (0.5, 1.0), (0.9, -0.3), (-1.0, 0.2)] {
                    let (axis, cos) = union_of_cones((a, cos_a), (b, cos_b));
                    assert!((axis.length() - 1.0).abs() < 1e-5);
                    let half = f64::from(cos).acos();
                    for (inner, cos_inner) in [(a, cos_a), (b, cos_b)] {
                        let between = axis.as_dvec3().angle_between(inner.as_dvec3());
                        let farthest = (between + f64::from(cos_inner).acos()).min(PI);
                        assert!(farthest <= half + 1e-5, "{a} {cos_a}, {b} {cos_b}: {farthest}, {half}");
                    }
                    // It is no wider than it must be.
                    let (half_a, half_b) = (f64::from(cos_a).acos(), f64::from(cos_b).acos());
                    let between = a.as_dvec3().angle_between(b.as_dvec3());
                    let widest = half_a.max(half_b).max(0.5 * (half_a + between + half_b));
                    assert!(half < widest + 1e-3, "{a} {cos_a}, {b} {cos_b}: {half}, {widest}");
                }
            }
        }
    }

    /// Nodes hold all lights with a place; a sun has no intensity in them.
    #[test]
    fn nodes_bound_all_lights_with_a_place() {
        let at = |id: u32| Vec3::new(id as f32, 0.5 * id as f32, -1.0);
        let mut lights: Vec<_> = (0..40).map(|id| PunctualLight::point(at(id), Vec3::ONE)).collect();
        lights[3].shape = LightShape::Directional { direction: Vec3::NEG_Y };
        lights[7].shape = LightShape::Spot { direction: Vec3::NEG_Y, inner: 0.1, outer: 0.4 };
        let mut scene = Scene::default();
        scene.light_keys = keys(&scene, &lights);
        let hull = [DVec3::ZERO, DVec3::new(40.0, 20.0, -1.0)];
        let (records, flux) = table(&scene, &hull, &lights, None);
        let nodes = nodes(&scene, &records, f64::from(flux.element_sum() / 3.0));
        // Levels of 1, 4 and 16 nodes, whose last one has 64 children.
        assert_eq!(nodes.len(), 21);
        let expected = 39.0 / f64::from(flux.x);
        assert!((f64::from(nodes[0].intensity.element_sum()) / expected - 1.0).abs() < 1e-4);
        for (id, light) in (0..).zip(&records).filter(|(_, light)| !light.is_endless()) {
            // The spheres of all nodes above a light hold it.
            let mut child = nodes.len() + id;
            while child > 0 {
                let (node, lane) = (&nodes[(child - 1) / 4], (child - 1) % 4);
                let center = Vec3::new(node.center_x[lane], node.center_y[lane], node.center_z[lane]);
                assert!(center.distance(light.position) <= node.radius[lane] + 1e-5, "{id}");
                assert!(node.intensity[lane] > 0.0, "{id}");
                child = (child - 1) / 4;
            }
        }
        let few = &records[..FEW_LIGHTS as usize];
        assert!(self::nodes(&scene, few, 1.0).is_empty());
        assert_eq!((share(few), share(&records), share(&records[..39])), (0.0, 0.5, 63.0 / 64.0));
    }

    #[test]
    fn lights_without_a_place_are_not_looked_for_in_the_bvh() {
        let sun = Light { kind: Features::DIRECTIONAL_LIGHTS.0, radius: 1.0, ..Light::default() };
        let lamp = Light { kind: Features::POINT_LIGHTS.0, ..Light::default() };
        assert_eq!(share(&[sun; 40]), 0.0);
        assert_eq!(share(&[sun, sun, sun, sun, lamp]), 0.5);
        assert_eq!(share(&[lamp; 40]), 63.0 / 64.0);
    }

    /// Cosines of a cone of 0.2 mrad differ from 1 by less than f32 can tell.
    #[test]
    fn narrow_spots_have_importance_where_they_shine() {
        let outer = 2.0e-4_f32;
        let direction = Vec3::new(0.3, -0.8, 0.5).normalize();
        let spot = PunctualLight {
            shape: LightShape::Spot { direction, inner: 0.0, outer: f64::from(outer) },
            ..PunctualLight::point(Vec3::new(1.0, 2.0, 3.0), Vec3::ONE)
        };
        let lights = vec![spot; 5];
        let mut scene = Scene::default();
        scene.light_keys = keys(&scene, &lights);
        let (records, flux) = table(&scene, &[], &lights, None);
        let nodes = nodes(&scene, &records, f64::from(flux.element_sum() / 3.0));
        let bvh = light_bvh::LightBvh { nodes: &nodes, light_count: 5 };
        let side = direction.any_orthonormal_vector();
        for step in 0..1000 {
            let distance = 0.01 * step as f32 + 0.1;
            let position = spot.position + direction * distance + side * (0.9 * outer * distance);
            assert!(bvh.probability(position, 2) > 0.0, "{distance} m");
        }
    }
}
