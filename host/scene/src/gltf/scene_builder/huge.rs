//! Splits triangles that are huge beside the objects between them, such as a plain of 20 km under a cup.
//!
//! The precision of a hit is that of its triangle's corners in f32, and a ray leaves with a clearance in proportion. A plain is
//! therefore split until its triangles are as large as their distance from the small objects. Positions are f64 here. The two
//! ends of an edge alone decide whether and where it is split, so that no crack opens between triangles that share it.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::corner::Corner;
use crate::geometry::MAX_COORDINATE;

/// Minimum ratio of a huge triangle's length to the width of all smaller triangles together. At this ratio a ray leaves it at
/// more than a thousandth of that width (`offset::clearance` is 2^-19 of the largest coordinate).
const HUGE: f64 = 1024.0;

/// Maximum length of an edge relative to its distance from the small objects. For every factor below 2 sqrt(3) some edge of a
/// triangle around them is longer (Weitzenboeck's inequality).
const GRADE: f64 = 2.0;

/// Maximum number of triangles that splitting adds; a plain of 200 km around 0.3 m takes some hundred.
const MAX_ADDED: usize = 1 << 20;

/// Ball around objects that are small beside the rest of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Centre (m).
    pub centre: DVec3,
    /// Radius (m).
    pub radius: f64,
}

/// Triangles whose longest edges share a power of two.
#[derive(Clone, Copy)]
struct Size {
    /// Shortest of these longest edges (m).
    min_length: f64,
    /// Box around the triangles (m).
    bounds: [DVec3; 2],
}

/// Finds the small objects of a scene of these triangles, the smallest first; most scenes have none.
///
/// Triangles are huge beside all smaller ones only if no triangle has a length between, over ten powers of two. Sorting by power
/// of two therefore suffices.
pub fn details(triangles: impl Iterator<Item = [DVec3; 3]>) -> Vec<Detail> {
    let usable = |p: &DVec3| p.abs().max_element() <= MAX_COORDINATE;
    let mut sizes: BTreeMap<u64, Size> = BTreeMap::new();
    for [a, b, c] in triangles.filter(|corners| corners.iter().all(usable)) {
        let length = a.distance(b).max(b.distance(c)).max(c.distance(a));
        if (b - a).cross(c - a).length() > 1e-7 * length * length {
            let none = Size { min_length: f64::MAX, bounds: [DVec3::MAX, DVec3::MIN] };
            let size = sizes.entry(length.to_bits() >> (f64::MANTISSA_DIGITS - 1)).or_insert(none);
            let [lower, upper] = size.bounds;
            size.min_length = size.min_length.min(length);
            size.bounds = [lower.min(a).min(b).min(c), upper.max(a).max(b).max(c)];
        }
    }
    let sizes: Vec<Size> = sizes.into_values().collect();
    let (mut lower, mut upper) = (DVec3::MAX, DVec3::MIN);
    let mut found = Vec::new();
    for pair in sizes.windows(2) {
        (lower, upper) = (lower.min(pair[0].bounds[0]), upper.max(pair[0].bounds[1]));
        let (centre, radius) = (0.5 * (lower + upper), 0.5 * lower.distance(upper));
        // Below this size f64 does not distinguish the objects from a point.
        if pair[1].min_length > HUGE * 2.0 * radius && radius > 1e-12 * centre.abs().max_element() {
            found.push(Detail { centre, radius });
        }
    }
    found
}

/// Splits triangles around small objects; each part inherits the other properties. The order stays.
pub fn split<T: Copy>(details: &[Detail], corners: &mut Vec<[Corner; 3]>, rest: &mut Vec<T>) {
    if details.is_empty() {
        return;
    }
    let max_corners = corners.len() + MAX_ADDED;
    let (whole, of_whole) = (std::mem::take(corners), std::mem::take(rest));
    let mut left = whole.len();
    let mut stack = Vec::new();
    for (triangle, its) in whole.into_iter().zip(of_whole) {
        left -= 1;
        stack.push(triangle);
        while let Some([a, b, c]) = stack.pop() {
            let too_long = |p: Corner, q: Corner| {
                let length = p.position.distance(q.position);
                if is_too_long(details, p.position, q.position) { length } else { 0.0 }
            };
            let lengths = [too_long(a, b), too_long(b, c), too_long(c, a)];
            let longest = lengths[0].max(lengths[1]).max(lengths[2]);
            if longest == 0.0 || corners.len() + stack.len() + left >= max_corners {
                corners.push([a, b, c]);
                rest.push(its);
                continue;
            }
            // Rotate the triangle so that its longest edge is the first.
            let [a, b, c] = match lengths {
                [first, ..] if first == longest => [a, b, c],
                [_, second, _] if second == longest => [b, c, a],
                _ => [c, a, b],
            };
            let middle = a.middle(&b);
            stack.extend([[middle, b, c], [a, middle, c]]);
        }
    }
}

/// Whether an edge is longer than the small objects allow at its nearest point.
fn is_too_long(details: &[Detail], p: DVec3, q: DVec3) -> bool {
    // Order the ends, so that both triangles of an edge round alike.
    let (p, q) = if p.to_array() <= q.to_array() { (p, q) } else { (q, p) };
    let along = q - p;
    let length = along.length();
    details.iter().any(|&Detail { centre, radius }| {
        let nearest = p + along * ((centre - p).dot(along) / (length * length)).clamp(0.0, 1.0);
        length > GRADE * ((nearest.distance(centre) - radius).max(0.0) + 2.0 * radius)
    })
}
