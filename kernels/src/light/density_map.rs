//! Piecewise-constant 2D distribution (pbrt: `PiecewiseConstant2D`) of the environment and of guided emission: a pyramid of sums
//! over texels of the unit square. A sample descends the pyramid by turning uniform numbers into shares of the sums [McCool and
//! Harwood 1997, Probability trees]. It distributes rays as the quadtree of counts of [Yang and Ouyang 2021] does, but over
//! random numbers instead of ray indices.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use caustics_kernel_macros::shared;
use spirv_std::glam::Vec2;

/// The layout of maps of 2^`SIDE_LOG2` texels a side: sums over nodes of all levels, one map behind the other. The texels' own
/// densities are the first level.
pub struct Pyramid<const SIDE_LOG2: u32>;

impl<const SIDE_LOG2: u32> Pyramid<SIDE_LOG2> {
    /// Number of texels of a side.
    pub const SIDE: u32 = 1 << SIDE_LOG2;
    /// Number of texels of a map.
    pub const TEXELS: u32 = Self::SIDE * Self::SIDE;
    /// Number of sums of a map, over all levels.
    pub const NODES: u32 = (4 * Self::TEXELS - 1) / 3;
    /// Level of the root.
    pub const TOP: u32 = SIDE_LOG2;

    /// Index of the first node of a level within a map.
    #[inline]
    pub fn first(level: u32) -> u32 {
        (4 * Self::TEXELS - ((4 * Self::TEXELS) >> (2 * level))) / 3
    }

    /// Number of nodes of a level over `maps` maps.
    #[inline]
    pub fn count(level: u32, maps: u32) -> u32 {
        maps * (Self::TEXELS >> (2 * level))
    }

    /// A node of a level, counted over all maps.
    #[inline]
    pub fn node(level: u32, index: u32) -> Node {
        let nodes = Self::TEXELS >> (2 * level);
        let (map, node) = (index / nodes, index % nodes);
        let side = Self::SIDE >> level;
        let base = map * Self::NODES;
        let mut below = 0;
        if level > 0 {
            below = base + Self::first(level - 1) + 4 * (node / side) * side + 2 * (node % side);
        }
        Node {
            slot: base + Self::first(level) + node,
            below: [below, below + 1, below + 2 * side, below + 2 * side + 1],
        }
    }

    /// The sum of a map.
    #[inline(always)]
    pub fn total(pyramid: &[f32], map: u32) -> f32 {
        pyramid[(map * Self::NODES + Self::first(SIDE_LOG2)) as usize]
    }

    /// Index of the texel of a point of the unit square, within its map.
    #[inline]
    pub fn texel_at(at: Vec2) -> u32 {
        let (x, y) = ((at.x * Self::SIDE as f32) as u32, (at.y * Self::SIDE as f32) as u32);
        y.min(Self::SIDE - 1) * Self::SIDE + x.min(Self::SIDE - 1)
    }

    /// Samples a point of map `map` by two uniform numbers. A map without sums is uniform.
    #[inline(always)]
    pub fn sample(pyramid: &[f32], map: u32, uniform: Vec2) -> PyramidSample {
        let base = map * Self::NODES;
        let total = Self::total(pyramid, map);
        let (mut u, mut v) = (uniform.x, uniform.y);
        let (mut x, mut y) = (0, 0);
        let mut density = 1.0;
        if total > 0.0 {
            // Descend from the root: choose a half of each node by its sum, first in v, then in u
            let mut level = SIDE_LOG2;
            while level > 0 {
                level -= 1;
                let side = Self::SIDE >> level;
                let corner = base + Self::first(level) + 2 * y * side + 2 * x;
                let (a, b) = (pyramid[corner as usize], pyramid[(corner + 1) as usize]);
                let (c, d) = (pyramid[(corner + side) as usize], pyramid[(corner + side + 1) as usize]);
                let upper = split(v, a + b, c + d);
                v = upper.1;
                let right = if upper.0 == 0 { split(u, a, b) } else { split(u, c, d) };
                u = right.1;
                x = 2 * x + right.0;
                y = 2 * y + upper.0;
            }
            density = pyramid[(base + y * Self::SIDE + x) as usize] * (Self::TEXELS as f32 / total);
        } else {
            // Sample a map without sums uniformly
            let (column, row) = (u * Self::SIDE as f32, v * Self::SIDE as f32);
            (x, y) = ((column as u32).min(Self::SIDE - 1), (row as u32).min(Self::SIDE - 1));
            (u, v) = (column - x as f32, row - y as f32);
        }
        let scale = 1.0 / Self::SIDE as f32;
        let at = Vec2::new((x as f32 + u.min(1.0)) * scale, (y as f32 + v.min(1.0)) * scale);
        PyramidSample { at, density, texel: map * Self::TEXELS + y * Self::SIDE + x }
    }
}

