//! Software tracer of GPUs without ray queries, and of CPUs without AVX2 (`bvh8.rs`). It traverses a bounding volume hierarchy
//! (BVH) of four children a node, whose boxes it tests at once. On a CPU glam's Vec4 is a vector register; on a GPU the same code
//! is scalar.

use core::ops::{Add, Div, Mul, Sub};

use crate::interface::NONE;
use crate::interface::bvh::{BVH_STACK_SIZE, BvhNode, INSTANCE, LEAF, TriangleBlock};
use crate::interface::features::Features;
use crate::interface::ray::{Hit, Ray};
use crate::platform::scratch;
use crate::texture::cut_out::CutOuts;
use crate::trace::Tracer;
use spirv_std::glam::{Vec3, Vec4};

/// Traverses the BVH that the host built.
#[derive(Clone, Copy)]
pub struct BvhTracer<'a> {
    /// Nodes; the root is the first.
    pub nodes: &'a [BvhNode],
    /// Leaves.
    pub blocks: &'a [TriangleBlock],
    /// Instances, and the presence of surfaces at hits.
    pub cut_outs: CutOuts<'a>,
}

/// Relative slack of 4 ulp, for two roundings a slab: keeps the test of a box conservative.
pub(super) const SLACK: f32 = 1.0 + 4.0 * f32::EPSILON;

impl Tracer for BvhTracer<'_> {
    #[inline(always)]
    fn closest(&mut self, ray: &Ray) -> Hit {
        self.find::<false>(ray)
    }
    #[inline(always)]
    fn occluded(&mut self, ray: &Ray) -> bool {
        !self.find::<true>(ray).is_miss()
    }
}

impl BvhTracer<'_> {
    /// Finds a hit. On a CPU, scenes without instances have a traversal of their own, which carries no state of instances. A
    /// GPU's compiler knows the bit.
    #[inline(always)]
    pub(super) fn find<const ANY: bool>(&self, ray: &Ray) -> Hit {
        let BvhTracer { nodes, blocks, cut_outs } = self;
        if cfg!(target_arch = "spirv") || cut_outs.features.has(Features::INSTANCES) {
            traverse::<ANY, true>(nodes, blocks, cut_outs, ray)
        } else {
            traverse::<ANY, false>(nodes, blocks, cut_outs, ray)
        }
    }
}

/// Inverses of a direction's components, by which a traversal multiplies instead of dividing.
#[inline(always)]
pub(super) fn safe_inverses(direction: Vec3) -> Vec3 {
    Vec3::new(safe_inverse(direction.x), safe_inverse(direction.y), safe_inverse(direction.z))
}

/// 1 / x, finite also for x = 0, so that no box test meets infinity times zero.
#[inline]
fn safe_inverse(x: f32) -> f32 {
    let limit = 1.0e-18;
    1.0 / if x.abs() < limit { if x < 0.0 { -limit } else { limit } } else { x }
}

/// Words of a stack: more than are used, so that the compiler does not keep two of them in registers.
const STACK_ROOM: usize = BVH_STACK_SIZE + 1;

