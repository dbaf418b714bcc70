//! Guided emission: paths start towards casters, as aimed ones do. They start from the lights and in the parts of the cones that
//! contributed to earlier images.
//!
//! Consecutive lights form a group. A group has a map over the cone of each caster, as its positions see it. Its last map covers
//! all directions, for casters beside the cones; a caster without a cone from a position leaves its share to that map. A map is
//! in the coordinates of its cone, so that it holds while light and caster move and has no parallax. Texels are sampled by the
//! root of the second moment of their starts' contributions, which minimises the variance [Rath et al. 2020, Variance-aware path
//! guiding]. Maps are sampled by the means of these roots.
//!
//! The flux of a path is divided by the density of the whole mixture, of which `BY_POWER` is emission by power. So no map changes
//! a mean, and no path is heavier than 1 / `BY_POWER` times its weight by power.
//!
//! Cost: up to 16 cones a path. Limitations: in the variant, `emission::guided`.

use crate::interface::NONE;
use crate::interface::frame::FrameParams;
use crate::interface::guide::GuideMap;
use crate::interface::light::Light;
use crate::light::aimed::BY_POWER;
use crate::light::choose;
use crate::light::density_map::{Pyramid, from_polar, to_polar};
use crate::light::emission_cone::EmissionCone;
use crate::light::emit::{EmissionSample, Emit, EvaluatedEmission};
use crate::light::mixture::{EmissionContext, EmissionDirection, EmissionMixture, start};
use crate::light::power::ByPower;
use crate::math::rng::Rng;
use spirv_std::glam::{Vec2, Vec3, Vec4};

/// The layout of the maps.
pub type GuidingPyramid = Pyramid<6>;
/// Largest number of maps.
pub const MAX_MAPS: u32 = 256;
/// Largest number of groups of lights.
pub const MAX_GROUPS: u32 = 32;
/// Share of paths that start uniformly in a cone, whatever the maps hold; all cones are equally likely.
pub const EVENLY: f32 = 0.125;
/// Share of paths that start by the maps.
pub const KNOWN: f32 = 1.0 - BY_POWER - EVENLY;

/// Number of maps of a group: one for each caster, and one of all directions.
#[inline(always)]
pub fn maps_of_group(params: &FrameParams) -> u32 {
    params.casters.count + 1
}

/// Largest number of groups of any table of lights.
#[inline(always)]
pub fn max_group_count(params: &FrameParams) -> u32 {
    (MAX_MAPS / maps_of_group(params)).min(MAX_GROUPS)
}

/// Number of groups of the light table.
#[inline(always)]
pub fn group_count(params: &FrameParams) -> u32 {
    max_group_count(params).min(params.light_count)
}

/// Number of maps of all groups.
#[inline(always)]
pub fn map_count(params: &FrameParams) -> u32 {
    group_count(params) * maps_of_group(params)
}

/// Largest number of maps of all groups, for any table of lights.
#[inline(always)]
pub fn max_map_count(params: &FrameParams) -> u32 {
    max_group_count(params) * maps_of_group(params)
}

/// Group of consecutive lights of the light table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Id of the first light.
    pub first: u32,
    /// Id behind the last light.
    pub end: u32,
    /// Share of the power of the lights before the group.
    pub below: f32,
    /// Share of the power of its own lights.
    pub power: f32,
}

/// Share of the power of the lights before this one.
#[inline(always)]
fn power_below(lights: &[Light], params: &FrameParams, light_id: u32) -> f32 {
    if light_id < params.light_count { lights[light_id as usize].power_below } else { 1.0 }
}

impl Group {
    /// Group with this index.
    #[inline(always)]
    pub fn new(lights: &[Light], params: &FrameParams, index: u32) -> Group {
        let (count, groups) = (params.light_count, group_count(params));
        let first = (index * count).div_ceil(groups);
        let end = ((index + 1) * count).div_ceil(groups);
        let below = power_below(lights, params, first);
        Group { first, end, below, power: power_below(lights, params, end) - below }
    }

    /// Index of the group of a light.
    #[inline(always)]
    fn index_at(light_id: u32, params: &FrameParams) -> u32 {
        light_id * group_count(params) / params.light_count
    }

