//! Inspection of a pixel of the last frame: its camera path, its collection point, the point's photons, and some of their
//! light paths. The CPU traces these paths again with the frame's random numbers, so that rendering has no extra cost.
//!
//! With the CPU runner, the inspected paths equal those of the frame to the bit. On a device, rounding changes a few paths
//! in a thousand. The point and its disc are read from the frame, and [`Photons::gathered`] is the frame's own count.

use serde::Serialize;

pub use self::event::Event;

mod camera;
mod event;
mod light;
mod look;
mod photons;
mod record;
mod shared;
mod view;

/// Inspection of a pixel. Positions are in the file's coordinates (m).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Column and row, from the upper left.
    pub pixel: [u32; 2],
    /// Index of the frame.
    pub frame: u32,
    /// Camera path up to the collection point; the whole path if the method has no collection points.
    pub camera_path: CameraPath,
    /// Collection point; `None` if the pixel has none.
    pub point: Option<Point>,
    /// Photons of the collection point; `None` if the method does not gather photons over discs.
    pub photons: Option<Photons>,
    /// Light path of each photon in `photons.some`, from its light to the photon.
    pub light_paths: Vec<LightPath>,
    /// Indirect light that the point took from others; `None` if it took none.
    pub shared_light: Option<SharedLight>,
}

/// Camera path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraPath {
    /// Position of the eye.
    pub eye: [f64; 3],
    /// Unit direction of the first ray.
    pub direction: [f32; 3],
    /// Vertices in order.
    pub vertices: Vec<Vertex>,
    /// Unit direction in which the path leaves the scene; `None` if it stays.
    pub leaves: Option<[f32; 3]>,
}

/// Vertex of a path, or a face that the path passes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Vertex {
    /// Position.
    pub position: [f64; 3],
    /// Unit normal of the face, on the side that the path came from.
    pub normal: [f32; 3],
    /// Event at the vertex.
    pub event: Event,
    /// Lobe that scattered the path. Several if they are sampled together, or if the direction does not determine the lobe.
    pub lobes: Vec<&'static str>,
    /// Whether the event is specular.
    pub specular: bool,
    /// Name of the material.
    pub material: String,
    /// Index of the material.
    pub material_index: u32,
    /// Index of the instance. 0 stands for all geometry that neither moves nor is instanced.
    pub instance: u32,
    /// Index of the triangle in the scene's tables.
    pub triangle: u32,
    /// Throughput of a camera path, or flux of a light path (W), on arrival.
    pub carries: [f32; 3],
    /// Colour channel of the path if dispersion in a medium left it a single one.
    pub channel: Option<&'static str>,
}

/// Collection point of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Position.
    pub position: [f64; 3],
    /// Unit normal of the disc: the face normal on the viewer's side.
    pub normal: [f32; 3],
    /// Unit shading normal.
    pub shading_normal: [f32; 3],
    /// Unit direction back along the camera path.
    pub to_viewer: [f32; 3],
    /// Radius of the disc (m).
    pub radius: f32,
    /// Number of vertices of the camera path, this one included.
    pub depth: u32,
    /// Throughput of the camera path.
    pub throughput: [f32; 3],
}

/// Photons of a collection point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Photons {
    /// Number of photons that the frame's gather counted.
    pub gathered: u32,
    /// Number of photons that the inspection found.
    pub count: u32,
    /// Number of light paths that were traced again.
    pub light_paths: u32,
    /// Number of light paths without kept starts, which cannot be traced again. See
    /// [`Session::keep_starts`](crate::session::Session::keep_starts).
    pub skipped: u32,
    /// Flux that arrives on the disc (W).
    pub flux: [f32; 3],
    /// Radiance of the pixel from these photons (W m^-2 sr^-1), before a history.
    pub radiance: [f32; 3],
    /// Selected photons.
    pub some: Vec<Photon>,
}

/// Photon on the disc of a collection point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Photon {
    /// Index of its light path.
    pub path: u32,
    /// Position.
    pub position: [f64; 3],
    /// Unit direction back along the light path.
    pub to_light: [f32; 3],
    /// Number of scattering events between the light and this hit.
    pub scatterings: u32,
    /// Flux that arrives (W).
    pub flux: [f32; 3],
    /// Radiance of the pixel from this photon (W m^-2 sr^-1).
    pub radiance: [f32; 3],
}

/// Indirect light of a collection point: the mean over points around it. All light is that of a white diffuse surface at the
/// point (W m^-2 sr^-1).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SharedLight {
    /// Radius within which the points lie (m).
    pub radius: f32,
    /// Light that the point's own camera path found.
    pub own: [f32; 3],
    /// Mean of the light of all points.
    pub mean: [f32; 3],
    /// Change of the pixel's radiance by it (W m^-2 sr^-1).
    pub change: [f32; 3],
    /// The points, in the order of their pixels. The point itself is among them, unless random numbers left it out of a crowded
    /// cell.
    pub points: Vec<SharingPoint>,
}

/// Collection point that gives its indirect light to another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SharingPoint {
    /// Column and row of its pixel.
    pub pixel: [u32; 2],
    /// Position.
    pub position: [f64; 3],
    /// Number of vertices of the camera path, this one included.
    pub depth: u32,
    /// Light that it gives.
    pub light: [f32; 3],
}

/// Light path up to a photon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightPath {
    /// Index in the frame.
    pub path: u32,
    /// Light that emits the path; `None` if it cannot be determined.
    pub light: Option<Light>,
    /// Start: a position on the light, or a position before the scene for a light at infinity.
    pub start: [f64; 3],
    /// Unit direction of its first ray.
    pub direction: [f32; 3],
    /// Flux at the start (W).
    pub flux: [f32; 3],
    /// Vertices in order; the last is the photon.
    pub vertices: Vec<Vertex>,
}

/// Light of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Light {
    /// Index into the light table.
    pub id: u32,
    /// Kind: `area`, `point`, `spot`, `directional` or `environment`.
    pub kind: &'static str,
}
