//! `shoot.yang2021`: traces light sub-paths with their differentials and spreads each photon over the pixels around it [Yang and
//! Ouyang 2021]. Receivers are primary surfaces: points at camera vertex 1.
//!
//! A photon's contribution is added to the sums of collection points, as in a gather. It is scaled by pi R^2 of the point, by
//! which `resolve` divides.
//!
//! Cost: OurBasic's light paths and the pixels of their ellipses; no index, no stored photon.
//!
//! Limitations: only primary surfaces receive. An ellipse blurs, and at borders and thin walls part of it is lost or leaks. The
//! extent of a light, normal maps and diffuse bounces do not widen it.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Step;
use crate::declare::pass;
use crate::gather::accumulator::{self, GatheredSum};
use crate::gather::contribution::{contribution, is_same_surface};
#[cfg(not(target_arch = "spirv"))]
use crate::interface::choice::TextureFilter;
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use crate::interface::ray::{Hit, Ray};
use crate::interface::scene::SceneTables;
#[cfg(not(target_arch = "spirv"))]
use crate::light::by_density::map_count;
use crate::light::by_density::{ByDensity, DensityPyramid, FEEDBACK_WORDS, MAPS};
use crate::light::emit::EmissionSample;
use crate::light::power::ByPower;
use crate::math::PI;
use crate::math::cone::lobe_variance;
use crate::math::differential::{Differential, NormalDerivatives};
use crate::math::quanta::Quanta;
#[cfg(not(target_arch = "spirv"))]
use crate::method::frame::frame_steps;
#[cfg(not(target_arch = "spirv"))]
use crate::method::{Method, Parts};
use crate::pass::shoot::shoot;
use crate::path::photon_sink::PhotonSink;
use crate::platform::{AtomicWords, Atomics, Record, scratch};
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
/// Adaptive anisotropic photon scattering, guided by feedback.
pub const YANG2021: Method = Method {
    name: "yang2021",
    description: "adaptive anisotropic photon scattering: ellipses on primary surfaces, guided by feedback",
    cost: "OurBasic's light paths and the pixels of their ellipses; no index, no stored photon",
    limitations: "only primary surfaces receive; ellipses blur, lose light at borders and leak through thin walls; the size of a light, \
            normal maps and diffuse bounces do not widen them",
    gathers: true,
    supports_history: false,
    chooses_gather: false,
    chooses_emission: false,
    converges: false,
    texture_filter: TextureFilter::Cone,
    shares_indirect: false,
    uses_cache: false,
    passes_thin_walls: false,
    keeps: &["density", "density_pyramid", "density_feedback"],
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
/// Steps that make the density map of this frame.
fn prepare(params: &FrameParams) -> Vec<Step> {
    let sum = |level| {
        let count = DensityPyramid::count(level, map_count(params.light_count));
        Step::level(&density::DENSITY_SUM, level, count)
    };
    let mut steps = vec![Step::new(&density::DENSITY_UPDATE, params)];
    steps.extend((0..=DensityPyramid::TOP).map(sum));
    steps.push(Step::Clear { buffer: "density_feedback" });
    steps
}

/// Traces light paths, one an invocation, and spreads their photons over the image.
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
    density_pyramid: &[f32],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: AtomicWords<'_>,
    #[len = MAPS * DensityPyramid::TEXELS * FEEDBACK_WORDS] density_feedback: AtomicWords<'_>,
) {
    scratch!(words: ROOM);
    let power = ByPower::new(scene, params, features);
    let emit = ByDensity { power, pyramid: density_pyramid };
    let mut spread = Spread {
        scene,
        point_geometry,
        point_shading,
        accumulator,
        feedback: density_feedback,
        params,
        features,
        path_state: LightPathState { words, record: Record::at(params.zero()) },
    };
    let path = dispatch.first + index;
    shoot(path, params, features, scene, &emit, tracer, &mut spread, counters);
    spread.path_state.total().tally(counters);
}

/// Spread of a footprint behind a diffuse bounce (rad): neighbouring paths leave it in any direction.
const DIFFUSE_SPREAD: f32 = 0.1;
/// Share of a glossy lobe's spread that widens a footprint; the whole spread would blur twice.
const LOBE_SHARE: f32 = 0.3;
/// 1 / quantum of a texel's feedback [1/px].
pub const FEEDBACK_INVERSE_QUANTUM: f32 = 256.0;

