//! Software tracer of CPUs with AVX2: the BVH of [`super::bvh`] with eight children a node, whose boxes it tests at once. It
//! shares the leaves and the tests of triangles with that module: both find the same hits, to the bit.

use std::arch::x86_64::{
    __m256, _CMP_LE_OQ, _MM_HINT_T0, _mm_prefetch, _mm256_cmp_ps, _mm256_max_ps, _mm256_min_ps,
    _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_ps, _mm256_setzero_ps, _mm256_sub_ps,
};

use bytemuck::{Pod, Zeroable, cast, cast_mut};
use spirv_std::glam::Vec3;

use crate::interface::NONE;
use crate::interface::bvh::{BvhNode, INSTANCE, LEAF, TriangleBlock};
use crate::interface::instance::Instance;
use crate::interface::ray::{Hit, Ray};
use crate::memory::Memory;
use crate::texture::cut_out::CutOuts;
use crate::trace::bvh::{SLACK, intersect_block, safe_inverses};
use crate::trace::on_cpu::has_avx2;

/// Children of a node.
const WIDTH: usize = 8;

/// Entries of a traversal's stack.
const STACK: usize = 96;

/// Subtrees that a ray has postponed: the distance (m) at which it enters, as bits in the upper half, and the child. Entries sort
/// by distance, since no distance is negative. A worker keeps one stack: filling it with zeros would take a ray as long as two
/// nodes.
pub type Stack = [u64; STACK];

/// An empty stack.
pub const EMPTY: Stack = [0; STACK];

/// Boxes of eight children (m), one lane a child. The planes of an empty lane are NaN, so that every ray misses it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Bvh8Node {
    /// Minima and maxima on each axis.
    planes: [[__m256; 2]; 3],
    /// Children, as in a [`BvhNode`].
    children: [u32; WIDTH],
    /// Keeps nodes at four cache lines.
    padding: [u32; 8],
}

/// A BVH of eight children a node, with the leaves of the BVH that it is made of.
pub struct Bvh8 {
    nodes: Memory,
    /// Root of each instance's mesh.
    roots: Vec<u32>,
}

impl Bvh8 {
    /// Opens the largest children of each node until there are eight. `None` if this CPU lacks AVX2, if there is no memory, or if
    /// rays would need more entries than their stack has.
    pub fn new(nodes: &[BvhNode], instances: &[Instance]) -> Option<Bvh8> {
        if nodes.is_empty() || !has_avx2() {
            return None;
        }
        // No node becomes two, and not all become one: the rest of the memory is never touched.
        let bvh8_nodes = Memory::zeros(nodes.len() * size_of::<Bvh8Node>()).ok()?;
        bvh8_nodes.in_huge_pages();
        let mut builder = Bvh8Builder { nodes, bvh8_nodes, rooms: Vec::new(), made: vec![NONE; nodes.len()] };
        builder.root(0);
        let roots: Vec<u32> = instances.iter().map(|instance| builder.root(instance.root)).collect();
        // The root of the world is the root of all, and belongs to no instance.
        let of_meshes = roots.iter().filter(|&&root| root != 0).map(|&root| builder.rooms[root as usize]);
        let room = builder.rooms[0] + of_meshes.max().unwrap_or(0);
        (room as usize <= STACK).then_some(Bvh8 { nodes: builder.bvh8_nodes, roots })
    }
}

/// Prefetches the node or the leaf of a child.
#[inline(always)]
fn fetch(child: u32, nodes: &[Bvh8Node], blocks: &[TriangleBlock]) {
    let node: *const i8 = nodes.as_ptr().wrapping_add(child as usize).cast();
    let block: *const i8 = blocks.as_ptr().wrapping_add((child & !LEAF) as usize).cast();
    let address = if child & LEAF != 0 { block } else { node };
    // A leaf has three lines; one more prefetch costs less than a branch.
    for line in 0..4 {
        prefetch(address.wrapping_add(64 * line));
    }
}

/// Prefetches the cache line of an address.
#[inline(always)]
fn prefetch(address: *const i8) {
    // SAFETY: whatever the address, nothing is read.
    #[allow(unsafe_code)]
    unsafe {
        _mm_prefetch::<_MM_HINT_T0>(address);
    }
}

struct Bvh8Builder<'a> {
    nodes: &'a [BvhNode],
    bvh8_nodes: Memory,
    /// Maximum number of stack entries that a ray takes from each node on.
    rooms: Vec<u32>,
    /// New node for each node that is a root.
    made: Vec<u32>,
}

