//! `index.*` and `gather.*`: build an index, and bring photons and points together. With an index over points, each photon
//! searches for the points that take it. With an index over photons, each point searches for the photons that it takes.

use crate::gather::accumulator::GatheredSum;
use crate::gather::contribution::{Receiver, contribution, disc_half_extent, takes};
use crate::gather::tables::Tables;
use crate::gather::{Near, Visit, score};
use crate::interface::point::{PhotonGeometry, PhotonLight, PointGeometry};
use crate::math::quanta::Quanta;
use crate::platform::Atomics;
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Declares the pass that builds the index of a variant: `index_pass!(stripes, Stripes)` makes `index` and `INDEX`.
#[macro_export]
macro_rules! index_pass {
    ($name:ident, $type:ty) => {
        /// Builds the index, one stage a dispatch.
        #[$crate::declare::pass(
            name = ["index.", $name], over = 0, work = Index, limit = dispatch.limit(photon_state, params),
        )]
        pub fn index(
            invocation: u32,
            params: &$crate::interface::frame::FrameParams,
            dispatch: $crate::interface::frame::Dispatch,
            pixel_order: &[u32],
            point_geometry: &[$crate::interface::point::PointGeometry],
            photon_state: &[u32],
            photon_geometry: &[$crate::interface::point::PhotonGeometry],
            photon_light: &[$crate::interface::point::PhotonLight],
            #[len = <$type as $crate::gather::Index>::VARIANT.sorted(params)]
            sorted_geometry: $crate::platform::Slots<'_, $crate::interface::point::PhotonGeometry>,
            #[len = <$type as $crate::gather::Index>::VARIANT.sorted(params)]
            sorted_light: $crate::platform::Slots<'_, $crate::interface::point::PhotonLight>,
            #[len = <$type as $crate::gather::Index>::VARIANT.words[0].count(params)]
            index_0: $crate::platform::AtomicWords<'_>,
            #[len = <$type as $crate::gather::Index>::VARIANT.words[1].count(params)]
            index_1: $crate::platform::AtomicWords<'_>,
            #[len = <$type as $crate::gather::Index>::VARIANT.words[2].count(params)]
            index_2: $crate::platform::AtomicWords<'_>,
            #[len = <$type as $crate::gather::Index>::VARIANT.words[3].count(params)]
            index_3: $crate::platform::AtomicWords<'_>,
        ) {
            let mut build = $crate::gather::tables::Build {
                params,
                pixel_order,
                point_geometry,
                photon_geometry,
                photon_light,
                photon_count: params.photon_count(photon_state),
                index_0,
                index_1,
                index_2,
                index_3,
                sorted_geometry,
                sorted_light,
            };
            <$type as $crate::gather::Index>::build(dispatch.level, invocation, &mut build);
        }
    };
}

