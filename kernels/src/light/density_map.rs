//! A map of how densely light paths start, and the warp that obeys it: a pyramid of sums over texels of the unit square,
//! descended by turning uniform numbers into shares of the sums [McCool and Harwood 1997, Probability trees]. It allots
//! rays as the quadtree of counts of [Yang and Ouyang 2021] does, but to random numbers instead of ray indices.

use spirv_std::glam::Vec2;

/// Texels of a side, as a power of two.
pub const SIDE_LOG2: u32 = 7;
/// Texels of a side.
pub const SIDE: u32 = 1 << SIDE_LOG2;
/// Texels of a map.
pub const TEXELS: u32 = SIDE * SIDE;
/// Sums of a map, all levels: the texels' own densities are the first.
pub const NODES: u32 = (4 * TEXELS - 1) / 3;
/// Maps there are. A light has that of its row, modulo this: lamps of many triangles share them.
pub const MAPS: u32 = 8;
/// Words of a texel's feedback: sum of screen areas, of their squares (two words each), photons, paths.
pub const FEEDBACK_WORDS: u32 = 6;

/// First node of a level of one map.
#[inline]
pub fn first(level: u32) -> u32 {
    (4 * TEXELS - ((4 * TEXELS) >> (2 * level))) / 3
}

/// The map of this light.
#[inline]
pub fn map_of(light: u32) -> u32 {
    light % MAPS
}

/// Maps that a table of so many lights uses.
#[inline]
pub fn map_count(light_count: u32) -> u32 {
    light_count.min(MAPS)
}

/// A place of the unit square drawn by its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Coordinates in the unit square.
    pub at: Vec2,
    /// Density there; 1 in the mean.
    pub density: f32,
    /// Texel, counted over all maps.
    pub texel: u32,
}

/// Draws a place of map `map` by two uniform numbers. A map without sums is uniform.
#[inline(always)]
pub fn draw(tree: &[f32], map: u32, uniform: Vec2) -> Place {
    let base = map * NODES;
    let total = tree[(base + first(SIDE_LOG2)) as usize];
    let (mut u, mut v) = (uniform.x, uniform.y);
    let (mut x, mut y) = (0, 0);
    let mut density = 1.0;
    if total > 0.0 {
        let mut level = SIDE_LOG2;
        while level > 0 {
            level -= 1;
            let side = SIDE >> level;
            let corner = base + first(level) + 2 * y * side + 2 * x;
            let (a, b) = (tree[corner as usize], tree[(corner + 1) as usize]);
            let (c, d) = (tree[(corner + side) as usize], tree[(corner + side + 1) as usize]);
            let upper = split(v, a + b, c + d);
            v = upper.1;
            let right = if upper.0 == 0 { split(u, a, b) } else { split(u, c, d) };
            u = right.1;
            x = 2 * x + right.0;
            y = 2 * y + upper.0;
        }
        density = tree[(base + y * SIDE + x) as usize] * (TEXELS as f32 / total);
    } else {
        let (column, row) = (u * SIDE as f32, v * SIDE as f32);
        (x, y) = ((column as u32).min(SIDE - 1), (row as u32).min(SIDE - 1));
        (u, v) = (column - x as f32, row - y as f32);
    }
    let scale = 1.0 / SIDE as f32;
    let at = Vec2::new((x as f32 + u.min(1.0)) * scale, (y as f32 + v.min(1.0)) * scale);
    Place { at, density, texel: map * TEXELS + y * SIDE + x }
}

/// Which of two shares a uniform number falls into, and how far into it.
#[inline(always)]
fn split(u: f32, first: f32, second: f32) -> (u32, f32) {
    let along = u * (first + second);
    if along < first { (0, along / first) } else { (1, (along - first) / second) }
}

/// The polar numbers (share of the disc's area, share of a turn) of a place of the unit square, by the map of squares
/// around the middle onto rings [Shirley and Chiu 1997]. It keeps areas: what is uniform stays so, and neighbours stay
/// neighbours, across the disc's middle too.
#[inline]
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
    use crate::math::rng::{Rng, Stream};

    /// A tree over these densities.
    fn tree(densities: impl Fn(u32, u32) -> f32) -> Vec<f32> {
        let mut tree = vec![0.0; NODES as usize];
        for y in 0..SIDE {
            for x in 0..SIDE {
                tree[(y * SIDE + x) as usize] = densities(x, y);
            }
        }
        for level in 1..=SIDE_LOG2 {
            let (side, below) = (SIDE >> level, first(level - 1));
            for node in 0..side * side {
                let (x, y) = (node % side, node / side);
                let corner = (below + 2 * y * 2 * side + 2 * x) as usize;
                let row = 2 * side as usize;
                tree[(first(level) + node) as usize] =
                    tree[corner] + tree[corner + 1] + tree[corner + row] + tree[corner + row + 1];
            }
        }
        tree
    }

    #[test]
    fn levels_follow_each_other() {
        assert_eq!((first(0), first(1)), (0, TEXELS));
        assert_eq!(first(2), TEXELS + TEXELS / 4);
        assert_eq!(first(SIDE_LOG2) + 1, NODES);
    }

    #[test]
    fn places_follow_the_densities_and_average_to_one() {
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
        let tree = tree(density);
        let (mut left, mut block, mut inverse, mut moment) = (0.0, 0.0, 0.0, 0.0);
        let count = 400_000;
        for path in 0..count {
            let u = Rng::new(Stream::Light, 3, path, 0).next4();
            let place = draw(&tree, 0, Vec2::new(u.x, u.y));
            let (x, y) = (place.texel % SIDE, place.texel / SIDE);
            assert!((place.at * SIDE as f32 - Vec2::new(x as f32, y as f32)).max_element() <= 1.001);
            let weight = 1.0 / f64::from(place.density);
            inverse += weight;
            moment += weight * f64::from(place.at.x);
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
        let place = draw(&vec![0.0; NODES as usize], 0, Vec2::new(0.3, 0.7));
        assert!((place.at - Vec2::new(0.3, 0.7)).length() < 1e-6 && place.density == 1.0);
    }

    /// Rings of equal area hold equal shares of the square, and so do sectors; the middle is the pole.
    #[test]
    fn polar_numbers_of_uniform_places_are_uniform() {
        let n = 400;
        let mut bins = [[0u32; 8]; 5];
        for i in 0..n * n {
            let at = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let polar = to_polar(at);
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