impl Bvh8Builder<'_> {
    /// Makes the new node of a root, which several instances may share.
    fn root(&mut self, root: u32) -> u32 {
        if self.made[root as usize] == NONE {
            self.made[root as usize] = self.node(root);
        }
        self.made[root as usize]
    }

    /// Appends the new node of a node, and all below it.
    fn node(&mut self, node: u32) -> u32 {
        let mut lanes = Lanes::from_node(&self.nodes[node as usize]);
        let mut below = lanes.all.map(|lane| self.below(&lane));
        // Open the largest child that fits, until none does.
        loop {
            let fits = |&lane: &usize| below[lane].count > 0 && lanes.count + below[lane].count <= WIDTH + 1;
            let area = |lane: usize| lanes.all[lane].area();
            let largest = (0..lanes.count).filter(fits).max_by(|&a, &b| area(a).total_cmp(&area(b)));
            let Some(open) = largest else { break };
            let opened = below[open];
            for (number, lane) in opened.all[..opened.count].iter().enumerate() {
                let slot = if number == 0 { open } else { lanes.count + number - 1 };
                (lanes.all[slot], below[slot]) = (*lane, self.below(lane));
            }
            lanes.count += opened.count - 1;
        }
        let index = self.rooms.len();
        self.rooms.push(0);
        self.bvh8_nodes()[index] = EMPTY_NODE;
        let mut room = 0;
        for (slot, lane) in lanes.all[..lanes.count].iter().enumerate() {
            let mut child = lane.child;
            if lane.is_node() {
                child = self.node(child);
                room = room.max(self.rooms[child as usize]);
            }
            let made = &mut self.bvh8_nodes()[index];
            made.children[slot] = child;
            for (sides, planes) in made.planes.iter_mut().zip(lane.planes) {
                for (side, plane) in sides.iter_mut().zip(planes) {
                    cast_mut::<__m256, [f32; WIDTH]>(side)[slot] = plane;
                }
            }
        }
        self.rooms[index] = room + lanes.count.saturating_sub(1) as u32;
        index as u32
    }

    fn bvh8_nodes(&mut self) -> &mut [Bvh8Node] {
        self.bvh8_nodes.edit()
    }

    /// Lanes that a lane would be opened to; none if it is no node.
    fn below(&self, lane: &Lane) -> Lanes {
        if lane.is_node() { Lanes::from_node(&self.nodes[lane.child as usize]) } else { Lanes::NONE }
    }
}

/// A child and its box.
#[derive(Clone, Copy)]
struct Lane {
    planes: [[f32; 2]; 3],
    child: u32,
}

impl Lane {
    fn is_node(&self) -> bool {
        self.child & (LEAF | INSTANCE) == 0
    }

    /// Half of the area of the box (m^2).
    fn area(&self) -> f32 {
        let [x, y, z] = self.planes.map(|[min, max]| max - min);
        x * y + y * z + z * x
    }
}

/// Children of a node under construction.
#[derive(Clone, Copy)]
struct Lanes {
    all: [Lane; WIDTH],
    count: usize,
}

impl Lanes {
    const NONE: Lanes = Lanes { all: [Lane { planes: [[0.0; 2]; 3], child: LEAF }; WIDTH], count: 0 };

    fn from_node(node: &BvhNode) -> Lanes {
        let mut lanes = Lanes::NONE;
        for lane in (0..4).filter(|&lane| node.min_x[lane] != f32::MAX) {
            lanes.all[lanes.count] = Lane {
                planes: [
                    [node.min_x[lane], node.max_x[lane]],
                    [node.min_y[lane], node.max_y[lane]],
                    [node.min_z[lane], node.max_z[lane]],
                ],
                child: node.children[lane],
            };
            lanes.count += 1;
        }
        lanes
    }
}

const EMPTY_NODE: Bvh8Node = {
    // SAFETY: any bits are eight floats.
    #[allow(unsafe_code)]
    let none = unsafe { std::mem::transmute::<[f32; WIDTH], __m256>([f32::NAN; WIDTH]) };
    Bvh8Node { planes: [[none; 2]; 3], children: [LEAF; WIDTH], padding: [0; 8] }
};

/// A ray, prepared for tests of boxes.
#[derive(Clone, Copy)]
struct Slabs {
    origin: [__m256; 3],
    inverse: [__m256; 3],
    /// Index of the plane of each axis through which the ray enters.
    near: [usize; 3],
}

impl Slabs {
    #[target_feature(enable = "avx2")]
    #[inline]
    fn new(origin: Vec3, direction: Vec3) -> Slabs {
        let inverse = safe_inverses(direction).to_array();
        Slabs {
            origin: [_mm256_set1_ps(origin.x), _mm256_set1_ps(origin.y), _mm256_set1_ps(origin.z)],
            inverse: [_mm256_set1_ps(inverse[0]), _mm256_set1_ps(inverse[1]), _mm256_set1_ps(inverse[2])],
            near: inverse.map(|inverse| usize::from(inverse < 0.0)),
        }
    }

