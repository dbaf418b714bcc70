//! Animations of the file, as channels of its nodes.

use std::collections::BTreeMap;

use glam::{DVec4, Vec3};
use gltf::json::Index;
use serde_json::Value;

use super::document::Document;
use super::{accessor, unsupported};
use crate::SceneError;
use crate::animation::{Channel, Interpolation, Path};
use caustics_files::text::cut;

/// Channels by node of the animation that was asked for, else of all together; damaged ones are left out, with a warning.
pub fn read(document: &mut Document) -> Result<BTreeMap<usize, Vec<Channel>>, SceneError> {
    let mut channels: BTreeMap<usize, Vec<Channel>> = BTreeMap::new();
    let all = std::mem::take(&mut document.sections.animations);
    let asked = document.options.animation.clone();
    let plays = |animation: &&Value| asked.is_none() || animation["name"].as_str() == asked.as_deref();
    if let Some(animation) = asked.clone().filter(|_| !all.iter().any(|one| plays(&one))) {
        let names: Vec<&str> = all.iter().filter_map(|one| one["name"].as_str()).collect();
        let known = if names.is_empty() { "none with a name".into() } else { cut(&names.join(", "), 1000) };
        return Err(SceneError::UnknownAnimation { file: document.file.clone(), animation, known });
    }
    for (index, animation) in all.iter().enumerate().filter(|(_, animation)| plays(animation)) {
        let label = unsupported::label("animation", index, animation["name"].as_str());
        for (number, value) in list(&animation["channels"]).iter().enumerate() {
            let owner = format!("{label}, channel {number}");
            let read = match target(document, value, &owner) {
                Ok(None) => continue,
                Ok(Some((node, path))) => {
                    let sampler = position(&value["sampler"]);
                    let sampler = sampler.and_then(|sampler| list(&animation["samplers"]).get(sampler));
                    let sampler = sampler.ok_or_else(|| wrong(document, &owner, "has no sampler"));
                    sampler
                        .and_then(|sampler| read_channels(document, sampler, node, path, &owner))
                        .map(|read| (node, path, read))
                }
                Err(error) => Err(error),
            };
            let (node, path, read) = match read {
                Ok(read) => read,
                Err(error @ SceneError::Memory { .. }) => return Err(error),
                Err(error) => {
                    let what = fault(&error);
                    document.replace(&owner, &what, "left out", error)?;
                    continue;
                }
            };
            let of_node = channels.entry(node).or_default();
            if of_node.iter().any(|known| known.path == path) {
                document.warn(&owner, "another channel sets the same; the last one counts");
                of_node.retain(|known| known.path != path);
            }
            of_node.extend(read);
        }
    }
    Ok(channels)
}

fn wrong(document: &Document, owner: &str, what: impl std::fmt::Display) -> SceneError {
    SceneError::Animation { file: document.file.clone(), animation: owner.into(), what: what.to_string() }
}

