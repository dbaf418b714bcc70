//! Fuzzing of shards: each is checked against the identity in its own head.

use std::path::Path;

use crate::checkpoint::{self, Head};
use crate::shard::Shard;
use caustics_files::sealed;

/// Reads a shard of any run and shape, as `merge` does.
pub fn shard(bytes: &[u8]) -> bool {
    super::accepts_as_is_or_sealed(bytes, accepts)
}

fn accepts(bytes: &[u8]) -> bool {
    let Ok(Ok(head)) = sealed::head::<Head>(checkpoint::KIND, bytes) else { return false };
    let shard = head.identity.get("shard").and_then(|text| Shard::parse(text));
    let frames = shard.and_then(|shard| shard.frames(0..head.shape.frames).ok());
    let shard = checkpoint::parse(Path::new("shard"), bytes, &head.identity, head.shape);
    frames.is_some()
        & shard.is_ok_and(|shard| {
            drop((shard.sums.mean(), shard.sums.variance(), shard.sums.relative_error()));
            true
        })
}
