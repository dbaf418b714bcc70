//! The node tree: what stands where, in f64.

use std::collections::HashMap;
use std::f32::consts::PI;

use glam::{DAffine3, DMat4, DQuat, DVec3, Vec3};
use gltf::json::extensions::scene::khr_lights_punctual::Light;
use gltf::json::scene::Node as JsonNode;
use gltf::json::{Index, Mesh};

use super::document::Document;
use super::{animation, instancing, unsupported};
use crate::animation::{Channel, Local, Morph, Node, NodeTree, Nodes, OfFile, Path, is_singular};
use crate::file_nodes::no_node;
use crate::motion::OnNode;
use crate::{LightShape, PunctualLight, SceneCamera, SceneError};

/// A mesh in the world.
#[derive(Clone)]
pub struct WorldMesh {
    /// How messages call its node.
    pub node: String,
    /// The mesh.
    pub mesh: Index<Mesh>,
    /// Its transform; that of a mesh that moves is left to the poses.
    pub to_world: DAffine3,
    /// Its node in the rig.
    pub joint: usize,
    /// Whether it moves.
    pub moves: bool,
    /// Its skin.
    pub skin: Option<usize>,
}

/// All that stands in the world, not yet recentred.
#[derive(Default)]
pub struct WorldNodes {
    /// The nodes.
    pub rig: NodeTree,
    /// Where they are at first.
    pub nodes: Nodes,
    /// Which of them each node of the file is.
    pub joint_of: HashMap<usize, usize>,
    /// Meshes.
    pub meshes: Vec<WorldMesh>,
    /// Cameras.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
}

impl WorldNodes {
    /// Punctual lights in a world around an origin (m); what moves may have no direction yet.
    pub fn lights_around(&self, file: &str, origin: DVec3) -> Result<Vec<PunctualLight>, SceneError> {
        let mut lights = Vec::new();
        for light in &self.lights {
            match light.what.placed(&self.nodes.to_world[light.joint], origin) {
                Some(light) => lights.push(light),
                None if light.moves => {}
                None => {
                    let node = self.rig.joints[light.joint].label.clone();
                    let what = "its light has no direction (a scale of zero)".into();
                    return Err(SceneError::Node { file: file.into(), node, what });
                }
            }
        }
        Ok(lights)
    }

    /// Cameras in a world around an origin (m).
    pub fn cameras_around(&self, origin: DVec3) -> Vec<SceneCamera> {
        let placed =
            |camera: &OnNode<SceneCamera>| camera.what.placed(&self.nodes.to_world[camera.joint], origin);
        self.cameras.iter().map(placed).collect()
    }
}

impl WorldNodes {
    fn mesh(&mut self, mut instance: WorldMesh) {
        if instance.moves {
            instance.to_world = DAffine3::IDENTITY;
        }
        self.meshes.push(instance);
    }

    /// Places a mesh many times; what has a scale of zero is not there. Where its node moves each is a node below.
    fn instances(&mut self, first: &WorldMesh, transforms: Vec<Local>, file: &str) -> Result<(), SceneError> {
        for (id, local) in transforms.into_iter().enumerate() {
            let node = format!("{}, instance {id}", first.node);
            let to_world = local.at(0.0).map(|local| first.to_world * local).filter(DAffine3::is_finite);
            let Some(to_world) = to_world else {
                let what = "its transform in the world is not finite".into();
                return Err(SceneError::Node { file: file.into(), node, what });
            };
            if is_singular(&to_world) {
                continue;
            }
            let (mesh, moves, skin) = (first.mesh, first.moves, first.skin);
            let mut joint = first.joint;
            if moves {
                joint = self.rig.joints.len();
                let (label, morph) = (node.clone(), self.rig.joints[first.joint].morph.clone());
                self.nodes.weights.push(morph.weights.clone());
                let parent = Some(first.joint);
                self.rig.joints.push(Node { label, of_file: None, parent, local, moves, morph });
                self.nodes.to_world.push(to_world);
            }
            self.mesh(WorldMesh { node, mesh, to_world, joint, moves, skin });
        }
        Ok(())
    }
}

