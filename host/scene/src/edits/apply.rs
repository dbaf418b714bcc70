//! Edits of the nodes of a scene.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec3, DVec4};

use super::{Edits, Keyframe, NodeEdit};
use crate::animation::{Channel, Interpolation, Path};
use crate::file_nodes::no_node;
use crate::{Scene, SceneError};
use caustics_files::text::cut;

/// Channels by node of the rig and the part that they set.
type Channels = BTreeMap<(usize, Path), Channel>;

impl Scene {
    /// Places nodes otherwise, from the next [`Scene::pose`] on, and takes back all edits before. Of a node that is placed by a
    /// matrix, rotation and scale are those nearest to it where one of the two is set.
    ///
    /// # Errors
    ///
    /// If there is no such node or it has another name, or it was neither loaded as one of
    /// [`LoadOptions::grabbed`](crate::LoadOptions::grabbed) nor moved by an animation; then nothing changes. A transform that
    /// cannot be shown is found by [`Scene::pose`].
    pub fn edit(&mut self, edits: &[NodeEdit]) -> Result<(), SceneError> {
        self.play(&Edits { nodes: edits.into(), ..Edits::default() })
    }

    /// The same with keys: nodes move by them, and so does a camera of its own where keys have one,
    /// [`Recorded::NAME`](crate::Recorded::NAME). A camera that stands still is left to [`Scene::place_camera`].
    ///
    /// # Errors
    ///
    /// Those of [`Scene::edit`]; a camera that cannot be placed.
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

    /// An error of edits that are not of this scene.
    fn wrong_edits(&self, what: String) -> SceneError {
        SceneError::Edits { file: self.file().into(), what }
    }

    /// How messages call its file.
    fn file(&self) -> &str {
        self.motion.as_ref().map_or(&self.name, |motion| &motion.file)
    }

    /// What edits set, by nodes that may be moved.
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
                // Where keys set it they alone count.
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

    /// Refuses an edit of a node that is another, or stands still.
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
    /// The parts that it sets.
    fn parts(&self) -> impl Iterator<Item = (Path, DVec4)> {
        let vector = |vector: [f64; 3]| DVec3::from(vector).extend(0.0);
        let translation = self.translation.map(|translation| (Path::Translation, vector(translation)));
        let rotation = self.rotation.map(|rotation| (Path::Rotation, DVec4::from(rotation)));
        let scale = self.scale.map(|scale| (Path::Scale, vector(scale)));
        [translation, rotation, scale].into_iter().flatten()
    }
}

impl Channel {
    /// One without keys yet.
    pub(super) fn linear(path: Path) -> Channel {
        Channel { path, interpolation: Interpolation::Linear, times: Vec::new(), values: Vec::new() }
    }
}
