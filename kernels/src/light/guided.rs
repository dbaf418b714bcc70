//! Guided emission: paths start towards casters, as aimed ones do. They start from the lights and in the parts of the cones that
//! contributed to earlier images.
//!
//! Lights of consecutive keys form a group: one light, or several in many-light scenes. A group has a map over the cone of each
//! caster, as its positions see it. Its last map covers all directions, for casters beside the cones; a caster without a cone from
//! a position leaves its share to that map. A map is in the coordinates of its cone, so that it holds while light and caster move
//! and has no parallax. Texels are sampled by the root of the second moment of their starts' contributions, which minimises the
//! variance [Rath et al. 2020, Variance-aware path guiding]. Maps are sampled by the means of these roots. Where a group has
//! several lights, each of its maps has a light pyramid (`light::light_pyramid`), which samples one of them in the same way.
//!
//! The flux of a path is divided by the density of the whole mixture, of which `BY_POWER` is emission by power. So no map changes
//! a mean, and no path is heavier than 1 / `BY_POWER` times its weight by power.
//!
//! Cost: up to 16 cones a path. Limitations: in the variant, `emission::guided`.

use crate::interface::NONE;
use crate::interface::frame::FrameParams;
use crate::interface::guide::{GuideMap, LightGroups};
use crate::light::aimed::BY_POWER;
use crate::light::choose;
use crate::light::density_map::{Pyramid, from_polar, to_polar};
use crate::light::emission_cone::EmissionCone;
use crate::light::emit::{EmissionSample, Emit, EvaluatedEmission};
use crate::light::light_pyramid::{GuidedStart, LightPyramid, LightRange};
use crate::light::mixture::{EmissionContext, EmissionDirection, EmissionMixture, start};
use crate::light::power::ByPower;
use crate::math::rng::Rng;
use spirv_std::glam::{Vec2, Vec3, Vec4};

/// The layout of the maps.
pub type GuidingPyramid = Pyramid<6>;
/// Share of paths that start uniformly in a cone, whatever the maps hold; all cones are equally likely. Their lights are chosen
/// uniformly or by the maps.
pub const EVENLY: f32 = 0.125;
/// Share of these paths whose light is chosen uniformly, so that a dim light beside a bright one is learnt.
const UNIFORM_LIGHT: f32 = 0.5;
/// Share of paths that start by the maps.
pub const KNOWN: f32 = 1.0 - BY_POWER - EVENLY;

/// Number of maps of a group: one for each caster, and one of all directions.
#[inline(always)]
pub fn maps_of_group(params: &FrameParams) -> u32 {
    params.casters.count + 1
}

/// Number of maps of all groups.
#[inline(always)]
pub fn map_count(params: &FrameParams) -> u32 {
    params.light_groups.count() * maps_of_group(params)
}

/// Largest number of maps of all groups, for any table of lights.
#[inline(always)]
pub fn max_map_count(params: &FrameParams) -> u32 {
    LightGroups::max_count(params.casters.count) * maps_of_group(params)
}

