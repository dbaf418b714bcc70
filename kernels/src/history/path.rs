//! `path.*`: a history of path-traced light at collection points, beside the history of their caustics.
//!
//! The history keeps the light of camera paths that the non-specular class of a point reflects, over the path's throughput and
//! the point's reflectance. Direct light is kept apart from the rest, as the probability of the class is in the throughput of the
//! rest alone. Light that a path saw before its point, or that a specular class reflects there, is always of this frame.
//!
//! Kept light is found where the previous camera saw the point, at the nearest point there of the same surface. In a still view
//! it is found in the pixel itself. A mean over neighbours would blur more with every frame. The mean position of a point's light
//! bounds the light's distance from the point.
//!
//! Paths that are traced again show whether kept light still holds: one path of the previous frame for every 5 by 5 pixels. It is
//! traced in the present scene, with the same camera and random numbers. Where nothing changed it finds the same light, to
//! rounding. A difference limits the number of frames that kept light may count. In a still view nothing is traced again, and all
//! frames count alike.
//!
//! The denoiser needs to know how noisy the blended light is. From four frames on, their variance shows it. With fewer (at the start, on
//! moving meshes, around a moving shadow), the changes between frames do. They underestimate the noise of rare bright light.
//!
//! Cost: a twenty-fifth of `collect` where something moved; 80 bytes a pixel of state. Limitations: a pixel keeps one point's
//! light. Where a path may pass a surface or be reflected by it, this is the light of the last choice, else of the nearest
//! pixel. Light beside a change is as noisy as without a history.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::history::demodulate::{MIN_REFLECTANCE, demodulated, head_on};
use crate::history::nearest::{Nearest, max_samples_by_view};
use crate::history::reprojected::ReprojectedPoint;
use crate::history::significance::significant_change;
use crate::history::window::{PreviousFrame, project, seen_from};
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::{
    HistoryPoint, PathHistoryLight, PathHistoryNoise, ReprojectedPathLight, Retraced,
};
use crate::interface::instance::Instance;
use crate::interface::material::Material;
use crate::interface::point::{PointDirect, PointGeometry, PointShading};
use crate::interface::scene::SceneTables;
use crate::math::rng::Stream;
use crate::math::{clamp, is_finite, octahedral};
use crate::path::camera_pass::{CameraPass, CameraPathRequest, run_camera_pass};
use crate::path::camera_path::{CameraPathLight, CameraSuffix};
use crate::path::observer::{CollectionPoint, PathObserver};
use crate::platform::{Slots, Uncounted};
use crate::surface::dispersion::is_mixed;
use crate::trace::Tracer;
use spirv_std::glam::{Vec2, Vec3};

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Stage of the path history: light that outlives its frame, and paths traced again to validate it.
#[cfg(not(target_arch = "spirv"))]
pub const PATH_HISTORY: FrameStage = FrameStage {
    look_back: |params| vec![Step::new(&PATH_RETRACE, params)],
    after_collect: |params| {
        let judge = (params.moved != 0).then(|| Step::new(&PATH_JUDGE, params));
        judge.into_iter().chain([Step::new(&PATH_REPROJECT, params)]).collect()
    },
    before_denoise: |params| vec![Step::new(&PATH_BLEND, params)],
    keeps: &["path_points", "path_light", "path_noise_kept", "path_brightness"],
    features: Features::PARTS,
    ..FrameStage::new("path history")
};

/// Side of a block (px); one pixel of each block is traced again.
pub const BLOCK: u32 = 5;
/// Step from frame to frame of the pixel that is traced again: prime to the number of pixels of a block.
const STRIDE: u32 = 7;
/// Maximum number of frames that kept light counts where something moves.
pub const MAX_FRAMES: f32 = 32.0;
/// Maximum number of frames in a still view; whole numbers stay exact.
const MAX_STILL_FRAMES: f32 = 4_194_304.0;
/// Maximum number of frames of light that a mesh carries along.
const MAX_CARRIED_FRAMES: f32 = 1.0;
/// Maximum distance at which the light of a point is reused, seen head on (radii).
const SEARCH_RADIUS: f32 = 1.3;
/// Minimum cosine that this distance is projected with.
const MIN_SLANT_COS: f32 = 0.05;
/// Minimum number of frames from which the variance of light is estimated.
const MIN_KNOWN_FRAMES: f32 = 4.0;
/// Weight of the last change in the noise of light that changes.
const NEW_NOISE: f32 = 0.25;
/// Maximum relative difference between two compilations of one computation.
const ROUNDING: f32 = 1.0e-3;

