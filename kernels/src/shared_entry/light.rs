//! Passes that trace light paths: those of the emissions, and validation.

use super::Counted;
use crate::declare::shared_entry;
use crate::history::validated::validate::{Compare, uncounted};
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::guide::GuideMap;
use crate::interface::history::ValidationPhoton;
use crate::interface::instance::Instance;
use crate::interface::point::{PhotonGeometry, PhotonLight};
use crate::interface::scene::SceneTables;
use crate::light::aimed::{self, Aimed};
use crate::light::emit::{EmissionSample, Emit, EvaluatedEmission};
use crate::light::guided::{self, Guided};
use crate::light::mixture::{EmissionContext, EmissionDirection, EmissionMixture, start};
use crate::light::power::ByPower;
use crate::math::rng::{Rng, Stream};
use crate::path::PathContext;
use crate::path::light_path::trace_light_path;
use crate::path::photon_sink::{PhotonSink, PhotonStore};
use crate::platform::{AtomicWords, Atomics, Slots};
use crate::trace::Tracer;
use spirv_std::glam::{Vec3, Vec4};

/// Traces one light path an invocation, for the pass that runs.
#[shared_entry(shoots = "shoot.store", aims = "shoot.aimed", guides = "shoot.guided", validates = "validate")]
pub fn light(
    index: u32,
    shoots: bool,
    aims: bool,
    guides: bool,
    validates: bool,
    params: &FrameParams,
    dispatch: Dispatch,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    counters: &mut impl Atomics,
    photon_geometry: Slots<'_, PhotonGeometry>,
    photon_light: Slots<'_, PhotonLight>,
    photon_state: AtomicWords<'_>,
    start_counts: AtomicWords<'_>,
    guide_maps: &[GuideMap],
    guide_pyramid: &[f32],
    instances: &[Instance],
    validation_photons: Slots<'_, ValidationPhoton>,
    validation_cells: AtomicWords<'_>,
) {
    let path = dispatch.first + index;
    let power = ByPower::new(scene, params, features);
    let starts = Starts {
        aims,
        guides,
        aimed: Aimed { power },
        guided: Guided { power, maps: guide_maps, pyramid: guide_pyramid },
    };
    let mut photons = Photons {
        stores: shoots || aims || guides,
        store: PhotonStore {
            geometry: photon_geometry,
            light: photon_light,
            state: photon_state,
            starts: start_counts,
            params,
            features,
        },
        compare: Compare::new(path, params, instances, validation_photons, validation_cells),
    };
    let mut rng = Rng::new(Stream::Light, params.seed, path, params.frame);
    let mut features = features;
    if validates {
        rng = photons.compare.rng();
        features = uncounted(features);
    }
    let mut counted = Counted { counts: photons.stores, counters };
    let context = PathContext { params, features, scene };
    let path_state = trace_light_path(path, rng, context, &starts, tracer, &mut photons, &mut counted);
    if validates {
        photons.compare.close(path_state);
    } else {
        photons.store.close(path_state, &mut counted);
    }
}

/// Emissions, one of which starts the paths: by power if it neither aims nor guides.
struct Starts<'a> {
    aims: bool,
    guides: bool,
    aimed: Aimed<'a>,
    guided: Guided<'a>,
}

impl Emit for Starts<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        start(self, &self.aimed.power, rng)
    }
}

impl EmissionMixture for Starts<'_> {
    type Choice = (aimed::CasterChoice, guided::GuidingChoice);

    #[inline(always)]
    fn mixes(&self) -> bool {
        self.aims || self.guides
    }

    #[inline(always)]
    fn light(&self, u_position: Vec4, numbers: Vec4, rng: &mut Rng) -> (u32, Self::Choice) {
        let mut choice = Self::Choice::default();
        let light_id;
        if self.guides {
            (light_id, choice.1) = self.guided.light(u_position, numbers, rng);
        } else {
            (light_id, choice.0) = self.aimed.light(u_position, numbers, rng);
        }
        (light_id, choice)
    }

    #[inline(always)]
    fn sample_direction(
        &self,
        (aimed, guided): &mut Self::Choice,
        context: &EmissionContext,
    ) -> EmissionDirection {
        if self.guides {
            self.guided.sample_direction(guided, context)
        } else {
            self.aimed.sample_direction(aimed, context)
        }
    }

    #[inline(always)]
    fn weigh(
        &self,
        (aimed, guided): &Self::Choice,
        context: &EmissionContext,
        direction: Vec3,
        emission: &EvaluatedEmission,
    ) -> EmissionSample {
        if self.guides {
            self.guided.weigh(guided, context, direction, emission)
        } else {
            self.aimed.weigh(aimed, context, direction, emission)
        }
    }
}

/// Photon sinks, one of which stores the photons.
struct Photons<'a> {
    stores: bool,
    store: PhotonStore<'a>,
    compare: Compare<'a>,
}

impl PhotonSink for Photons<'_> {
    type PathState = u32;

    #[inline(always)]
    fn start(&mut self, path_state: &mut u32, emission: &EmissionSample) {
        if self.stores {
            self.store.start(path_state, emission);
        }
    }

    #[inline(always)]
    fn store_photon(&mut self, path_state: &mut u32, geometry: PhotonGeometry, light: PhotonLight) {
        if self.stores {
            self.store.store_photon(path_state, geometry, light);
        } else {
            self.compare.store_photon(path_state, geometry, light);
        }
    }
}