/// Finds the closest hit, or any hit if `ANY`. With `INSTANCES`, instances transform the ray into their own space. Its direction
/// keeps the length that it gets there, so that distances are the world's.
#[inline]
fn traverse<const ANY: bool, const INSTANCES: bool>(
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    cut_outs: &CutOuts<'_>,
    world: &Ray,
) -> Hit {
    let instanced = INSTANCES && cut_outs.features.has(Features::INSTANCES);
    let mut ray = *world;
    let mut inverse = safe_inverses(ray.direction);
    // The instance at hand, and the height of the stack at which it ends, plus one; 0 outside of instances.
    let (mut inside, mut floor) = (0u32, 0usize);
    let mut best = Hit { distance: world.length, ..Hit::MISS };
    scratch!(stack_child: STACK_ROOM);
    scratch!(stack_distance: STACK_ROOM);
    let mut height = 0usize;
    let mut current = 0u32;
    loop {
        if current & LEAF != 0 {
            intersect_block(&blocks[(current & !LEAF) as usize], inside, cut_outs, &ray, &mut best);
            if ANY && best.triangle != NONE {
                return best;
            }
        } else if instanced && current & INSTANCE != 0 {
            inside = current & !INSTANCE;
            let instance = &cut_outs.instances[inside as usize];
            ray.origin = instance.to_object.point(world.origin);
            ray.direction = instance.to_object.vector(world.direction);
            inverse = safe_inverses(ray.direction);
            floor = height + 1;
            current = instance.root;
            continue;
        } else {
            let node = &nodes[current as usize];
            let near = intersect_children(node, ray.origin, inverse, best.distance).to_array();

            // Descend into the nearest child and push the others.
            let mut nearest = f32::MAX;
            let mut next = NONE;
            let mut lane = 0;
            while lane < 4 {
                let distance = near[lane];
                if distance < f32::MAX {
                    let child = node.children[lane];
                    let (far_child, far_distance) =
                        if distance < nearest { (next, nearest) } else { (child, distance) };
                    if distance < nearest {
                        next = child;
                        nearest = distance;
                    }
                    if far_child != NONE && height < BVH_STACK_SIZE {
                        stack_child[height] = far_child;
                        stack_distance[height] = far_distance.to_bits();
                        height += 1;
                    }
                }
                lane += 1;
            }
            if next != NONE {
                current = next;
                continue;
            }
        }

        // Pop the next subtree that may hold a closer hit.
        loop {
            if instanced && floor == height + 1 {
                ray = *world;
                inverse = safe_inverses(ray.direction);
                (inside, floor) = (0, 0);
            }
            if height == 0 {
                return best;
            }
            height -= 1;
            if f32::from_bits(stack_distance[height]) <= best.distance {
                current = stack_child[height];
                break;
            }
        }
    }
}

/// Distances at which the ray enters the four boxes; f32::MAX for boxes it misses within `length`.
#[inline(always)]
fn intersect_children(node: &BvhNode, origin: Vec3, inverse: Vec3, length: f32) -> Vec4 {
    let x = (slabs(node.min_x, origin.x, inverse.x), slabs(node.max_x, origin.x, inverse.x));
    let y = (slabs(node.min_y, origin.y, inverse.y), slabs(node.max_y, origin.y, inverse.y));
    let z = (slabs(node.min_z, origin.z, inverse.z), slabs(node.max_z, origin.z, inverse.z));
    let enter = x.0.min(x.1).max(y.0.min(y.1)).max(z.0.min(z.1).max(Vec4::ZERO));
    let leave = x.0.max(x.1).min(y.0.max(y.1)).min(z.0.max(z.1).min(Vec4::splat(length)));
    let hit = enter.cmple(leave * SLACK);
    Vec4::select(hit, enter, Vec4::splat(f32::MAX))
}

#[inline(always)]
fn slabs(planes: Vec4, origin: f32, inverse: f32) -> Vec4 {
    (planes - Vec4::splat(origin)) * inverse
}

/// Tests the ray against the block's triangles, one after another: four at once would take a GPU's registers.
#[cfg(target_arch = "spirv")]
#[inline(always)]
pub(super) fn intersect_block(
    block: &TriangleBlock,
    instance: u32,
    cut_outs: &CutOuts<'_>,
    ray: &Ray,
    best: &mut Hit,
) {
    let mut lane = 0;
    while lane < block.count {
        let at = lane as usize & 3;
        let corner = |lanes: &[[f32; 4]; 3]| [lanes[0][at], lanes[1][at], lanes[2][at]];
        let found = Crossing::new(corner(&block.a), corner(&block.b), corner(&block.c), ray);
        let inside = found.u.min(found.v).min(found.w) >= 0.0 || found.u.max(found.v).max(found.w) <= 0.0;
        if inside && found.sum != 0.0 && found.distance > 0.0 && found.distance <= best.distance {
            consider(&found, block.first + lane, instance, cut_outs, ray.key, best);
        }
        lane += 1;
    }
}