    /// Samples a light of the group by power.
    #[inline(always)]
    fn light_at(&self, lights: &[Light], u: f32) -> u32 {
        // Compare differences, which keep all their bits; sums would be rounded onto lights without power.
        let at = u * self.power;
        let (mut low, mut high) = (self.first, self.end);
        while low + 1 < high {
            let middle = (low + high) / 2;
            if lights[middle as usize].power_below - self.below <= at {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Probability that `light_at` samples a light.
    #[inline(always)]
    fn probability(&self, lights: &[Light], params: &FrameParams, light_id: u32) -> f32 {
        let power = power_below(lights, params, light_id + 1) - power_below(lights, params, light_id);
        if self.power > 0.0 { power / self.power } else { 0.0 }
    }
}

/// Guided emission: most paths start by maps of what earlier starts contributed.
#[derive(Clone, Copy)]
pub struct Guided<'a> {
    /// Emission by power, for a share of the paths.
    pub power: ByPower<'a>,
    /// Maps, group by group.
    pub maps: &'a [GuideMap],
    /// Guiding pyramids of the maps: sums of the roots.
    pub pyramid: &'a [f32],
}

impl Guided<'_> {
    /// Samples a map by its share.
    #[inline(always)]
    fn map_at(&self, u: f32) -> u32 {
        let (mut low, mut high) = (0, map_count(self.power.params));
        while low + 1 < high {
            let middle = (low + high) / 2;
            if self.maps[middle as usize].below <= u {
                low = middle;
            } else {
                high = middle;
            }
        }
        // Step back over maps without a share: shares add up to 1 but for rounding.
        while low > 0 && self.maps[low as usize].share == 0.0 {
            low -= 1;
        }
        low
    }

    /// Samples a point of the unit square by a map: two numbers for the texel, two for the position within it.
    #[inline(always)]
    fn sample_map(&self, map: u32, texel: Vec2, within: Vec2) -> Vec2 {
        // Use other numbers within the texel: its choice takes most bits of the first two.
        let sampled = GuidingPyramid::sample(self.pyramid, map, texel).texel % GuidingPyramid::TEXELS;
        let corner =
            Vec2::new((sampled % GuidingPyramid::SIDE) as f32, (sampled / GuidingPyramid::SIDE) as f32);
        (corner + within) / GuidingPyramid::SIDE as f32
    }

    /// Density of `sample_map` at a texel; 1 on average.
    #[inline(always)]
    fn density(&self, map: u32, texel: u32) -> f32 {
        let scale = self.maps[map as usize].scale;
        if scale > 0.0 { self.pyramid[(map * GuidingPyramid::NODES + texel) as usize] * scale } else { 1.0 }
    }
}

/// Choices by which a start is sampled.
#[derive(Clone, Copy, Default)]
pub struct GuidingChoice {
    /// Index of the caster; the number of casters for all directions; `NONE` for a start by power.
    chosen: u32,
    /// Whether the map of that caster samples the direction; otherwise it is uniform in the cone.
    known: bool,
    /// Two numbers for the position within a texel.
    within: Vec2,
    /// Position of the direction in the map.
    own: Vec2,
}

impl Guided<'_> {
    /// Emission cone of a caster, seen from a position; behind the last caster, the cone of all directions.
    #[inline(always)]
    fn cone(&self, context: &EmissionContext, caster: u32) -> EmissionCone {
        let casters = &self.power.params.casters;
        if caster < casters.count {
            EmissionCone::at(&casters.spheres[caster as usize], &context.light, context.position)
        } else {
            EmissionCone::everywhere(&context.light)
        }
    }

    /// Index of the first map of the group of a start.
    #[inline(always)]
    fn first(&self, context: &EmissionContext) -> u32 {
        Group::index_at(context.light_id, self.power.params) * maps_of_group(self.power.params)
    }
}