/// Walks the default scene's nodes, parents first.
pub fn read(document: &mut Document) -> Result<WorldNodes, SceneError> {
    let mut channels = animation::read(document)?;
    let mut world = WorldNodes::default();
    let mut visited = vec![false; document.root.nodes.len()];
    let mut stack: Vec<_> = roots(document)?.into_iter().rev().map(|root| (root, None)).collect();
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
        let channels = channels.remove(&index.value()).unwrap_or_default();
        let (weights, channels) = channels.into_iter().partition(|channel| channel.path == Path::Weights);
        let (local, morph) = (local(&node, channels), morph(document, &node, weights));
        let to_parent = parent.map_or(DAffine3::IDENTITY, |parent: usize| world.nodes.to_world[parent]);
        let to_world = to_parent * local.at(0.0).ok_or_else(|| wrong("its transform is not finite"))?;
        if !to_world.is_finite() {
            return Err(wrong("its transform in the world is not finite"));
        }
        let is_grabbed = document.options.grabbed.contains(&index.value());
        let moves = is_grabbed
            || !local.channels.is_empty()
            || parent.is_some_and(|parent| world.rig.joints[parent].moves);
        // A skin leads to the world, wherever its node is.
        let is_flat = !moves && node.skin.is_none() && is_singular(&to_world);
        if is_flat && (node.mesh.is_some() || node.camera.is_some()) {
            let what = "its transform is singular (a scale of zero, or axes in one plane)";
            document.warn(&label, format_args!("{what}; not shown"));
        }
        let joint = world.rig.joints.len();
        world.joint_of.insert(index.value(), joint);
        world.nodes.weights.push(morph.at(0.0));
        let light = node.extensions.as_ref().and_then(|all| all.khr_lights_punctual.as_ref());
        let of_file = OfFile {
            index: index.value(),
            name: node.name.clone(),
            has_mesh: node.mesh.is_some(),
            has_light: light.is_some(),
            has_camera: node.camera.is_some(),
        };
        let in_rig = Node { label: label.clone(), of_file: Some(of_file), parent, local, moves, morph };
        world.rig.joints.push(in_rig);
        world.nodes.to_world.push(to_world);
        if let Some(mesh) = node.mesh.filter(|_| !is_flat) {
            let skin = node.skin.map(|skin| skin.value());
            let instance = WorldMesh { node: label.clone(), mesh, to_world, joint, moves, skin };
            let of_node = moves.then(|| bytes(&world.rig.joints[joint].morph));
            match instancing::read(document, index.value(), &label, of_node)? {
                Some(transforms) => world.instances(&instance, transforms, &document.file)?,
                None => world.mesh(instance),
            }
        }
        if node.camera.is_some() && !is_flat {
            let camera = camera(document, &node, &label)?;
            world.cameras.extend(camera.map(|what| OnNode { joint, moves, what }));
        }
        if let Some(light) = light {
            let light = light_of(document, light.light, &label)?;
            let is_lost = |light: &PunctualLight| !moves && light.placed(&to_world, DVec3::ZERO).is_none();
            if light.as_ref().is_some_and(is_lost) {
                document.warn(&label, "its light has no direction (a scale of zero); left out");
            }
            let light = light.filter(|light| !is_lost(light));
            world.lights.extend(light.map(|what| OnNode { joint, moves, what }));
        }
        stack.extend(node.children.iter().flatten().rev().map(|&child| (child, Some(joint))));
    }
    if let Some(&node) = document.options.grabbed.iter().find(|node| !world.joint_of.contains_key(node)) {
        return Err(no_node(&document.file, node));
    }
    Ok(world)
}

