//! Solids that triangles bound, and whether their surfaces are closed. Imports interface.

use std::collections::HashMap;

use caustics_kernels::interface::triangle::Triangle;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::borders::Borders;
use super::geometry;

/// Maximum number of compared pairs of a cavity and a solid. Above it, all closed parts are one solid.
const MAX_PAIRS: usize = 1 << 24;

/// Solids bounded by triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solids {
    /// Whether each edge occurs equally often in both directions, so that no border is open.
    pub is_closed: bool,
    /// Boxes around connected parts (m).
    pub boxes: Vec<[Vec3; 2]>,
    /// The solids. A cavity belongs to the solid around it; all open parts are one solid.
    pub solids: Vec<Solid>,
    /// Index of each triangle's solid.
    pub of_triangle: Vec<u32>,
}

/// A connected part with its cavities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Box around the solid (m).
    pub bounds: [Vec3; 2],
    /// Volume of the box (m^3); for the open solid, of its largest part's box.
    pub size: f64,
    /// Enclosed volume (m^3); negative if fronts face inwards.
    pub volume: f64,
    /// Whether the solid has an open border.
    pub is_open: bool,
}

impl Solids {
    /// Finds the solids of these triangles; `origin` (m) was subtracted from their corners. Corners coincide if they are equal
    /// or, along borders, differ by rounding.
    pub fn from_triangles(triangles: &[Triangle], origin: DVec3) -> Solids {
        let (ids, points) = welded(triangles);
        let Borders { open, joins } = Borders::from_triangles(&ids, &points, tolerance(&points, origin));

        // Connect parts: by corners of triangles, by rounding, and along split edges.
        let mut roots = Roots((0..points.len() as u32).collect());
        ids.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]).chain(joins).for_each(|[a, b]| roots.join(a, b));
        let mut of_root: HashMap<u32, usize> = HashMap::new();
        let mut parts: Vec<Solid> = Vec::new();
        for (id, &p) in points.iter().enumerate() {
            let part = *of_root.entry(roots.find(id as u32)).or_insert_with(|| {
                parts.push(Solid { bounds: [p; 2], size: 0.0, volume: 0.0, is_open: false });
                parts.len() - 1
            });
            let [low, high] = &mut parts[part].bounds;
            (*low, *high) = (low.min(p), high.max(p));
        }
        let mut of_triangle = Vec::with_capacity(triangles.len());
        for (triangle, corners) in triangles.iter().zip(&ids) {
            let part = of_root[&roots.find(corners[0])];
            let [a, b, c] = geometry::corners(triangle);
            parts[part].volume += a.dot(b.cross(c)) / 6.0;
            of_triangle.push(part as u32);
        }
        open.iter().for_each(|[a, _]| parts[of_root[&roots.find(*a)]].is_open = true);
        parts.iter_mut().for_each(|part| part.size = volume_of_box(&part.bounds));

        let boxes = parts.iter().map(|part| part.bounds).collect();
        let into = owners(&parts);
        let (solids, of_part) = merged(&parts, &into);
        of_triangle.iter_mut().for_each(|part| *part = of_part[*part as usize]);
        Solids { is_closed: open.is_empty(), boxes, solids, of_triangle }
    }
}

/// Maximum distance (m) of coinciding border points. Corners, and points of edges between them, are rounded in the file's space and
/// around the origin, by less than 4 ulp in all. Gaps as wide as 1e-5 of the whole stay open.
fn tolerance(points: &[Vec3], origin: DVec3) -> f64 {
    let [low, high] = geometry::box_around(points.iter().map(|p| p.as_dvec3()));
    let max_abs = |p: DVec3| p.abs().max_element();
    let rounding = max_abs(low + origin).max(max_abs(high + origin)) * 2f64.powi(-20);
    let own = max_abs(low).max(max_abs(high)) * 2f64.powi(-22);
    rounding.min(1e-5 * low.distance(high)).max(own).max(f64::MIN_POSITIVE)
}

fn volume_of_box(&[low, high]: &[Vec3; 2]) -> f64 {
    let DVec3 { x, y, z } = (high - low).as_dvec3();
    x * y * z
}

