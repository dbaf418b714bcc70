//! Shards of a run, by what they say of themselves.

use std::path::Path;

use crate::checkpoint::{self, Head};
use crate::sealed;
use crate::shard::Shard;

/// A shard of any run and shape, as `merge` reads it; and, since hardly any bytes have the right checksum, what they are with it:
/// a line of JSON, the head, and sums.
pub fn shard(bytes: &[u8]) -> bool {
    let end = bytes.iter().position(|&byte| byte == b'\n').unwrap_or(bytes.len());
    let (head, sums) = bytes.split_at(end);
    let head: Option<serde_json::Value> = serde_json::from_slice(head).ok();
    let sealed = head.and_then(|head| {
        sealed::seal(checkpoint::KIND, &head, |bytes| bytes.extend(sums.iter().skip(1))).ok()
    });
    accepts(bytes) | sealed.is_some_and(|bytes| accepts(&bytes))
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
