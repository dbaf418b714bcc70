//! First hit of a pixel's ray.

use caustics::scene::{Scene, SceneCamera};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::trace::Tracer;
use serde::Serialize;

/// First hit of a pixel's ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Picked {
    /// Position in the file's coordinates (m).
    pub position: [f64; 3],
    /// Distance from the eye (m).
    pub distance: f64,
    /// Index of the triangle.
    pub triangle: u32,
    /// Index of its instance; 0 is the world.
    pub instance: u32,
    /// Name of its material.
    pub material: String,
    /// Index of the node in the file that it belongs to.
    pub node: Option<usize>,
}

/// Returns the first hit of the ray through `image_position`, in shares of width and height from the upper left; `size` is
/// in px.
pub fn picked(
    scene: &Scene,
    camera: &SceneCamera,
    size: [u32; 2],
    image_position: [f64; 2],
) -> Option<Picked> {
    let eye = camera.camera(size[0], size[1]);
    let [x, y] = image_position.map(|share| (2.0 * share - 1.0) as f32);
    let direction = (eye.forward + eye.right * x - eye.up * y).try_normalize()?;
    let ray = Ray::endless(camera.position, direction);
    let features = scene.features(0.0) | Features::INSTANCES | Features::CUT_OUTS;
    let hit = scene.tracer(features).closest(&ray);
    if hit.is_miss() {
        return None;
    }
    let position = scene.origin + (camera.position + direction * hit.distance).as_dvec3();
    let material = scene.surfaces[hit.triangle as usize].material;
    Some(Picked {
        position: position.to_array(),
        distance: f64::from(hit.distance),
        triangle: hit.triangle,
        instance: hit.instance,
        material: scene.material_name(material).into(),
        node: scene.node_of(hit.instance, hit.triangle),
    })
}
