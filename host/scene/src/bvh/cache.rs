//! Cache of BVHs on disk: a scene that is opened again need not build its BVH again.
//!
//! The name of a file is the BLAKE3 of its triangles. Its content is not trusted: a BVH that is not sound is ignored, and boxes
//! are computed from the scene's triangles. Therefore no file can make a ray miss a triangle.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use bytemuck::{cast_slice, pod_collect_to_vec};
use caustics_kernels::interface::triangle::Triangle;
use serde::{Deserialize, Serialize};

use super::plan::WIDTH;
use super::{Bvh, BvhQuality, Shape};
use caustics_files::file;
use caustics_files::hash::Digest;
use caustics_files::sealed;

/// Kind of file, in its first line.
const KIND: &str = "bvh";
/// Prefix of the files' names.
const PREFIX: &str = "bvh-";
/// Minimum number of triangles of a cached BVH; it takes about 0.05 s to build.
const WORTH: usize = 1 << 16;
/// Default size limit of all files together (MiB).
const DEFAULT_MIB: u64 = 1024;
/// The crate that reinserts nodes; its versions may build different BVHs.
const BUILDER: &str = "obvhs 0.4.0";
/// Version of `clustering.rs`. Raise it when the builder gives different BVHs.
const CLUSTERING: u32 = 1;
/// Maximum size of a file's header (bytes).
const MAX_HEAD: u64 = 1 << 16;
/// Maximum bytes a triangle, with its share of the nodes: each node but the root of a single triangle has two children.
const MAX_TRIANGLE: u64 = (size_of::<u32>() + size_of::<u8>() + size_of::<[u32; WIDTH]>()) as u64;
/// Limit of the expected number of boxes that a ray enters in a cached BVH: this number and [`MAX_SHARE`] of the leaves. With
/// triangles in random order it is a tenth of all. A BVH above the limit is built each time.
const MAX_BOXES: f64 = 256.0;
/// Share of the leaves; see [`MAX_BOXES`].
const MAX_SHARE: f64 = 1.0 / 64.0;

/// A folder of BVHs, by the hash of their triangles. Files appear complete; damaged files and those of other programs are ignored.
/// A folder that cannot be read or written is no error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BvhCache {
    /// The folder; it is created when the first BVH is stored.
    pub folder: PathBuf,
    /// Maximum size of all files together (bytes). The least recently used files are removed first.
    pub max_bytes: u64,
}

/// All inputs that decide a BVH.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct BvhCacheKey {
    /// BLAKE3 of the triangles.
    triangles: String,
    count: usize,
    levels: u32,
    quality: BvhQuality,
    builder: String,
}

#[derive(Serialize, Deserialize)]
struct Head {
    key: BvhCacheKey,
    nodes: usize,
    leaves: usize,
}

impl BvhCacheKey {
    pub(super) fn new(triangles: &[Triangle], levels: u32, quality: BvhQuality) -> BvhCacheKey {
        let builder = format!("clustering {CLUSTERING}, {BUILDER}");
        let (digest, count) = (Digest::hex([cast_slice(triangles)]), triangles.len());
        BvhCacheKey { triangles: digest, count, levels, quality, builder }
    }

    fn file_name(&self) -> String {
        let quality = format!("{:?}", self.quality).to_lowercase();
        format!("{PREFIX}{}-{}-{quality}.bin", self.triangles, self.levels)
    }
}

impl BvhCache {
    /// Returns the user's cache: `bvh` in `$CAUSTICS_CACHE`, `$XDG_CACHE_HOME/caustics` or `~/.cache/caustics`.
    /// `$CAUSTICS_BVH_CACHE_MIB` limits its size. `None` if that is 0, or if no such folder exists.
    pub fn for_user() -> Option<BvhCache> {
        let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
        let path = |name| set(name).map(PathBuf::from);
        let mib =
            set("CAUSTICS_BVH_CACHE_MIB").and_then(|mib| mib.to_str()?.parse().ok()).unwrap_or(DEFAULT_MIB);
        let cache = path("CAUSTICS_CACHE")
            .or_else(|| Some(path("XDG_CACHE_HOME")?.join("caustics")))
            .or_else(|| Some(path("HOME")?.join(".cache/caustics")))?;
        (mib > 0).then(|| BvhCache { folder: cache.join("bvh"), max_bytes: mib.saturating_mul(1 << 20) })
    }

    /// Returns the BVH of these triangles: from the cache, or built by `build`.
    pub(super) fn bvh(
        &self,
        triangles: &[Triangle],
        levels: u32,
        quality: BvhQuality,
        build: impl FnOnce() -> Shape,
    ) -> Bvh {
        if triangles.len() < WORTH {
            return build().bvh(triangles);
        }
        let key = BvhCacheKey::new(triangles, levels, quality);
        self.find(&key, triangles).unwrap_or_else(|| {
            let shape = build();
            let bvh = shape.clone().bvh(triangles);
            if is_quick(&bvh) {
                let _ = self.keep(key, &shape);
            }
            bvh
        })
    }