/// Part that each part merges with: open parts with the first open one, a cavity with the smallest solid around it.
fn owners(parts: &[Solid]) -> Vec<usize> {
    let mut into: Vec<usize> = (0..parts.len()).collect();
    let parts_where = |is_wanted: fn(&Solid) -> bool| -> Vec<usize> {
        (0..parts.len()).filter(|&part| is_wanted(&parts[part])).collect()
    };
    let open = parts_where(|part| part.is_open);
    open.iter().for_each(|&part| into[part] = open[0]);
    let cavities = parts_where(|part| !part.is_open && part.volume < 0.0);
    let mut solids = parts_where(|part| !part.is_open && part.volume >= 0.0);
    solids.sort_by(|&a, &b| parts[a].size.total_cmp(&parts[b].size));
    if cavities.len().saturating_mul(solids.len()) > MAX_PAIRS {
        cavities.iter().chain(&solids).for_each(|&part| into[part] = cavities[0]);
        return into;
    }
    for cavity in cavities {
        let [low, high] = parts[cavity].bounds;
        let holds = |&&solid: &&usize| {
            let [lower, upper] = parts[solid].bounds;
            lower.cmple(low).all() && high.cmple(upper).all() && parts[solid].volume > -parts[cavity].volume
        };
        into[cavity] = solids.iter().find(holds).copied().unwrap_or(cavity);
    }
    into
}

/// Merges parts into solids, and returns the solid of each part.
fn merged(parts: &[Solid], into: &[usize]) -> (Vec<Solid>, Vec<u32>) {
    let mut solids: Vec<Solid> = Vec::new();
    let mut of_owner = vec![u32::MAX; parts.len()];
    let mut of_part = Vec::with_capacity(parts.len());
    for (part, &owner) in parts.iter().zip(into) {
        let index = &mut of_owner[owner];
        if *index == u32::MAX {
            *index = solids.len() as u32;
            solids.push(*part);
        } else {
            let solid = &mut solids[*index as usize];
            let ([low, high], [lower, upper]) = (part.bounds, solid.bounds);
            solid.bounds = [low.min(lower), high.max(upper)];
            solid.size = solid.size.max(part.size);
            solid.volume += part.volume;
        }
        of_part.push(*index);
    }
    (solids, of_part)
}

/// Disjoint sets of connected points.
struct Roots(Vec<u32>);