/// Tests the ray against the block's triangles, four at once.
#[cfg(not(target_arch = "spirv"))]
#[inline(always)]
pub(super) fn intersect_block(
    block: &TriangleBlock,
    instance: u32,
    cut_outs: &CutOuts<'_>,
    ray: &Ray,
    best: &mut Hit,
) {
    let all = |lanes: &[[f32; 4]; 3]| lanes.map(Vec4::from_array);
    let Crossing { u, v, w, sum, distance } = Crossing::new(all(&block.a), all(&block.b), all(&block.c), ray);
    let inside = u.min(v).min(w).cmpge(Vec4::ZERO) | u.max(v).max(w).cmple(Vec4::ZERO);
    // Return on a miss: the rest needs normals and a division.
    if !inside.any() {
        return;
    }
    let hit = inside
        & sum.cmpne(Vec4::ZERO)
        & distance.cmpgt(Vec4::ZERO)
        & distance.cmple(Vec4::splat(best.distance));
    if hit.any() {
        let distances = Vec4::select(hit, distance, Vec4::splat(f32::MAX)).to_array();
        let (u, v, w, sum) = (u.to_array(), v.to_array(), w.to_array(), sum.to_array());
        for lane in 0..4 {
            if distances[lane] <= best.distance {
                let found = Crossing {
                    u: u[lane],
                    v: v[lane],
                    w: w[lane],
                    sum: sum[lane],
                    distance: distances[lane],
                };
                consider(&found, block.first + lane as u32, instance, cut_outs, ray.key, best);
            }
        }
    }
}

/// Crossing of a ray with the plane of a triangle, or with the planes of four at once. It is computed from signed edge volumes
/// around the ray's origin. A shared edge gives its two triangles the same numbers with opposite signs, so that no ray slips
/// between them.
struct Crossing<T> {
    /// Twice the barycentric volumes of the corners. Where the ray is inside, no two have opposite signs.
    u: T,
    v: T,
    w: T,
    /// Sum of the three volumes.
    sum: T,
    /// Distance to the plane, in lengths of the ray's direction.
    distance: T,
}

/// A number of one triangle, or the numbers of four.
trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f32, Output = Self>
    + Div<Output = Self>
{
    /// One value for all triangles.
    fn splat(value: f32) -> Self;
}

impl Number for f32 {
    #[inline(always)]
    fn splat(value: f32) -> f32 {
        value
    }
}

impl Number for Vec4 {
    #[inline(always)]
    fn splat(value: f32) -> Vec4 {
        Vec4::splat(value)
    }
}

impl<T: Number> Crossing<T> {
    /// Crossing with the triangle of corners a, b and c.
    #[inline(always)]
    fn new(a: [T; 3], b: [T; 3], c: [T; 3], ray: &Ray) -> Crossing<T> {
        let o = [T::splat(ray.origin.x), T::splat(ray.origin.y), T::splat(ray.origin.z)];
        let (a, b, c) = (minus(a, o), minus(b, o), minus(c, o));
        let d = ray.direction;
        let u = edge_volume(b, c, d);
        let v = edge_volume(c, a, d);
        let w = edge_volume(a, b, d);

        let (e1, e2) = (minus(b, a), minus(c, a));
        let n = [e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]];
        let along = n[0] * d.x + n[1] * d.y + n[2] * d.z;
        let height = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
        Crossing { u, v, w, sum: u + v + w, distance: height / along }
    }
}

#[inline(always)]
fn minus<T: Number>(p: [T; 3], q: [T; 3]) -> [T; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// Signed volume of the ray against the edge from p to q (both relative to the ray's origin).
#[inline(always)]
fn edge_volume<T: Number>(p: [T; 3], q: [T; 3], d: Vec3) -> T {
    let e = minus(p, q);
    let s = [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
    (e[1] * s[2] - e[2] * s[1]) * d.x + (e[2] * s[0] - e[0] * s[2]) * d.y + (e[0] * s[1] - e[1] * s[0]) * d.z
}

/// Takes a crossing inside of a triangle as the best hit, if it comes before the best so far.
#[inline(always)]
fn consider(
    found: &Crossing<f32>,
    triangle: u32,
    instance: u32,
    cut_outs: &CutOuts<'_>,
    key: u32,
    best: &mut Hit,
) {
    let inverse = 1.0 / found.sum;
    let (u, v) = (found.v * inverse, found.w * inverse);
    let hit = Hit { distance: found.distance, triangle, u, v, instance };
    if is_before(&hit, best) && cut_outs.is_there(&hit, key) {
        *best = hit;
    }
}

/// Whether a hit is closer than the best so far. Ties are broken by the smaller id, so that the order of traversal decides
/// nothing.
#[inline(always)]
fn is_before(found: &Hit, best: &Hit) -> bool {
    let tie = found.distance == best.distance && !best.is_miss();
    let smaller =
        found.triangle < best.triangle || (found.triangle == best.triangle && found.instance < best.instance);
    found.distance < best.distance || (tie && smaller)
}