/// Number of blocks along a row of the image.
#[inline(always)]
fn blocks_per_row(params: &FrameParams) -> u32 {
    params.width.div_ceil(BLOCK)
}

/// Number of blocks of the image.
#[inline(always)]
pub fn block_count(params: &FrameParams) -> u32 {
    blocks_per_row(params) * params.height.div_ceil(BLOCK)
}

/// Traces one path of each block again.
#[pass(name = "path.retrace", over = block_count(params), work = Reuse, shared_entry)]
pub fn path_retrace(
    block: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    #[len = params.pixel_count()] path_points: &[HistoryPoint],
    #[len = params.pixel_count()] path_brightness: &[Vec2],
    path_retraced: Slots<'_, Retraced>,
) {
    let retrace = Retrace {
        block,
        pixel: pixel_of(block, path_points, params),
        params,
        features,
        materials: scene.materials,
        points: path_points,
        brightness: path_brightness,
        retraced: path_retraced,
    };
    run_camera_pass(retrace, params, features, scene, tracer, &mut Uncounted);
}

/// Pixel of a block whose turn it is; `NONE` if it has no kept light.
#[inline(always)]
pub fn pixel_of(block: u32, path_points: &[HistoryPoint], params: &FrameParams) -> u32 {
    let turn = params.frame % (BLOCK * BLOCK) * STRIDE % (BLOCK * BLOCK);
    let column = block % blocks_per_row(params) * BLOCK + turn % BLOCK;
    let row = block / blocks_per_row(params) * BLOCK + turn / BLOCK;
    let pixel = row * params.width + column;
    if column < params.width && row < params.height && path_points[pixel as usize].samples > 0.0 {
        pixel
    } else {
        NONE
    }
}

/// Camera pass `path.retrace`: finds the light of a pixel's previous path in the present scene.
pub struct Retrace<'a> {
    /// The block.
    pub block: u32,
    /// Pixel; `NONE`: there is nothing to compare with.
    pub pixel: u32,
    /// Settings.
    pub params: &'a FrameParams,
    /// Features that are compiled in.
    pub features: Features,
    /// Materials.
    pub materials: &'a [Material],
    /// `path_points`.
    pub points: &'a [HistoryPoint],
    /// `path_brightness`.
    pub brightness: &'a [Vec2],
    /// `path_retraced`, by block.
    pub retraced: Slots<'a, Retraced>,
}

impl PathObserver for Retrace<'_> {
    type Kept = CollectionPoint;

    #[inline(always)]
    fn collect(&mut self, kept: &mut CollectionPoint, point: &CollectionPoint) {
        *kept = *point;
    }
    #[inline(always)]
    fn end(&mut self, _kept: &mut CollectionPoint, _last: Vec3) {}
}

impl CameraPass for Retrace<'_> {
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
    fn store(&mut self, light: &CameraPathLight, point: &CollectionPoint) {
        let mut retraced = Retraced::default();
        // Skip another surface, which the history would not find either.
        if point.geometry.exists() && point.shading.material == self.points[self.pixel as usize].material {
            let (radiance, direct) = (light.radiance - light.prefix, &light.direct);
            let found =
                arriving(radiance, direct, &point.shading, self.materials, self.params, self.features);
            let now = brightness(&found, direct.class_probability);
            retraced = Retraced { before: self.brightness[self.pixel as usize], now };
        }
        self.retraced.write(self.block, retraced);
    }
}

/// Computes the maximum number of frames that kept light may count in each block.
#[pass(name = "path.judge", over = block_count(params), work = Reuse)]
pub fn path_judge(
    block: u32,
    params: &FrameParams,
    #[len = block_count(params)] path_retraced: &[Retraced],
    mut path_max_frames: Slots<'_, Vec2>,
) {
    let mut frames = Vec2::splat(MAX_FRAMES);
    let mut window = 0;
    while window < 3 {
        let side = [1, 3, 7][window as usize];
        let changes = Changes::around(block, side, params, path_retraced);
        frames = frames.min(changes.max_frames());
        window += 1;
    }
    path_max_frames.write(block, frames);
}

/// Changes of direct and of indirect light that paths traced again found around a position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Changes {
    /// Sum of the light in the previous frame.
    before: Vec2,
    /// Sum of the light now.
    now: Vec2,
    /// Sum of the greater of both.
    greater: Vec2,
    /// Sum of absolute differences.
    differences: Vec2,
    /// Sum of squared differences.
    squares: Vec2,
}

