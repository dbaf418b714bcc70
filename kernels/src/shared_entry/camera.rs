//! Passes that trace camera paths.

use super::Counted;
use crate::declare::shared_entry;
use crate::history::auxiliary::Shown;
use crate::history::path::{self, Retrace};
use crate::interface::NONE;
use crate::interface::auxiliary::Auxiliary;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistoryPoint, Retraced};
use crate::interface::instance::Instance;
use crate::interface::point::{IndirectSample, PointDirect, PointGeometry, PointShading};
use crate::interface::radiance_cache::{CacheCell, CacheKey, CacheSample};
use crate::interface::scene::SceneTables;
use crate::method::path::request as request_of_reference;
use crate::pass::collect::Collect;
use crate::pass::more_points::request as request_of_further_point;
use crate::path::camera_pass::{CameraPass, CameraPathRequest, run_camera_pass};
use crate::path::camera_path::CameraPathLight;
use crate::path::observer::{CollectionPoint, PathObserver};
use crate::platform::{Atomics, Slots};
use crate::trace::Tracer;
use spirv_std::glam::{UVec2, Vec2, Vec3};

/// Traces one camera path an invocation, for the pass that runs.
#[shared_entry(
    collects = "collect",
    adds = "points.trace",
    refers = "reference",
    retraces = "path.retrace",
    shows = "auxiliary"
)]
pub fn camera(
    index: u32,
    collects: bool,
    adds: bool,
    refers: bool,
    retraces: bool,
    shows: bool,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    counters: &mut impl Atomics,
    instances: &[Instance],
    pixel_order: &[u32],
    slot_prefixes: &[UVec2],
    path_radiance: Slots<'_, Vec3>,
    prefix_radiance: Slots<'_, Vec3>,
    delta_prefix_radiance: Slots<'_, Vec3>,
    point_direct: Slots<'_, PointDirect>,
    point_geometry: Slots<'_, PointGeometry>,
    point_shading: Slots<'_, PointShading>,
    point_indirect: Slots<'_, IndirectSample>,
    cache_cells: &[CacheCell],
    cache_samples: Slots<'_, CacheSample>,
    path_points: &[HistoryPoint],
    path_brightness: &[Vec2],
    path_retraced: Slots<'_, Retraced>,
    auxiliary: Slots<'_, Auxiliary>,
) {
    let materials = scene.materials;
    let (mut pixel, mut prefix) = (index, UVec2::ZERO);
    if retraces {
        pixel = path::pixel_of(index, path_points, params);
    } else if adds {
        prefix = slot_prefixes[index as usize];
    } else {
        pixel = pixel_order[index as usize];
    }
    let pass = AnyCameraPass {
        runs: RunningPass { collects, adds, refers, retraces, shows },
        collect: Collect {
            pixel,
            params,
            features,
            radiance: path_radiance,
            prefix: prefix_radiance,
            delta_prefix: delta_prefix_radiance,
            direct: point_direct,
            geometry: point_geometry,
            shading: point_shading,
            indirect: point_indirect,
            cells: cache_cells,
            cached: cache_samples,
        },
        prefix,
        retrace: Retrace {
            block: index,
            pixel,
            params,
            features,
            materials,
            points: path_points,
            brightness: path_brightness,
            retraced: path_retraced,
        },
        shown: Shown { pixel, params, features, materials, instances, records: auxiliary },
    };
    let mut counted = Counted { counts: collects || adds || refers, counters };
    run_camera_pass(pass, params, features, scene, tracer, &mut counted);
}

/// The pass that runs.
#[derive(Clone, Copy)]
struct RunningPass {
    collects: bool,
    adds: bool,
    refers: bool,
    retraces: bool,
    shows: bool,
}

/// All camera passes, of which one runs. `reference` stores nothing but radiance, where `collect` does.
struct AnyCameraPass<'a> {
    runs: RunningPass,
    collect: Collect<'a>,
    /// Pixel and number of a further prefix, whose point `collect` stores in the slot of the invocation.
    prefix: UVec2,
    retrace: Retrace<'a>,
    shown: Shown<'a>,
}

impl PathObserver for AnyCameraPass<'_> {
    type Kept = CollectionPoint;

    #[inline(always)]
    fn cached(&self, key: &CacheKey) -> CacheCell {
        if self.runs.collects { self.collect.cached(key) } else { CacheCell::default() }
    }

    #[inline(always)]
    fn collect(&mut self, kept: &mut CollectionPoint, point: &CollectionPoint) {
        if self.runs.collects || self.runs.adds {
            self.collect.collect(&mut (), point);
        }
        if self.runs.retraces {
            self.retrace.collect(kept, point);
        }
        if self.runs.shows {
            self.shown.collect(&mut (), point);
        }
    }

    #[inline(always)]
    fn end(&mut self, _kept: &mut CollectionPoint, last: Vec3) {
        if self.runs.collects || self.runs.adds {
            self.collect.end(&mut (), last);
        }
        if self.runs.shows {
            self.shown.end(&mut (), last);
        }
    }
}

impl CameraPass for AnyCameraPass<'_> {
    #[inline(always)]
    fn features(&self, features: Features) -> Features {
        if self.runs.shows { self.shown.features(features) } else { features }
    }

    #[inline(always)]
    fn request(&self) -> CameraPathRequest {
        if self.runs.refers {
            request_of_reference(self.collect.pixel)
        } else if self.runs.adds {
            request_of_further_point(self.prefix)
        } else if self.runs.shows {
            self.shown.request()
        } else {
            // Trace a path again as `collect` traced it.
            self.collect.request()
        }
    }

    #[inline(always)]
    fn store(&mut self, light: &CameraPathLight, kept: &CollectionPoint) {
        if self.runs.collects {
            self.collect.store(light, &());
        }
        if self.runs.adds && self.prefix.x == NONE {
            self.collect.geometry.write(self.collect.pixel, PointGeometry::default());
        }
        if self.runs.refers {
            self.collect.radiance.write(self.collect.pixel, light.radiance);
        }
        if self.runs.retraces {
            self.retrace.store(light, kept);
        }
    }
}