/// Spreads the photons of a light path.
pub struct Spread<'a, A, F> {
    /// The scene.
    pub scene: SceneTables<'a>,
    /// Points by pixel.
    pub point_geometry: &'a [PointGeometry],
    /// Their shading.
    pub point_shading: &'a [PointShading],
    /// Sums by pixel.
    pub accumulator: A,
    /// Feedback of photons to the density map, by texel.
    pub feedback: F,
    /// Settings.
    pub params: &'a FrameParams,
    /// Code that is compiled in.
    pub features: Features,
    /// State of the path.
    pub path_state: LightPathState<'a>,
}

/// Number of words of a path's state.
const WORDS: usize = 26;
/// Number of words of its array; AMD's compiler does not keep an array of this size in registers.
const ROOM: usize = 3 * WORDS;

/// State of a light path, in memory: a GPU has few registers left beside those of the path itself.
pub struct LightPathState<'a> {
    words: &'a mut [u32; ROOM],
    record: Record<WORDS, ROOM>,
}

// Indices of its words.
const ROUGH: usize = 12;
const ARRIVING: usize = 14;
const HIT: usize = 17;
const TEXEL: usize = 22;
const TOTAL: usize = 23;

impl LightPathState<'_> {
    #[inline(always)]
    fn differential(&self) -> Differential {
        let number = |word| f32::from_bits(self.record.take(self.words, word));
        Differential {
            position_u: self.record.take3(self.words, 0),
            position_v: self.record.take3(self.words, 3),
            direction_u: self.record.take3(self.words, 6),
            direction_v: self.record.take3(self.words, 9),
            rough_width: number(ROUGH),
            rough_spread: number(ROUGH + 1),
        }
    }

    #[inline(always)]
    fn set_differential(&mut self, differential: &Differential) {
        self.record.put3(self.words, 0, differential.position_u);
        self.record.put3(self.words, 3, differential.position_v);
        self.record.put3(self.words, 6, differential.direction_u);
        self.record.put3(self.words, 9, differential.direction_v);
        self.record.put(self.words, ROUGH, differential.rough_width.to_bits());
        self.record.put(self.words, ROUGH + 1, differential.rough_spread.to_bits());
    }

    /// Arrival of the path: its direction, the hit, and whether it met the front.
    #[inline(always)]
    fn arrival(&self) -> (Vec3, Hit, bool) {
        let number = |word| f32::from_bits(self.record.take(self.words, word));
        let hit = Hit {
            triangle: self.record.take(self.words, HIT),
            instance: self.record.take(self.words, HIT + 1),
            u: number(HIT + 2),
            v: number(HIT + 3),
            ..Hit::MISS
        };
        (self.record.take3(self.words, ARRIVING), hit, self.record.take(self.words, HIT + 4) != 0)
    }

    #[inline(always)]
    fn arrive(&mut self, direction: Vec3, hit: &Hit, front: bool) {
        self.record.put3(self.words, ARRIVING, direction);
        self.record.put(self.words, HIT, hit.triangle);
        self.record.put(self.words, HIT + 1, hit.instance);
        self.record.put(self.words, HIT + 2, hit.u.to_bits());
        self.record.put(self.words, HIT + 3, hit.v.to_bits());
        self.record.put(self.words, HIT + 4, u32::from(front));
    }

    #[inline(always)]
    fn texel(&self) -> u32 {
        self.record.take(self.words, TEXEL)
    }

    #[inline(always)]
    fn set_texel(&mut self, texel: u32) {
        self.record.put(self.words, TEXEL, texel);
    }

    /// Counts of the photons that were spread, clamped, and not finite.
    #[inline(always)]
    fn total(&self) -> GatheredSum {
        let count = self.record.take(self.words, TOTAL);
        let (clamped, non_finite) =
            (self.record.take(self.words, TOTAL + 1), self.record.take(self.words, TOTAL + 2));
        GatheredSum { count, clamped, non_finite, ..GatheredSum::default() }
    }

    #[inline(always)]
    fn set_total(&mut self, total: &GatheredSum) {
        self.record.put(self.words, TOTAL, total.count);
        self.record.put(self.words, TOTAL + 1, total.clamped);
        self.record.put(self.words, TOTAL + 2, total.non_finite);
    }
}

impl<A: Atomics, F: Atomics> Spread<'_, A, F> {
    /// Unit `normal`, with its derivatives where the path arrived.
    #[inline(always)]
    fn normals(
        &self,
        differential: &Differential,
        hit: &Hit,
        front: bool,
        normal: Vec3,
    ) -> NormalDerivatives {
        let steps = (differential.position_u, differential.position_v);
        let (by_u, by_v) = normal_changes(self.scene, self.features, hit, front, steps);
        NormalDerivatives { normal, by_u, by_v }
    }

    /// Adds a photon to the point of one pixel. Returns whether the point took it.
    #[inline(always)]
    fn give(
        &mut self,
        pixel: u32,
        geometry: &PhotonGeometry,
        light: &PhotonLight,
        footprint: &Footprint,
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
        let inverse_quantum = self.params.inverse_quantum();
        let sum =
            GatheredSum::new(value * (disc * weight), inverse_quantum, geometry.position, point.position);
        sum.add_to(&mut self.accumulator, pixel);
        self.path_state.set_total(&self.path_state.total().plus(sum));
        true
    }
}