impl Roots {
    /// Smallest point that is connected with this one.
    fn find(&mut self, mut id: u32) -> u32 {
        let Roots(parents) = self;
        while parents[id as usize] != id {
            parents[id as usize] = parents[parents[id as usize] as usize];
            id = parents[id as usize];
        }
        id
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// Corners as indices of distinct points.
fn welded(triangles: &[Triangle]) -> (Vec<[u32; 3]>, Vec<Vec3>) {
    // Both zeros are equal.
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

    fn solids(triangles: &[Triangle]) -> Solids {
        Solids::from_triangles(triangles, DVec3::ZERO)
    }

    /// Total enclosed volume (m^3).
    fn volume(found: &Solids) -> f64 {
        found.solids.iter().map(|solid| solid.volume).sum()
    }

    fn turned(triangles: Vec<Triangle>) -> Vec<Triangle> {
        triangles.into_iter().map(|Triangle { a, b, c }| Triangle { a, b: c, c: b }).collect()
    }

    /// A cube whose faces are cut in grids of different sizes, so that corners of one face lie on edges of others.
    fn patched(counts: [u32; 6]) -> Vec<Triangle> {
        let faces = cube(Vec3::splat(0.1));
        let patch = |(pair, count): (&[Triangle], u32)| {
            let [first, second] = [pair[0], pair[1]];
            let (right, up) = (first.b - first.a, second.c - first.a);
            let at = move |x: u32, y: u32| {
                first.a + right * (x as f32 / count as f32) + up * (y as f32 / count as f32)
            };
            let square = move |id: u32| {
                let (x, y) = (id % count, id / count);
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                [Triangle { a, b, c }, Triangle { a, b: c, c: d }]
            };
            (0..count * count).flat_map(square).collect::<Vec<_>>()
        };
        faces.chunks(2).zip(counts).flat_map(patch).collect()
    }

    #[test]
    fn closed_box_has_its_volume_and_bounds() {
        let found = solids(&cube(Vec3::splat(2.0)));
        assert!(found.is_closed && (volume(&found) - 1.0).abs() < 1e-6);
        assert_eq!(found.boxes, [[Vec3::splat(2.0), Vec3::splat(3.0)]]);
        assert!((volume(&solids(&turned(cube(Vec3::ZERO)))) + 1.0).abs() < 1e-6);
    }

    #[test]
    fn missing_or_flipped_triangle_opens_a_border() {
        let mut open = cube(Vec3::ZERO);
        let Triangle { a, b, c } = open.pop().expect("twelve");
        assert!(!solids(&open).is_closed);
        open.push(Triangle { a, b: c, c: b });
        assert!(!solids(&open).is_closed);
    }

    #[test]
    fn rounding_opens_no_border() {
        let mut cube = cube(Vec3::splat(0.1));
        cube[3].a.x = cube[3].a.x.next_up();
        cube[7].b.y = cube[7].b.y.next_down();
        let found = solids(&cube);
        assert!(found.is_closed && found.solids.len() == 1);
        cube[3].a.x += 1e-4;
        assert!(!solids(&cube).is_closed);
    }

    #[test]
    fn edge_along_several_shorter_ones_opens_no_border() {
        // One corner on an edge; several, at equal and different positions on both sides; thirds, which are rounded.
        for counts in [[1, 1, 2, 1, 1, 1], [2, 3, 4, 1, 5, 6], [3, 7, 11, 13, 17, 19]] {
            let mut patched = patched(counts);
            let found = solids(&patched);
            assert!(found.is_closed && found.solids.len() == 1, "{counts:?}: {found:?}");
            assert!((volume(&found) - 1.0).abs() < 1e-5);
            // Far from the origin, coordinates are rounded more.
            let origin = DVec3::splat(100.0);
            let far = |p: Vec3| ((p.as_dvec3() + origin).as_vec3().as_dvec3() - origin).as_vec3();
            let moved = patched.iter().map(|t| Triangle { a: far(t.a), b: far(t.b), c: far(t.c) });
            assert!(Solids::from_triangles(&moved.collect::<Vec<_>>(), origin).is_closed, "{counts:?}");
            // A hole stays open,
            let lost = patched.pop().expect("many");
            assert!(!solids(&patched).is_closed && solids(&patched).solids.iter().all(|solid| solid.is_open));
            // and so does a gap beside an edge that is wider than rounding.
            patched.push(Triangle { c: lost.c + 1e-4, ..lost });
            assert!(!solids(&patched).is_closed, "{counts:?}");
        }
    }

    #[test]
    fn corner_beside_an_edge_by_rounding_opens_no_border() {
        let mut patched = patched([1, 1, 2, 1, 1, 1]);
        // Move the corners of the third face that lie within edges by two units in the last place.
        let middle = |p: &Vec3| p.to_array().into_iter().filter(|x| (x - 0.6).abs() < 1e-6).count() == 1;
        let mut moved = 0;
        for triangle in &mut patched {
            for p in [&mut triangle.a, &mut triangle.b, &mut triangle.c] {
                if middle(p) {
                    *p = p.map(|x| if (x - 1.1).abs() < 1e-6 { x.next_down().next_down() } else { x });
                    moved += 1;
                }
            }
        }
        assert!(moved > 4 && solids(&patched).is_closed);
    }

    #[test]
    fn edges_that_meet_only_at_their_ends_stay_open() {
        // A finely cut box without one face is open, and so is a strip whose edges cross without a common corner.
        let mut open = patched([4, 3, 5, 2, 6, 1]);
        open.truncate(open.len() - 2);
        assert!(!solids(&open).is_closed);
        let strip = [
            Triangle { a: Vec3::ZERO, b: Vec3::X, c: Vec3::Y },
            Triangle { a: Vec3::new(0.5, -1.0, 0.0), b: Vec3::new(0.5, 1.0, 0.0), c: Vec3::Z },
        ];
        assert_eq!(solids(&strip).solids.len(), 1, "open parts must be one solid");
        assert!(!solids(&strip).is_closed);
    }

    #[test]
    fn separate_parts_are_separate_solids() {
        let found = solids(&[cube(Vec3::ZERO), cube(Vec3::splat(5.0))].concat());
        assert!(found.is_closed && found.boxes.len() == 2 && found.solids.len() == 2);
        assert!(found.solids.iter().all(|solid| (solid.size - 1.0).abs() < 1e-6));
        assert_eq!(found.of_triangle, [vec![0; 12], vec![1; 12]].concat());
    }

    #[test]
    fn cavity_belongs_to_the_smallest_solid_around_it() {
        let scaled = |triangles: Vec<Triangle>, by: f32| -> Vec<Triangle> {
            let by = |p: Vec3| 0.5 + (p - 0.5) * by;
            triangles.iter().map(|t| Triangle { a: by(t.a), b: by(t.b), c: by(t.c) }).collect()
        };
        let cube = || cube(Vec3::ZERO);
        // A ball in the cavity of a box in a larger box, all of one material.
        let all = [scaled(cube(), 4.0), scaled(turned(cube()), 0.5), cube(), scaled(cube(), 0.2)].concat();
        let found = solids(&all);
        assert_eq!((found.boxes.len(), found.solids.len()), (4, 3));
        assert_eq!(found.of_triangle[12], found.of_triangle[24]);
        let volumes: Vec<f64> = found.solids.iter().map(|solid| solid.volume).collect();
        let expected = [64.0, 1.0 - 0.125, 0.008];
        for volume in expected {
            assert!(volumes.iter().any(|found| (found - volume).abs() < 1e-5), "{volumes:?}");
        }
    }
}