/// Maximum share of a position's light that is late. It is below the promised 0.01, as few paths see less of a fade than there
/// is.
const MAX_LATE: f32 = 0.007;
/// Maximum late share of the light of single paths. One path gains what another loses, for example at the moving edge of a
/// shadow.
const MAX_PATHS_LATE: f32 = 0.05;
/// Share of changed light above which nothing is reused.
const MAX_CHANGED: f32 = 0.25;

impl Changes {
    /// Sums the changes of the blocks up to `side` away.
    #[inline(always)]
    fn around(block: u32, side: u32, params: &FrameParams, retraced: &[Retraced]) -> Changes {
        let (width, height) = (blocks_per_row(params), params.height.div_ceil(BLOCK));
        let (column, row) = (block % width, block / width);
        let mut sum = Changes::default();
        let mut y = row.max(side) - side;
        while y <= (row + side).min(height - 1) {
            let mut x = column.max(side) - side;
            while x <= (column + side).min(width - 1) {
                sum.add(&retraced[(y * width + x) as usize]);
                x += 1;
            }
            y += 1;
        }
        sum
    }

    #[inline(always)]
    fn add(&mut self, path: &Retraced) {
        let greater = path.before.max(path.now);
        // Ignore what rounding may change.
        let difference = ((path.now - path.before).abs() - greater * ROUNDING).max(Vec2::ZERO);
        self.before += path.before;
        self.now += path.now;
        self.greater += greater;
        self.differences += difference;
        self.squares += difference * difference;
    }

    /// Maximum number of frames of direct and of indirect light.
    #[inline(always)]
    fn max_frames(&self) -> Vec2 {
        Vec2::new(
            max_frames_of_kind(self.before.x, self.now.x, self.greater.x, self.differences.x, self.squares.x),
            max_frames_of_kind(self.before.y, self.now.y, self.greater.y, self.differences.y, self.squares.y),
        )
    }
}

/// Maximum number of frames of light for which a bounded part of its brightness is late: n frames' worth are n frames late.
#[inline(always)]
fn max_frames_of_kind(before: f32, now: f32, greater: f32, differences: f32, squares: f32) -> f32 {
    if differences <= 0.0 {
        return MAX_FRAMES;
    }
    let frames = max_frames(significant_change(now - before, squares) / before.max(now), MAX_LATE);
    frames.min(max_frames(differences / greater, MAX_PATHS_LATE))
}

/// Maximum number of frames for which a share `late` of light is late, if a share `changed` of it changes in a frame.
#[inline(always)]
fn max_frames(changed: f32, late: f32) -> f32 {
    if changed <= 0.0 {
        return MAX_FRAMES;
    }
    clamp(late * (1.0 / changed - 1.0 / MAX_CHANGED), 0.0, MAX_FRAMES)
}

/// Reprojects light of the previous frame to each pixel.
#[pass(name = "path.reproject", over = params.pixel_count(), work = Reuse)]
pub fn path_reproject(
    pixel: u32,
    params: &FrameParams,
    features: Features,
    path_radiance: &[Vec3],
    prefix_radiance: &[Vec3],
    point_direct: &[PointDirect],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    materials: &[Material],
    instances: &[Instance],
    path_points: &[HistoryPoint],
    path_light: &[PathHistoryLight],
    path_noise_kept: &[PathHistoryNoise],
    #[len = block_count(params)] path_max_frames: &[Vec2],
    mut path_brightness: Slots<'_, Vec2>,
    mut path_reprojected: Slots<'_, ReprojectedPathLight>,
) {
    let i = pixel as usize;
    let (point, shading, direct) = (&point_geometry[i], &point_shading[i], &point_direct[i]);
    let mut found = PathHistoryLight::default();
    let mut reprojected =
        ReprojectedPathLight { noise: PathHistoryNoise::NONE, ..ReprojectedPathLight::default() };
    if point.exists() {
        let light = path_radiance[i] - prefix_radiance[i];
        found = arriving(light, direct, shading, materials, params, features);
    }
    if found.exists() {
        let history = PreviousFrame { points: path_points, light: path_light };
        let history_sample = find_history_sample(
            pixel,
            point,
            shading,
            materials,
            instances,
            history,
            path_max_frames,
            params,
            features,
        );
        if history_sample.pixel != NONE {
            let light = path_light[history_sample.pixel as usize];
            reprojected = ReprojectedPathLight {
                light: PathHistoryLight {
                    direct_samples: light.direct_samples.min(history_sample.frames.x),
                    indirect_samples: light.indirect_samples.min(history_sample.frames.y),
                    ..light
                },
                offset: history_sample.offset,
                noise: path_noise_kept[history_sample.pixel as usize],
            };
        }
    }
    path_brightness.write(pixel, brightness(&found, direct.class_probability));
    path_reprojected.write(pixel, reprojected);
}