/// Whether a primary point may take a photon: both are on the same side of the same surface, and their path is short enough.
#[inline(always)]
fn takes(point: &PointGeometry, photon: &PhotonGeometry, footprint: &Footprint, max_bounces: u32) -> bool {
    let along = photon.position - point.position;
    point.depth == 1
        && is_same_surface(along, point.normal, photon.normal, point.radius + footprint.reach)
        && point.depth + photon.scatterings <= max_bounces
}

impl<A: Atomics, F: Atomics> PhotonSink for Spread<'_, A, F> {
    type PathState = ();

    #[inline(always)]
    fn start(&mut self, _path_state: &mut (), emission: &EmissionSample) {
        let share = 1.0 / self.params.light_path_count as f32;
        let (direction, solid_angle) = (emission.ray.direction, emission.solid_angle * share);
        self.path_state.set_differential(&Differential::at_light(
            direction,
            solid_angle,
            emission.area * share,
        ));
        self.path_state.set_total(&GatheredSum::default());
        self.path_state.set_texel(emission.start_code);
        self.feedback.add(emission.start_code * FEEDBACK_WORDS + 5, 1);
    }

    #[inline(always)]
    fn arrive(&mut self, _path_state: &mut (), ray: &Ray, hit: &Hit, here: &Vertex) {
        let differential = self.path_state.differential();
        let arrived = differential.transfer(ray.direction, hit.distance, here.face_normal);
        self.path_state.set_differential(&arrived);
        self.path_state.arrive(ray.direction, hit, here.front);
    }

    #[inline(always)]
    fn store_photon(&mut self, _path_state: &mut (), geometry: PhotonGeometry, light: PhotonLight) {
        let differential = self.path_state.differential();
        // Project the ellipse of the photon into the image
        let footprint = Footprint::new(geometry.position, geometry.normal, &differential, self.params);
        if footprint.area_px == 0.0 {
            return;
        }
        // Add the photon to the pixels that may see its ellipse
        let mut taken = false;
        let mut row = footprint.first_row;
        while row <= footprint.last_row {
            let mut column = footprint.first_column;
            while column <= footprint.last_column {
                let pixel = row * self.params.width + column;
                taken |= self.give(pixel, &geometry, &light, &footprint);
                column += 1;
            }
            row += 1;
        }
        // Feed the size of the ellipse back to the density map
        if taken {
            let first = self.path_state.texel() * FEEDBACK_WORDS;
            let area = footprint.area_px;
            Quanta::from_f32(area, FEEDBACK_INVERSE_QUANTUM).add_to(&mut self.feedback, first);
            Quanta::from_f32(area * area, FEEDBACK_INVERSE_QUANTUM).add_to(&mut self.feedback, first + 2);
            self.feedback.add(first + 4, 1);
        }
    }

    #[inline(always)]
    fn scatter(&mut self, _path_state: &mut (), scattered: &BsdfSample, _flux: Vec3) {
        let sampled = &scattered.sampled;
        let direction = scattered.ray.direction;
        let mut differential = self.path_state.differential();
        // Widen the footprint at a diffuse bounce
        if sampled.class == Classes::NON_SPECULAR {
            self.path_state.set_differential(&differential.roughen(DIFFUSE_SPREAD, true));
            return;
        }
        // Reflect or refract the differential at the facet that turned the path; on a rough surface, the one that it met.
        let (arriving, hit, front) = self.path_state.arrival();
        let unrefracted = sampled.straight || (sampled.transmitted && sampled.eta == 1.0);
        if !sampled.transmitted {
            let normal = (direction - arriving).normalize();
            let normals = self.normals(&differential, &hit, front, normal);
            differential = differential.reflect(arriving, normals);
        } else if !unrefracted {
            let facet = (arriving * sampled.eta - direction).normalize();
            let side = if facet.dot(arriving) > 0.0 { -1.0 } else { 1.0 };
            let normals = self.normals(&differential, &hit, front, facet * side);
            differential = differential.refract(arriving, direction, normals, sampled.eta);
        }
        // Widen the footprint by the spread of a rough lobe
        if sampled.roughness > 0.0 {
            let spread = LOBE_SHARE * lobe_variance(sampled.roughness).sqrt();
            differential = differential.roughen(spread, false);
        }
        self.path_state.set_differential(&differential);
    }
}