/// A node of a pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Index of the node among the sums of all maps.
    pub slot: u32,
    /// Indices of the four nodes that it sums; meaningless for a texel.
    pub below: [u32; 4],
}

/// A point of the unit square sampled by its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PyramidSample {
    /// Coordinates in the unit square.
    pub at: Vec2,
    /// Density there; 1 on average.
    pub density: f32,
    /// Texel, counted over all maps.
    pub texel: u32,
}

/// Chooses the first (0) or the second (1) of two shares by a uniform number. Returns the choice, and the number rescaled within
/// it.
#[shared]
fn split(u: f32, first: f32, second: f32) -> (u32, f32) {
    let along = u * (first + second);
    if along < first { (0, along / first) } else { (1, (along - first) / second) }
}

/// Point of the unit square with these polar numbers; the inverse of `to_polar`.
#[shared]
pub fn from_polar(polar: Vec2) -> Vec2 {
    let radius = polar.x.sqrt();
    // In eighths of a turn from the middle of the side.
    let eighths = 8.0 * polar.y + 1.0;
    let (a, b);
    if eighths < 2.0 {
        (a, b) = (radius, radius * (eighths - 1.0));
    } else if eighths < 4.0 {
        (a, b) = (radius * (3.0 - eighths), radius);
    } else if eighths < 6.0 {
        (a, b) = (-radius, radius * (5.0 - eighths));
    } else if eighths < 8.0 {
        (a, b) = (radius * (eighths - 7.0), -radius);
    } else {
        (a, b) = (radius, radius * (eighths - 9.0));
    }
    Vec2::new(0.5 * a + 0.5, 0.5 * b + 0.5)
}

