//! Animations of the file, as channels of its nodes.

use std::collections::BTreeMap;

use self::keys::KeyReader;
use crate::SceneError;
use crate::animation::{Channel, Path};
use crate::gltf::context::{ImportContext, label};
use crate::gltf::document::Document;
use crate::gltf::document::sections::{JsonAnimation, JsonChannel};
use caustics_files::text::cut;

mod keys;

/// Channels by the index of their node.
type NodeChannels = BTreeMap<usize, Vec<Channel>>;

/// Reads the channels of the animation that the caller names, or of all together. Damaged channels are left out with a warning.
pub fn read(document: &Document, context: &mut ImportContext<'_>) -> Result<NodeChannels, SceneError> {
    let mut channels = NodeChannels::new();
    for (index, animation) in playing(document, context)? {
        let label = label("animation", index, animation.name.as_deref());
        for (number, channel) in animation.channels.iter().enumerate() {
            let owner = format!("{label}, channel {number}");
            match read_channel(document, context, animation, channel, &owner) {
                Ok(None) => {}
                Ok(Some((node, read))) => add(channels.entry(node).or_default(), read, context, &owner),
                Err(error @ SceneError::Memory { .. }) => return Err(error),
                Err(error) => context.replace(&owner, &fault(&error), "left out", error)?,
            }
        }
    }
    Ok(channels)
}

/// Animations that play, with their indices.
fn playing<'a>(
    document: &'a Document,
    context: &ImportContext<'_>,
) -> Result<Vec<(usize, &'a JsonAnimation)>, SceneError> {
    let all = &document.sections.animations;
    let Some(name) = &context.options.animation else { return Ok(all.iter().enumerate().collect()) };
    let is_named = |animation: &JsonAnimation| animation.name.as_ref() == Some(name);
    if !all.iter().any(is_named) {
        let names: Vec<&str> = all.iter().filter_map(|animation| animation.name.as_deref()).collect();
        let known = if names.is_empty() { "none with a name".into() } else { cut(&names.join(", "), 1000) };
        let (file, animation) = (context.file.into(), name.clone());
        return Err(SceneError::UnknownAnimation { file, animation, known });
    }
    Ok(all.iter().enumerate().filter(|(_, animation)| is_named(animation)).collect())
}

/// Adds the channels of one member to a node, in place of earlier channels of this member.
fn add(node: &mut Vec<Channel>, read: Vec<Channel>, context: &mut ImportContext<'_>, owner: &str) {
    let is_set = |known: &Channel| read.iter().any(|channel| channel.path == known.path);
    if node.iter().any(is_set) {
        context.warn(owner, "another channel sets the same; the last one counts");
        node.retain(|known| !is_set(known));
    }
    node.extend(read);
}

/// Fault of a channel: the text of its error without the file and the advice.
fn fault(error: &SceneError) -> String {
    match error {
        SceneError::Animation { what, .. } => what.clone(),
        SceneError::Accessor { accessor, what, .. } => format!("accessor {accessor} {what}"),
        SceneError::Index { kind, index, count, .. } => {
            format!("refers to {kind} {index}, but there are {count}")
        }
        error => error.to_string(),
    }
}

/// Reads a channel: its node, and its keys; weights give a channel for every four. `None`, with a warning, if it is not
/// supported.
fn read_channel(
    document: &Document,
    context: &mut ImportContext<'_>,
    animation: &JsonAnimation,
    channel: &JsonChannel,
    owner: &str,
) -> Result<Option<(usize, Vec<Channel>)>, SceneError> {
    let Some((node, path)) = target(document, context, channel, owner)? else { return Ok(None) };
    let sampler = channel.sampler.and_then(|sampler| animation.samplers.get(sampler));
    let sampler = sampler.ok_or_else(|| context.animation_error(owner, "has no sampler"))?;
    let keys = KeyReader { document, sampler, path, targets: target_count(document, node), owner };
    Ok(Some((node, keys.read(context)?)))
}

/// Node and member that a channel sets; `None`, with a warning, if it is not supported.
fn target(
    document: &Document,
    context: &mut ImportContext<'_>,
    channel: &JsonChannel,
    owner: &str,
) -> Result<Option<(usize, Path)>, SceneError> {
    let path = match channel.target.path.as_deref() {
        Some("translation") => Path::Translation,
        Some("rotation") => Path::Rotation,
        Some("scale") => Path::Scale,
        Some("weights") => Path::Weights,
        Some(path) => {
            let what = format!("animated {} is not supported; left out", cut(path, 80));
            context.warn(owner, what);
            return Ok(None);
        }
        None => return Err(context.animation_error(owner, "has no target path")),
    };
    let Some(node) = channel.target.node else {
        context.warn(owner, "it moves no node; left out");
        return Ok(None);
    };
    let nodes = &document.root.nodes;
    let Some(target) = nodes.get(node) else {
        return Err(context.index_error(owner, "node", node, nodes.len()));
    };
    if path == Path::Weights {
        if target_count(document, node) == 0 {
            context.warn(owner, "it weights morph targets that its node does not have; left out");
            return Ok(None);
        }
    } else if target.matrix.is_some() {
        let what = format!("moves node {node}, which is placed by a matrix");
        return Err(context.animation_error(owner, what));
    }
    Ok(Some((node, path)))
}

/// Number of morph targets of a node's mesh.
fn target_count(document: &Document, node: usize) -> usize {
    let mesh = document.root.nodes.get(node).and_then(|node| document.root.meshes.get(node.mesh?.value()));
    let targets = mesh.and_then(|mesh| mesh.primitives.first()?.targets.as_ref());
    targets.map_or(0, Vec::len)
}