/// History point whose light is reused.
#[derive(Clone, Copy)]
struct HistorySample {
    /// Pixel of the history point; `NONE`: there is none.
    pixel: u32,
    /// Number of frames that its direct and its indirect light may count.
    frames: Vec2,
    /// Offset from the reprojected point to the mean position of that light (m).
    offset: Vec3,
}

/// Finds the point of the previous frame whose light the point of a pixel reuses.
///
/// A point on a mesh that moved is first looked for at its present position. Light there stays in the world while surfaces move
/// below it, and paths traced again compare that light. They do not find light that a mesh carries along, so that light counts
/// one frame.
#[inline(always)]
fn find_history_sample(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    materials: &[Material],
    instances: &[Instance],
    history: PreviousFrame<'_, PathHistoryLight>,
    path_max_frames: &[Vec2],
    params: &FrameParams,
    features: Features,
) -> HistorySample {
    // Neighbouring pixels see a slanted surface further apart than a disc is wide.
    let cos = shading.to_viewer.dot(point.normal).abs().max(MIN_SLANT_COS);
    let search_radius = SEARCH_RADIUS / cos.sqrt();
    let mut reprojected_point = ReprojectedPoint::unmoved(point, shading);
    let mut nearest = Nearest::new(reprojected_point, search_radius);
    let mut frames = Vec2::splat(MAX_STILL_FRAMES);
    if params.moved == 0 {
        // Rays over the whole pixel hit further apart: prefer the pixel's own point.
        nearest.prefer(pixel, history);
        if !nearest.found {
            nearest.search(centre(pixel, params), point.depth, params, history);
        }
    } else {
        let before = &params.previous_camera;
        let at = project(
            seen_from(before, pixel, point, shading, reprojected_point.position, params),
            before,
            params,
        );
        nearest.search(at, point.depth, params, history);
        frames = max_frames_at(at, path_max_frames, params);
        if !nearest.found && shading.instance != 0 {
            reprojected_point = ReprojectedPoint::new(point, shading, instances);
            nearest = Nearest::new(reprojected_point, search_radius);
            let seen = seen_from(before, pixel, point, shading, reprojected_point.position, params);
            let at = project(seen, before, params);
            nearest.search(at, point.depth, params, history);
            frames = max_frames_at(at, path_max_frames, params).min(Vec2::splat(MAX_CARRIED_FRAMES));
        }
    }
    if !nearest.found {
        return HistorySample { pixel: NONE, frames: Vec2::ZERO, offset: Vec3::ZERO };
    }
    let point = history.points[nearest.pixel as usize];
    let by_view = max_samples_by_view(&point, shading, materials, instances, params, features);
    HistorySample {
        pixel: nearest.pixel,
        frames: frames.min(Vec2::splat(by_view)),
        offset: point.position - reprojected_point.position,
    }
}

/// Maximum number of frames of light at a position in the previous frame (px).
#[inline(always)]
fn max_frames_at(at: Vec2, path_max_frames: &[Vec2], params: &FrameParams) -> Vec2 {
    let column = clamp(at.x, 0.0, params.width as f32 - 1.0) as u32;
    let row = clamp(at.y, 0.0, params.height as f32 - 1.0) as u32;
    path_max_frames[(row / BLOCK * blocks_per_row(params) + column / BLOCK) as usize]
}

/// Centre of a pixel (px).
#[inline(always)]
fn centre(pixel: u32, params: &FrameParams) -> Vec2 {
    Vec2::new((pixel % params.width) as f32 + 0.5, (pixel / params.width) as f32 + 0.5)
}