/// Guided emission: most paths start by maps of what earlier starts contributed.
#[derive(Clone, Copy)]
pub struct Guided<'a> {
    /// Emission by power, for a share of the paths.
    pub power: ByPower<'a>,
    /// Maps, group by group.
    pub maps: &'a [GuideMap],
    /// Guiding pyramids of the maps, and their light pyramids: sums of the roots.
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

    /// Leaf of the light of a start, counted over all groups.
    #[inline(always)]
    fn leaf(&self, context: &EmissionContext) -> u32 {
        context.light.key >> self.power.params.light_groups.leaf_keys_log2
    }

    /// Index of the first map of the group of a start.
    #[inline(always)]
    fn first(&self, context: &EmissionContext) -> u32 {
        (self.leaf(context) >> LightPyramid::new(self.power.params).top) * maps_of_group(self.power.params)
    }

    /// Sum of a map's light pyramid: 0 where nothing is learnt, or no light pyramid is used.
    #[inline(always)]
    fn light_total(&self, map: u32) -> f32 {
        let ByPower { params, features, .. } = self.power;
        let mut total = 0.0;
        if LightPyramid::is_used(params, features) {
            let layout = LightPyramid::new(params);
            total = self.pyramid[(LightPyramid::offset(params) + layout.node(layout.top, map).slot) as usize];
        }
        total
    }

    /// Samples a light of the group of a map, by the map's light pyramid, or by power.
    #[inline(always)]
    fn light_at(&self, map: u32, u: f32, v: f32) -> u32 {
        let ByPower { scene, params, .. } = self.power;
        let group = map / maps_of_group(params);
        if self.light_total(map) > 0.0 {
            let layout = LightPyramid::new(params);
            let leaf = layout.sample(self.pyramid, LightPyramid::offset(params), map, u);
            return LightRange::leaf(scene.lights, params, (group << layout.top) + leaf)
                .light_at(scene.lights, v);
        }
        LightRange::group(scene.lights, params, group).light_at(scene.lights, u)
    }

    /// Probability that `light_at` samples the light of a start: `in_leaf` within its leaf, `in_group` by power within its group.
    #[inline(always)]
    fn probability(&self, map: u32, leaf: u32, in_leaf: f32, in_group: f32) -> f32 {
        let params = self.power.params;
        let total = self.light_total(map);
        let mut probability = in_group;
        if total > 0.0 {
            let layout = LightPyramid::new(params);
            let slot = LightPyramid::offset(params) + map * layout.nodes() + layout.leaf_within(leaf);
            probability = self.pyramid[slot as usize] / total * in_leaf;
        }
        probability
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
            // Sample a map, and a light of its group
            let map = self.map_at((numbers.w - (BY_POWER + EVENLY)) / KNOWN);
            chosen = map % maps_of_group(params);
            light_id = self.light_at(map, u_position.x, u_position.y);
        } else {
            // Sample a cone uniformly (or none), and a light
            let evenly = (numbers.w - BY_POWER) / EVENLY * maps_of_group(params) as f32;
            chosen = if by_power { NONE } else { (evenly as u32).min(params.casters.count) };
            light_id = if by_power {
                choose(scene.lights, params.light_count, u_position.x, u_position.y)
            } else if more.z < UNIFORM_LIGHT {
                ((u_position.x * params.light_count as f32) as u32).min(params.light_count - 1)
            } else {
                let map = self.map_at((more.z - UNIFORM_LIGHT) / (1.0 - UNIFORM_LIGHT));
                self.light_at(map, u_position.x, u_position.y)
            };
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
        let ByPower { scene, params, features } = self.power;
        let (casters, first, leaf) = (params.casters.count, self.first(context), self.leaf(context));
        let GuidingChoice { chosen, own, .. } = *choice;
        let group = LightRange::group(scene.lights, params, first / maps_of_group(params));
        let by_power = context.light.pdf_light_choice;
        let in_group = group.probability(scene.lights, params, context.light_id);
        let mut in_leaf = in_group;
        if LightPyramid::is_used(params, features) {
            let leaf = LightRange::leaf(scene.lights, params, leaf);
            in_leaf = leaf.probability(scene.lights, params, context.light_id);
        }
        // Sum the density of the direction over all maps of the group, and find the map that is scored. It is the map that the
        // direction was sampled from, else the first whose cone holds the direction. So the last map learns where no cone serves.
        let even = EVENLY / maps_of_group(params) as f32;
        let (mut evenly, mut guided, mut closed_even, mut closed_known) = (0.0, 0.0, 0.0, 0.0);
        let mut all_known = 0.0;
        let (mut scored, mut scored_texel, mut scored_size) = (casters, 0, 0.0);
        let mut caster = 0;
        while caster <= casters {
            let cone = self.cone(context, caster);
            let map = first + caster;
            let probability = self.probability(map, leaf, in_leaf, in_group);
            let share = KNOWN * self.maps[map as usize].share * (probability / by_power);
            all_known += share;
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
        // Lights of the even share are chosen uniformly, or by the maps
        let uniform_light = 1.0 / (params.light_count as f32 * by_power);
        evenly *= UNIFORM_LIGHT * uniform_light + (1.0 - UNIFORM_LIGHT) / KNOWN * all_known;
        // Divide the start by the density of the whole mixture
        let sample = emission.sample.over(emission.pdf, BY_POWER, evenly + guided);
        let mut score = 0.0;
        // Score the start. A group without power is never sampled from maps, and learns nothing.
        if group.power > 0.0 {
            // Divide the density by that of a uniform start of the map.
            let over_uniform = (BY_POWER * emission.pdf + evenly + guided) * (group.power * scored_size);
            // Scale to one path a pixel, whatever the number of paths.
            let paths = over_uniform * params.light_path_count as f32 / params.pixel_count() as f32;
            score = paths * paths / self.maps[(first + scored) as usize].unit;
        }
        EmissionSample {
            start_code: GuidedStart::encode(params, leaf, scored, scored_texel),
            score,
            ..sample
        }
    }
}

impl Emit for Guided<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        start(self, &self.power, rng)
    }
}