/// Declares the pass that gathers by a variant: `gather_pass!(stripes, Stripes)` makes `gather` and `GATHER`. The arguments in
/// brackets serve variants of this crate that search by ray queries.
#[macro_export]
macro_rules! gather_pass {
    ($name:ident, $type:ty) => {
        $crate::gather_pass!($name, $type, [], [], |tables, near, visit| {
            <$type as $crate::gather::Gather>::for_each_near(tables, near, visit);
        });
    };
    (
        $name:ident, $type:ty, [$($hardware:tt)*], [$($structure:tt)*],
        |$tables:ident, $near:ident, $visit:ident| $search:expr
    ) => {
        /// Gathers, one point or one photon an invocation.
        #[$crate::declare::pass(
            name = ["gather.", $name],
            over = $crate::gather::variant::Over::searchers(<$type as $crate::gather::Index>::VARIANT.side).extent(params),
            work = Gather,
            limit = dispatch.limit(photon_state, params),
            $($hardware)*
        )]
        pub fn gather(
            searcher: u32,
            params: &$crate::interface::frame::FrameParams,
            features: $crate::interface::features::Features,
            counters: &mut impl $crate::platform::Atomics,
            materials: &[$crate::interface::material::Material],
            pixel_order: &[u32],
            point_geometry: &[$crate::interface::point::PointGeometry],
            point_shading: &[$crate::interface::point::PointShading],
            photon_state: &[u32],
            photon_geometry: &[$crate::interface::point::PhotonGeometry],
            photon_light: &[$crate::interface::point::PhotonLight],
            sorted_geometry: &[$crate::interface::point::PhotonGeometry],
            sorted_light: &[$crate::interface::point::PhotonLight],
            index_0: &[u32],
            index_1: &[u32],
            index_2: &[u32],
            index_3: &[u32],
            #[len = params.pixel_count() * $crate::gather::accumulator::WORDS]
            accumulator: $crate::platform::AtomicWords<'_>,
            pixel_weights: &[f32],
            #[len = 0]
            start_scores: $crate::platform::AtomicWords<'_>,
            $($structure)*
        ) {
            let sorts = const { <$type as $crate::gather::Index>::VARIANT.sorts };
            let $tables = &mut $crate::gather::tables::Tables {
                params,
                features,
                materials,
                pixel_order,
                point_geometry,
                point_shading,
                photon_geometry: if sorts { sorted_geometry } else { photon_geometry },
                photon_light: if sorts { sorted_light } else { photon_light },
                photon_count: params.photon_count(photon_state),
                index_0,
                index_1,
                index_2,
                index_3,
                pixel_weights,
                accumulator,
                start_scores,
            };
            if const {
                matches!(<$type as $crate::gather::Index>::VARIANT.side, $crate::gather::variant::Side::Points)
            } {
                // Find the points that take this photon
                let mut give = $crate::gather::exchange::PhotonGather::new(searcher, $tables);
                let ($near, $visit) = (give.near(), &mut give);
                $search;
                give.close($tables, counters);
            } else {
                // Find the photons that this point takes
                let mut take = $crate::gather::exchange::PointGather::new(searcher, $tables);
                if take.is_point() {
                    let ($near, $visit) = (take.near(), &mut take);
                    $search;
                    take.close($tables, counters);
                }
            }
        }
    };
}

/// Declares the passes of every variant, one module each.
macro_rules! passes {
    ([$($file:ident $type:ident $constant:ident;)*] [$($file_rt:ident $type_rt:ident $constant_rt:ident;)*]) => {
        $(
            #[doc = concat!("The passes of `gather::", stringify!($file), "`.")]
            pub mod $file {
                use crate::gather::$file::$type;

                index_pass!($file, $type);
                gather_pass!($file, $type);
            }
        )*
        $(
            #[doc = concat!("The passes of `gather::", stringify!($file_rt), "`.")]
            pub mod $file_rt {
                #[cfg(feature = "ray-query")]
                use crate::gather::$file_rt::for_each_near;
                use crate::gather::$file_rt::$type_rt;

                index_pass!($file_rt, $type_rt);
                gather_pass!(
                    $file_rt,
                    $type_rt,
                    [hardware],
                    [neighbour_structure: &spirv_std::ray_tracing::AccelerationStructure],
                    |tables, near, visit| for_each_near(neighbour_structure, tables, near, visit)
                );
            }
        )*
    };
}

for_each_gather!(passes);

/// Photon that searches for the points that take it.
pub struct PhotonGather {
    geometry: PhotonGeometry,
    light: PhotonLight,
    total: GatheredSum,
    score: Quanta,
}

impl PhotonGather {
    /// Photon `index`, before its search.
    #[inline(always)]
    pub fn new(index: u32, tables: &Tables<'_>) -> PhotonGather {
        let geometry = tables.photon_geometry[index as usize];
        let light = tables.photon_light[index as usize];
        PhotonGather { geometry, light, total: GatheredSum::default(), score: Quanta::default() }
    }

    /// Region of its points: their boxes hold the photon.
    #[inline(always)]
    pub fn near(&self) -> Near {
        Near { position: self.geometry.position, half_extent: Vec3::ZERO }
    }

