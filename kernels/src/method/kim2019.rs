//! `splat.kim2019`: adds each photon to the one pixel that it projects to, if that pixel sees the photon's position.
//!
//! Source: [Kim 2019, Caustics using screen-space photon mapping, Ray Tracing Gems, ch. 30]. Beyond the published test of depths,
//! a pixel at a slant takes the depth of its plane, where its neighbours see that plane too.
//!
//! Cost: a projection a photon, whatever the number of pixels.
//!
//! Limitations: receivers are primary surfaces only, so caustics in mirrors, through glass and off glossy surfaces are missing. A
//! pixel is a sharp box, so few light paths show as grains. Light leaks between surfaces whose distances from the eye agree
//! within 1 %.

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Step;
use crate::declare::pass;
use crate::gather::accumulator::{self, GatheredSum};
use crate::gather::contribution::contribution;
use crate::gather::score::{self, score};
#[cfg(not(target_arch = "spirv"))]
use crate::gather::variant::Over;
#[cfg(not(target_arch = "spirv"))]
use crate::interface::choice::TextureFilter;
use crate::interface::features::Features;
use crate::interface::frame::{Camera, Dispatch, FrameParams, Window};
use crate::interface::material::Material;
use crate::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use crate::math::PI;
#[cfg(not(target_arch = "spirv"))]
use crate::method::frame;
#[cfg(not(target_arch = "spirv"))]
use crate::method::{Method, Parts};
use crate::platform::{AtomicWords, Atomics};
use crate::surface::textured::material_of;
use spirv_std::glam::{Vec2, Vec3};

/// Largest difference between the distances of a photon and of the surface that its pixel sees, relative to the photon's.
const DISTANCE_TOLERANCE: f32 = 0.01;
/// Smallest cosine that a pixel is projected with.
const MIN_COS: f32 = 0.01;

/// Kind of area of a pixel: its footprint on the tangent plane of the photon.
pub const AREA_FOOTPRINT: u32 = 0;
/// Kind of area of a pixel: Kim's, on a sphere about the eye through the photon, (d f_w / (f W)) (d f_h / (f H)).
pub const AREA_FACING: u32 = 1;

#[cfg(not(target_arch = "spirv"))]
/// Kim 2019 with the area of a pixel's footprint on the surface, which conserves energy.
pub const KIM2019: Method = Method {
    name: "kim2019",
    description: "Kim 2019: photons splatted to the pixels that see them directly",
    cost: "a projection a photon: no index, no search",
    limitations: "caustics appear on primary surfaces only, never in a mirror; grain with few light paths",
    gathers: true,
    supports_history: false,
    chooses_gather: false,
    chooses_emission: true,
    converges: false,
    texture_filter: TextureFilter::Cone,
    shares_indirect: false,
    uses_cache: false,
    passes_thin_walls: false,
    keeps: &[],
    frame: |params, index| FrameParams { frame: index, ..params },
    steps: |parts, params| steps(parts, params, AREA_FOOTPRINT),
};

#[cfg(not(target_arch = "spirv"))]
/// Kim 2019 with the published area of a pixel, which faces the eye. It is too bright by 1 / cos where the surface does not face
/// the eye.
pub const KIM2019_FACING: Method = Method {
    name: "kim2019-facing",
    description: "Kim 2019 with his area of a pixel, which ignores the slant of the surface",
    steps: |parts, params| steps(parts, params, AREA_FACING),
    ..KIM2019
};

#[cfg(not(target_arch = "spirv"))]
fn steps(parts: Parts, params: &FrameParams, area: u32) -> Vec<Step> {
    frame::frame_steps(parts, params, Vec::new(), |batch| {
        let mut steps = frame::shoot(parts.emission, batch);
        let photons = frame::over(Over::Photons, params);
        steps.push(Step::dispatch(&SPLAT_KIM2019, Dispatch { level: area, ..photons }));
        steps
    })
}

