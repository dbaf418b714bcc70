//! Light path of an inspected photon.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light as LightRecord;
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight};
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::light::emit::{EmissionSample, Emit};
use caustics_kernels::pass::shoot::shoot;
use caustics_kernels::path::observer::PathObserver;
use caustics_kernels::path::photon_sink::PhotonSink;
use caustics_kernels::platform::Uncounted;
use caustics_kernels::surface::scatter::BsdfSample;
use caustics_kernels::surface::vertex::{Vertex, vertex};
use caustics_kernels::trace::Tracer;
use glam::Vec3;

use super::photons::GatheredPhoton;
use super::record::PathRecorder;
use super::view::InspectedFrame;
use super::{Event, Light, LightPath};

/// Photon sink that records a light path up to a photon.
struct Follow<'a> {
    record: PathRecorder<'a>,
    emission: Option<EmissionSample>,
    /// Flux of the path (W).
    flux: Vec3,
    light_path_count: u32,
    /// Number of scattering events before the photon.
    scatterings: u32,
    is_done: bool,
}

impl PhotonSink for Follow<'_> {
    type PathState = ();

    fn start(&mut self, (): &mut (), emission: &EmissionSample) {
        self.emission = Some(*emission);
        self.flux = emission.flux / self.light_path_count as f32;
    }

    fn arrive(&mut self, (): &mut (), ray: &Ray, hit: &Hit, here: &Vertex) {
        if !self.is_done {
            self.record.arrive(ray, hit, here, self.flux);
        }
    }

    fn scatter(&mut self, (): &mut (), departure: &BsdfSample, flux: Vec3) {
        if !self.is_done {
            self.record.scatter(departure);
            self.flux = flux;
        }
    }

    fn store_photon(&mut self, (): &mut (), geometry: PhotonGeometry, _light: PhotonLight) {
        if geometry.scatterings == self.scatterings {
            self.record.end(Event::Photon);
            self.is_done = true;
        }
    }
}

/// Traces the light path of a photon.
pub fn path(view: InspectedFrame<'_>, emit: &(dyn Emit + Sync), found: &GatheredPhoton) -> LightPath {
    let InspectedFrame { scene, params, features } = view;
    let mut follow = Follow {
        record: PathRecorder::new(view),
        emission: None,
        flux: Vec3::ZERO,
        light_path_count: params.light_path_count,
        scatterings: found.geometry.scatterings,
        is_done: false,
    };
    let (tables, mut tracer) = (scene.tables(), scene.tracer(features));
    shoot(found.path, params, features, tables, &emit, &mut tracer, &mut follow, &mut Uncounted);
    let emission = follow.emission.unwrap_or_else(|| EmissionSample::new(Ray::default(), Vec3::ZERO, 0.0));
    LightPath {
        path: found.path,
        light: light(view, &emission),
        start: view.file_position(emission.ray.origin),
        direction: emission.ray.direction.to_array(),
        flux: (emission.flux / params.light_path_count as f32).to_array(),
        vertices: follow.record.vertices,
    }
}

/// Finds the light of an emission sample. The sample has no light id, so that position and direction determine the light.
fn light(view: InspectedFrame<'_>, emission: &EmissionSample) -> Option<Light> {
    let (ray, lights) = (&emission.ray, &view.scene.lights);
    let is_it = |record: &LightRecord| match record.kind {
        kind if kind == Features::ENVIRONMENT.0 => emission.area > 0.0,
        _ if record.is_parallel() => emission.area > 0.0 && record.direction == ray.direction,
        _ => record.triangle == NONE && record.position == ray.origin,
    };
    // The environment is the last record.
    let light_id =
        lights.iter().position(is_it).map(|index| index as u32).or_else(|| area_light_behind(view, ray))?;
    let kind = lights.get(light_id as usize)?.kind;
    let (_, name) = Features::NAMES.into_iter().find(|(bit, _)| bit.0 == kind)?;
    Some(Light { id: light_id, kind: name.trim_end_matches("-lights") })
}

/// Returns the light id of the emitting triangle at a ray's origin.
fn area_light_behind(view: InspectedFrame<'_>, ray: &Ray) -> Option<u32> {
    let (tables, features) = (view.scene.tables(), Features(view.features.0 & Features::INSTANCES.0));
    let back = Ray::endless(ray.origin, -ray.direction);
    let hit = view.scene.tracer(features).closest(&back);
    if hit.is_miss() {
        return None;
    }
    let here = vertex(tables, features, &back, &hit, 0.0);
    let height = hit.distance * here.to_previous.dot(here.face_normal);
    (here.light != NONE && height <= 4.0 * here.clearance).then_some(here.light)
}
