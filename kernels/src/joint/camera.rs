//! Passes that trace camera paths.

use super::Counted;
use crate::declare::joint;
use crate::history::auxiliary::Shown;
use crate::history::path::{self, Retrace};
use crate::interface::auxiliary::Auxiliary;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistoryPoint, Retraced};
use crate::interface::instance::Instance;
use crate::interface::point::{PointDirect, PointGeometry, PointShading};
use crate::interface::scene::SceneTables;
use crate::method::path::wanted as wanted_by_reference;
use crate::pass::collect::errand::{Errand, Wanted, run};
use crate::pass::collect::observer::{CollectionPoint, PathObserver};
use crate::pass::collect::{CameraPathLight, Collect};
use crate::platform::{Atomics, Slots};
use crate::trace::Tracer;
use spirv_std::glam::{Vec2, Vec3};

/// A camera path an invocation.
#[joint(collects = "collect", refers = "reference", retraces = "path.retrace", shows = "auxiliary")]
pub fn camera(
    index: u32,
    collects: bool,
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
    path_radiance: Slots<'_, Vec3>,
    prefix_radiance: Slots<'_, Vec3>,
    delta_prefix_radiance: Slots<'_, Vec3>,
    point_direct: Slots<'_, PointDirect>,
    point_geometry: Slots<'_, PointGeometry>,
    point_shading: Slots<'_, PointShading>,
    path_points: &[HistoryPoint],
    path_brightness: &[Vec2],
    path_retraced: Slots<'_, Retraced>,
    auxiliary: Slots<'_, Auxiliary>,
) {
    let materials = scene.materials;
    let pixel =
        if retraces { path::pixel_of(index, path_points, params) } else { pixel_order[index as usize] };
    let errands = Errands {
        runs: Runs { collects, refers, retraces, shows },
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
        },
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
    let mut counted = Counted { counts: collects || refers, counters };
    run(errands, params, features, scene, tracer, &mut counted);
}

/// Which one runs.
#[derive(Clone, Copy)]
struct Runs {
    collects: bool,
    refers: bool,
    retraces: bool,
    shows: bool,
}

/// The errands, of which one is run. That of `reference` leaves nothing but radiance, where `collect` does.
struct Errands<'a> {
    runs: Runs,
    collect: Collect<'a>,
    retrace: Retrace<'a>,
    shown: Shown<'a>,
}

impl PathObserver for Errands<'_> {
    type Kept = CollectionPoint;

    #[inline(always)]
    fn collect(&mut self, kept: &mut CollectionPoint, point: &CollectionPoint) {
        if self.runs.collects {
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
        if self.runs.collects {
            self.collect.end(&mut (), last);
        }
        if self.runs.shows {
            self.shown.end(&mut (), last);
        }
    }
}

impl Errand for Errands<'_> {
    #[inline(always)]
    fn features(&self, features: Features) -> Features {
        if self.runs.shows { self.shown.features(features) } else { features }
    }

    #[inline(always)]
    fn wanted(&self) -> Wanted {
        if self.runs.refers {
            wanted_by_reference(self.collect.pixel)
        } else if self.runs.shows {
            self.shown.wanted()
        } else {
            // Paths are traced again as they were traced.
            self.collect.wanted()
        }
    }

    #[inline(always)]
    fn leave(&mut self, light: &CameraPathLight, kept: &CollectionPoint) {
        if self.runs.collects {
            self.collect.leave(light, &());
        }
        if self.runs.refers {
            self.collect.radiance.write(self.collect.pixel, light.radiance);
        }
        if self.runs.retraces {
            self.retrace.leave(light, kept);
        }
    }
}
