//! `shoot.yang2021`: traces light sub-paths with their differentials and spreads each deposit over the pixels around it
//! [Yang and Ouyang 2021]. Receivers are primary surfaces: points at camera vertex 1.
//!
//! What a deposit gives is added to the sums of collection points as gathers do, times pi R^2 of the point, which `resolve`
//! divides by.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Step;
use crate::declare::pass;
use crate::gather::accumulator::{self, Sum};
use crate::gather::contribution::{contribution, is_same_surface};
#[cfg(not(target_arch = "spirv"))]
use crate::interface::choice::TextureFilter;
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use crate::interface::ray::{Hit, Ray};
use crate::interface::scene::SceneTables;
#[cfg(not(target_arch = "spirv"))]
use crate::light::by_density::map_count;
use crate::light::by_density::{ByDensity, FEEDBACK_WORDS, MAPS, Map};
use crate::light::emit::EmissionSample;
use crate::light::power::ByPower;
use crate::math::PI;
use crate::math::cone::lobe_variance;
use crate::math::differential::{Differential, Normals};
use crate::math::quanta::Quanta;
#[cfg(not(target_arch = "spirv"))]
use crate::method::frame::frame_steps;
#[cfg(not(target_arch = "spirv"))]
use crate::method::{Method, Parts};
use crate::pass::shoot::receive::Receive;
use crate::pass::shoot::shoot;
use crate::seam::{AtomicWords, Atomics};
use crate::surface::class::Classes;
use crate::surface::scatter::BsdfSample;
use crate::surface::textured::material_of;
use crate::surface::turn::normal_changes;
use crate::surface::vertex::Vertex;
use crate::trace::Tracer;
use footprint::Footprint;
use spirv_std::glam::Vec3;

pub mod density;
pub mod footprint;

#[cfg(not(target_arch = "spirv"))]
/// See the head of the file.
pub const YANG2021: Method = Method {
    name: "yang2021",
    about: "adaptive anisotropic photon scattering: ellipses on primary surfaces, guided by feedback",
    cost: "OurBasic's light paths and the pixels of their ellipses; no index, no stored deposit",
    wrong: "only primary surfaces receive; an ellipse blurs, and at borders and thin walls part of it is lost or leaks; the \
            extent of a lamp, normal maps and diffuse bounces do not widen it",
    gathers: true,
    lends: false,
    chooses_gather: false,
    chooses_emission: false,
    converges: false,
    texture_filter: TextureFilter::Cone,
    keeps: &["density", "density_tree", "density_feedback"],
    frame: |params, index| FrameParams { frame: index, ..params },
    steps,
};

#[cfg(not(target_arch = "spirv"))]
fn steps(parts: Parts, params: &FrameParams) -> Vec<Step> {
    frame_steps(parts, params, prepare(params), |batch| {
        vec![Step::dispatch(&SHOOT_YANG2021, batch.dispatch())]
    })
}

#[cfg(not(target_arch = "spirv"))]
/// The density map of this frame.
fn prepare(params: &FrameParams) -> Vec<Step> {
    let sum = |level| {
        let count = Map::count(level, map_count(params.light_count));
        Step::level(&density::DENSITY_SUM, level, count)
    };
    let mut steps = vec![Step::of(&density::DENSITY_UPDATE, params)];
    steps.extend((0..=Map::TOP).map(sum));
    steps.push(Step::Clear { buffer: "density_feedback" });
    steps
}

/// Light paths, one an invocation; deposits are spread over the picture.
#[pass(name = "shoot.yang2021", over = params.light_path_batch, work = Light)]
pub fn shoot_yang2021(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    counters: &mut impl Atomics,
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    density_tree: &[f32],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: AtomicWords<'_>,
    #[len = MAPS * Map::TEXELS * FEEDBACK_WORDS] density_feedback: AtomicWords<'_>,
) {
    let power = ByPower::new(scene, params, features);
    let emit = ByDensity { power, tree: density_tree };
    let mut spread = Spread {
        scene,
        point_geometry,
        point_shading,
        accumulator,
        feedback: density_feedback,
        params,
        features,
    };
    let path = dispatch.first + index;
    let way = shoot(path, params, features, scene, &emit, tracer, &mut spread, counters);
    way.total.tally(counters);
}

/// Spread of a footprint behind a diffuse bounce (rad): neighbours there go anywhere.
const DIFFUSE_SPREAD: f32 = 0.1;
/// Share of a glossy lobe's spread that is a footprint's: the spread itself would blur twice.
const LOBE_SHARE: f32 = 0.3;
/// 1 / quantum of a texel's feedback [1/px].
pub const FEEDBACK_INVERSE_QUANTUM: f32 = 256.0;

/// Spreads the deposits of a light path.
pub struct Spread<'a, A, F> {
    /// The scene.
    pub scene: SceneTables<'a>,
    /// Points by pixel.
    pub point_geometry: &'a [PointGeometry],
    /// Their shading.
    pub point_shading: &'a [PointShading],
    /// Sums by pixel.
    pub accumulator: A,
    /// What deposits tell the density map, by texel.
    pub feedback: F,
    /// Settings.
    pub params: &'a FrameParams,
    /// What the scene needs.
    pub features: Features,
}