/// Polar numbers (share of the disc's area, share of a turn) of a point of the unit square. The map takes squares around the
/// middle to rings [Shirley and Chiu 1997] and keeps areas: a uniform distribution stays uniform. Neighbours stay neighbours,
/// across the disc's middle too.
#[shared]
pub fn to_polar(at: Vec2) -> Vec2 {
    let (a, b) = (2.0 * at.x - 1.0, 2.0 * at.y - 1.0);
    let (radius, mut turn);
    if a.abs() > b.abs() {
        radius = a.abs();
        turn = b / a * 0.125;
        if a < 0.0 {
            turn += 0.5;
        }
    } else if b != 0.0 {
        radius = b.abs();
        turn = 0.25 - a / b * 0.125;
        if b < 0.0 {
            turn += 0.5;
        }
    } else {
        return Vec2::ZERO;
    }
    if turn < 0.0 {
        turn += 1.0;
    }
    Vec2::new((radius * radius).min(1.0), turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    type Map = Pyramid<7>;
    const SIDE: u32 = Map::SIDE;
    use crate::math::rng::{Rng, Stream};

    /// A pyramid over these densities.
    fn pyramid(densities: impl Fn(u32, u32) -> f32) -> Vec<f32> {
        let mut pyramid: Vec<f32> = vec![0.0; Map::NODES as usize];
        for y in 0..SIDE {
            for x in 0..SIDE {
                pyramid[(y * SIDE + x) as usize] = densities(x, y);
            }
        }
        for level in 1..=Map::TOP {
            for index in 0..Map::count(level, 1) {
                let Node { slot, below } = Map::node(level, index);
                pyramid[slot as usize] = below.map(|child| pyramid[child as usize]).iter().sum();
            }
        }
        pyramid
    }

    #[test]
    fn levels_of_a_pyramid_follow_each_other() {
        assert_eq!((Map::first(0), Map::first(1)), (0, Map::TEXELS));
        assert_eq!(Map::first(2), Map::TEXELS + Map::TEXELS / 4);
        assert_eq!(Map::first(Map::TOP) + 1, Map::NODES);
    }

    #[test]
    fn samples_follow_the_densities_and_weigh_one_on_average() {
        // Left half thin, one dense block.
        let density = |x: u32, y: u32| {
            if x < SIDE / 2 {
                0.125
            } else if (80..84).contains(&x) && (40..48).contains(&y) {
                100.0
            } else {
                1.0
            }
        };
        let pyramid = pyramid(density);
        let (mut left, mut block, mut inverse, mut moment) = (0.0, 0.0, 0.0, 0.0);
        let count = 400_000;
        for path in 0..count {
            let u = Rng::new(Stream::Light, 3, path, 0).next4();
            let sample = Map::sample(&pyramid, 0, Vec2::new(u.x, u.y));
            let (x, y) = (sample.texel % SIDE, sample.texel / SIDE);
            assert!((sample.at * SIDE as f32 - Vec2::new(x as f32, y as f32)).max_element() <= 1.001);
            let weight = 1.0 / f64::from(sample.density);
            inverse += weight;
            moment += weight * f64::from(sample.at.x);
            left += f64::from(u32::from(x < SIDE / 2));
            block += f64::from(u32::from((80..84).contains(&x) && (40..48).contains(&y)));
        }
        let n = f64::from(count);
        let total = 0.125 * 8192.0 + 3200.0 + (8192.0 - 32.0);
        // Standard errors: a share's is sqrt(p (1 - p) / n) < 0.0008; that of weights of at most 8 is below 0.004.
        assert!((left / n - 1024.0 / total).abs() < 0.003, "{}", left / n);
        assert!((block / n - 3200.0 / total).abs() < 0.003, "{}", block / n);
        assert!((inverse / n - 1.0).abs() < 0.012, "{}", inverse / n);
        assert!((moment / n - 0.5).abs() < 0.006, "{}", moment / n);
    }

    #[test]
    fn an_empty_map_is_uniform() {
        let sample = Map::sample(&vec![0.0; Map::NODES as usize], 0, Vec2::new(0.3, 0.7));
        assert!((sample.at - Vec2::new(0.3, 0.7)).length() < 1e-6 && sample.density == 1.0);
    }

    /// Rings of equal area hold equal shares of the square, and so do sectors; the middle is the pole.
    #[test]
    fn polar_numbers_of_uniform_points_are_uniform() {
        let n = 400;
        let mut bins = [[0u32; 8]; 5];
        for i in 0..n * n {
            let at = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let polar = to_polar(at);
            assert!((from_polar(polar) - at).abs().max_element() < 1e-5, "{at} {polar}");
            assert!((0.0..=1.0).contains(&polar.x) && (0.0..1.0).contains(&polar.y));
            bins[((polar.x * 5.0) as usize).min(4)][(polar.y * 8.0) as usize] += 1;
        }
        for bin in bins.iter().flatten() {
            // Cells at the borders of a bin: four sides of at most 180 cells.
            assert!(bin.abs_diff(4000) < 200, "{bins:?}");
        }
        assert!(to_polar(Vec2::splat(0.5)).x == 0.0);
    }
}
