//! Borders of triangle meshes: edges that no other edge covers in the opposite direction. Imports nothing.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Maximum number of comparisons of an edge with a point. Edges beyond it are not cut, so that their mesh may be called open.
const MAX_COMPARISONS: usize = 1 << 26;

/// Open edges of a mesh, and pairs of points that coincide by rounding or are joined along a cut edge.
#[derive(Debug, Default)]
pub struct Borders {
    /// Directed edges without a partner in the opposite direction.
    pub open: Vec<[u32; 2]>,
    /// Pairs of joined points.
    pub joins: Vec<[u32; 2]>,
}

impl Borders {
    /// Finds the borders of triangles whose corners are indices of points (m). Points of borders coincide where they are less
    /// than `tolerance` (m) apart. Short edges cover a long edge (T-junctions) where their points lie within `tolerance` of it.
    pub fn from_triangles(triangles: &[[u32; 3]], points: &[Vec3], tolerance: f64) -> Borders {
        // Pair edges by their ends.
        let mut open: Vec<[u32; 2]> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .filter(|[a, b]| a != b)
            .collect();
        unpaired(&mut open);
        let mut joins = Vec::new();
        if open.is_empty() {
            return Borders { open, joins };
        }

        // Pair the rest by ends that coincide but for rounding.
        let near = clusters(&open, points, tolerance);
        joins.extend(near.iter().map(|(&id, &first)| [id, first]).filter(|[id, first]| id != first));
        open = open.iter().map(|edge| edge.map(|id| near[&id])).filter(|[a, b]| a != b).collect();
        unpaired(&mut open);

        // Cut the rest at every remaining point, and pair the pieces.
        let pieces = cut(&open, points, tolerance);
        if pieces.len() > open.len() {
            open = pieces;
            joins.extend(&open);
            unpaired(&mut open);
        }
        Borders { open, joins }
    }
}

/// Keeps the edges without a partner in the opposite direction.
fn unpaired(edges: &mut Vec<[u32; 2]>) {
    edges.par_sort_unstable_by_key(|&[a, b]| (a.min(b), a.max(b)));
    let same = |x: &[u32; 2], y: &[u32; 2]| x == y || *x == [y[1], y[0]];
    *edges = edges
        .chunk_by(same)
        .flat_map(|chunk| {
            let [a, b] = chunk[0];
            let forth = chunk.iter().filter(|edge| **edge == [a, b]).count();
            let back = chunk.len() - forth;
            let (edge, count) = if forth > back { ([a, b], forth - back) } else { ([b, a], back - forth) };
            std::iter::repeat_n(edge, count)
        })
        .collect();
}

/// Maps each point of these edges to the first point of its cluster: points less than `tolerance` (m) apart.
fn clusters(edges: &[[u32; 2]], points: &[Vec3], tolerance: f64) -> HashMap<u32, u32> {
    let cell = |p: DVec3| (p / (4.0 * tolerance)).floor().to_array().map(|x| x as i64);
    let (mut cells, mut near) = (HashMap::new(), HashMap::new());
    for &id in edges.iter().flatten() {
        if near.contains_key(&id) {
            continue;
        }
        let p = points[id as usize].as_dvec3();
        let corner = |bits: u32| {
            let side = |bit: u32| if bits & bit == 0 { -tolerance } else { tolerance };
            cell(p + DVec3::new(side(1), side(2), side(4)))
        };
        let first = (0..8).find_map(|bits| cells.get(&corner(bits)).copied()).unwrap_or(id);
        cells.entry(cell(p)).or_insert(first);
        near.insert(id, first);
    }
    near
}

/// Cuts these edges at the points of the edges that lie on them within `tolerance` (m).
fn cut(edges: &[[u32; 2]], points: &[Vec3], tolerance: f64) -> Vec<[u32; 2]> {
    let position = |id: u32| points[id as usize].as_dvec3();
    let mut ids: Vec<u32> = edges.iter().flatten().copied().collect();
    ids.sort_unstable();
    ids.dedup();
    // Sort the points along each axis. Each edge is compared with the points beside it, along the axis with the fewest.
    let along: [Vec<(f64, u32)>; 3] = [0, 1, 2].map(|axis| {
        let mut along: Vec<_> = ids.iter().map(|&id| (position(id)[axis], id)).collect();
        along.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        along
    });
    let mut comparisons = 0;
    let mut pieces = Vec::with_capacity(edges.len());
    for &[from, to] in edges {
        let (start, end) = (position(from), position(to));
        let [low, high] = [start.min(end) - tolerance, start.max(end) + tolerance];
        let beside = |axis: usize| {
            let first = along[axis].partition_point(|(at, _)| *at < low[axis]);
            let last = along[axis].partition_point(|(at, _)| *at <= high[axis]);
            &along[axis][first..last]
        };
        let beside = [beside(0), beside(1), beside(2)].into_iter().min_by_key(|beside| beside.len());
        let beside = beside.unwrap_or_default();
        comparisons += beside.len();
        if comparisons > MAX_COMPARISONS {
            pieces.push([from, to]);
            continue;
        }
        let way = end - start;
        let length = way.length();
        let on_edge = |&(_, id): &(f64, u32)| {
            let offset = position(id) - start;
            let at = offset.dot(way) / length;
            let is_between = at > tolerance && at < length - tolerance;
            let is_on = (offset - way * (at / length)).length_squared() <= tolerance * tolerance;
            (is_between && is_on && id != from && id != to).then_some((at, id))
        };
        let mut on_edge: Vec<(f64, u32)> = beside.iter().filter_map(on_edge).collect();
        on_edge.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut last = from;
        for id in on_edge.into_iter().map(|(_, id)| id).chain([to]) {
            pieces.push([last, id]);
            last = id;
        }
    }
    pieces
}
