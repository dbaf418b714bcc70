//! Trees on disk: who opens a scene again need not build its tree again.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use bytemuck::{cast_slice, pod_collect_to_vec};
use caustics_kernels::interface::tree::TreeNode;
use caustics_kernels::interface::triangle::Triangle;
use serde::{Deserialize, Serialize};

use super::{Shape, TreeQuality};
use crate::hash::of_many;
use crate::sealed;

/// What a file of a tree is called in its first line.
const KIND: &str = "tree";
/// How names of such files begin.
const PREFIX: &str = "tree-";
/// Triangles from which on a tree is kept: it takes some 0.05 s to build.
const WORTH: usize = 1 << 16;
/// What all files may take unless somebody says otherwise (MiB).
const USUAL_MIB: u64 = 1024;
/// The crate that the trees are built with, whose versions may build different ones.
const BUILDER: &str = "obvhs 0.4.0";

/// A folder of trees by what they are of. Its files appear whole; one that is damaged, or of another program, is as none. Not
/// being able to read or write is no error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeCache {
    /// The folder; it is made when the first tree is kept.
    pub folder: PathBuf,
    /// What its files may take together (bytes); those that were not used for longest go.
    pub most_bytes: u64,
}

/// All that decides a tree.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Key {
    /// A hash of the triangles.
    triangles: String,
    count: usize,
    levels: u32,
    quality: TreeQuality,
    builder: String,
}

#[derive(Serialize, Deserialize)]
struct Head {
    key: Key,
    nodes: usize,
    leaves: usize,
}

impl Key {
    pub(super) fn of(triangles: &[Triangle], levels: u32, quality: TreeQuality) -> Key {
        let (hash, count) = (of_many(cast_slice(triangles)), triangles.len());
        Key { triangles: hash, count, levels, quality, builder: BUILDER.into() }
    }

    fn file_name(&self) -> String {
        let quality = format!("{:?}", self.quality).to_lowercase();
        format!("{PREFIX}{}-{}-{quality}.bin", self.triangles, self.levels)
    }
}

impl TreeCache {
    /// That of this user: `trees` in `$CAUSTICS_CACHE`, `$XDG_CACHE_HOME/caustics` or `~/.cache/caustics`, of at most
    /// `$CAUSTICS_TREES_MIB`; none where that is 0, or where there is no such folder to be had.
    pub fn of_user() -> Option<TreeCache> {
        let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
        let path = |name| set(name).map(PathBuf::from);
        let mib = set("CAUSTICS_TREES_MIB").and_then(|mib| mib.to_str()?.parse().ok()).unwrap_or(USUAL_MIB);
        let cache = path("CAUSTICS_CACHE")
            .or_else(|| Some(path("XDG_CACHE_HOME")?.join("caustics")))
            .or_else(|| Some(path("HOME")?.join(".cache/caustics")))?;
        (mib > 0).then(|| TreeCache { folder: cache.join("trees"), most_bytes: mib.saturating_mul(1 << 20) })
    }

    /// The tree of these triangles, built by `build` unless it is there.
    pub(super) fn shape(
        &self,
        triangles: &[Triangle],
        levels: u32,
        quality: TreeQuality,
        build: impl FnOnce() -> Shape,
    ) -> Shape {
        if triangles.len() < WORTH {
            return build();
        }
        let key = Key::of(triangles, levels, quality);
        self.find(&key).unwrap_or_else(|| {
            let shape = build();
            let _ = self.keep(key, &shape);
            shape
        })
    }

    /// The tree of a key, if it is there and whole.
    pub(super) fn find(&self, key: &Key) -> Option<Shape> {
        let path = self.folder.join(key.file_name());
        let bytes = std::fs::read(&path).ok()?;
        let (head, payload): (Head, _) = sealed::open(KIND, &bytes).ok()?;
        let sizes =
            [size_of::<u32>() * key.count, head.leaves, size_of::<TreeNode>().checked_mul(head.nodes)?];
        let (order, rest) = payload.split_at_checked(sizes[0])?;
        let (counts, nodes) = rest.split_at_checked(sizes[1])?;
        if head.key != *key || nodes.len() != sizes[2] {
            return None;
        }
        // So that it is not among those that go first.
        let _ =
            std::fs::File::options().append(true).open(&path).and_then(|f| f.set_modified(SystemTime::now()));
        Some(Shape {
            nodes: pod_collect_to_vec(nodes),
            counts: counts.into(),
            order: pod_collect_to_vec(order),
        })
    }

    /// Writes a tree, and removes others as far as there is no room for all.
    pub(super) fn keep(&self, key: Key, shape: &Shape) -> std::io::Result<()> {
        let name = key.file_name();
        let head = Head { key, nodes: shape.nodes.len(), leaves: shape.counts.len() };
        let parts: [&[u8]; 3] = [cast_slice(&shape.order), &shape.counts, cast_slice(&shape.nodes)];
        if parts.iter().map(|part| part.len() as u64).sum::<u64>() > self.most_bytes {
            return Ok(());
        }
        std::fs::create_dir_all(&self.folder)?;
        let file = tempfile::Builder::new().prefix(PREFIX).tempfile_in(&self.folder)?;
        sealed::write(KIND, &head, file.as_file(), |to| {
            parts.iter().try_for_each(|part| to.write_all(part))
        })?;
        file.persist(self.folder.join(name))?;
        self.tidy(&self.folder)
    }