/// Blends light of this frame with reused light, to show and to keep: each kind by (n old + new) / (n + 1).
#[pass(name = "path.blend", over = params.pixel_count(), work = Reuse)]
pub fn path_blend(
    pixel: u32,
    params: &FrameParams,
    features: Features,
    prefix_radiance: &[Vec3],
    point_direct: &[PointDirect],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    materials: &[Material],
    path_reprojected: &[ReprojectedPathLight],
    mut path_radiance: Slots<'_, Vec3>,
    mut path_points: Slots<'_, HistoryPoint>,
    mut path_light: Slots<'_, PathHistoryLight>,
    mut path_noise_kept: Slots<'_, PathHistoryNoise>,
    mut path_noise: Slots<'_, f32>,
) {
    let i = pixel as usize;
    let (point, shading, direct) = (&point_geometry[i], &point_shading[i], &point_direct[i]);
    let (mut kept, mut light) = (HistoryPoint::default(), PathHistoryLight::default());
    // Noise of the blended mean: one plus its relative variance; 0 where it is unknown
    let (mut kept_noise, mut noise) = (PathHistoryNoise::NONE, 0.0);
    if point.exists() {
        let found = path_radiance.read(pixel) - prefix_radiance[i];
        light = arriving(found, direct, shading, materials, params, features);
    }
    if light.exists() {
        let found = brightness(&light, direct.class_probability).element_sum();
        let mut square = found * found;
        let ReprojectedPathLight { light: reprojected, offset, noise: before } = path_reprojected[i];
        let shares =
            Vec2::new(1.0 / (reprojected.direct_samples + 1.0), 1.0 / (reprojected.indirect_samples + 1.0));
        if reprojected.exists() {
            light = PathHistoryLight {
                direct: reprojected.direct + (light.direct - reprojected.direct) * shares.x,
                direct_samples: reprojected.direct_samples + 1.0,
                indirect: reprojected.indirect + (light.indirect - reprojected.indirect) * shares.y,
                indirect_samples: reprojected.indirect_samples + 1.0,
            };
            square = before.square + (square - before.square) * shares.max_element();
            let reflected = shading.throughput * head_on(shading, materials, params, features);
            let shown = reflected * (light.direct * direct.class_probability + light.indirect);
            path_radiance.write(pixel, prefix_radiance[i] + shown);
        }
        // Estimate the noise from the mean, or from the change where the mean has too few frames
        let frames = light.direct_samples.min(light.indirect_samples);
        let mean_of = |light| brightness(light, direct.class_probability).element_sum();
        let relative_square = if frames >= MIN_KNOWN_FRAMES {
            noise_of_mean(mean_of(&light), square, frames)
        } else {
            noise_of_change(&before, mean_of(&reprojected), found)
        };
        kept_noise = PathHistoryNoise { square, relative_square };
        if relative_square > 0.0 {
            noise = 1.0 + (relative_square - 1.0) / frames;
        }
        kept = HistoryPoint {
            position: point.position + offset * (1.0 - shares.x),
            radius: point.radius,
            normal: octahedral::encode(point.normal),
            to_viewer: octahedral::encode(shading.to_viewer),
            material: shading.material,
            samples: light.direct_samples,
        };
    }
    path_points.write(pixel, kept);
    path_light.write(pixel, light);
    path_noise_kept.write(pixel, kept_noise);
    path_noise.write(pixel, noise);
}

/// Estimates `relative_square` of `PathHistoryNoise` from the mean and the mean square of some frames.
#[inline(always)]
fn noise_of_mean(mean: f32, square: f32, frames: f32) -> f32 {
    // A black mean has been black in all frames. Where frames have unequal weights, bound the ratio by that of one lit frame.
    let mean_square = mean * mean;
    let of_frames = if mean_square > 0.0 { (square / mean_square - 1.0).max(0.0).min(frames) } else { 0.0 };
    1.0 + of_frames * frames / (frames - 1.0)
}

/// Estimates it where light changes in every frame, from the noise known before and the change of brightness since; 0 without light
/// of earlier frames. The change is relative to the larger brightness: the edge of a shadow that passes counts as one at most.
#[inline(always)]
fn noise_of_change(before: &PathHistoryNoise, brightness_before: f32, brightness: f32) -> f32 {
    if !before.exists() {
        return 0.0;
    }
    let larger = brightness_before.max(brightness);
    let change = if larger > 0.0 { (brightness - brightness_before) / larger } else { 0.0 };
    let found = 1.0 + change * change;
    if before.relative_square > 0.0 {
        before.relative_square + (found - before.relative_square) * NEW_NOISE
    } else {
        found
    }
}