/// What an error says of a channel, without its file and advice.
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

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn position(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

/// Node and part that a channel sets; none, with a warning, where it is not supported.
fn target(
    document: &mut Document,
    channel: &Value,
    owner: &str,
) -> Result<Option<(usize, Path)>, SceneError> {
    let target = &channel["target"];
    let path = match target["path"].as_str() {
        Some("translation") => Path::Translation,
        Some("rotation") => Path::Rotation,
        Some("scale") => Path::Scale,
        Some("weights") => Path::Weights,
        Some(path) => {
            let what = format!("animated {} is not supported; left out", cut(path, 80));
            document.warn(owner, what);
            return Ok(None);
        }
        None => return Err(wrong(document, owner, "has no target path")),
    };
    if target["node"].is_null() {
        document.warn(owner, "it moves no node; left out");
        return Ok(None);
    }
    let node =
        position(&target["node"]).ok_or_else(|| wrong(document, owner, "has a target that is no node"))?;
    let count = document.root.nodes.len();
    let Some(target) = document.root.nodes.get(node) else {
        let (file, owner) = (document.file.clone(), owner.into());
        return Err(SceneError::Index { file, owner, kind: "node", index: node, count });
    };
    if path == Path::Weights {
        if target_count(document, node) == 0 {
            document.warn(owner, "it weights morph targets that its node does not have; left out");
            return Ok(None);
        }
    } else if target.matrix.is_some() {
        return Err(wrong(document, owner, format!("moves node {node}, which is placed by a matrix")));
    }
    Ok(Some((node, path)))
}

/// Morph targets of a node's mesh.
fn target_count(document: &Document, node: usize) -> usize {
    let mesh = document.root.nodes.get(node).and_then(|node| document.root.meshes.get(node.mesh?.value()));
    let targets = mesh.and_then(|mesh| mesh.primitives.first()?.targets.as_ref());
    targets.map_or(0, Vec::len)
}

/// What a sampler sets of a node: weights take a channel for every four.
fn read_channels(
    document: &mut Document,
    sampler: &Value,
    node: usize,
    path: Path,
    owner: &str,
) -> Result<Vec<Channel>, SceneError> {
    let file = document.file.clone();
    let wrong = |what: String| SceneError::Animation { file: file.clone(), animation: owner.into(), what };
    let interpolation = match &sampler["interpolation"] {
        Value::Null => Interpolation::Linear,
        name => match name.as_str() {
            Some("STEP") => Interpolation::Step,
            Some("LINEAR") => Interpolation::Linear,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            _ => return Err(wrong(format!("has the interpolation {name}, which glTF does not know"))),
        },
    };
    let accessor_of = |key: &str| {
        let index = position(&sampler[key]).and_then(|index| u32::try_from(index).ok());
        index.map(Index::new).ok_or_else(|| wrong(format!("has no {key}")))
    };
    let (input, output) = (accessor_of("input")?, accessor_of("output")?);
    // Keys as they are read and as they are kept.
    let keys = accessor::count(document, input, owner)?;
    let values = accessor::count(document, output, owner)?;
    let bytes = keys.saturating_mul(12).saturating_add(values.saturating_mul(48));
    document.take(bytes, format_args!("{owner}"))?;
    let times: Vec<f32> = accessor::numbers(document, input, owner)?.into_iter().map(|[time]| time).collect();
    let targets = target_count(document, node);
    let values: Vec<Vec<DVec4>> = match path {
        Path::Weights => {
            let values: Vec<f64> = accessor::numbers(document, output, owner)?
                .into_iter()
                .map(|[x]: [f32; 1]| x.into())
                .collect();
            if !values.len().is_multiple_of(targets) {
                return Err(wrong(format!(
                    "has {} weights, no multiple of its {targets} targets",
                    values.len()
                )));
            }
            let four = |first: usize| {
                let of_key = |key: &[f64]| {
                    DVec4::from(std::array::from_fn(|at| key.get(first + at).copied().unwrap_or(0.0)))
                };
                values.chunks(targets).map(of_key).collect()
            };
            (0..targets).step_by(4).map(four).collect()
        }
        Path::Rotation => {
            let values = accessor::numbers::<4>(document, output, owner)?;
            vec![values.into_iter().map(|value| DVec4::from(value.map(f64::from))).collect()]
        }
        _ => {
            let values = accessor::numbers::<3>(document, output, owner)?;
            vec![values.into_iter().map(|value| Vec3::from(value).as_dvec3().extend(0.0)).collect()]
        }
    };

    let is_spline = interpolation == Interpolation::Cubic;
    let wanted = times.len() * if is_spline { 3 } else { 1 };
    if times.is_empty() {
        return Err(wrong("has no keys".into()));
    }
    if !times.iter().all(|time| (0.0..=1e9).contains(time)) {
        return Err(wrong("has a time that is negative, beyond 1e9 s or not a number".into()));
    }
    if let Some(key) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(wrong(format!("has times that do not ascend (key {})", key + 1)));
    }
    for values in &values {
        if values.len() != wanted {
            let (keys, values) = (times.len(), values.len());
            return Err(wrong(format!("has {values} values for {keys} keys, but {wanted} are needed")));
        }
        let usable = |value: &DVec4| value.is_finite() && value.abs().max_element() <= 1e30;
        if let Some(id) = values.iter().position(|value| !usable(value)) {
            return Err(wrong(format!("has a value that is not finite or beyond 1e30 (value {id})")));
        }
        let keys = values.iter().skip(usize::from(is_spline)).step_by(if is_spline { 3 } else { 1 });
        if path == Path::Rotation
            && let Some(key) = keys.into_iter().position(|value| value.length() <= 1e-6)
        {
            return Err(wrong(format!("has a rotation of no length (key {key})")));
        }
    }
    let times: Vec<f64> = times.into_iter().map(f64::from).collect();
    let channel = |values| Channel { path, interpolation, times: times.clone(), values };
    Ok(values.into_iter().map(channel).collect())
}