    /// Returns the cached BVH of a key and its triangles, if it is usable.
    fn find(&self, key: &BvhCacheKey, triangles: &[Triangle]) -> Option<Bvh> {
        let file = file::open(&self.folder.join(key.file_name())).ok()?;
        let limit = MAX_HEAD + MAX_TRIANGLE * key.count as u64;
        let bytes = file::read_open(&file, limit + 1).ok().filter(|bytes| bytes.len() as u64 <= limit)?;
        let bvh = parse(&bytes, key, triangles)?;
        // Mark the file as used, so that it is not removed first.
        let _ = file.set_modified(SystemTime::now());
        Some(bvh)
    }

    /// Writes a BVH, and removes other files above the size limit.
    fn keep(&self, key: BvhCacheKey, shape: &Shape) -> std::io::Result<()> {
        let name = key.file_name();
        let parts = shape.parts();
        if parts.iter().map(|part| part.len() as u64).sum::<u64>() > self.max_bytes {
            return Ok(());
        }
        let head = Head { key, nodes: shape.children.len(), leaves: shape.counts.len() };
        std::fs::create_dir_all(&self.folder)?;
        let file = tempfile::Builder::new().prefix(PREFIX).tempfile_in(&self.folder)?;
        sealed::write(KIND, &head, file.as_file(), |to| {
            parts.iter().try_for_each(|part| to.write_all(part))
        })?;
        file.persist(self.folder.join(name))?;
        self.tidy(&self.folder)
    }

    /// Removes the least recently used files above the size limit.
    fn tidy(&self, folder: &Path) -> std::io::Result<()> {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            if entry.file_name().to_string_lossy().starts_with(PREFIX) {
                let about = entry.metadata()?;
                files.push((about.modified()?, about.len(), entry.path()));
            }
        }
        files.sort();
        let mut all = 0;
        for (_, bytes, path) in files.into_iter().rev() {
            all += bytes;
            if all > self.max_bytes {
                std::fs::remove_file(path)?;
            }
        }
        Ok(())
    }
}

impl Shape {
    /// Its arrays in the order of the file.
    fn parts(&self) -> [&[u8]; 3] {
        [cast_slice(&self.order), &self.counts, cast_slice(&self.children)]
    }
}

/// Whether rays enter few enough of its boxes. Slow BVHs are not stored, and a file crafted to be slow is not used.
fn is_quick(bvh: &Bvh) -> bool {
    bvh.expected_boxes() <= MAX_BOXES + MAX_SHARE * bvh.blocks.len() as f64
}

/// Bytes of triangles, leaves and nodes in a file.
fn size(triangles: usize, leaves: usize, nodes: usize) -> Option<usize> {
    let nodes = size_of::<[u32; WIDTH]>().checked_mul(nodes)?;
    size_of::<u32>().checked_mul(triangles)?.checked_add(leaves)?.checked_add(nodes)
}

/// Parses the BVH of these triangles from the bytes of a file. The key must match, and the BVH must be sound and quick.
fn parse(bytes: &[u8], key: &BvhCacheKey, triangles: &[Triangle]) -> Option<Bvh> {
    let (Head { key: theirs, nodes, leaves }, payload) = sealed::open(KIND, bytes).ok()?;
    if theirs != *key || size(key.count, leaves, nodes) != Some(payload.len()) {
        return None;
    }
    let (order, rest) = payload.split_at(size(key.count, 0, 0)?);
    let (counts, children) = rest.split_at(leaves);
    let shape = Shape {
        children: pod_collect_to_vec(children),
        counts: counts.into(),
        order: pod_collect_to_vec(order),
    };
    let bvh = shape.is_sound(triangles.len(), key.levels).then(|| shape.bvh(triangles))?;
    is_quick(&bvh).then_some(bvh)
}

/// Whether the bytes of a file are a BVH of these triangles.
pub fn accepts(bytes: &[u8], triangles: &[Triangle]) -> bool {
    parse(bytes, &BvhCacheKey::new(triangles, super::LEVELS, BvhQuality::default()), triangles).is_some()
}

/// A file with the right key and checksum for [`accepts`], with any content.
pub fn sealed_file(
    triangles: &[Triangle],
    nodes: usize,
    leaves: usize,
    payload: &[u8],
) -> std::io::Result<Vec<u8>> {
    let key = BvhCacheKey::new(triangles, super::LEVELS, BvhQuality::default());
    sealed::seal(KIND, &Head { key, nodes, leaves }, |bytes| bytes.extend(payload))
}

#[cfg(test)]
mod tests;