/// Light that arrives at a point, by the light that its non-specular class sends to the eye; none if it cannot be separated.
#[inline(always)]
fn arriving(
    light: Vec3,
    direct: &PointDirect,
    shading: &PointShading,
    materials: &[Material],
    params: &FrameParams,
    features: Features,
) -> PathHistoryLight {
    let reflected = shading.throughput * head_on(shading, materials, params, features);
    // With dispersion a pixel has another channel in every frame, which tells nothing about the others.
    let parted = features.has(Features::DISPERSION) && !is_mixed(shading.throughput);
    let known = (reflected * direct.class_probability.min(1.0)).max_element();
    if !is_finite(light.element_sum())
        || !is_finite(reflected.element_sum())
        || known < MIN_REFLECTANCE
        || parted
    {
        return PathHistoryLight::default();
    }
    // Count what is left of a bounded sample as direct light first.
    let from_lights = direct.radiance.min(light);
    PathHistoryLight {
        direct: demodulated(from_lights, reflected * direct.class_probability),
        direct_samples: 1.0,
        indirect: demodulated(light - from_lights, reflected),
        indirect_samples: 1.0,
    }
}

/// Brightness of direct and of indirect light, summed over channels. It contains the class probability, but neither the
/// reflectance of the point nor the throughput of the path to it.
#[inline(always)]
fn brightness(light: &PathHistoryLight, class_probability: f32) -> Vec2 {
    Vec2::new(light.direct.element_sum() * class_probability, light.indirect.element_sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Changes of 49 paths: `count` of them went from `before` to `now`, the others rest at `before`.
    fn changes(count: u32, before: f32, now: f32) -> Changes {
        let mut changes = Changes::default();
        for path in 0..49 {
            let now = if path < count { now } else { before };
            changes.add(&Retraced { before: Vec2::new(before, 1.0), now: Vec2::new(now, 1.0) });
        }
        changes
    }

    #[test]
    fn resting_and_rounded_light_counts_the_maximum_of_frames() {
        assert_eq!(Changes::default().max_frames(), Vec2::splat(MAX_FRAMES));
        assert_eq!(changes(0, 2.0, 2.0).max_frames(), Vec2::splat(MAX_FRAMES));
        assert_eq!(changes(49, 2.0, 2.001).max_frames(), Vec2::splat(MAX_FRAMES));
    }

    #[test]
    fn changing_light_is_late_by_a_bounded_part_of_its_brightness() {
        for change in [0.01, 0.02, 0.05, 0.1, 0.2] {
            for now in [1.0 - change, 1.0 / (1.0 - change)] {
                let frames = changes(49, 1.0, now).max_frames();
                // Noise takes 1.44 / 49 of the change of 49 paths that change alike.
                assert!(frames.x * change <= MAX_LATE / (1.0 - 1.44 / 49.0), "{change}: {frames}");
                assert_eq!(frames.y, MAX_FRAMES, "the other kind rests");
            }
        }
        for change in [0.3, 0.5, 1.0] {
            assert_eq!(changes(49, 1.0, 1.0 - change).max_frames().x, 0.0);
            assert_eq!(changes(49, 1.0 - change, 1.0).max_frames().x, 0.0);
        }
    }

    #[test]
    fn noise_of_changing_light_is_known_from_its_second_frame_on() {
        let none = PathHistoryNoise::NONE;
        assert_eq!(noise_of_change(&none, 0.0, 1.0), 0.0, "a first frame shows none");
        let dark = PathHistoryNoise { square: 0.0, relative_square: 0.0 };
        assert_eq!(noise_of_change(&dark, 0.0, 0.0), 1.0, "black light has no noise");
        for (mean, square) in [(1.0e-23, 1.0), (1.0e-10, 1.0), (1.0, 1.0e9)] {
            assert!((1.0..40.0).contains(&noise_of_mean(mean, square, 32.0)), "{mean}, {square}");
        }
        // The edge of a shadow passes, and the light rests behind it.
        let mut noise = PathHistoryNoise { square: 1.0, relative_square: 1.0 };
        noise.relative_square = noise_of_change(&noise, 0.0, 5.0);
        assert_eq!(noise.relative_square, 1.0 + NEW_NOISE);
        for _ in 0..10 {
            noise.relative_square = noise_of_change(&noise, 5.0, 5.0);
        }
        assert!((1.0..1.02).contains(&noise.relative_square), "{noise:?}");
    }

    #[test]
    fn a_single_changed_path_shortens_but_does_not_end_reuse() {
        let frames = changes(1, 1.0, 0.0).max_frames().x;
        assert!(1.0 < frames && frames < 4.0, "{frames}");
        assert_eq!(changes(20, 1.0, 0.0).max_frames().x, 0.0);
    }
}
