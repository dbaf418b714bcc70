//! `collect`: traces a camera path through each pixel. Its prefix of specular events ends at the collection point. The path also
//! gathers all light that is no caustic.

use crate::declare::pass;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::point::{IndirectSample, PointDirect, PointGeometry, PointShading};
use crate::interface::radiance_cache::{CacheCell, CacheKey, CacheSample};
use crate::interface::scene::SceneTables;
use crate::math::rng::Stream;
use crate::path::camera_pass::{CameraPass, CameraPathRequest, run_camera_pass};
use crate::path::camera_path::{CameraPathLight, CameraSuffix};
use crate::path::observer::{CollectionPoint, PathObserver};
use crate::path::radiance_cache::{cell_mask, find};
use crate::platform::{Atomics, Slots};
use crate::trace::Tracer;
use spirv_std::glam::Vec3;

/// Pixels in Morton order: neighbouring invocations and boxes stay close in the image.
#[cfg(not(target_arch = "spirv"))]
pub fn pixel_order(width: u32, height: u32) -> Vec<u32> {
    let spread = |x: u32| (0..16).fold(0u32, |code, bit| code | (x >> bit & 1) << (2 * bit));
    let mut order: Vec<u32> = (0..width * height).collect();
    order.sort_by_cached_key(|&pixel| spread(pixel % width) | spread(pixel / width) << 1);
    order
}

/// Traces camera paths, one pixel an invocation.
#[pass(name = "collect", over = params.pixel_count(), work = Camera, shared_entry)]
pub fn collect(
    index: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    counters: &mut impl Atomics,
    #[len = params.pixel_count()] pixel_order: &[u32],
    path_radiance: Slots<'_, Vec3>,
    prefix_radiance: Slots<'_, Vec3>,
    delta_prefix_radiance: Slots<'_, Vec3>,
    point_direct: Slots<'_, PointDirect>,
    point_geometry: Slots<'_, PointGeometry>,
    point_shading: Slots<'_, PointShading>,
    point_indirect: Slots<'_, IndirectSample>,
    cache_cells: &[CacheCell],
    cache_samples: Slots<'_, CacheSample>,
) {
    let collect = Collect {
        pixel: pixel_order[index as usize],
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
    };
    run_camera_pass(collect, params, features, scene, tracer, counters);
}

/// The camera pass `collect`: light that is no caustic, and a collection point. The point is stored where it is found, since the
/// path behind it does not need it.
pub struct Collect<'a> {
    /// The pixel.
    pub pixel: u32,
    /// Settings.
    pub params: &'a FrameParams,
    /// Code that is compiled in.
    pub features: Features,
    /// `path_radiance`, by pixel, as the buffers below.
    pub radiance: Slots<'a, Vec3>,
    /// `prefix_radiance`.
    pub prefix: Slots<'a, Vec3>,
    /// `delta_prefix_radiance`.
    pub delta_prefix: Slots<'a, Vec3>,
    /// `point_direct`.
    pub direct: Slots<'a, PointDirect>,
    /// `point_geometry`.
    pub geometry: Slots<'a, PointGeometry>,
    /// `point_shading`.
    pub shading: Slots<'a, PointShading>,
    /// `point_indirect`.
    pub indirect: Slots<'a, IndirectSample>,
    /// `cache_cells`.
    pub cells: &'a [CacheCell],
    /// `cache_samples`.
    pub cached: Slots<'a, CacheSample>,
}

impl PathObserver for Collect<'_> {
    type Kept = ();

    #[inline(always)]
    fn cached(&self, key: &CacheKey) -> CacheCell {
        let cell = self.cells[find(key, self.cells, cell_mask(self.params)) as usize];
        if cell.key == *key { cell } else { CacheCell::default() }
    }
    #[inline(always)]
    fn collect(&mut self, _kept: &mut (), point: &CollectionPoint) {
        self.geometry.write(self.pixel, point.geometry);
        self.shading.write(self.pixel, point.shading);
    }
    #[inline(always)]
    fn end(&mut self, kept: &mut (), last: Vec3) {
        self.collect(kept, &CollectionPoint::none(last));
    }
}

impl CameraPass for Collect<'_> {
    #[inline(always)]
    fn request(&self) -> CameraPathRequest {
        CameraPathRequest {
            pixel: self.pixel,
            stream: Stream::Camera,
            number: 0,
            suffix: CameraSuffix::new(self.params),
        }
    }
    #[inline(always)]
    fn store(&mut self, light: &CameraPathLight, _kept: &()) {
        self.radiance.write(self.pixel, light.radiance);
        if self.features.has(Features::PARTS) {
            self.prefix.write(self.pixel, light.prefix);
            self.delta_prefix.write(self.pixel, light.delta_prefix);
            self.direct.write(self.pixel, light.direct);
        }
        if self.features.has(Features::INDIRECT) {
            self.indirect.write(self.pixel, light.indirect);
        }
        if self.features.has(Features::INDIRECT) && self.params.uses_cache() {
            self.cached.write(self.pixel, light.cached);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixel_order_is_a_permutation_by_tiles() {
        let order = pixel_order(17, 9);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..17 * 9).collect::<Vec<_>>());
        // The first 64 are the first tile of 8 by 8.
        assert!(order[..64].iter().all(|pixel| pixel % 17 < 8 && pixel / 17 < 8));
    }
}