/// Adds each photon to its pixel; the dispatch's level chooses the pixel's area.
#[pass(
    name = "splat.kim2019",
    over = params.photon_capacity,
    work = Splat,
    limit = dispatch.limit(photon_state, params)
)]
pub fn splat_kim2019(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    features: Features,
    counters: &mut impl Atomics,
    materials: &[Material],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    _photon_state: &[u32],
    photon_geometry: &[PhotonGeometry],
    photon_light: &[PhotonLight],
    #[len = params.pixel_count() * accumulator::WORDS] mut accumulator: AtomicWords<'_>,
    pixel_weights: &[f32],
    #[len = 0] mut start_scores: AtomicWords<'_>,
) {
    // Project the photon into the image
    let photon = photon_geometry[index as usize];
    let to = photon.position - params.camera.position;
    let (is_seen, position_px) = raster_position(to, params);
    if !is_seen {
        return;
    }
    let pixel = pixel_of(position_px, params);
    let point = point_geometry[pixel as usize];
    let distance = to.length();
    // Accept the photon if its pixel collects light at its first surface, and sees it there.
    let is_primary = point.depth == 1 && photon.scatterings < params.max_bounces;
    if is_primary && agrees(&point, &photon, position_px, point_geometry, params) {
        let light = photon_light[index as usize];
        // Reject light on the back of a thin wall: `contribution` takes both ends above the face.
        if light.to_light.dot(point.normal) <= 0.0 {
            return;
        }
        let shading = point_shading[pixel as usize];
        let material = material_of(&shading, materials, features);
        let roughness = params.specular_roughness;
        let value = contribution(&shading, material, &light, roughness, features);
        // Add BSDF times flux over the area of the pixel; `resolve` divides by the disc.
        let disc = PI * point.radius * point.radius;
        let value = value * (disc / area(&photon, to, distance, dispatch.level, params));
        let sum = GatheredSum::new(value, params.inverse_quantum(), photon.position, point.position);
        sum.add_to(&mut accumulator, pixel);
        if light.score > 0.0 {
            let score = score(&light, &point, &shading, value, pixel_weights[pixel as usize]);
            score::add(score, &light, params, features, &mut start_scores);
        }
        sum.tally(counters);
    }
}

/// Whether a photon, seen at `position_px`, lies on the surface that its pixel sees in `point`. It does if it is as far from the
/// eye as `point`. It also does if it lies on the plane of `point`, and the next pixels on its side, in row and column, see that
/// plane. A pixel at a slant spans distances far above the tolerance. Nothing hides a position between visible points of one
/// plane; beyond the last of them something may, as a wall does.
#[inline(always)]
fn agrees(
    point: &PointGeometry,
    photon: &PhotonGeometry,
    position_px: Vec2,
    points: &[PointGeometry],
    params: &FrameParams,
) -> bool {
    let eye = params.camera.position;
    let (seen, distance) = ((point.position - eye).length(), (photon.position - eye).length());
    if (distance - seen).abs() <= DISTANCE_TOLERANCE * distance {
        return true;
    }
    if !is_on_plane(point, photon.position, photon.normal, eye) {
        return false;
    }
    // At the edge of the image a pixel is its own neighbour.
    let (_, own) = raster_position(point.position - eye, params);
    let pixel = pixel_of(position_px, params);
    let (column, row) = (pixel % params.width, pixel / params.width);
    let in_row = row * params.width + beside(column, position_px.x < own.x, params.width);
    let in_column = beside(row, position_px.y < own.y, params.height) * params.width + column;
    sees_plane(point, in_row, points, eye) && sees_plane(point, in_column, points, eye)
}

/// Column or row before or behind `index`, clamped to `count` of them.
#[inline(always)]
fn beside(index: u32, before: bool, count: u32) -> u32 {
    if before { index.max(1) - 1 } else { (index + 1).min(count - 1) }
}

/// Whether a position lies on the plane through a point, within the tolerance along the eye's ray to the position. The plane
/// leans by the mean of both normals, and so follows slightly curved surfaces.
#[inline(always)]
fn is_on_plane(point: &PointGeometry, position: Vec3, normal: Vec3, eye: Vec3) -> bool {
    let normals = point.normal + normal;
    let height = (position - point.position).dot(normals);
    // Along that ray the plane is height / (normals . to / distance) away.
    point.normal.dot(normal) > 0.0 && height.abs() <= DISTANCE_TOLERANCE * (position - eye).dot(normals).abs()
}

