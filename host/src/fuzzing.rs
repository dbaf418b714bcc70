//! Entry points of the fuzz targets in `fuzz/`, and of the test that replays their corpus. Each function parses bytes and
//! returns whether they are accepted. Not a public interface.

use std::path::Path;

use caustics_kernels::interface::triangle::Triangle;
use glam::Vec3;

use crate::accumulation::Shape;
use crate::checkpoint::{self, Checkpoint, Identity};
use caustics_files::image_file::Channels;
use caustics_files::sealed;
use caustics_scene::{Edits, Viewpoint};

mod compressed;
mod shard;

pub use compressed::{draco, environment, ktx2, meshopt, webp};
pub use shard::shard;

/// Reads a .gltf or .glb file without external files, computes its features and poses it up to the end of its animations.
/// It adds no default light, which takes a third of a second for any file.
pub fn scene(bytes: &[u8]) -> bool {
    caustics_scene::read(bytes).is_ok_and(|mut scene| {
        drop(scene.place_camera(&Viewpoint::default(), 1.5).cloned());
        scene.features(0.25);
        let end = scene.duration();
        scene.pose(0.5 * end).is_ok() & scene.pose(end).is_ok()
    })
}

/// Decodes an EXR or PNG file.
pub fn image(bytes: &[u8]) -> bool {
    Channels::decode(bytes).is_ok_and(|image| {
        // `layer` must find every listed name. The beauty layer itself has an empty name.
        let is_known = |name: &String| name == "beauty" || image.layer(name).is_some();
        assert!(image.layer_names().iter().all(is_known));
        true
    })
}

/// Parses a checkpoint of 2 pixels, of a run with an empty identity.
pub fn checkpoint(bytes: &[u8]) -> bool {
    let shape = Shape { width: 2, height: 1, ..Shape::default() };
    let accepts = |bytes: &[u8]| {
        let path = Path::new("checkpoint");
        checkpoint::parse(path, bytes, &Identity::default(), shape).is_ok_and(
            |Checkpoint { sums, .. }| {
                drop((sums.mean(), sums.variance(), sums.relative_error()));
                true
            },
        )
    };
    accepts_as_is_or_sealed(bytes, accepts)
}

/// Whether a parser accepts bytes as they are, or sealed with this program's line and the right checksum. Random bytes
/// hardly ever have a right checksum. Sealed bytes are a line of JSON for the head, then sums.
fn accepts_as_is_or_sealed(bytes: &[u8], accepts: impl Fn(&[u8]) -> bool) -> bool {
    let (head, sums) = match bytes.iter().position(|&byte| byte == b'\n') {
        Some(end) => (&bytes[..end], &bytes[end + 1..]),
        None => (bytes, &[][..]),
    };
    let head: Option<serde_json::Value> = serde_json::from_slice(head).ok();
    let sealed = head.and_then(|head| sealed::seal(checkpoint::KIND, &head, |bytes| bytes.extend(sums)).ok());
    accepts(bytes) | sealed.is_some_and(|bytes| accepts(&bytes))
}

/// Parses a file of the BVH cache for fixed triangles, as it is and with the right key and checksum around it. The bytes
/// then are the numbers of nodes and leaves, triangles, leaves and nodes.
pub fn bvh(bytes: &[u8]) -> bool {
    const TRIANGLES: u8 = 16;
    let corner = |id: u8, at: u8| Vec3::new(f32::from(id), f32::from(at), f32::from(id * at));
    let triangle = |id| Triangle { a: corner(id, 0), b: corner(id, 1), c: corner(id, 2) };
    let triangles: Vec<Triangle> = (0..TRIANGLES).map(triangle).collect();
    let accepts = |bytes: &[u8]| caustics_scene::accepts_bvh(bytes, &triangles);
    let sealed = bytes.split_first_chunk().and_then(|(&[nodes, leaves], payload)| {
        caustics_scene::sealed_bvh(&triangles, nodes.into(), leaves.into(), payload).ok()
    });
    accepts(bytes) | sealed.is_some_and(|bytes| accepts(&bytes))
}

/// Parses the TOML of edits. Edits that are written must be read back unchanged.
pub fn edits(bytes: &[u8]) -> bool {
    let edits = std::str::from_utf8(bytes).ok().and_then(|text| Edits::parse(text).ok());
    edits.is_some_and(|edits| {
        let text = edits.to_toml().unwrap_or_default();
        assert!(Edits::parse(&text).is_ok_and(|again| again == edits), "{text}");
        true
    })
}
