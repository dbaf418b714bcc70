//! The node tree: what stands where, in f64.

use std::f32::consts::{FRAC_PI_4, PI};

use glam::{DAffine3, DMat4, DQuat, DVec3, Vec3};
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{Index, Mesh};

use super::document::Document;
use super::{unsupported, vector};
use crate::scene::punctual::cone_fault;
use crate::scene::{LightShape, PunctualLight, SceneCamera, SceneError};

/// A mesh in the world.
pub struct MeshInstance {
    /// How messages call its node.
    pub node: String,
    /// The mesh.
    pub mesh: Index<Mesh>,
    /// Its place.
    pub to_world: DAffine3,
}

/// All that stands in the world, not yet recentred.
#[derive(Default)]
pub struct Placed {
    /// Meshes.
    pub meshes: Vec<MeshInstance>,
    /// Cameras and their positions [m].
    pub cameras: Vec<(DVec3, SceneCamera)>,
    /// Punctual lights and their positions [m].
    pub lights: Vec<(DVec3, PunctualLight)>,
}

/// Walks the default scene's nodes, parents first.
pub fn place(document: &mut Document) -> Result<Placed, SceneError> {
    let mut placed = Placed::default();
    let mut visited = vec![false; document.root.nodes.len()];
    let mut stack: Vec<_> =
        roots(document)?.into_iter().rev().map(|root| (root, DAffine3::IDENTITY)).collect();
    while let Some((index, parent)) = stack.pop() {
        let node = document.get(&document.root.nodes, index, "node", "the node tree")?.clone();
        let label = unsupported::label("node", index.value(), node.name.as_deref());
        let wrong = |what: &str| SceneError::Node {
            file: document.file.clone(),
            node: label.clone(),
            what: what.into(),
        };
        if std::mem::replace(&mut visited[index.value()], true) {
            return Err(wrong("has two parents or is below itself"));
        }
        let to_world = parent * local(&node).ok_or_else(|| wrong("its transform is not finite"))?;
        if !to_world.is_finite() {
            return Err(wrong("its place in the world is not finite"));
        }
        if (node.mesh.is_some() || node.camera.is_some()) && is_singular(&to_world) {
            return Err(wrong("its transform is singular (a scale of zero, or axes in one plane)"));
        }
        if let Some(mesh) = node.mesh {
            placed.meshes.push(MeshInstance { node: label.clone(), mesh, to_world });
        }
        if node.camera.is_some() {
            placed.cameras.extend(camera(document, &node, &label, &to_world)?);
        }
        if let Some(light) = node.extensions.as_ref().and_then(|all| all.khr_lights_punctual.as_ref()) {
            placed.lights.push(light_at(document, light.light, &label, &to_world)?);
        }
        stack.extend(node.children.iter().flatten().rev().map(|&child| (child, to_world)));
    }
    Ok(placed)
}

/// Root nodes of the default scene, else of the first, else every node that is no child.
fn roots(document: &Document) -> Result<Vec<Index<Node>>, SceneError> {
    let root = &document.root;
    if let Some(scene) = root.scene {
        return Ok(document.get(&root.scenes, scene, "scene", "the document")?.nodes.clone());
    }
    if let Some(scene) = root.scenes.first() {
        return Ok(scene.nodes.clone());
    }
    let children: std::collections::HashSet<usize> =
        root.nodes.iter().flat_map(|node| node.children.iter().flatten()).map(Index::value).collect();
    Ok((0..root.nodes.len())
        .filter(|node| !children.contains(node))
        .map(|node| Index::new(node as u32))
        .collect())
}

/// A node's own transform; none if it is not finite or no rotation.
fn local(node: &Node) -> Option<DAffine3> {
    let transform = match node.matrix {
        Some(matrix) => DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from))),
        None => {
            let rotation = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
            let rotation = (rotation.length() > 1e-6).then(|| rotation.normalize())?;
            DAffine3::from_scale_rotation_translation(
                node.scale.map_or(DVec3::ONE, vector),
                rotation,
                node.translation.map_or(DVec3::ZERO, vector),
            )
        }
    };
    transform.is_finite().then_some(transform)
}

