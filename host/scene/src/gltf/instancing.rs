//! EXT_mesh_gpu_instancing: many instances of a node's mesh.

use glam::{DQuat, DVec3};
use gltf::json::Index;
use gltf::json::accessor::Accessor;

use super::accessor;
use super::document::Document;
use crate::SceneError;
use crate::animation::Local;

/// Memory that an instance takes until its triangles are made (bytes): its transform and its name.
const INSTANCE_BYTES: u64 = 1024;
/// Memory that one takes that moves (bytes): its node too, its row, and its leaf of the BVH. Measured as the growth of the peak of
/// `scene info` with instances: 1,960.
const MOVING_BYTES: u64 = 2304;

/// Transforms of the instances of a node's mesh, in the node's space; `None` without the extension. Each one that moves takes `of_node` more bytes, as
/// its node does.
pub fn read(
    document: &mut Document,
    node: usize,
    owner: &str,
    of_node: Option<u64>,
) -> Result<Option<Vec<Local>>, SceneError> {
    let Some(attributes) = document.sections.instancing.get(&node) else { return Ok(None) };
    let accessor = |name: &str| {
        let index = attributes[name].as_u64().and_then(|index| u32::try_from(index).ok());
        index.map(Index::<Accessor>::new)
    };
    let (translations, rotations, scales) =
        (accessor("TRANSLATION"), accessor("ROTATION"), accessor("SCALE"));
    let mut count = None;
    for index in [translations, rotations, scales].into_iter().flatten() {
        let of_this = accessor::count(document, index, owner)?;
        if *count.get_or_insert(of_this) != of_this {
            let what = "has not as many translations, rotations and scales of its instances".into();
            return Err(SceneError::Node { file: document.file.clone(), node: owner.into(), what });
        }
    }
    let count = count.unwrap_or(0);
    let each = of_node.map_or(INSTANCE_BYTES, |bytes| MOVING_BYTES.saturating_add(bytes));
    document.take(count.saturating_mul(each), format_args!("the {count} instances of {owner}"))?;
    let translations =
        translations.map(|index| accessor::numbers::<3>(document, index, owner)).transpose()?;
    let rotations = rotations.map(|index| accessor::numbers::<4>(document, index, owner)).transpose()?;
    let scales = scales.map(|index| accessor::numbers::<3>(document, index, owner)).transpose()?;
    let vector = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
    let local = |id: usize| Local {
        translation: translations.as_ref().map_or(DVec3::ZERO, |all| vector(all[id])),
        rotation: DQuat::from_array(
            rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[id].map(f64::from)),
        ),
        scale: scales.as_ref().map_or(DVec3::ONE, |all| vector(all[id])),
        ..Local::default()
    };
    Ok(Some((0..count as usize).map(local).collect()))
}