    /// Distances at which the ray enters the boxes, and a bit for each box that it meets within `length`.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn enter(&self, node: &Bvh8Node, length: f32) -> ([f32; WIDTH], u32) {
        // If an operand is NaN, min and max return the second: so `leave` is NaN in an empty lane.
        let mut enter = _mm256_setzero_ps();
        let mut leave = _mm256_set1_ps(length);
        let mut axis = 0;
        while axis < 3 {
            let at =
                |plane: __m256| _mm256_mul_ps(_mm256_sub_ps(plane, self.origin[axis]), self.inverse[axis]);
            let near = self.near[axis] & 1;
            enter = _mm256_max_ps(at(node.planes[axis][near]), enter);
            leave = _mm256_min_ps(leave, at(node.planes[axis][near ^ 1]));
            axis += 1;
        }
        let met = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, _mm256_mul_ps(leave, _mm256_set1_ps(SLACK)));
        (cast(enter), _mm256_movemask_ps(met) as u32)
    }
}

/// Finds the hit that [`super::bvh`] finds.
#[inline]
pub(super) fn find<const ANY: bool, const INSTANCES: bool>(
    bvh: &Bvh8,
    blocks: &[TriangleBlock],
    cut_outs: &CutOuts<'_>,
    ray: &Ray,
    stack: &mut Stack,
) -> Hit {
    // Pass the ray in registers: its numbers were written one by one, and a read of two at once waits until memory has both.
    let &Ray { origin: Vec3 { x, y, z }, length, direction: Vec3 { x: dx, y: dy, z: dz }, key } = ray;
    // SAFETY: a `Bvh8` exists only where there is AVX2.
    #[allow(unsafe_code)]
    unsafe {
        traverse::<ANY, INSTANCES>(bvh, blocks, cut_outs, stack, x, y, z, dx, dy, dz, length, key)
    }
}

/// Traverses the BVH with a ray from (x, y, z) along (dx, dy, dz).
#[target_feature(enable = "avx2")]
fn traverse<const ANY: bool, const INSTANCES: bool>(
    bvh: &Bvh8,
    blocks: &[TriangleBlock],
    cut_outs: &CutOuts<'_>,
    stack: &mut Stack,
    x: f32,
    y: f32,
    z: f32,
    dx: f32,
    dy: f32,
    dz: f32,
    length: f32,
    key: u32,
) -> Hit {
    let nodes: &[Bvh8Node] = bvh.nodes.read();
    let world = Ray { origin: Vec3::new(x, y, z), length, direction: Vec3::new(dx, dy, dz), key };
    let mut ray = world;
    let mut slabs = Slabs::new(ray.origin, ray.direction);
    // The instance at hand, and the height of the stack at which it ends, plus one; 0 outside of instances.
    let (mut inside, mut floor) = (0u32, 0usize);
    let mut best = Hit { distance: world.length, ..Hit::MISS };
    let mut height = 0usize;
    let mut current = 0u32;
    loop {
        if current & LEAF != 0 {
            let before = best.triangle;
            intersect_block(&blocks[(current & !LEAF) as usize], inside, cut_outs, &ray, &mut best);
            if ANY && best.triangle != NONE {
                return best;
            }
            if !ANY && best.triangle != before {
                // Prefetch the surface: most likely the path will make a vertex of this hit.
                prefetch(cut_outs.surfaces.as_ptr().wrapping_add(best.triangle as usize).cast());
            }
        } else if INSTANCES && current & INSTANCE != 0 {
            inside = current & !INSTANCE;
            let instance = &cut_outs.instances[inside as usize];
            ray.origin = instance.to_object.point(world.origin);
            ray.direction = instance.to_object.vector(world.direction);
            slabs = Slabs::new(ray.origin, ray.direction);
            floor = height + 1;
            current = bvh.roots[inside as usize];
            continue;
        } else {
            let node = &nodes[current as usize];
            let (near, met) = slabs.enter(node, best.distance);
            if met != 0 {
                // Go on to the nearest child, and push the others unsorted, since sorting them gains nothing. A single child need
                // not wait for its distance.
                let first = lowest(met);
                current = node.children[first];
                let mut others = met & (met - 1);
                if others == 0 {
                    continue;
                }
                let mut nearest = entry(&near, node, first);
                while others != 0 {
                    let other = entry(&near, node, lowest(others));
                    others &= others - 1;
                    let later = nearest.max(other);
                    fetch(later as u32, nodes, blocks);
                    stack[height] = later;
                    nearest = nearest.min(other);
                    height += 1;
                }
                current = nearest as u32;
                continue;
            }
        }

        // Pop the next subtree that may hold a closer hit.
        loop {
            if INSTANCES && floor == height + 1 {
                ray = world;
                slabs = Slabs::new(ray.origin, ray.direction);
                (inside, floor) = (0, 0);
            }
            if height == 0 {
                return best;
            }
            height -= 1;
            if f32::from_bits((stack[height] >> 32) as u32) <= best.distance {
                current = stack[height] as u32;
                break;
            }
        }
    }
}

/// Lowest lane in a set of bits.
#[inline(always)]
fn lowest(lanes: u32) -> usize {
    lanes.trailing_zeros() as usize & (WIDTH - 1)
}

/// Entry of the stack for the child of a lane.
#[inline(always)]
fn entry(near: &[f32; WIDTH], node: &Bvh8Node, lane: usize) -> u64 {
    u64::from(near[lane].to_bits()) << 32 | u64::from(node.children[lane])
}
