//! Applies edits to the nodes of a scene.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec3, DVec4};

use super::{Edits, Keyframe, NodeEdit};
use crate::animation::{Channel, Interpolation, Path};
use crate::file_nodes::no_node;
use crate::{Scene, SceneError};
use caustics_files::text::cut;

/// Channels by node and property.
type Channels = BTreeMap<(usize, Path), Channel>;

impl Scene {
    /// Replaces all edits of nodes, from the next [`Scene::pose`] on. If a node has a matrix and an edit sets only its rotation
    /// or its scale, the other is the nearest to the matrix.
    ///
    /// # Errors
    ///
    /// If a node does not exist or has another name; or if it may not move, which takes
    /// [`LoadOptions::grabbed`](crate::LoadOptions::grabbed) or an animation. Then nothing changes. [`Scene::pose`] finds
    /// transforms that cannot be shown.
    pub fn edit(&mut self, edits: &[NodeEdit]) -> Result<(), SceneError> {
        self.play(&Edits { nodes: edits.into(), ..Edits::default() })
    }

    /// Replaces all edits, with keyframes: nodes follow them, and so does a camera [`Recorded::NAME`](crate::Recorded::NAME) if
    /// keyframes have one. The caller places a resting camera with [`Scene::place_camera`].
    ///
    /// # Errors
    ///
    /// Errors of [`Scene::edit`], or a camera that cannot be placed.
    pub fn play(&mut self, edits: &Edits) -> Result<(), SceneError> {
        edits.check().map_err(|error| self.wrong_edits(error.to_string()))?;
        let channels = self.channels(edits)?;
        self.record(&edits.keys)?;
        for joint in &mut self.rig.joints {
            joint.local.edits.clear();
        }
        for ((joint, _), channel) in channels {
            self.rig.joints[joint].local.edits.push(channel);
        }
        Ok(())
    }

    /// An error for edits that do not fit this scene.
    fn wrong_edits(&self, what: String) -> SceneError {
        SceneError::Edits { file: self.file().into(), what }
    }

    /// Name of the file in messages.
    fn file(&self) -> &str {
        self.motion.as_ref().map_or(&self.name, |motion| &motion.file)
    }

    /// Channels of the edits, for nodes that may move.
    fn channels(&self, edits: &Edits) -> Result<Channels, SceneError> {
        let joints = self.rig.joints.iter().enumerate();
        let of_file = joints.filter_map(|(id, joint)| Some((joint.of_file.as_ref()?.index, id)));
        let joint_of: HashMap<usize, usize> = of_file.collect();
        let mut channels = Channels::new();
        let mut add = |edit: &NodeEdit, time: f64, is_key: bool| {
            let joint = *joint_of.get(&edit.node).ok_or_else(|| no_node(self.file(), edit.node))?;
            self.check_edit(joint, edit)?;
            for (path, value) in edit.parts() {
                let channel = channels.entry((joint, path));
                let channel = channel.or_insert_with(|| Channel::linear(path));
                // Keyframes override values without a time.
                if is_key || channel.times.is_empty() {
                    channel.times.push(time);
                    channel.values.push(value);
                }
            }
            Ok(())
        };
        for Keyframe { time, nodes, .. } in &edits.keys {
            nodes.iter().try_for_each(|edit| add(edit, *time, true))?;
        }
        edits.nodes.iter().try_for_each(|edit| add(edit, 0.0, false))?;
        Ok(channels)
    }

    /// Refuses an edit of a node with another name, or of a node that may not move.
    fn check_edit(&self, joint: usize, edit: &NodeEdit) -> Result<(), SceneError> {
        let joint = &self.rig.joints[joint];
        let name = joint.of_file.as_ref().and_then(|of_file| of_file.name.as_deref());
        if let Some(wanted) = edit.name.as_deref().filter(|wanted| Some(*wanted) != name) {
            let is = name.map_or("has no name".into(), |name| format!("is called {:?}", cut(name, 80)));
            let (node, wanted) = (edit.node, cut(wanted, 80));
            return Err(self.wrong_edits(format!(
                "its node {node} {is}, but the edits are of {wanted:?}; are they of another file?"
            )));
        }
        if !joint.moves {
            let what = format!("{} was loaded as one that stands still (LoadOptions::grabbed)", joint.label);
            return Err(self.wrong_edits(what));
        }
        Ok(())
    }
}

impl NodeEdit {
    /// Properties that it sets, with their values.
    fn parts(&self) -> impl Iterator<Item = (Path, DVec4)> {
        let vector = |vector: [f64; 3]| DVec3::from(vector).extend(0.0);
        let translation = self.translation.map(|translation| (Path::Translation, vector(translation)));
        let rotation = self.rotation.map(|rotation| (Path::Rotation, DVec4::from(rotation)));
        let scale = self.scale.map(|scale| (Path::Scale, vector(scale)));
        [translation, rotation, scale].into_iter().flatten()
    }
}

impl Channel {
    /// A linear channel without keys.
    pub(super) fn linear(path: Path) -> Channel {
        Channel { path, interpolation: Interpolation::Linear, times: Vec::new(), values: Vec::new() }
    }
}