fn is_singular(transform: &DAffine3) -> bool {
    let axes = transform.matrix3;
    let size = axes.x_axis.length() * axes.y_axis.length() * axes.z_axis.length();
    // Written so that what is not finite counts as singular.
    !(axes.determinant().abs() > 1e-12 * size && transform.inverse().is_finite())
}

/// A perspective camera; none, with a warning, if it is another one.
fn camera(
    document: &mut Document,
    node: &Node,
    label: &str,
    to_world: &DAffine3,
) -> Result<Option<(DVec3, SceneCamera)>, SceneError> {
    let Some(index) = node.camera else { return Ok(None) };
    let camera = document.get(&document.root.cameras, index, "camera", label)?.clone();
    let Some(lens) = camera.perspective else {
        document.warn(format!("{label}: only perspective cameras are supported; left out"));
        return Ok(None);
    };
    if !(lens.yfov > 1e-4 && lens.yfov < PI - 1e-4) {
        let what = format!("its camera's yfov is {} rad and should be between 0 and pi", lens.yfov);
        return Err(SceneError::Node { file: document.file.clone(), node: label.into(), what });
    }
    let forward = -to_world.matrix3.z_axis.normalize();
    let right = forward.cross(to_world.matrix3.y_axis).normalize();
    let camera = SceneCamera {
        name: node.name.clone().or(camera.name).unwrap_or_else(|| format!("camera {}", index.value())),
        position: Vec3::ZERO,
        right: right.as_vec3(),
        up: right.cross(forward).as_vec3(),
        forward: forward.as_vec3(),
        fov_y: lens.yfov,
        aspect: lens.aspect_ratio.filter(|aspect| aspect.is_finite() && *aspect > 0.0),
    };
    Ok(Some((to_world.translation, camera)))
}

/// A punctual light.
fn light_at(
    document: &mut Document,
    index: Index<Light>,
    label: &str,
    to_world: &DAffine3,
) -> Result<(DVec3, PunctualLight), SceneError> {
    let extensions = document.root.extensions.as_ref();
    let lights = extensions.and_then(|all| all.khr_lights_punctual.as_ref()).map(|all| all.lights.as_slice());
    let light = document.get(lights.unwrap_or_default(), index, "light", label)?.clone();
    let wrong = |what: String| SceneError::Node { file: document.file.clone(), node: label.into(), what };
    let intensity = Vec3::from(light.color) * light.intensity;
    if !(intensity.is_finite() && intensity.min_element() >= 0.0) {
        return Err(wrong("its light's intensity or colour is negative, infinite or not a number".into()));
    }

    // Light that has a direction goes along -z; scale does not count, but axes of no length have no direction.
    let direction = (-to_world.matrix3.z_axis).try_normalize().map(|direction| direction.as_vec3());
    let aimed = || direction.ok_or_else(|| wrong("its light has no direction (a scale of zero)".into()));
    let shape = match light.type_ {
        Checked::Valid(Type::Point) => LightShape::Point,
        Checked::Valid(Type::Directional) => LightShape::Directional { direction: aimed()? },
        Checked::Valid(Type::Spot) => {
            let cone = light.spot.as_ref();
            let inner = f64::from(cone.map_or(0.0, |cone| cone.inner_cone_angle));
            let outer = f64::from(cone.map_or(FRAC_PI_4, |cone| cone.outer_cone_angle));
            if let Some(fault) = cone_fault(inner, outer) {
                return Err(wrong(format!("its light has {fault}")));
            }
            LightShape::Spot { direction: aimed()?, inner, outer }
        }
        Checked::Invalid => return Err(wrong("its light is no point, spot or directional light".into())),
    };
    if light.range.is_some() {
        document.warn(format!("{label}: a light's range is not supported; it reaches everywhere"));
    }
    // A directional light may stand anywhere: its place says nothing.
    let position =
        if matches!(shape, LightShape::Directional { .. }) { DVec3::ZERO } else { to_world.translation };
    Ok((position, PunctualLight { position: Vec3::ZERO, intensity, shape }))
}
