//! `auxiliary`: layers for other tools, on request. The pass walks the camera prefixes of `collect` again, with the same numbers
//! to the same points, and samples no light on the way. Methods without points have the layers too, and a run without them pays
//! nothing. The pass counts no rays, so counters and rates remain those of the frame.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::history::reprojected::ReprojectedPoint;
use crate::history::window::{project, seen_from};
use crate::interface::auxiliary::Auxiliary;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::instance::Instance;
use crate::interface::material::Material;
use crate::interface::scene::SceneTables;
use crate::math::rng::Stream;
use crate::path::camera_pass::{CameraPass, CameraPathRequest, run_camera_pass};
use crate::path::camera_path::{CameraPathLight, CameraSuffix};
use crate::path::observer::{CollectionPoint, PathObserver};
use crate::path::radiance_cache::cube_around;
use crate::platform::{Slots, Uncounted};
use crate::surface::textured::material_of;
use crate::trace::Tracer;
use spirv_std::glam::{Vec2, Vec3};

/// Stage that writes layers for other tools.
#[cfg(not(target_arch = "spirv"))]
pub const AUXILIARY_LAYERS: FrameStage = FrameStage {
    at_end: |params| vec![Step::new(&AUXILIARY, params)],
    ..FrameStage::new("auxiliary layers")
};

/// Traces prefixes of camera paths, a pixel an invocation.
#[pass(name = "auxiliary", over = params.pixel_count(), work = Auxiliary, shared_entry)]
pub fn auxiliary(
    index: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    instances: &[Instance],
    #[len = params.pixel_count()] pixel_order: &[u32],
    auxiliary: Slots<'_, Auxiliary>,
) {
    let pixel = pixel_order[index as usize];
    let shown = Shown { pixel, params, features, materials: scene.materials, instances, records: auxiliary };
    run_camera_pass(shown, params, features, scene, tracer, &mut Uncounted);
}

/// Camera pass `auxiliary`, which stores its record where it finds the point.
pub struct Shown<'a> {
    /// The pixel.
    pub pixel: u32,
    /// Settings.
    pub params: &'a FrameParams,
    /// Features that are compiled in.
    pub features: Features,
    /// Materials.
    pub materials: &'a [Material],
    /// Instances.
    pub instances: &'a [Instance],
    /// `auxiliary`, by pixel.
    pub records: Slots<'a, Auxiliary>,
}

impl PathObserver for Shown<'_> {
    type Kept = ();

    #[inline(always)]
    fn collect(&mut self, _kept: &mut (), point: &CollectionPoint) {
        let CollectionPoint { geometry, shading, length } = point;
        let record = Auxiliary {
            position: geometry.position,
            depth: *length,
            normal: shading.shading_normal,
            material: self.materials[shading.material as usize].medium,
            albedo: material_of(shading, self.materials, self.features).base_color,
            cell: cube_around(
                geometry.position,
                geometry.normal,
                shading.material,
                geometry.depth,
                self.params,
            )
            .number(),
            motion: motion(self.pixel, point, self.instances, self.params),
            ..Auxiliary::default()
        };
        self.records.write(self.pixel, record);
    }
    #[inline(always)]
    fn end(&mut self, _kept: &mut (), _last: Vec3) {
        self.records.write(self.pixel, Auxiliary::default());
    }
}

impl CameraPass for Shown<'_> {
    /// Adds the virtual images in mirrors and lenses, which give the motion of points.
    #[inline(always)]
    fn features(&self, features: Features) -> Features {
        features | Features::HISTORY
    }
    #[inline(always)]
    fn request(&self) -> CameraPathRequest {
        CameraPathRequest {
            pixel: self.pixel,
            stream: Stream::Camera,
            number: 0,
            suffix: CameraSuffix::NOTHING,
        }
    }
    #[inline(always)]
    fn store(&mut self, _light: &CameraPathLight, _kept: &()) {}
}

/// Motion of a point in the image since the last frame (px). Behind mirrors and glass only the motion of the eye counts: the
/// virtual image is taken to stand still. A surface that deforms is also taken to stand still.
#[inline(always)]
fn motion(pixel: u32, seen: &CollectionPoint, instances: &[Instance], params: &FrameParams) -> Vec2 {
    let (point, shading) = (&seen.geometry, &seen.shading);
    let mut position = point.position;
    // A surface that deforms is taken to stand still.
    if shading.instance != 0 && !instances[shading.instance as usize].to_previous.is_nowhere() {
        position = ReprojectedPoint::new(point, shading, instances).position;
    }
    let (eye, eye_before) = (&params.camera, &params.previous_camera);
    let now = seen_from(eye, pixel, point, shading, point.position, params);
    let before = seen_from(eye_before, pixel, point, shading, position, params);
    project(now, eye, params) - project(before, eye_before, params)
}
