//! Cached BVHs: stored files are found, and no damaged or crafted file gives an invalid BVH.

use std::fs::File;
use std::path::PathBuf;

use caustics_kernels::interface::bvh::LEAF;

use super::super::tests::{check, soup};
use super::super::{LEVELS, NO_CHILD, bounds};
use super::*;

fn cache(max_bytes: u64) -> (tempfile::TempDir, BvhCache) {
    let folder = tempfile::tempdir().unwrap();
    let cache = BvhCache { folder: folder.path().join("bvh"), max_bytes };
    (folder, cache)
}

fn made(triangles: &[Triangle]) -> Shape {
    super::super::shape(triangles, LEVELS, BvhQuality::default())
}

fn key(triangles: &[Triangle]) -> BvhCacheKey {
    BvhCacheKey::new(triangles, LEVELS, BvhQuality::default())
}

fn files(cache: &BvhCache) -> Vec<PathBuf> {
    std::fs::read_dir(&cache.folder).map_or(vec![], |all| all.map(|file| file.unwrap().path()).collect())
}

/// A complete file of a given shape.
fn shape_file(triangles: &[Triangle], shape: &Shape) -> Vec<u8> {
    sealed_file(triangles, shape.children.len(), shape.counts.len(), &shape.parts().concat()).unwrap()
}

#[test]
fn cache_finds_the_bvh_of_equal_triangles_only() {
    let (_folder, cache) = cache(1 << 30);
    let triangles = soup(WORTH as u32, 0.01);
    let get = |triangles: &[Triangle], build: &dyn Fn() -> Shape| {
        cache.bvh(triangles, LEVELS, BvhQuality::default(), build)
    };
    let built = get(&triangles, &|| made(&triangles));
    assert_eq!(files(&cache).len(), 1);
    let found = get(&triangles, &|| panic!("the cache must hold it"));
    assert_eq!(bytemuck::cast_slice::<_, u8>(&found.nodes), bytemuck::cast_slice::<_, u8>(&built.nodes));
    assert_eq!((&found.blocks, &found.order), (&built.blocks, &built.order));

    // A corner that differs by one bit, other levels, another quality
    let mut others = triangles.clone();
    others[WORTH / 2].b.y = others[WORTH / 2].b.y.next_up();
    let is_built = std::cell::Cell::new(false);
    let build = || {
        is_built.set(true);
        made(&others)
    };
    get(&others, &build);
    assert!(is_built.get());
    let find = |levels, quality| cache.find(&BvhCacheKey::new(&triangles, levels, quality), &triangles);
    assert!(find(LEVELS - 1, BvhQuality::default()).is_none());
    assert!(find(LEVELS, BvhQuality::Best).is_none());

    // A BVH that builds fast is not stored.
    let few = soup(100, 0.1);
    get(&few, &|| made(&few));
    assert_eq!(files(&cache).len(), 2);
}

/// The former hash of file names, of inputs below a MiB: each step is invertible.
fn invertible(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks();
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    words.iter().chain([&last]).fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        let product = (hash ^ u64::from_le_bytes(*word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        product ^ product >> 32
    })
}

