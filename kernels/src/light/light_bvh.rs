//! The light BVH: samples one of many lights by what it may give at a position.
//!
//! A walk from the root takes one of four children at each level, in proportion to their importance. Cost: a node of 192 bytes
//! and some 60 operations on four lanes a level, over log4 of the number of lights levels. The density of a light that a path
//! found by scattering takes the same walk.
//!
//! The importance knows neither the orientation of the vertex nor occluders. Lights without a place (directional lights, the
//! environment) have none: they are only sampled by power.

use crate::interface::NONE;
use crate::interface::light_bvh::LightBvhNode;
use crate::math::BELOW_ONE;
use spirv_std::glam::{Vec3, Vec4};

/// A light that was sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledLight {
    /// Id, or `NONE`.
    pub light_id: u32,
    /// Probability of this choice.
    pub probability: f32,
}

/// The light BVH.
#[derive(Clone, Copy)]
pub struct LightBvh<'a> {
    /// Nodes.
    pub nodes: &'a [LightBvhNode],
    /// Number of lights.
    pub light_count: u32,
}

/// Squared distance (m^2) below which lights do not grow more important. It only bounds quotients.
const MIN_DISTANCE_SQUARED: f32 = 1.0e-12;

/// Importance of four children at a position (m^-2), over the flux of all lights: the largest irradiance that their lights could
/// give there. It is 0 where none of a child's lights shines.
///
/// The angle from the cone's axis to the position, less the half angles of cone and sphere, is the smallest angle of any light.
/// Sines and cosines are times the distance to the centre.
#[inline(always)]
fn importance(node: &LightBvhNode, position: Vec3) -> Vec4 {
    let x = Vec4::splat(position.x) - node.center_x;
    let y = Vec4::splat(position.y) - node.center_y;
    let z = Vec4::splat(position.z) - node.center_z;
    let square = (x * x + y * y + z * z).max(Vec4::splat(MIN_DISTANCE_SQUARED));
    let radius_square = node.radius * node.radius;
    let distance = square.sqrt();
    let cos_axis = x * node.axis_x + y * node.axis_y + z * node.axis_z;
    let sin_axis = (square - cos_axis * cos_axis).max(Vec4::ZERO).sqrt();
    let cos_sphere = (square - radius_square).max(Vec4::ZERO).sqrt();
    // Subtract the cone
    let in_cone = cos_axis.cmpge(node.cos_spread * distance);
    let cos_light = Vec4::select(in_cone, distance, cos_axis * node.cos_spread + sin_axis * node.sin_spread);
    let sin_light =
        Vec4::select(in_cone, Vec4::ZERO, sin_axis * node.cos_spread - cos_axis * node.sin_spread);
    // Subtract the sphere; the product is times the squared distance
    let falloff = square.max(radius_square);
    let faces = cos_light.cmpge(cos_sphere) | square.cmple(radius_square);
    let cos_min = Vec4::select(faces, falloff, cos_light * cos_sphere + sin_light * node.radius);
    let shines = faces | cos_min.cmpgt(node.cos_emission * square);
    let inverse = falloff.recip();
    Vec4::select(shines, node.intensity * cos_min * inverse * inverse, Vec4::ZERO)
}

/// Number of levels of nodes over this number of lights.
#[inline(always)]
pub fn levels(light_count: u32) -> u32 {
    let (mut levels, mut leaves) = (1, 4);
    while leaves < light_count {
        leaves *= 4;
        levels += 1;
    }
    levels
}

/// Number of nodes of these levels, and index of the first light behind them.
#[inline(always)]
pub fn node_count(levels: u32) -> u32 {
    ((1 << (2 * levels)) - 1) / 3
}

impl LightBvh<'_> {
    /// Samples a light for a position, by a uniform number. Returns no light where none has importance.
    #[inline(always)]
    pub fn sample(&self, position: Vec3, u: f32) -> SampledLight {
        let levels = levels(self.light_count);
        let (mut node, mut u, mut probability) = (0, u, 1.0);
        let mut level = 0;
        while level < levels {
            level += 1;
            let [x, y, z, w] = importance(&self.nodes[node as usize], position).to_array();
            let sum = (x + y) + (z + w);
            if sum <= 0.0 {
                return SampledLight { light_id: NONE, probability: 0.0 };
            }
            // Sample one of the two pairs, then one of the pair
            let mut child = 0;
            let (mut left, mut right) = (x, y);
            let mut along = u * sum;
            if along >= x + y {
                (left, right, child) = (z, w, 2);
                along -= x + y;
            }
            let mut chosen = left;
            if along >= left {
                (chosen, child) = (right, child + 1);
                along -= left;
            }
            if chosen <= 0.0 {
                // Only rounding leads to a child without importance
                return SampledLight { light_id: NONE, probability: 0.0 };
            }
            probability *= chosen / sum;
            u = (along / chosen).min(BELOW_ONE);
            node = 4 * node + 1 + child;
        }
        SampledLight { light_id: node - node_count(levels), probability }
    }

    /// Probability that `sample` returns a light.
    #[inline(always)]
    pub fn probability(&self, position: Vec3, light_id: u32) -> f32 {
        let levels = levels(self.light_count);
        let (mut node, mut probability) = (0, 1.0);
        let mut level = levels;
        while level > 0 {
            level -= 1;
            let child = (light_id >> (2 * level)) % 4;
            let [x, y, z, w] = importance(&self.nodes[node as usize], position).to_array();
            let sum = (x + y) + (z + w);
            let left = if child < 2 { x } else { z };
            let right = if child < 2 { y } else { w };
            let chosen = if child.is_multiple_of(2) { left } else { right };
            probability *= if sum > 0.0 { chosen / sum } else { 0.0 };
            node = 4 * node + 1 + child;
        }
        probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Children at one place that shine along `axis` within 90 degrees, with spheres of these radii.
    fn children(position: Vec3, axis: Vec3, radius: Vec4) -> LightBvhNode {
        let Vec3 { x, y, z } = position;
        LightBvhNode {
            center_x: Vec4::splat(x),
            center_y: Vec4::splat(y),
            center_z: Vec4::splat(z),
            radius,
            axis_x: Vec4::splat(axis.x),
            axis_y: Vec4::splat(axis.y),
            axis_z: Vec4::splat(axis.z),
            cos_spread: Vec4::ONE,
            intensity: Vec4::splat(3.0),
            ..LightBvhNode::default()
        }
    }

    #[test]
    fn a_light_has_the_importance_of_its_irradiance_and_none_behind_it() {
        let children = children(Vec3::Y, Vec3::NEG_Y, Vec4::new(0.0, 0.5, 1.5, 3.0));
        let below = importance(&children, Vec3::NEG_Y);
        assert!((below - Vec4::new(0.75, 0.75, 0.75, 3.0 / 9.0)).abs().max_element() < 1e-6, "{below}");
        // The position sees spheres that touch it under a right angle, so that some light of them may face it.
        let beside = importance(&children, Vec3::X);
        assert!((beside.x - 3.0 * 0.5f32.sqrt() / 2.0).abs() < 1e-6, "{beside}");
        assert!(beside.y > beside.x && beside.y < 1.5, "{beside}");
        let above = importance(&children, 2.0 * Vec3::Y);
        assert_eq!((above.x, above.y), (0.0, 0.0));
        assert!(above.z > 0.0 && above.w > 0.0, "{above}");
    }
}