/// A light path on its way.
#[derive(Clone, Copy, Default)]
pub struct Spreading {
    differential: Differential,
    arriving: Vec3,
    hit: Hit,
    front: bool,
    texel: u32,
    /// What was given.
    pub total: Sum,
}

impl<A: Atomics, F: Atomics> Spread<'_, A, F> {
    /// The unit `normal` with its changes where the path arrived.
    #[inline(always)]
    fn normals(&self, way: &Spreading, normal: Vec3) -> Normals {
        let steps = (way.differential.position_u, way.differential.position_v);
        let (by_u, by_v) = normal_changes(self.scene, self.features, &way.hit, way.front, steps);
        Normals { normal, by_u, by_v }
    }

    /// Gives to one pixel; whether it took.
    #[inline(always)]
    fn give(
        &mut self,
        pixel: u32,
        geometry: &DepositGeometry,
        light: &DepositLight,
        footprint: &Footprint,
        total: &mut Sum,
    ) -> bool {
        let point = self.point_geometry[pixel as usize];
        if !takes(&point, geometry, footprint, self.params.max_bounces) {
            return false;
        }
        let weight = footprint.weight(point.position - geometry.position);
        if weight <= 0.0 {
            return false;
        }
        let shading = self.point_shading[pixel as usize];
        let material = material_of(&shading, self.scene.materials, self.features);
        let value = contribution(&shading, material, light, self.params.specular_roughness, self.features);
        let disc = PI * point.radius * point.radius;
        let sum = Sum::of(value * (disc * weight), self.params.inverse_quantum());
        sum.add_to(&mut self.accumulator, pixel);
        *total = total.plus(sum);
        true
    }
}

/// Whether a primary point may take a deposit: on the same side of the same surface, and short enough a path.
#[inline(always)]
fn takes(point: &PointGeometry, deposit: &DepositGeometry, footprint: &Footprint, max_bounces: u32) -> bool {
    let along = deposit.position - point.position;
    point.depth == 1
        && is_same_surface(along, point.normal, deposit.normal, point.radius + footprint.reach)
        && point.depth + deposit.scatterings <= max_bounces
}

impl<A: Atomics, F: Atomics> Receive for Spread<'_, A, F> {
    type Way = Spreading;

    #[inline(always)]
    fn start(&mut self, way: &mut Spreading, leaving: &EmissionSample) {
        let share = 1.0 / self.params.light_path_count as f32;
        way.differential =
            Differential::leaving(leaving.ray.direction, leaving.solid_angle * share, leaving.area * share);
        way.texel = leaving.texel;
        self.feedback.add(way.texel * FEEDBACK_WORDS + 5, 1);
    }

    #[inline(always)]
    fn arrive(&mut self, way: &mut Spreading, ray: &Ray, hit: &Hit, here: &Vertex) {
        way.differential = way.differential.transfer(ray.direction, hit.distance, here.face_normal);
        way.arriving = ray.direction;
        way.hit = *hit;
        way.front = here.front;
    }

    #[inline(always)]
    fn receive(&mut self, way: &mut Spreading, geometry: DepositGeometry, light: DepositLight) {
        let footprint = Footprint::new(geometry.position, geometry.normal, &way.differential, self.params);
        if footprint.area_px == 0.0 {
            return;
        }
        let mut taken = false;
        let mut row = footprint.first_row;
        while row <= footprint.last_row {
            let mut column = footprint.first_column;
            while column <= footprint.last_column {
                let pixel = row * self.params.width + column;
                taken |= self.give(pixel, &geometry, &light, &footprint, &mut way.total);
                column += 1;
            }
            row += 1;
        }
        if taken {
            let first = way.texel * FEEDBACK_WORDS;
            let area = footprint.area_px;
            Quanta::from_f32(area, FEEDBACK_INVERSE_QUANTUM).add_to(&mut self.feedback, first);
            Quanta::from_f32(area * area, FEEDBACK_INVERSE_QUANTUM).add_to(&mut self.feedback, first + 2);
            self.feedback.add(first + 4, 1);
        }
    }

    #[inline(always)]
    fn scatter(&mut self, way: &mut Spreading, scattered: &BsdfSample, _flux: Vec3) {
        let sampled = &scattered.sampled;
        let direction = scattered.ray.direction;
        if sampled.class == Classes::NON_SPECULAR {
            way.differential = way.differential.roughen(DIFFUSE_SPREAD, true);
            return;
        }
        // The facet that turned the path: of a rough surface, the one that it met.
        let unbent = sampled.straight || (sampled.transmitted && sampled.eta == 1.0);
        if !sampled.transmitted {
            let normals = self.normals(way, (direction - way.arriving).normalize());
            way.differential = way.differential.reflect(way.arriving, normals);
        } else if !unbent {
            let facet = (way.arriving * sampled.eta - direction).normalize();
            let side = if facet.dot(way.arriving) > 0.0 { -1.0 } else { 1.0 };
            let normals = self.normals(way, facet * side);
            way.differential = way.differential.refract(way.arriving, direction, normals, sampled.eta);
        }
        if sampled.roughness > 0.0 {
            let spread = LOBE_SHARE * lobe_variance(sampled.roughness).sqrt();
            way.differential = way.differential.roughen(spread, false);
        }
    }
}
