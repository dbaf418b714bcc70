//! What light transport did at a pixel of the last frame: its camera path, its collection point, the photons that the point
//! took, and light paths that made some of them. All of it is traced again on the CPU, by the walks and the random numbers of the
//! frame, so that nothing of the frame itself pays for it.
//!
//! On the CPU runner what is found is what the frame found, to the bit. Frames of a device may differ from it in the few paths in a
//! thousand that rounding parts; the point and its disc are the frame's own, and [`Photons::gathered`] is what it counted.

use serde::Serialize;

pub use self::event::Event;

mod camera;
mod event;
mod light;
mod look;
mod photons;
mod record;
mod view;

/// A pixel of a frame, looked into. Positions are in the file's coordinates (m).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Column and row, from the upper left.
    pub pixel: [u32; 2],
    /// Index of the frame.
    pub frame: u32,
    /// The path from the camera, to the collection point; of a method without such points, all of the path.
    pub camera_path: CameraPath,
    /// The collection point, if there is one.
    pub point: Option<Point>,
    /// The photons that it took; none of methods that bring them to pixels in other ways than by discs.
    pub photons: Option<Photons>,
    /// A light path for each of `photons.some`, from its light to that photon.
    pub light_paths: Vec<LightPath>,
}

/// A path from the camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraPath {
    /// The eye.
    pub eye: [f64; 3],
    /// Unit direction of the first ray.
    pub direction: [f32; 3],
    /// What it meets, in order.
    pub vertices: Vec<Vertex>,
    /// Unit direction in which it leaves the scene, if it does.
    pub leaves: Option<[f32; 3]>,
}

/// A vertex of a path, or a face that it passes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Vertex {
    /// Position.
    pub position: [f64; 3],
    /// Unit normal of the face, on the side that the path came from.
    pub normal: [f32; 3],
    /// What the path does there.
    pub event: Event,
    /// The lobe that it was scattered by; several where they are sampled as one, or the direction does not say which it was.
    pub lobes: Vec<&'static str>,
    /// Whether that is a specular event.
    pub specular: bool,
    /// Name of the material.
    pub material: String,
    /// Its index.
    pub material_index: u32,
    /// Index of the instance; 0 is all that neither moves nor is stored once for many nodes.
    pub instance: u32,
    /// Index of the triangle in the scene's tables.
    pub triangle: u32,
    /// What the path carries as it arrives: throughput of a camera path, flux of a light path (W).
    pub carries: [f32; 3],
    /// The only channel that it carries, where a medium parted them.
    pub channel: Option<&'static str>,
}

/// A collection point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Position.
    pub position: [f64; 3],
    /// Unit normal of its disc: of the face, on the viewer's side.
    pub normal: [f32; 3],
    /// Unit shading normal.
    pub shading_normal: [f32; 3],
    /// Unit direction to where the camera path came from.
    pub to_viewer: [f32; 3],
    /// Radius of the disc (m).
    pub radius: f32,
    /// Vertices of the camera path, this one included.
    pub depth: u32,
    /// What the camera path lets through, divided by the probabilities of its choices.
    pub throughput: [f32; 3],
}

/// The photons of a collection point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Photons {
    /// How many the frame's own gather counted.
    pub gathered: u32,
    /// How many were found again.
    pub count: u32,
    /// Light paths that were traced again.
    pub light_paths: u32,
    /// Light paths that could not be, since what they started by is gone: see [`Session::keep_starts`](crate::session::Session::keep_starts).
    pub skipped: u32,
    /// Flux that arrives on the disc (W).
    pub flux: [f32; 3],
    /// What they give the pixel (W m^-2 sr^-1), before any history adds to it.
    pub radiance: [f32; 3],
    /// Some of them.
    pub some: Vec<Photon>,
}

/// A photon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Photon {
    /// Index of its light path.
    pub path: u32,
    /// Position.
    pub position: [f64; 3],
    /// Unit direction back along the light path.
    pub to_light: [f32; 3],
    /// Scatterings between the light and this hit.
    pub scatterings: u32,
    /// Flux that arrives (W).
    pub flux: [f32; 3],
    /// What it gives the pixel (W m^-2 sr^-1).
    pub radiance: [f32; 3],
}

/// A path from a light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightPath {
    /// Its index in the frame.
    pub path: u32,
    /// What it leaves; none where that cannot be told.
    pub light: Option<Light>,
    /// Where it starts: on the light, or before the scene where the light is endlessly far away.
    pub start: [f64; 3],
    /// Unit direction of its first ray.
    pub direction: [f32; 3],
    /// Flux that it starts with (W).
    pub flux: [f32; 3],
    /// What it meets, in order; the last is the photon.
    pub vertices: Vec<Vertex>,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Light {
    /// Index into the light table.
    pub id: u32,
    /// What it is: `area`, `point`, `spot`, `directional` or `environment`.
    pub kind: &'static str,
}
