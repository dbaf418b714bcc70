//! Recording of moving nodes and the camera, as keys that hold only what changed.

use std::collections::BTreeMap;

use caustics::scene::{CameraEdit, Keyframe, NodeEdit};

use super::request::NodeEdits;

/// Maximum number of translations, rotations, scales and cameras of a recording. A node dragged before a moving camera, at
/// 60 frames a second, gives them in about ten minutes. They take at most 40 MB of memory and 20 MB in a file.
const MAX_VALUES: usize = 100_000;

/// A value that holds until another one is recorded.
#[derive(Clone, Copy, Debug)]
struct Held<T> {
    value: T,
    /// Time of the last key with the value (s).
    written: f64,
}

/// The last recorded edit of a node.
#[derive(Clone, Copy, Debug, Default)]
struct HeldNode {
    translation: Option<Held<[f64; 3]>>,
    rotation: Option<Held<[f64; 4]>>,
    scale: Option<Held<[f64; 3]>>,
}

/// Keys of everything that moves.
#[derive(Debug, Default)]
pub struct Recording {
    keys: Vec<Keyframe>,
    nodes: BTreeMap<usize, HeldNode>,
    camera: Option<Held<CameraEdit>>,
    /// Time of the last frame (s).
    last: f64,
    values: usize,
}

impl Recording {
    /// Records nodes and camera in a frame, at a time after the previous frame's (s). A full recording stays as it is.
    pub fn add(&mut self, time: f64, nodes: &NodeEdits, camera: Option<CameraEdit>) {
        if self.is_full() || (time <= self.last && !self.keys.is_empty()) {
            return;
        }
        let times = [self.last, time];
        // Interpolation is linear: a value that rested until the previous frame needs a key there.
        let [mut before, mut now] = times.map(key_at);
        [before.camera, now.camera] = changed(&mut self.camera, camera, times);
        for (&node, edit) in nodes {
            let held = self.nodes.entry(node).or_default();
            let [mut old, mut new] = [node, node].map(edit_of);
            [old.translation, new.translation] = changed(&mut held.translation, edit.translation, times);
            [old.rotation, new.rotation] = changed(&mut held.rotation, edit.rotation, times);
            [old.scale, new.scale] = changed(&mut held.scale, edit.scale, times);
            before.nodes.extend(Some(old).filter(|edit| *edit != edit_of(node)));
            now.nodes.extend(Some(new).filter(|edit| *edit != edit_of(node)));
        }
        self.values += values(&before) + values(&now);
        for key in [before, now] {
            push(&mut self.keys, key);
        }
        self.last = time;
    }

    /// Whether the recording is full.
    pub fn is_full(&self) -> bool {
        self.values >= MAX_VALUES
    }

    /// Number of keys.
    pub fn len(&self) -> usize {
        self.keys.len() + usize::from(self.rests())
    }

    /// Whether nothing changed in the last frame.
    fn rests(&self) -> bool {
        self.keys.last().is_some_and(|key| key.time < self.last)
    }

    /// Returns the keys; the last one is at the time of the last frame.
    pub fn keys(&self) -> Vec<Keyframe> {
        let mut keys = self.keys.clone();
        if self.rests() {
            let mut end = key_at(self.last);
            end.camera = self.camera.map(|held| held.value);
            for (&node, held) in &self.nodes {
                let HeldNode { translation, rotation, scale } = *held;
                end.nodes.push(NodeEdit {
                    translation: translation.map(|held| held.value),
                    rotation: rotation.map(|held| held.value),
                    scale: scale.map(|held| held.value),
                    ..edit_of(node)
                });
            }
            keys.push(end);
        }
        keys
    }
}

fn key_at(time: f64) -> Keyframe {
    Keyframe { time, camera: None, nodes: Vec::new() }
}

fn edit_of(node: usize) -> NodeEdit {
    NodeEdit { node, ..NodeEdit::default() }
}

/// Updates a held value at the later of two times. Returns the values to record at each time.
fn changed<T: Copy + PartialEq>(
    held: &mut Option<Held<T>>,
    value: Option<T>,
    [last, time]: [f64; 2],
) -> [Option<T>; 2] {
    let Some(value) = value.filter(|value| held.is_none_or(|held| held.value != *value)) else {
        return [None; 2];
    };
    let before = held.filter(|held| held.written < last).map(|held| held.value);
    *held = Some(Held { value, written: time });
    [before, Some(value)]
}

fn values(key: &Keyframe) -> usize {
    let of_node = |edit: &NodeEdit| -> usize {
        [edit.translation.is_some(), edit.rotation.is_some(), edit.scale.is_some()]
            .map(usize::from)
            .iter()
            .sum()
    };
    usize::from(key.camera.is_some()) + key.nodes.iter().map(of_node).sum::<usize>()
}