/// Root nodes of the default scene, else of the first, else every node that is no child.
fn roots(document: &Document) -> Result<Vec<Index<JsonNode>>, SceneError> {
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

/// A node's own transform and what moves it.
fn local(node: &JsonNode, channels: Vec<Channel>) -> Local {
    if let Some(matrix) = node.matrix {
        let matrix = DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        // A flat one has none.
        let rotation = if rotation.is_finite() { rotation.normalize() } else { DQuat::IDENTITY };
        return Local { translation, rotation, scale, matrix: Some(matrix.matrix3), ..Local::default() };
    }
    Local {
        translation: node.translation.map_or(DVec3::ZERO, |vector| Vec3::from(vector).as_dvec3()),
        rotation: DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from)),
        scale: node.scale.map_or(DVec3::ONE, |vector| Vec3::from(vector).as_dvec3()),
        channels,
        ..Local::default()
    }
}

/// Memory of what weights the morph targets of a node (bytes).
fn bytes(morph: &Morph) -> u64 {
    let keys = morph.channels.iter().map(|channel| 8 * channel.times.len() + 32 * channel.values.len());
    (16 * morph.weights.len() + keys.sum::<usize>()) as u64
}

/// How a node weights the morph targets of its mesh.
fn morph(document: &Document, node: &JsonNode, channels: Vec<Channel>) -> Morph {
    let mesh = node.mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
    let Some(count) = mesh.and_then(|mesh| mesh.primitives.first()?.targets.as_ref()).map(Vec::len) else {
        return Morph::default();
    };
    let set = node.weights.as_ref().or(mesh.and_then(|mesh| mesh.weights.as_ref()));
    let mut weights: Vec<f64> = set.iter().flat_map(|all| all.iter()).map(|&weight| weight.into()).collect();
    weights.resize(count, 0.0);
    Morph { weights, channels }
}

/// A perspective camera, not yet placed; none, with a warning, if it is another one.
fn camera(document: &mut Document, node: &JsonNode, label: &str) -> Result<Option<SceneCamera>, SceneError> {
    let Some(index) = node.camera else { return Ok(None) };
    let camera = document.get(&document.root.cameras, index, "camera", label)?.clone();
    let Some(lens) = camera.perspective else {
        document.warn(label, "only perspective cameras are supported; left out");
        return Ok(None);
    };
    if !(lens.yfov > 1e-4 && lens.yfov < PI - 1e-4) {
        let what = format!("its camera's yfov is {} rad and should be between 0 and pi", lens.yfov);
        let (file, node) = (document.file.clone(), label.into());
        document.replace(label, &what, "left out", SceneError::Node { file, node, what: what.clone() })?;
        return Ok(None);
    }
    let camera = SceneCamera {
        name: node.name.clone().or(camera.name).unwrap_or_else(|| format!("camera {}", index.value())),
        position: Vec3::ZERO,
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        fov_y: lens.yfov,
        aspect: lens.aspect_ratio.filter(|aspect| aspect.is_finite() && *aspect > 0.0),
    };
    Ok(Some(camera))
}

/// A punctual light, not yet placed; none, with a warning, if it is none that can be.
fn light_of(
    document: &mut Document,
    index: Index<Light>,
    label: &str,
) -> Result<Option<PunctualLight>, SceneError> {
    let extensions = document.root.extensions.as_ref();
    let lights = extensions.and_then(|all| all.khr_lights_punctual.as_ref()).map(|all| all.lights.as_slice());
    let light = document.get(lights.unwrap_or_default(), index, "light", label)?.clone();
    let intensity = Vec3::from(light.color) * light.intensity;
    let shape = match LightShape::from_gltf(&light) {
        Ok(shape) if intensity.is_finite() && intensity.min_element() >= 0.0 => Ok(shape),
        Ok(_) => Err("its light's intensity or colour is negative, infinite or not a number".into()),
        Err(what) => Err(format!("its light {what}")),
    };
    let shape = match shape {
        Ok(shape) => shape,
        Err(what) => {
            let (file, node) = (document.file.clone(), label.into());
            document.replace(
                label,
                &what,
                "left out",
                SceneError::Node { file, node, what: what.clone() },
            )?;
            return Ok(None);
        }
    };
    if light.range.is_some() {
        document.warn(label, "a light's range is not supported; it reaches everywhere");
    }
    Ok(Some(PunctualLight { position: Vec3::ZERO, intensity, shape }))
}
