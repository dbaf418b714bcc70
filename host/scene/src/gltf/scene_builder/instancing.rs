//! EXT_mesh_gpu_instancing: many instances of a node's mesh.

use glam::{DQuat, DVec3};

use crate::SceneError;
use crate::animation::Local;
use crate::gltf::accessor::AccessorReader;
use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;

/// Temporary memory of an instance, until its triangles are made (bytes): its transform and its name.
const INSTANCE_BYTES: u64 = 1024;
/// Memory of a moving instance (bytes): also its node, its record, and its leaf of the BVH. Measured as the growth of the peak
/// memory of `scene info` with instances: 1,960.
const MOVING_BYTES: u64 = 2304;

/// Reads the transforms of the instances of a node's mesh, in the node's space; `None` without the extension. An instance that
/// moves takes `of_node` more bytes, like its node.
pub fn read(
    document: &Document,
    context: &mut ImportContext<'_>,
    node: usize,
    owner: &str,
    of_node: Option<u64>,
) -> Result<Option<Vec<Local>>, SceneError> {
    let Some(attributes) = document.sections.instances.get(&node) else { return Ok(None) };
    let accessors = AccessorReader::new(document, context, owner);

    // Reserve memory
    let mut count = None;
    for index in [attributes.translation, attributes.rotation, attributes.scale].into_iter().flatten() {
        let of_this = accessors.count(index)?;
        if *count.get_or_insert(of_this) != of_this {
            let what = "has not as many translations, rotations and scales of its instances";
            return Err(context.node_error(owner, what));
        }
    }
    let count = count.unwrap_or(0);
    let each = of_node.map_or(INSTANCE_BYTES, |bytes| MOVING_BYTES.saturating_add(bytes));
    context.take(count.saturating_mul(each), format_args!("the {count} instances of {owner}"))?;

    // Read transforms
    let translations = attributes.translation.map(|index| accessors.numbers::<3>(index)).transpose()?;
    let rotations = attributes.rotation.map(|index| accessors.numbers::<4>(index)).transpose()?;
    let scales = attributes.scale.map(|index| accessors.numbers::<3>(index)).transpose()?;
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