    /// Removes what was not used for longest, as far as all takes too much.
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
            if all > self.most_bytes {
                std::fs::remove_file(path)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::soup;
    use super::*;
    use crate::scene::tree::LEVELS;

    fn cache(most_bytes: u64) -> (tempfile::TempDir, TreeCache) {
        let folder = tempfile::tempdir().unwrap();
        let cache = TreeCache { folder: folder.path().join("trees"), most_bytes };
        (folder, cache)
    }

    fn made(triangles: &[Triangle]) -> Shape {
        super::super::shape(triangles, LEVELS, TreeQuality::Fast)
    }

    fn key(triangles: &[Triangle]) -> Key {
        Key::of(triangles, LEVELS, TreeQuality::Fast)
    }

    fn files(cache: &TreeCache) -> Vec<PathBuf> {
        std::fs::read_dir(&cache.folder).map_or(vec![], |all| all.map(|file| file.unwrap().path()).collect())
    }

    #[test]
    fn what_was_kept_is_found_and_nothing_else() {
        let (_folder, cache) = cache(1 << 30);
        let triangles = soup(WORTH as u32, 0.01);
        let get = |triangles: &[Triangle], build: &dyn Fn() -> Shape| {
            cache.shape(triangles, LEVELS, TreeQuality::Fast, build)
        };
        let built = get(&triangles, &|| made(&triangles));
        assert_eq!(files(&cache).len(), 1);
        assert_eq!(get(&triangles, &|| panic!("it is there")), built);

        // A corner that is elsewhere by one bit, other levels, another quality.
        let mut others = triangles.clone();
        others[WORTH / 2].b.y = others[WORTH / 2].b.y.next_up();
        let mark = Shape { counts: vec![7], ..Shape::default() };
        assert_eq!(get(&others, &|| mark.clone()), mark);
        assert!(cache.find(&Key::of(&triangles, LEVELS - 1, TreeQuality::Fast)).is_none());
        assert!(cache.find(&Key::of(&triangles, LEVELS, TreeQuality::Best)).is_none());

        // What is built in no time is not kept.
        let few = soup(100, 0.1);
        get(&few, &|| made(&few));
        assert_eq!(files(&cache).len(), 2);
    }

    #[test]
    fn a_file_that_is_damaged_or_foreign_is_as_none() {
        let (_folder, cache) = cache(1 << 30);
        let [one, other] = [soup(500, 0.1), soup(501, 0.1)];
        cache.keep(key(&one), &made(&one)).unwrap();
        let path = cache.folder.join(key(&one).file_name());
        let whole = std::fs::read(&path).unwrap();
        for at in [0, 20, whole.len() / 2, whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[at] ^= 4;
            std::fs::write(&path, damaged).unwrap();
            assert!(cache.find(&key(&one)).is_none(), "byte {at}");
        }
        std::fs::write(&path, &whole[..whole.len() - 9]).unwrap();
        assert!(cache.find(&key(&one)).is_none());
        std::fs::write(&path, &whole).unwrap();
        assert!(cache.find(&key(&one)).is_some());
        // Whole, but of other triangles, or of fewer nodes than it says.
        std::fs::rename(&path, cache.folder.join(key(&other).file_name())).unwrap();
        assert!(cache.find(&key(&other)).is_none());
        let head = Head { key: key(&one), nodes: 3, leaves: 1 };
        std::fs::write(&path, sealed::seal(KIND, &head, |_| ()).unwrap()).unwrap();
        assert!(cache.find(&key(&one)).is_none());
    }

    #[test]
    fn what_was_not_used_for_longest_goes_when_there_is_no_room() {
        let (_folder, mut cache) = cache(1 << 30);
        let all = [300, 301, 302].map(|count| soup(count, 0.1));
        let age = |of: usize, cache: &TreeCache, seconds: u64| {
            let file =
                std::fs::File::options().append(true).open(cache.folder.join(key(&all[of]).file_name()));
            file.unwrap()
                .set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds))
                .unwrap();
        };
        for (of, triangles) in all[..2].iter().enumerate() {
            cache.keep(key(triangles), &made(triangles)).unwrap();
            age(of, &cache, 10 + of as u64);
        }
        // The older one is used: it is no longer that.
        assert!(cache.find(&key(&all[0])).is_some());
        cache.most_bytes = 5 * std::fs::metadata(&files(&cache)[0]).unwrap().len() / 2;
        cache.keep(key(&all[2]), &made(&all[2])).unwrap();
        assert_eq!(all.each_ref().map(|of| cache.find(&key(of)).is_some()), [true, false, true]);
        // One that has no room alone is not kept, and takes no other's.
        cache.most_bytes = 100;
        cache.keep(key(&all[1]), &made(&all[1])).unwrap();
        assert_eq!(files(&cache).len(), 2);
    }

    #[test]
    fn the_builder_is_that_of_the_lock_file() {
        let lock = include_str!("../../../../Cargo.lock");
        let (name, version) = BUILDER.split_once(' ').unwrap();
        assert!(lock.contains(&format!("name = \"{name}\"\nversion = \"{version}\"")));
    }
}