/// Other triangles with the same `invertible` hash: a second word compensates for another first word.
fn impostor(triangles: &[Triangle]) -> Vec<Triangle> {
    let state = |word: u64| {
        let product = (0xcbf2_9ce4_8422_2325 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        product ^ product >> 32
    };
    let pair = |a: f32, b: f32| u64::from(a.to_bits()) | u64::from(b.to_bits()) << 32;
    let Triangle { a, b, .. } = triangles[0];
    let own = state(pair(a.x, a.y));
    for step in 1..100_000 {
        let x = a.x + 1e-5 * step as f32;
        let second = pair(a.z, b.x) ^ own ^ state(pair(x, a.y));
        let [z, bx] = [second, second >> 32].map(|bits| f32::from_bits(bits as u32));
        if x != a.x && z.abs() < 1e9 && bx.abs() < 1e9 {
            let mut others = triangles.to_vec();
            (others[0].a.x, others[0].a.z, others[0].b.x) = (x, z, bx);
            return others;
        }
    }
    panic!("no second word is of two usable numbers")
}

#[test]
fn scene_crafted_for_the_hash_of_another_does_not_replace_its_bvh() {
    let (_folder, cache) = cache(1 << 30);
    let triangles = soup(500, 0.1);
    let others = impostor(&triangles);
    assert_ne!(others, triangles);
    assert_eq!(invertible(cast_slice(&others)), invertible(cast_slice(&triangles)));
    cache.keep(key(&others), &made(&others)).unwrap();
    assert!(cache.find(&key(&triangles), &triangles).is_none());
    // Even under the other scene's name the BVH gets the boxes of the given triangles.
    let bvh = parse(&shape_file(&triangles, &made(&others)), &key(&triangles), &triangles).unwrap();
    check(&triangles, &bvh);
}

#[test]
fn damaged_and_foreign_files_are_ignored() {
    let (_folder, cache) = cache(1 << 30);
    let [one, other] = [soup(500, 0.1), soup(501, 0.1)];
    cache.keep(key(&one), &made(&one)).unwrap();
    let path = cache.folder.join(key(&one).file_name());
    let whole = std::fs::read(&path).unwrap();
    for at in [0, 20, whole.len() / 2, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[at] ^= 4;
        std::fs::write(&path, damaged).unwrap();
        assert!(cache.find(&key(&one), &one).is_none(), "byte {at}");
    }
    for length in [0, 9, whole.len() / 2, whole.len() - 9, whole.len() - 1] {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(cache.find(&key(&one), &one).is_none(), "cut to {length} bytes");
    }
    std::fs::write(&path, &whole).unwrap();
    assert!(cache.find(&key(&one), &one).is_some());
    // Complete, but of other triangles
    std::fs::rename(&path, cache.folder.join(key(&other).file_name())).unwrap();
    assert!(cache.find(&key(&other), &other).is_none());
    // Much longer than any BVH of this number of triangles, and without limit in memory
    let file = File::create(&path).unwrap();
    if file.set_len(1 << 40).is_ok() {
        assert!(cache.find(&key(&one), &one).is_none());
    }
}

#[cfg(unix)]
#[test]
fn pipes_links_to_devices_and_folders_in_the_cache_are_replaced() {
    let (folder, cache) = cache(1 << 30);
    let triangles = soup(WORTH as u32, 0.01);
    let path = cache.folder.join(key(&triangles).file_name());
    std::fs::create_dir_all(&cache.folder).unwrap();
    for make in ["mkfifo \"$0\"", "ln -s /dev/zero \"$0\"", "ln -s /proc/kmsg \"$0\""] {
        let made_it = std::process::Command::new("sh").args(["-c", make]).arg(&path).status().unwrap();
        assert!(made_it.success(), "{make}");
        cache.bvh(&triangles, LEVELS, BvhQuality::default(), || made(&triangles));
        assert!(path.symlink_metadata().unwrap().is_file(), "{make}: a BVH must replace it");
        std::fs::remove_file(&path).unwrap();
    }
    std::fs::create_dir(&path).unwrap();
    cache.bvh(&triangles, LEVELS, BvhQuality::default(), || made(&triangles));
    drop(folder);
}

/// Every file has the right key and the right checksum.
#[test]
fn crafted_shapes_are_refused() {
    let triangles = soup(500, 0.05);
    let whole = made(&triangles);
    assert!(accepts(&shape_file(&triangles, &whole), &triangles));
    let (nodes, leaves) = (whole.children.len() as u32, whole.counts.len() as u32);
    // A root lane that is a node; the last node has only leaves.
    let root_lane = whole.children[0].iter().position(|child| child & LEAF == 0).expect("a node below");
    let last = nodes as usize - 1;
    let refused = |what: &str, craft: &dyn Fn(&mut Shape)| {
        let mut shape = whole.clone();
        craft(&mut shape);
        assert!(!accepts(&shape_file(&triangles, &shape), &triangles), "{what}");
    };
    // Order and leaves
    refused("an id beyond the triangles", &|shape| shape.order[7] = 500);
    refused("an id of all ones", &|shape| shape.order[7] = u32::MAX);
    refused("an id twice", &|shape| shape.order[7] = shape.order[8]);
    refused("a leaf of no triangles", &|shape| shape.counts[0] = 0);
    refused("a leaf of five", &|shape| shape.counts[0] = 5);
    refused("a leaf of 255", &|shape| shape.counts[3] = 255);
    refused("leaves of too many", &|shape| shape.counts.iter_mut().for_each(|count| *count = 4));
    refused("leaves of too few", &|shape| shape.counts.iter_mut().for_each(|count| *count = 1));
    // Nodes
    refused("a root below itself", &|shape| shape.children[0][root_lane] = 0);
    refused("a node below itself", &|shape| shape.children[last][0] = last as u32);
    refused("a cycle with the root", &|shape| shape.children[last][0] = 0);
    refused("a node of no parent", &|shape| shape.children[0][root_lane] = NO_CHILD);
    refused("a node twice", &|shape| shape.children[0] = [shape.children[0][root_lane]; WIDTH]);
    refused("a node beyond the last", &|shape| shape.children[0][root_lane] = nodes);
    refused("an instance", &|shape| shape.children[0][root_lane] = 0x4000_0000);
    refused("a leaf beyond the last", &|shape| shape.children[last][0] = LEAF | leaves);
    refused("a leaf of nearly all ones", &|shape| shape.children[last][0] = u32::MAX - 1);
    refused("a leaf twice and another never", &|shape| {
        let leaf = |child: &&mut u32| **child & LEAF != 0 && **child != NO_CHILD;
        let mut leaves = shape.children.iter_mut().flatten().filter(leaf);
        *leaves.next().unwrap() = *leaves.next().unwrap();
    });
    refused("a node of no lanes", &|shape| shape.children.push([NO_CHILD; WIDTH]));
    refused("no nodes", &|shape| shape.children.clear());
    refused("no leaves", &|shape| shape.counts.clear());
    refused("no triangles", &|shape| shape.order.clear());
    refused("nothing", &|shape| *shape = Shape::default());
    // Each node but the last has a leaf and the next node.
    refused("a chain deeper than the stack", &|shape| {
        let leaves = shape.order.len() as u32;
        shape.counts = vec![1; leaves as usize];
        let next = |node: u32| if node + 2 < leaves { node + 1 } else { LEAF | (leaves - 1) };
        let node = |node: u32| [LEAF | node, next(node), NO_CHILD, NO_CHILD];
        shape.children = (0..leaves - 1).map(node).collect();
    });
    // Sizes that differ from the payload's
    let payload = whole.parts().concat();
    for (nodes, leaves) in [(0, 0), (1, 1), (usize::MAX, 1), (usize::MAX / 16, usize::MAX), (1, usize::MAX)] {
        let file = sealed_file(&triangles, nodes, leaves, &payload).unwrap();
        assert!(!accepts(&file, &triangles), "{nodes} nodes and {leaves} leaves");
    }
}

/// Boxes are not read: with triangles in any order, the BVH still bounds the given triangles.
#[test]
fn sound_shapes_of_another_order_hold_every_triangle_in_its_boxes() {
    let triangles = soup(500, 0.05);
    let mut shape = made(&triangles);
    shape.order.reverse();
    let bvh = parse(&shape_file(&triangles, &shape), &key(&triangles), &triangles).unwrap();
    check(&triangles, &bvh);
}

#[test]
fn slow_bvhs_are_neither_used_nor_stored() {
    let (_folder, cache) = cache(1 << 30);
    let triangles = soup(WORTH as u32, 0.01);
    let whole = made(&triangles);
    assert!(is_quick(&whole.clone().bvh(&triangles)));
    let mut shape = whole;
    // Separate neighbours.
    let count = shape.order.len();
    shape.order = (0..count).map(|at| shape.order[at * 10_007 % count]).collect();
    assert!(shape.is_sound(count, LEVELS));
    assert!(!accepts(&shape_file(&triangles, &shape), &triangles));
    cache.bvh(&triangles, LEVELS, BvhQuality::default(), || shape);
    assert_eq!(files(&cache).len(), 0);
}

#[test]
fn boxes_of_the_plan_are_those_of_its_triangles() {
    use super::super::{binary, groups::Groups, plan::CollapsePlan};
    let triangles = soup(3000, 0.05);
    let boxes: Vec<_> = triangles.iter().map(bounds).collect();
    let groups = Groups::from_boxes(&boxes);
    for quality in [BvhQuality::Fast, BvhQuality::Medium, BvhQuality::Best] {
        let binary = binary::build(&boxes, quality);
        let plan = CollapsePlan::new(&binary, &groups);
        for at in 0..2 * groups.count() - 1 {
            let mut ids = Vec::new();
            plan.triangles(at, &mut ids);
            let around =
                ids.iter().fold(obvhs::aabb::Aabb::empty(), |all, &id| all.union(&boxes[id as usize]));
            assert_eq!(plan.bounds(at), &around, "{quality:?}: {at}");
        }
    }
}

#[test]
fn least_recently_used_files_are_removed_above_the_size_limit() {
    let (_folder, mut cache) = cache(1 << 30);
    let all = [300, 301, 302].map(|count| soup(count, 0.1));
    let find = |cache: &BvhCache, index: usize| cache.find(&key(&all[index]), &all[index]).is_some();
    let age = |index: usize, cache: &BvhCache, seconds: u64| {
        let file = File::options().append(true).open(cache.folder.join(key(&all[index]).file_name()));
        file.unwrap().set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds)).unwrap();
    };
    for (index, triangles) in all[..2].iter().enumerate() {
        cache.keep(key(triangles), &made(triangles)).unwrap();
        age(index, &cache, 10 + index as u64);
    }
    // Using the older file makes it the newer one.
    assert!(find(&cache, 0));
    cache.max_bytes = 5 * std::fs::metadata(&files(&cache)[0]).unwrap().len() / 2;
    cache.keep(key(&all[2]), &made(&all[2])).unwrap();
    assert_eq!([0, 1, 2].map(|index| find(&cache, index)), [true, false, true]);
    // A BVH that alone exceeds the limit is not stored and removes no other.
    cache.max_bytes = 100;
    cache.keep(key(&all[1]), &made(&all[1])).unwrap();
    assert_eq!(files(&cache).len(), 2);
}

#[test]
fn builder_version_is_that_of_the_lock_file() {
    let lock = include_str!("../../../../../Cargo.lock");
    let (name, version) = BUILDER.split_once(' ').unwrap();
    assert!(lock.contains(&format!("name = \"{name}\"\nversion = \"{version}\"")));
}