/// Whether the first surface of pixel `beside` lies on the plane through a point.
#[inline(always)]
fn sees_plane(point: &PointGeometry, beside: u32, points: &[PointGeometry], eye: Vec3) -> bool {
    let other = points[beside as usize];
    other.depth == 1 && is_on_plane(point, other.position, other.normal, eye)
}

/// Whether a direction from the eye is in the image, and its position there (px).
#[inline(always)]
fn raster_position(to: Vec3, params: &FrameParams) -> (bool, Vec2) {
    let (is_before, at) = params.camera.on_plane(to);
    let position_px = params.raster_position(at);
    (is_before && params.shows(position_px), position_px)
}

/// Pixel of a position in the image.
#[inline(always)]
fn pixel_of(position_px: Vec2, params: &FrameParams) -> u32 {
    (position_px.y as u32).min(params.height - 1) * params.width
        + (position_px.x as u32).min(params.width - 1)
}

/// Area of a pixel at the photon (m^2).
#[inline(always)]
fn area(photon: &PhotonGeometry, to: Vec3, distance: f32, kind: u32, params: &FrameParams) -> f32 {
    let Camera { right, up, forward, .. } = params.camera;
    // Area of a pixel a metre before the eye.
    let Window { film_width, film_height, .. } = params.window;
    let pixel = 4.0 * right.length() * up.length() / (film_width * film_height) as f32;
    if kind == AREA_FACING {
        return pixel * distance * distance;
    }
    let depth = to.dot(forward);
    let cos = (photon.normal.dot(to) / distance).abs().max(MIN_COS);
    pixel * depth * depth * depth / (distance * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params() -> FrameParams {
        let camera = Camera {
            position: Vec3::new(1.0, 2.0, 3.0),
            right: Vec3::X * 0.8,
            up: Vec3::Y * 0.6,
            forward: Vec3::NEG_Z,
        };
        FrameParams { camera, width: 40, height: 30, window: Window::all(40, 30), ..FrameParams::default() }
    }

    #[test]
    fn a_direction_projects_to_the_pixel_of_its_ray() {
        let params = params();
        for pixel in 0..1200 {
            let (column, row) = ((pixel % 40) as f32 + 0.3, (pixel / 40) as f32 + 0.7);
            let Camera { right, up, forward, .. } = params.camera;
            let to = forward + right * (column / 20.0 - 1.0) + up * (1.0 - row / 15.0);
            let (is_seen, position_px) = raster_position(to * 7.0, &params);
            assert!(is_seen && position_px.distance(Vec2::new(column, row)) < 1.0e-4);
            assert_eq!(pixel_of(position_px, &params), pixel);
            assert!(!raster_position(to * -1.0, &params).0);
        }
        assert!(!raster_position(Vec3::new(0.81, 0.0, -1.0), &params).0);
    }

    /// An eye a metre above a floor, looking along it, with three by three pixels. The middle pixel sees the floor 5 m ahead, the
    /// pixel above it 7 m ahead and the pixel below it 4 m ahead.
    fn floor() -> (FrameParams, [PointGeometry; 9]) {
        let camera = Camera {
            position: Vec3::Y,
            right: Vec3::Z * 0.1,
            up: Vec3::new(0.2, 1.0, 0.0).normalize() * 0.1,
            forward: Vec3::new(1.0, -0.2, 0.0).normalize(),
        };
        let params =
            FrameParams { camera, width: 3, height: 3, window: Window::all(3, 3), ..FrameParams::default() };
        let point = PointGeometry { normal: Vec3::Y, depth: 1, ..PointGeometry::default() };
        let points = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|pixel| {
            let x = [7.0, 5.0, 4.0][pixel / 3];
            PointGeometry { position: Vec3::new(x, 0.0, x / 15.0 * (pixel as f32 % 3.0 - 1.0)), ..point }
        });
        (params, points)
    }

    fn takes(points: &[PointGeometry; 9], position: Vec3, normal: Vec3) -> bool {
        let params = floor().0;
        let (is_seen, position_px) = raster_position(position - params.camera.position, &params);
        assert!(
            is_seen && pixel_of(position_px, &params) == 4,
            "the test has lost its subject: {position_px}"
        );
        agrees(
            &points[4],
            &PhotonGeometry { position, normal, ..PhotonGeometry::default() },
            position_px,
            points,
            &params,
        )
    }

    /// Two points of one pixel, a tenth of their distance apart, are on one surface. A point that floats above the floor, or
    /// hangs below it with its face down, is not on it.
    #[test]
    fn a_pixel_at_a_slant_has_the_depth_of_its_plane() {
        let at = |position, normal| takes(&floor().1, position, normal);
        assert!(at(Vec3::X * 5.5, Vec3::Y) && at(Vec3::X * 4.5, Vec3::Y));
        // A hill of radius 5 m, where the plane through the point alone is 2.4 % off.
        assert!(at(Vec3::new(4.5, -0.025, 0.0), Vec3::new(-0.1, 1.0, 0.0).normalize()));
        assert!(!at(Vec3::new(5.5, 0.05, 0.0), Vec3::Y) && !at(Vec3::X * 5.5, Vec3::NEG_Y));
        assert!(at(Vec3::new(5.0, 0.05, 0.0), Vec3::Y), "the published tolerance stays");
    }

    /// A wall or a mirror stands on the floor 5.2 m ahead, or to the right, so that the next pixel sees it.
    #[test]
    fn a_plane_ends_where_the_next_pixel_sees_something_else() {
        let (_, floor) = floor();
        let wall =
            PointGeometry { position: Vec3::new(5.2, 0.3, 0.0), normal: Vec3::NEG_X, depth: 1, ..floor[4] };
        let mirror = PointGeometry { depth: 2, ..floor[1] };
        let (behind, before) = (Vec3::new(5.5, 0.0, 0.05), Vec3::new(4.5, 0.0, -0.05));
        for (beside, other) in [(1, wall), (5, wall), (1, mirror)] {
            let mut points = floor;
            points[beside] = other;
            assert!(takes(&floor, behind, Vec3::Y) && !takes(&points, behind, Vec3::Y), "{beside}");
            assert!(takes(&points, before, Vec3::Y), "{beside}: the floor before it is seen");
        }
    }

    /// The footprints of all pixels on a plane across the whole view add up to the visible area of the plane.
    #[test]
    fn footprints_tile_a_plane() {
        let params = params();
        let Camera { right, up, forward, .. } = params.camera;
        // A plane that leans by 0.5 across x: points p with (p - c) . n = 0, c 4 m before the eye.
        let normal = Vec3::new(0.5, 0.0, 1.0).normalize();
        let mut sum = 0.0;
        for pixel in 0..1200 {
            let (column, row) = ((pixel % 40) as f32 + 0.5, (pixel / 40) as f32 + 0.5);
            let ray = forward + right * (column / 20.0 - 1.0) + up * (1.0 - row / 15.0);
            let to = ray * (4.0 * forward.dot(normal) / ray.dot(normal));
            let photon = PhotonGeometry { normal, ..PhotonGeometry::default() };
            let area_of = |kind| area(&photon, to, to.length(), kind, &params);
            sum += area_of(AREA_FOOTPRINT);
            // Kim's area leaves out the slant, and that the corners of a flat film are smaller from the eye.
            let slant = normal.dot(to).abs() / to.length();
            let off_axis = to.dot(forward) / to.length();
            let ratio = area_of(AREA_FACING) / area_of(AREA_FOOTPRINT);
            assert!((ratio * off_axis.powi(3) / slant - 1.0).abs() < 1.0e-4, "{ratio}");
        }
        // The visible trapezoid: x = 4 s / (1 - s / 2) for s = -0.8 and 0.8, heights 1.2 of the depths there.
        let edge = |s: f32| (4.0 * s / (1.0 - 0.5 * s), 4.0 / (1.0 - 0.5 * s));
        let ((x0, d0), (x1, d1)) = (edge(-0.8), edge(0.8));
        let slanted = (x1 - x0) / normal.z;
        let expected = slanted * 0.5 * 1.2 * (d0 + d1);
        // Midpoints of 40 columns: the integral's error is below 1 / 40^2.
        assert!((sum / expected - 1.0).abs() < 1.0e-3, "{sum} {expected}");
    }
}