impl EmissionMixture for Guided<'_> {
    type Choice = GuidingChoice;

    #[inline(always)]
    fn light(&self, u_position: Vec4, numbers: Vec4, rng: &mut Rng) -> (u32, GuidingChoice) {
        let ByPower { scene, params, .. } = self.power;
        let more = rng.next4();
        let (by_power, known) = (numbers.w < BY_POWER, numbers.w >= BY_POWER + EVENLY);
        let (light_id, chosen);
        if known {
            // Sample a map, and by power a light of its group
            let map = self.map_at((numbers.w - (BY_POWER + EVENLY)) / KNOWN);
            chosen = map % maps_of_group(params);
            light_id = Group::new(scene.lights, params, map / maps_of_group(params))
                .light_at(scene.lights, u_position.x);
        } else {
            // Sample a cone uniformly (or none), and a light by power
            let evenly = (numbers.w - BY_POWER) / EVENLY * maps_of_group(params) as f32;
            chosen = if by_power { NONE } else { (evenly as u32).min(params.casters.count) };
            light_id = choose(scene.lights, params.light_count, u_position.x, u_position.y);
        }
        (light_id, GuidingChoice { chosen, known, within: Vec2::new(more.x, more.y), own: Vec2::ZERO })
    }

    #[inline(always)]
    fn sample_direction(&self, choice: &mut GuidingChoice, context: &EmissionContext) -> EmissionDirection {
        let mut direction = EmissionDirection::BY_POWER;
        if choice.chosen != NONE {
            if !self.cone(context, choice.chosen).is_open() {
                // Take all directions where the caster has no cone from this position
                choice.chosen = self.power.params.casters.count;
            }
            choice.own = Vec2::new(context.numbers.x, context.numbers.y);
            if choice.known {
                choice.own = self.sample_map(self.first(context) + choice.chosen, choice.own, choice.within);
            }
            direction = EmissionDirection::at(
                self.cone(context, choice.chosen).direction(&context.light, to_polar(choice.own)),
            );
        }
        direction
    }

    #[inline(always)]
    fn weigh(
        &self,
        choice: &GuidingChoice,
        context: &EmissionContext,
        direction: Vec3,
        emission: &EvaluatedEmission,
    ) -> EmissionSample {
        let ByPower { scene, params, .. } = self.power;
        let (casters, first) = (params.casters.count, self.first(context));
        let GuidingChoice { chosen, own, .. } = *choice;
        // Sum the density of the direction over all maps of the group, and find the map that is scored. It is the map that the
        // direction was sampled from, else the first whose cone holds the direction. So the last map learns where no cone serves.
        let even = EVENLY / maps_of_group(params) as f32;
        let (mut evenly, mut guided, mut closed_even, mut closed_known) = (0.0, 0.0, 0.0, 0.0);
        let (mut scored, mut scored_texel, mut scored_size) = (casters, 0, 0.0);
        let mut caster = 0;
        while caster <= casters {
            let cone = self.cone(context, caster);
            let map = first + caster;
            let share = KNOWN * self.maps[map as usize].share;
            if !cone.is_open() {
                closed_even += even;
                closed_known += share;
            } else if caster == chosen || cone.holds(direction) {
                let at =
                    if caster == chosen { own } else { from_polar(cone.polar(&context.light, direction)) };
                let texel = GuidingPyramid::texel_at(at);
                let (mut uniform, mut known) = (even, share);
                if caster == casters {
                    uniform += closed_even;
                    known += closed_known;
                }
                evenly += uniform / cone.size();
                guided += known * self.density(map, texel) / cone.size();
                let is_own = caster == chosen && caster < casters;
                if is_own || (chosen >= casters && scored_size == 0.0) {
                    (scored, scored_texel, scored_size) = (caster, texel, cone.size());
                }
            }
            caster += 1;
        }
        // Divide the start by the density of the whole mixture
        let group = Group::new(scene.lights, params, Group::index_at(context.light_id, params));
        let ratio =
            group.probability(scene.lights, params, context.light_id) / context.light.pdf_light_choice;
        let sample = emission.sample.over(emission.pdf, BY_POWER, evenly + guided * ratio);
        let mut score = 0.0;
        // Score the start. A group without power is never sampled from maps, and learns nothing.
        if ratio > 0.0 {
            // Divide the density by that of a uniform start of the map.
            let over_uniform = ((BY_POWER * emission.pdf + evenly) / ratio + guided) * scored_size;
            // Scale to one path a pixel, whatever the number of paths.
            let paths = over_uniform * params.light_path_count as f32 / params.pixel_count() as f32;
            score = paths * paths / self.maps[(first + scored) as usize].unit;
        }
        EmissionSample { texel: (first + scored) * GuidingPyramid::TEXELS + scored_texel, score, ..sample }
    }
}

impl Emit for Guided<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        start(self, &self.power, rng)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside a light of nearly all power: lights at the last bits of its share, and lights without power.
    #[test]
    fn lights_of_a_group_are_sampled_with_their_probability() {
        let mut lights = Vec::new();
        let mut below = 0.0;
        for light_id in 0..400_u32 {
            lights.push(Light { power_below: below as f32, ..Light::default() });
            below += if light_id == 0 { 1.0 - 4.0e-5 } else { 1.0e-7 * f64::from(light_id % 3) };
        }
        let params = FrameParams { light_count: lights.len() as u32, ..FrameParams::default() };
        let (mut dim, mut without) = (0, 0);
        for index in 0..group_count(&params) {
            let group = Group::new(&lights, &params, index);
            let samples = 1 << 16;
            let mut sampled = vec![0; lights.len()];
            for sample in 0..samples {
                sampled[group.light_at(&lights, (sample as f32 + 0.5) / samples as f32) as usize] += 1;
            }
            let mut all = 0.0;
            for light_id in group.first..group.end {
                let probability = group.probability(&lights, &params, light_id);
                let found = sampled[light_id as usize] as f32 / samples as f32;
                assert!(
                    (found - probability).abs() <= 2.0 / samples as f32,
                    "{index}, {light_id}: {found}, {probability}"
                );
                assert!(probability > 0.0 || found == 0.0, "{light_id} is sampled");
                all += probability;
                dim += u32::from(probability > 0.0);
                without += u32::from(probability == 0.0);
            }
            assert!((all - 1.0).abs() < 1e-5, "{index}: {all}");
        }
        assert!(dim > 200 && without > 100, "{dim}, {without}");
    }
}