    /// Adds its counts to the counters, and its score to the photon's start.
    #[inline(always)]
    pub fn close<C: Atomics>(self, tables: &mut Tables<'_>, counters: &mut C) {
        let (params, features) = (tables.params, tables.features);
        score::add(self.score, &self.light, params, features, &mut tables.start_scores);
        self.total.tally(counters);
    }
}

impl Visit for PhotonGather {
    #[inline(always)]
    fn visit(&mut self, tables: &mut Tables<'_>, id: u32) {
        let pixel = tables.pixel_order[id as usize];
        let point = tables.point_geometry[pixel as usize];
        if takes(&point, &self.geometry, tables.params.max_bounces) {
            let shading = tables.point_shading[pixel as usize];
            let material = material_of(&shading, tables.materials, tables.features);
            let roughness = tables.params.specular_roughness;
            let value = contribution(&shading, material, &self.light, roughness, tables.features);
            // Add the photon to the point's sum
            let inverse_quantum = tables.params.inverse_quantum();
            let sum = GatheredSum::new(value, inverse_quantum, self.geometry.position, point.position);
            sum.add_to(&mut tables.accumulator, pixel);
            self.total = self.total.plus(sum);
            // Score the start of the light path
            if self.light.score > 0.0 {
                let weight = tables.pixel_weights[pixel as usize];
                self.score = self.score.plus(score::score(&self.light, &point, &shading, value, weight));
            }
        }
    }
}

/// Point that searches for the photons that it takes.
pub struct PointGather {
    pixel: u32,
    point: PointGeometry,
    /// BSDF of the point, made for the first photon that it takes; meaningless before.
    receiver: Receiver,
    sum: GatheredSum,
}

impl PointGather {
    /// Point at position `index` of `pixel_order`, before its search.
    #[inline(always)]
    pub fn new(index: u32, tables: &Tables<'_>) -> PointGather {
        let pixel = tables.pixel_order[index as usize];
        let point = tables.point_geometry[pixel as usize];
        PointGather { pixel, point, receiver: Receiver::default(), sum: GatheredSum::default() }
    }

    /// Whether the pixel has a point.
    #[inline(always)]
    pub fn is_point(&self) -> bool {
        self.point.exists()
    }

    /// Box of the photons that its disc may take.
    #[inline(always)]
    pub fn near(&self) -> Near {
        Near { position: self.point.position, half_extent: disc_half_extent(&self.point) }
    }

    /// Adds the sum to the point's words, and its counts to the counters.
    #[inline(always)]
    pub fn close<C: Atomics>(self, tables: &mut Tables<'_>, counters: &mut C) {
        if self.sum.count != 0 {
            self.sum.add_to(&mut tables.accumulator, self.pixel);
            self.sum.tally(counters);
        }
    }
}

impl Visit for PointGather {
    #[inline(always)]
    fn visit(&mut self, tables: &mut Tables<'_>, id: u32) {
        let photon = tables.photon_geometry[id as usize];
        if takes(&self.point, &photon, tables.params.max_bounces) {
            // Make the BSDF of the point. A GPU makes it for each photon: keeping it would halve the number of waves.
            if cfg!(target_arch = "spirv") || self.sum.count == 0 {
                let shading = tables.point_shading[self.pixel as usize];
                let material = material_of(&shading, tables.materials, tables.features);
                let roughness = tables.params.specular_roughness;
                self.receiver = Receiver::new(&shading, material, roughness, tables.features);
            }
            // Add the photon to the point's sum
            let light = tables.photon_light[id as usize];
            let value = self.receiver.contribution(&light);
            let inverse_quantum = tables.params.inverse_quantum();
            let sum = GatheredSum::new(value, inverse_quantum, photon.position, self.point.position);
            self.sum = self.sum.plus(sum);
            // Score the start of the light path
            if light.score > 0.0 {
                let shading = tables.point_shading[self.pixel as usize];
                let weight = tables.pixel_weights[self.pixel as usize];
                let score = score::score(&light, &self.point, &shading, value, weight);
                let (params, features) = (tables.params, tables.features);
                score::add(score, &light, params, features, &mut tables.start_scores);
            }
        }
    }
}
