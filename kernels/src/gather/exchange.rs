//! `index.*` and `gather.*`: build an index, and bring photons and points together. An index over points is asked by each
//! photon, which gives to the points that take it; an index over photons by each point, which takes from them.

use crate::gather::accumulator::GatheredSum;
use crate::gather::contribution::{Receiver, contribution, disc_half_extent, takes};
use crate::gather::tables::Tables;
use crate::gather::{Near, Visit, score};
use crate::interface::point::{PhotonGeometry, PhotonLight, PointGeometry};
use crate::math::quanta::Quanta;
use crate::platform::Atomics;
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// The pass that builds the index of a variant: `index_pass!(stripes, Stripes)` declares `index` and `INDEX`.
#[macro_export]
macro_rules! index_pass {
    ($name:ident, $type:ty) => {
        /// Builds the index, a stage a dispatch.
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

/// The pass that gathers by a variant: `gather_pass!(stripes, Stripes)` declares `gather` and `GATHER`. In brackets what
/// searches by ray queries, inside of this crate.
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
        /// Gathers, a point or a photon an invocation.
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
                let mut give = $crate::gather::exchange::PhotonGather::new(searcher, $tables);
                let ($near, $visit) = (give.near(), &mut give);
                $search;
                give.close($tables, counters);
            } else {
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

/// The passes of every variant, a module each.
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

/// A photon that gives to points.
pub struct PhotonGather {
    geometry: PhotonGeometry,
    light: PhotonLight,
    total: GatheredSum,
    score: Quanta,
}

impl PhotonGather {
    /// Photon `index`, which has given nothing yet.
    #[inline(always)]
    pub fn new(index: u32, tables: &Tables<'_>) -> PhotonGather {
        let geometry = tables.photon_geometry[index as usize];
        let light = tables.photon_light[index as usize];
        PhotonGather { geometry, light, total: GatheredSum::default(), score: Quanta::default() }
    }

    /// Where its points are: their boxes hold it.
    #[inline(always)]
    pub fn near(&self) -> Near {
        Near { position: self.geometry.position, half_extent: Vec3::ZERO }
    }

    /// Counts what was given, and tells it to the photon's start.
    #[inline(always)]
    pub fn close<C: Atomics>(self, tables: &mut Tables<'_>, counters: &mut C) {
        score::add(self.score, &self.light, &mut tables.start_scores);
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
            let sum = GatheredSum::new(value, tables.params.inverse_quantum());
            sum.add_to(&mut tables.accumulator, pixel);
            self.total = self.total.plus(sum);
            if self.light.score > 0.0 {
                let weight = tables.pixel_weights[pixel as usize];
                self.score = self.score.plus(score::score(&self.light, &point, &shading, value, weight));
            }
        }
    }
}

/// A point that takes from photons.
pub struct PointGather {
    pixel: u32,
    point: PointGeometry,
    /// Made for the first photon that it takes; what it was before tells nothing.
    receiver: Receiver,
    sum: GatheredSum,
}

impl PointGather {
    /// The point at position `index` of `pixel_order`, which has taken nothing yet.
    #[inline(always)]
    pub fn new(index: u32, tables: &Tables<'_>) -> PointGather {
        let pixel = tables.pixel_order[index as usize];
        let point = tables.point_geometry[pixel as usize];
        PointGather { pixel, point, receiver: Receiver::default(), sum: GatheredSum::default() }
    }

    /// Whether there is a point.
    #[inline(always)]
    pub fn is_point(&self) -> bool {
        self.point.exists()
    }

    /// Where its photons are.
    #[inline(always)]
    pub fn near(&self) -> Near {
        Near { position: self.point.position, half_extent: disc_half_extent(&self.point) }
    }

    /// Adds what was taken to the point's words.
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
        if takes(&self.point, &tables.photon_geometry[id as usize], tables.params.max_bounces) {
            // A GPU makes it anew each time: to keep it would take half of the waves.
            if cfg!(target_arch = "spirv") || self.sum.count == 0 {
                let shading = tables.point_shading[self.pixel as usize];
                let material = material_of(&shading, tables.materials, tables.features);
                let roughness = tables.params.specular_roughness;
                self.receiver = Receiver::new(&shading, material, roughness, tables.features);
            }
            let light = tables.photon_light[id as usize];
            let value = self.receiver.contribution(&light);
            self.sum = self.sum.plus(GatheredSum::new(value, tables.params.inverse_quantum()));
            if light.score > 0.0 {
                let shading = tables.point_shading[self.pixel as usize];
                let weight = tables.pixel_weights[self.pixel as usize];
                let score = score::score(&light, &self.point, &shading, value, weight);
                score::add(score, &light, &mut tables.start_scores);
            }
        }
    }
}
