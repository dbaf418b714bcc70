//! BVHs: every triangle is in one leaf and inside all boxes above it, within the traversal's stack.

use clap::ValueEnum;

use super::*;

/// A deterministic pseudorandom number in [0, 1).
fn noise(index: u32) -> f32 {
    let mut x = index.wrapping_mul(0x9E37_79B9) ^ 0x5bd1_e995;
    x = (x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d);
    x = (x ^ (x >> 12)).wrapping_mul(0x297a_2d39);
    (x ^ (x >> 15)) as f32 / 4_294_967_808.0
}

pub fn soup(count: u32, size: f32) -> Vec<Triangle> {
    let point = |seed: u32| Vec3::new(noise(seed), noise(seed + 1), noise(seed + 2));
    (0..count)
        .map(|id| {
            let a = point(9 * id);
            Triangle { a, b: a + size * point(9 * id + 3), c: a + size * point(9 * id + 6) }
        })
        .collect()
}

fn built(triangles: &[Triangle]) -> Bvh {
    build(triangles, LEVELS, &BvhOptions::default())
}

/// Walks the BVH, checks boxes and blocks, and returns its depth in levels of nodes.
pub fn check(triangles: &[Triangle], bvh: &Bvh) -> u32 {
    let mut seen = vec![0; triangles.len()];
    let mut blocks_seen = vec![0; bvh.blocks.len()];
    let mut deepest = 0;
    let mut stack = vec![(0, 1, Vec3::MIN, Vec3::MAX)];
    while let Some((id, depth, lower, upper)) = stack.pop() {
        deepest = deepest.max(depth);
        let node: &BvhNode = &bvh.nodes[id];
        for lane in 0..WIDTH {
            let min = Vec3::new(node.min_x[lane], node.min_y[lane], node.min_z[lane]);
            let max = Vec3::new(node.max_x[lane], node.max_y[lane], node.max_z[lane]);
            let child = node.children[lane];
            if min.x == f32::MAX {
                assert_eq!((min, max, child), (Vec3::MAX, Vec3::MAX, LEAF), "empty lanes must be canonical");
                continue;
            }
            assert!(lower.cmple(min).all() && max.cmple(upper).all(), "boxes must nest");
            if child & LEAF == 0 {
                stack.push((child as usize, depth + 1, min, max));
                continue;
            }
            let block = &bvh.blocks[(child & !LEAF) as usize];
            blocks_seen[(child & !LEAF) as usize] += 1;
            for lane in 0..WIDTH {
                let [a, b, c] =
                    [block.a, block.b, block.c].map(|corner| Vec3::from(corner.map(|axis| axis[lane])));
                if lane as u32 >= block.count {
                    assert!(a == b && b == c, "unused lanes must be points");
                    continue;
                }
                let old = bvh.order[block.first as usize + lane] as usize;
                seen[old] += 1;
                assert_eq!(Triangle { a, b, c }, triangles[old]);
                for corner in [a, b, c] {
                    assert!(min.cmplt(corner).all() && corner.cmplt(max).all(), "boxes hold their triangles");
                }
            }
        }
    }
    assert!(seen.iter().all(|&times| times == 1), "every triangle must be in exactly one leaf");
    assert!(blocks_seen.iter().all(|&times| times == 1));
    deepest
}

#[test]
fn bvh_holds_every_triangle_once_inside_all_its_boxes() {
    for count in [1, 2, 4, 5, 17, 1000, 5000] {
        let triangles = soup(count, 0.05);
        assert!(check(&triangles, &built(&triangles)) <= LEVELS);
    }
}

#[test]
fn one_triangle_has_a_root_that_is_a_node() {
    let bvh = built(&soup(1, 1.0));
    assert_eq!((bvh.nodes.len(), bvh.blocks.len()), (1, 1));
}

#[test]
fn same_triangles_give_the_same_bits_on_any_number_of_threads() {
    // Two equal layers, so that many boxes cost the same; large enough that all parallel parts run in parallel.
    let layer = soup(60_000, 0.02);
    let above = |t: &Triangle| Triangle { a: t.a + Vec3::Y, b: t.b + Vec3::Y, c: t.c + Vec3::Y };
    let triangles: Vec<_> = layer.iter().copied().chain(layer.iter().map(above)).collect();
    for quality in BvhQuality::value_variants() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| shape(&triangles, LEVELS, *quality))
        };
        let alone = on(1);
        assert!((2..=5).all(|threads| on(threads) == alone), "{quality:?}");
        check(&triangles, &alone.bvh(&triangles));
    }
}

#[test]
fn identical_triangles_stay_within_the_stack() {
    let triangles = vec![soup(1, 1.0)[0]; 10_000];
    assert!(check(&triangles, &built(&triangles)) <= LEVELS);
}

#[test]
fn identical_triangles_among_others_are_all_kept() {
    let triangles: Vec<_> = soup(200, 0.1).into_iter().flat_map(|t| [t; 9]).collect();
    assert!(check(&triangles, &built(&triangles)) <= LEVELS);
}

#[test]
fn nested_triangles_stay_within_the_stack() {
    // Each triangle contains all smaller ones: no split separates them.
    let shrink = |id: i32| 0.97_f32.powi(id);
    let triangles: Vec<_> = (0..2000)
        .map(|id| Triangle { a: Vec3::ZERO, b: Vec3::X * shrink(id), c: Vec3::Y * shrink(id) })
        .collect();
    assert!(check(&triangles, &built(&triangles)) <= LEVELS);
}

#[test]
fn balanced_bvh_holds_every_triangle_within_min_levels() {
    let triangles = soup(4096, 0.02);
    let boxes: Vec<Aabb> = triangles.iter().map(bounds).collect();
    let groups = Groups::from_boxes(&boxes);
    let binary = binary::build(&boxes, BvhQuality::Fast);
    let plan = CollapsePlan::new(&binary, &groups);
    let mut builder = Builder { boxes: &boxes, plan: &plan, shape: Shape::default() };
    let mut all = Vec::new();
    plan.triangles(0, &mut all);
    builder.balanced(&mut all);
    assert_eq!(check(&triangles, &builder.shape.bvh(&triangles)), min_levels(4096));

    // A budget one level above the minimum forces a mixture of planned and balanced parts.
    builder.shape = Shape::default();
    builder.node(0, min_levels(4096) + 1);
    assert!(check(&triangles, &builder.shape.bvh(&triangles)) <= min_levels(4096) + 1);
}

#[test]
fn flat_and_huge_scenes_are_built() {
    for scale in [1e-12_f32, 1.0, 1e12] {
        let flat = |p: Vec3| Vec3::new(p.x, 0.0, p.z) * scale;
        let triangles: Vec<_> =
            soup(300, 0.1).iter().map(|t| Triangle { a: flat(t.a), b: flat(t.b), c: flat(t.c) }).collect();
        assert!(check(&triangles, &built(&triangles)) <= LEVELS);
    }
}
