//! `reference`: path tracing of all light, one sample a pixel. It is `collect` with a camera suffix that follows specular lobes,
//! too. So it finds at random the light that light paths and the gather find on purpose. Unbiased.
//!
//! Cost: a camera path a pixel. Limitations: caustics are noisy, and those of lights without extent are missing.

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Step;
use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::interface::choice::TextureFilter;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::scene::SceneTables;
use crate::math::rng::Stream;
#[cfg(not(target_arch = "spirv"))]
use crate::method::Method;
#[cfg(not(target_arch = "spirv"))]
use crate::pass::display::DISPLAY;
use crate::path::camera_pass::{CameraPass, CameraPathRequest, run_camera_pass};
use crate::path::camera_path::{CameraPathLight, CameraSuffix};
use crate::path::observer::{CollectionPoint, PathObserver};
use crate::platform::{Atomics, Slots};
use crate::trace::Tracer;
use spirv_std::glam::Vec3;

#[cfg(not(target_arch = "spirv"))]
/// Path tracing of all light: the estimator of the reference.
pub const PATH: Method = Method {
    name: "path",
    description: "path tracing of all light, one path a pixel: the estimator of references",
    cost: "a camera path a pixel",
    limitations: "unbiased; caustics are noisy, and those of lights without area are missing",
    gathers: false,
    supports_history: false,
    chooses_gather: false,
    chooses_emission: false,
    converges: true,
    texture_filter: TextureFilter::Finest,
    shares_indirect: false,
    uses_cache: false,
    passes_thin_walls: true,
    keeps: &[],
    frame: |params, index| FrameParams { frame: index, light_path_count: 0, ..params },
    steps: |_, params| {
        vec![Step::Clear { buffer: "counters" }, Step::new(&REFERENCE, params), Step::new(&DISPLAY, params)]
    },
};

/// Traces the paths of the reference, one pixel an invocation.
#[pass(name = "reference", over = params.pixel_count(), work = Camera, shared_entry)]
pub fn reference(
    index: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    counters: &mut impl Atomics,
    #[len = params.pixel_count()] pixel_order: &[u32],
    path_radiance: Slots<'_, Vec3>,
) {
    let reference = Reference { pixel: pixel_order[index as usize], radiance: path_radiance };
    run_camera_pass(reference, params, features, scene, tracer, counters);
}

/// The camera pass `reference`: all light.
struct Reference<'a> {
    pixel: u32,
    radiance: Slots<'a, Vec3>,
}

impl PathObserver for Reference<'_> {
    type Kept = ();

    #[inline(always)]
    fn collect(&mut self, _kept: &mut (), _point: &CollectionPoint) {}
    #[inline(always)]
    fn end(&mut self, _kept: &mut (), _last: Vec3) {}
}

impl CameraPass for Reference<'_> {
    #[inline(always)]
    fn request(&self) -> CameraPathRequest {
        request(self.pixel)
    }
    #[inline(always)]
    fn store(&mut self, light: &CameraPathLight, _kept: &()) {
        self.radiance.write(self.pixel, light.radiance);
    }
}

/// Requests a path through a pixel that finds all light.
#[inline(always)]
pub fn request(pixel: u32) -> CameraPathRequest {
    CameraPathRequest { pixel, stream: Stream::Reference, number: 0, suffix: CameraSuffix::ALL }
}