/// Appends a key that has values, or adds them to the last key if its time is the same.
fn push(keys: &mut Vec<Keyframe>, mut key: Keyframe) {
    if values(&key) == 0 {
        return;
    }
    let Some(last) = keys.last_mut().filter(|last| last.time == key.time) else {
        key.nodes.shrink_to_fit();
        keys.push(key);
        return;
    };
    last.camera = key.camera.or(last.camera);
    for edit in key.nodes {
        match last.nodes.binary_search_by_key(&edit.node, |known| known.node) {
            Ok(index) => {
                let known = &mut last.nodes[index];
                known.translation = edit.translation.or(known.translation);
                known.rotation = edit.rotation.or(known.rotation);
                known.scale = edit.scale.or(known.scale);
            }
            Err(index) => last.nodes.insert(index, edit),
        }
    }
}

#[cfg(test)]
mod tests {
    use caustics::scene::Edits;

    use super::*;

    /// Interpolates the x of a node at a time, linearly between the keys that have it.
    fn x_at(keys: &[Keyframe], node: usize, time: f64) -> Option<f64> {
        let of_key = |key: &Keyframe| {
            let edit = key.nodes.iter().find(|edit| edit.node == node)?;
            Some((key.time, edit.translation?[0]))
        };
        let known: Vec<(f64, f64)> = keys.iter().filter_map(of_key).collect();
        let next = known.partition_point(|(at, _)| *at < time);
        let (after, before) = (known.get(next).or(known.last())?, &known[next.saturating_sub(1)]);
        let share =
            if after.0 > before.0 { ((time - before.0) / (after.0 - before.0)).min(1.0) } else { 1.0 };
        Some(before.1 + share * (after.1 - before.1))
    }

    fn camera(x: f64) -> CameraEdit {
        CameraEdit { from: [x, 1.0, 0.0], look_at: [0.0; 3], fov: 40.0 }
    }

    #[test]
    fn recorded_keys_play_the_recorded_motion() {
        let mut recording = Recording::default();
        let mut frames = Vec::new();
        let mut nodes = NodeEdits::new();
        for frame in 0..150_u32 {
            // Node 1 rests for 20 frames after frame 20. Node 2 appears at 50 and rests from 60 on. Node 3 always rests.
            let x = f64::from(if frame / 20 % 2 == 0 { frame } else { frame / 20 * 20 });
            let late = f64::from(frame.min(60));
            for (node, x) in [(1, Some(x)), (2, (frame >= 50).then_some(late)), (3, Some(7.0))] {
                let Some(x) = x else { continue };
                let rotation = Some([0.0, 0.0, 0.0, 1.0]);
                nodes.insert(node, NodeEdit { translation: Some([x, 0.0, 0.0]), rotation, ..edit_of(node) });
            }
            let time = 0.25 * f64::from(frame);
            recording.add(time, &nodes, Some(camera(1.0 + late)));
            frames.push(Keyframe {
                time,
                camera: Some(camera(1.0 + late)),
                nodes: nodes.values().cloned().collect(),
            });
        }
        let keys = recording.keys();
        for node in 1..=3 {
            for Keyframe { time, .. } in &frames {
                let [played, was] = [&keys, &frames].map(|keys| x_at(keys, node, *time));
                assert_eq!(played, was, "node {node} at {time} s");
            }
        }
        assert_eq!((keys.len(), keys.last().unwrap().time), (recording.len(), frames.last().unwrap().time));
        let edits = Edits { keys: keys.clone(), ..Edits::default() };
        assert_eq!(Edits::parse(&edits.to_toml().unwrap()).unwrap(), edits);
        // The rotation never changes, so only the first and the last key have it; the same holds for node 3.
        let with_rotation = keys.iter().flat_map(|key| &key.nodes).filter(|edit| edit.rotation.is_some());
        assert_eq!(with_rotation.filter(|edit| edit.node == 1).count(), 2);
        assert_eq!(keys.iter().flat_map(|key| &key.nodes).filter(|edit| edit.node == 3).count(), 2);
        assert_eq!(keys.iter().filter(|key| key.camera.is_some()).count(), 62);
    }

    #[test]
    fn nodes_that_rest_take_no_memory_and_nodes_that_move_little() {
        let all = |x: f64| -> NodeEdits {
            (0..900).map(|node| (node, NodeEdit { translation: Some([x; 3]), ..edit_of(node) })).collect()
        };
        let (mut recording, mut nodes) = (Recording::default(), all(0.0));
        for frame in 0..1000_u32 {
            nodes.get_mut(&450).unwrap().translation = Some([f64::from(frame); 3]);
            recording.add(f64::from(frame) / 60.0, &nodes, None);
        }
        assert!(!recording.is_full());
        assert_eq!(recording.keys().iter().map(values).sum::<usize>(), 1000 + 899);

        let mut recording = Recording::default();
        for frame in 0..200_u32 {
            recording.add(f64::from(frame) / 60.0, &all(f64::from(frame)), None);
        }
        let keys = recording.keys();
        let count: usize = keys.iter().map(values).sum();
        assert!(recording.is_full() && (MAX_VALUES..MAX_VALUES + 2 * 900).contains(&count), "{count}");
        assert!(keys.last().unwrap().time < 2.0, "it stays as it was");
    }
}
