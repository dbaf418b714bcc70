//! Whether triangles close, and the solids that they bound. Imports interface.

use std::collections::HashMap;

use caustics_kernels::interface::triangle::Triangle;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::geometry;

/// What triangles bound.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solids {
    /// Whether every edge is used as often one way as the other: no border is open.
    pub is_closed: bool,
    /// What they enclose (m^3); negative where their fronts look inwards.
    pub volume: f64,
    /// Boxes around what hangs together (m).
    pub boxes: Vec<[Vec3; 2]>,
}

impl Solids {
    /// What these triangles bound. Corners are one where they are equal, or, along borders, differ by rounding.
    pub fn of(triangles: &[Triangle]) -> Solids {
        let (ids, points) = welded(triangles);
        let mut edges: Vec<[u32; 2]> =
            ids.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).filter(|[a, b]| a != b).collect();
        unpaired(&mut edges);
        if !edges.is_empty() {
            let most = points.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
            let near = clusters(&edges, &points, most);
            edges = edges.iter().map(|edge| edge.map(|id| near[&id])).filter(|[a, b]| a != b).collect();
            unpaired(&mut edges);
        }
        let volume = triangles.iter().map(|triangle| {
            let [a, b, c] = geometry::corners(triangle);
            a.dot(b.cross(c)) / 6.0
        });
        Solids { is_closed: edges.is_empty(), volume: volume.sum(), boxes: boxes(&ids, &points) }
    }

    /// Volume of the largest box (m^3).
    pub fn size(&self) -> f64 {
        let volume = |&[low, high]: &[Vec3; 2]| {
            let DVec3 { x, y, z } = (high - low).as_dvec3();
            x * y * z
        };
        self.boxes.iter().map(volume).fold(0.0, f64::max)
    }
}

/// Corners as indices of different points.
fn welded(triangles: &[Triangle]) -> (Vec<[u32; 3]>, Vec<Vec3>) {
    // Zeros of both signs are one.
    let bits = |p: Vec3| (p + 0.0).to_array().map(f32::to_bits);
    let corners = triangles.iter().flat_map(|t| [t.a, t.b, t.c]);
    let mut sorted: Vec<_> = corners.zip(0u32..).map(|(p, at)| (bits(p), at)).collect();
    sorted.par_sort_unstable();
    let (mut ids, mut points) = (vec![[0; 3]; triangles.len()], Vec::new());
    let mut last = None;
    for (bits, at) in sorted {
        if last != Some(bits) {
            points.push(Vec3::from(bits.map(f32::from_bits)));
            last = Some(bits);
        }
        ids[at as usize / 3][at as usize % 3] = points.len() as u32 - 1;
    }
    (ids, points)
}

/// Leaves the edges that have no partner the other way round.
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

/// Points of these edges that are one but for rounding: a few ulp of the largest coordinate, `most`.
fn clusters(edges: &[[u32; 2]], points: &[Vec3], most: f32) -> HashMap<u32, u32> {
    let tolerance = (f64::from(most) * 2f64.powi(-22)).max(f64::MIN_POSITIVE);
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

/// Boxes around the points that triangles join.
fn boxes(ids: &[[u32; 3]], points: &[Vec3]) -> Vec<[Vec3; 2]> {
    let mut parents: Vec<u32> = (0..points.len() as u32).collect();
    fn root(parents: &mut [u32], mut id: u32) -> u32 {
        while parents[id as usize] != id {
            parents[id as usize] = parents[parents[id as usize] as usize];
            id = parents[id as usize];
        }
        id
    }
    for &[a, b, c] in ids {
        for other in [b, c] {
            let (one, other) = (root(&mut parents, a), root(&mut parents, other));
            parents[one.max(other) as usize] = one.min(other);
        }
    }
    let mut of_root: HashMap<u32, usize> = HashMap::new();
    let mut boxes: Vec<[Vec3; 2]> = Vec::new();
    for (id, &p) in points.iter().enumerate() {
        let index = *of_root.entry(root(&mut parents, id as u32)).or_insert_with(|| {
            boxes.push([p; 2]);
            boxes.len() - 1
        });
        boxes[index] = [boxes[index][0].min(p), boxes[index][1].max(p)];
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with corners at `low` and `low + 1`; its fronts look outwards.
    fn cube(low: Vec3) -> Vec<Triangle> {
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let unit = |axis: usize| 0.5 * Vec3::AXES[axis % 3];
                let (right, up) = (sign * unit(axis + 1), unit(axis + 2));
                let centre = low + 0.5 + sign * unit(axis);
                let [a, b, c, d] = [-right - up, right - up, right + up, up - right].map(|p| centre + p);
                triangles.extend([Triangle { a, b, c }, Triangle { a, b: c, c: d }]);
            }
        }
        triangles
    }

    #[test]
    fn a_closed_box_has_its_volume_and_its_place() {
        let solids = Solids::of(&cube(Vec3::splat(2.0)));
        assert!(solids.is_closed && (solids.volume - 1.0).abs() < 1e-6);
        assert_eq!(solids.boxes, [[Vec3::splat(2.0), Vec3::splat(3.0)]]);
        let inwards: Vec<_> =
            cube(Vec3::ZERO).iter().map(|&Triangle { a, b, c }| Triangle { a, b: c, c: b }).collect();
        assert!((Solids::of(&inwards).volume + 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_missing_or_turned_triangle_is_a_border() {
        let mut open = cube(Vec3::ZERO);
        let Triangle { a, b, c } = open.pop().expect("twelve");
        assert!(!Solids::of(&open).is_closed);
        open.push(Triangle { a, b: c, c: b });
        assert!(!Solids::of(&open).is_closed);
    }

    #[test]
    fn rounding_opens_no_border() {
        let mut cube = cube(Vec3::splat(0.1));
        cube[3].a.x = cube[3].a.x.next_up();
        cube[7].b.y = cube[7].b.y.next_down();
        assert!(Solids::of(&cube).is_closed);
        cube[3].a.x += 1e-4;
        assert!(!Solids::of(&cube).is_closed);
    }

    #[test]
    fn parts_have_boxes_of_their_own() {
        let two = [cube(Vec3::ZERO), cube(Vec3::splat(5.0))].concat();
        let solids = Solids::of(&two);
        assert!(solids.is_closed && solids.boxes.len() == 2);
        assert!((solids.size() - 1.0).abs() < 1e-6);
    }
}
