//! Random numbers of camera paths: independent, or points of Sobol sequences over a pixel's frames [Sobol' 1967; direction
//! numbers of Joe and Kuo 2008].
//!
//! A path samples four numbers at a time, a group. Each group has a four-dimensional sequence of its own, whose points are in
//! another order (padding [Kollig and Keller 2002, Efficient multidimensional sampling]). The points of a frame are equal for all
//! pixels and are computed once. Each pixel scrambles their digits by itself [Owen 1995], so that pixels are independent and each
//! number is uniform. The hash is that of Laine and Karras 2011 with the constants of Vegdahl 2021 [Building a better LK hash]. A
//! number is a function of (seed, pixel, frame, dimension): in any order, on any runner.
//!
//! Alternatively, neighbouring pixels share an even set: all are scrambled alike, and each pixel's points are moved by a point of
//! the same sequence. The index of that point is the index of the pixel on a curve through the image that fills squares first
//! [Ahmed and Wonka 2020]. In every frame the numbers of a square of pixels then fill the unit square evenly. Their errors differ
//! and cancel for an eye or a denoiser. In every pixel the numbers of its frames fill the unit square too. Neighbours meet again
//! in other frames of a batch: over very many frames squares of pixels gain less than single pixels.
//!
//! Ahmed and Wonka: Screen-space blue-noise diffusion of Monte Carlo sampling error.
//!
//! Points of one sequence are not independent samples and do not show their variance. Frames therefore take turns in `batches`
//! sequences, and the variance is taken between these.

use crate::interface::sequence::Sequence;
use crate::math::rng::{Rng, units};
use caustics_kernel_macros::shared;
use spirv_std::glam::{UVec4, Vec4};

/// Samples the next four numbers of a camera path, uniform in [0, 1), multiples of 2^-24. Groups behind those of the sequence are
/// independent.
#[inline(always)]
pub fn next4(rng: &mut Rng, sequence: &Sequence) -> Vec4 {
    let group = rng.dimension();
    let is_in = group < sequence.groups;
    let bits = rng.next_bits(if is_in { sequence.batch } else { rng.frame() });
    if !is_in {
        units(bits)
    } else if sequence.width == 0 {
        units(scrambled(sequence.points[group as usize], bits))
    } else {
        let seeds = sequence.seeds[group as usize];
        let pixel = rng.path();
        let curve_index = curve_index(pixel % sequence.width, pixel / sequence.width);
        let moved = sequence.points[group as usize] ^ curve_point(curve_index, seeds);
        units(scrambled(moved, seeds))
    }
}

/// Index of a pixel on the curve: bits of its column and its row in turns, the first digits in the highest bits.
#[shared]
fn curve_index(column: u32, row: u32) -> u32 {
    let spread = |bits: u32| {
        let bits = (bits | bits << 8) & 0x00ff_00ff;
        let bits = (bits | bits << 4) & 0x0f0f_0f0f;
        let bits = (bits | bits << 2) & 0x3333_3333;
        (bits | bits << 1) & 0x5555_5555
    };
    spread(column) | spread(row) << 1
}

/// First two coordinates of two Sobol points for an index on the curve. Each point has another order within each square.
#[shared]
fn curve_point(curve_index: u32, seeds: UVec4) -> UVec4 {
    let shuffled = |seed: u32| laine_karras(curve_index.reverse_bits(), seed).reverse_bits();
    let (first, second) = (shuffled(seeds.z), shuffled(seeds.x));
    UVec4::new(first, second_coordinate(first), second, second_coordinate(second))
}

/// Second coordinate of a Sobol point, with the first binary digit in the lowest bit. It is the polynomial of the index's digits
/// in `x + 1` instead of `x`.
#[inline(always)]
fn second_coordinate(index: u32) -> u32 {
    let digits = index ^ (index >> 1 & 0x5555_5555);
    let digits = digits ^ (digits >> 2 & 0x3333_3333);
    let digits = digits ^ (digits >> 4 & 0x0f0f_0f0f);
    let digits = digits ^ (digits >> 8 & 0x00ff_00ff);
    digits ^ digits >> 16
}

/// Scrambles the digits of four numbers, each digit by those before it, and puts the first digits into the highest bits. The bits
/// of a seed that affect the first digits are taken from its middle: the lowest bits of PCG4D depend on too little.
#[shared]
fn scrambled(point: UVec4, seeds: UVec4) -> UVec4 {
    let scrambled = |digits: u32, seed: u32| laine_karras(digits, seed.rotate_left(16)).reverse_bits();
    UVec4::new(
        scrambled(point.x, seeds.x),
        scrambled(point.y, seeds.y),
        scrambled(point.z, seeds.z),
        scrambled(point.w, seeds.w),
    )
}

/// Hash in which no bit affects a lower one.
#[inline(always)]
fn laine_karras(mut bits: u32, seed: u32) -> u32 {
    bits ^= bits.wrapping_mul(0x3d20_adea);
    bits = bits.wrapping_add(seed);
    bits = bits.wrapping_mul((seed >> 16) | 1);
    bits ^= bits.wrapping_mul(0x0552_6c56);
    bits ^ bits.wrapping_mul(0x53a2_2864)
}

#[cfg(not(target_arch = "spirv"))]
mod points {
    use super::laine_karras;
    use crate::interface::sequence::{SEQUENCE_GROUPS, Sequence};
    use crate::math::rng::pcg4d;
    use spirv_std::glam::UVec4;

    /// Degree, inner coefficients and first direction numbers of the primitive polynomials of dimensions 2 to 4.
    const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] =
        [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

    impl Sequence {
        /// Points of frame `frame`, if frames take turns in `batches` sequences.
        pub fn sobol(seed: u32, batches: u32, frame: u32) -> Sequence {
            let (batch, index) = (frame % batches.max(1), frame / batches.max(1));
            let mut points = [UVec4::ZERO; SEQUENCE_GROUPS];
            for (group, point) in points.iter_mut().enumerate() {
                let order = pcg4d(UVec4::new(group as u32, batch, seed, 0x736f_626f)).x;
                // Reorder the points: the first 2^k remain a whole block of 2^k.
                let permuted = laine_karras(index.reverse_bits(), order).reverse_bits();
                *point = UVec4::from_array(
                    [0, 1, 2, 3].map(|dimension| coordinate(permuted, dimension).reverse_bits()),
                );
            }
            let groups = SEQUENCE_GROUPS as u32;
            Sequence { points, groups, batch, ..Sequence::default() }
        }

        /// Points of [`Sequence::sobol`], moved in each pixel of an image of a width.
        pub fn moved(seed: u32, batches: u32, frame: u32, width: u32) -> Sequence {
            let sequence = Sequence::sobol(seed, batches, frame);
            let of_group = |group| pcg4d(UVec4::new(group as u32, sequence.batch, seed, 0x626c_7565));
            Sequence { seeds: std::array::from_fn(of_group), width, ..sequence }
        }
    }

    /// Coordinate of a Sobol point, times 2^32.
    fn coordinate(index: u32, dimension: usize) -> u32 {
        if dimension == 0 {
            return index.reverse_bits();
        }
        let (degree, coefficients, first) = POLYNOMIALS[dimension - 1];
        let mut directions = [0u32; 32];
        for k in 0..32 {
            directions[k] = if k < degree {
                first[k] << (31 - k)
            } else {
                let before = directions[k - degree];
                let inner = (1..degree).filter(|i| coefficients >> (degree - 1 - i) & 1 == 1);
                inner.fold(before ^ (before >> degree), |sum, i| sum ^ directions[k - i])
            };
        }
        (0..32).filter(|bit| index >> bit & 1 == 1).fold(0, |sum, bit| sum ^ directions[bit])
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use crate::math::rng::{Rng, Stream};
        use crate::math::sampler::next4;
        use spirv_std::glam::Vec4;

        /// Numbers of a group in a frame of a pixel.
        fn sample(seed: u32, pixel: u32, group: usize, batches: u32, frame: u32) -> Vec4 {
            let sequence = Sequence::sobol(seed, batches, frame);
            let mut rng = Rng::new(Stream::Camera, seed, pixel, frame);
            (0..=group).map(|_| next4(&mut rng, &sequence)).last().unwrap()
        }

        fn numbers(seed: u32, pixel: u32, group: usize, frames: u32) -> Vec<Vec4> {
            (0..frames).map(|frame| sample(seed, pixel, group, 1, frame)).collect()
        }

        #[test]
        fn a_block_of_frames_fills_every_interval_of_every_dimension() {
            for (pixel, group, log) in [(0, 0, 6), (17, 3, 5), (1 << 20, SEQUENCE_GROUPS - 1, 4)] {
                let count = 1 << log;
                // Check every aligned block of a power of two.
                for (block, points) in numbers(5, pixel, group, 4 * count).chunks(count as usize).enumerate()
                {
                    for dimension in 0..4 {
                        let mut cells: Vec<u32> =
                            points.iter().map(|u| (u[dimension] * count as f32) as u32).collect();
                        cells.sort_unstable();
                        assert_eq!(
                            cells,
                            (0..count).collect::<Vec<_>>(),
                            "block {block} dimension {dimension}"
                        );
                    }
                    // Check every elementary interval of the first two dimensions, too.
                    for wide in 0..=log {
                        let cell = |u: &Vec4| {
                            let (x, y) = (u.x * (1 << wide) as f32, u.y * (1 << (log - wide)) as f32);
                            (x as u32) << (log - wide) | y as u32
                        };
                        let mut cells: Vec<u32> = points.iter().map(cell).collect();
                        cells.sort_unstable();
                        assert_eq!(cells, (0..count).collect::<Vec<_>>(), "block {block} intervals {wide}");
                    }
                }
            }
        }

        /// Numbers of a group where pixels of rows of 64 share an even set.
        fn sample_moved(pixel: u32, group: usize, frame: u32) -> Vec4 {
            let sequence = Sequence::moved(5, 2, frame, 64);
            let mut rng = Rng::new(Stream::Camera, 5, pixel, frame);
            (0..=group).map(|_| next4(&mut rng, &sequence)).last().unwrap()
        }

        /// Whether the points fill every elementary interval of the pair of dimensions that starts at `dimension`.
        fn fills(points: &[Vec4], dimension: usize) -> bool {
            let log = points.len().ilog2();
            assert_eq!(points.len(), 1 << log);
            (0..=log).all(|wide| {
                let cell = |u: &Vec4| {
                    let (x, y) =
                        (u[dimension] * (1 << wide) as f32, u[dimension + 1] * (1 << (log - wide)) as f32);
                    (x as u32) << (log - wide) | y as u32
                };
                let mut cells: Vec<u32> = points.iter().map(cell).collect();
                cells.sort_unstable();
                cells == (0..1 << log).collect::<Vec<_>>()
            })
        }

        #[test]
        fn moved_points_fill_the_square_over_pixels_of_a_frame_and_over_frames_of_a_pixel() {
            for (group, side, frame) in [(0, 8, 0), (3, 4, 9), (SEQUENCE_GROUPS - 1, 16, 2)] {
                for (column, row) in [(0, 0), (side, 3 * side), (2 * side, side)] {
                    let pixels = (0..side * side).map(|i| (row + i / side) * 64 + column + i % side);
                    let points: Vec<Vec4> = pixels.map(|pixel| sample_moved(pixel, group, frame)).collect();
                    assert!(fills(&points, 0) && fills(&points, 2), "{group} {side} {column} {row}");
                }
            }
            for pixel in [0, 77, 4000] {
                // Frames of one of two batches. Their points have four coordinates, of which the first two fill squares.
                let points: Vec<Vec4> = (0..32).map(|frame| sample_moved(pixel, 1, 2 * frame)).collect();
                assert!(fills(&points, 0), "{pixel}");
            }
            // Squares off the grid of the curve are not filled: the test can fail.
            let points: Vec<Vec4> =
                (0..16).map(|i| sample_moved((1 + i / 4) * 64 + 1 + i % 4, 0, 0)).collect();
            assert!(!fills(&points, 0));
        }

        #[test]
        fn moved_numbers_are_uniform_over_seeds() {
            // A pixel's number is uniform over seeds, and two neighbours' first numbers are never near each other.
            let count = 20_000;
            let (mut sum, mut square, mut nearest) = (Vec4::ZERO, Vec4::ZERO, 1.0f32);
            // Number of pairs of numbers of different dimensions in each of 4 by 4 cells.
            let mut cells = [[0u32; 16]; 6];
            for seed in 0..count {
                let sequence = Sequence::moved(seed, 4, 1, 64);
                let sequence = |pixel| {
                    let mut rng = Rng::new(Stream::Camera, seed, pixel, 1);
                    next4(&mut rng, &sequence)
                };
                let (u, beside) = (sequence(130), sequence(131));
                sum += u - 0.5;
                square += (u - 0.5) * (u - 0.5);
                let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
                for (cells, (a, b)) in cells.iter_mut().zip(pairs) {
                    cells[(u[a] * 4.0) as usize * 4 + (u[b] * 4.0) as usize] += 1;
                }
                let halves = |u: Vec4| ((u.x * 2.0) as u32, (u.y * 2.0) as u32);
                nearest = nearest.min(if halves(u) == halves(beside) { 0.0 } else { 1.0 });
            }
            let n = count as f32;
            assert!((sum / n).abs().max_element() < 4.5 * (1.0f32 / 12.0).sqrt() / n.sqrt(), "{sum}");
            assert!((square / n - 1.0 / 12.0).abs().max_element() < 4.5 * (1.0f32 / 180.0).sqrt() / n.sqrt());
            assert_eq!(nearest, 1.0, "two of a square of four share a quarter");
            // Chi squared of 15 degrees of freedom: mean 15, deviation 5.5.
            let expected = f64::from(count) / 16.0;
            for cells in cells {
                let chi: f64 =
                    cells.iter().map(|&found| (f64::from(found) - expected).powi(2) / expected).sum();
                assert!(chi < 44.0, "{chi}: {cells:?}");
            }
        }

        #[test]
        fn second_coordinate_matches_the_direction_numbers() {
            for index in [0, 1, 2, 3, 7, 100, 0x1234_5678, u32::MAX] {
                assert_eq!(
                    super::super::second_coordinate(index),
                    coordinate(index, 1).reverse_bits(),
                    "{index}"
                );
            }
        }

        #[test]
        fn each_number_is_uniform_and_pixels_groups_and_batches_are_independent() {
            let count = 40_000;
            let (mut sums, mut squares, mut products) = (Vec4::ZERO, Vec4::ZERO, [Vec4::ZERO; 4]);
            for pixel in 0..count {
                let u = sample(9, pixel, 1, 2, 2) - 0.5;
                let others = [
                    sample(9, pixel + 1, 1, 2, 2),
                    sample(9, pixel, 2, 2, 2),
                    // The first point of the other batch, and another seed.
                    sample(9, pixel, 1, 2, 1),
                    sample(10, pixel, 1, 2, 2),
                ];
                sums += u;
                squares += u * u;
                for (product, other) in products.iter_mut().zip(others) {
                    *product += u * (other - 0.5);
                }
            }
            let n = count as f32;
            let close = |sums: Vec4, mean: f32, deviation: f32| {
                assert!((sums / n - mean).abs().max_element() < 4.5 * deviation / n.sqrt(), "{sums} {mean}");
            };
            close(sums, 0.0, (1.0f32 / 12.0).sqrt());
            close(squares, 1.0 / 12.0, (1.0f32 / 180.0).sqrt());
            for product in products {
                close(product, 0.0, 1.0 / 12.0);
            }
        }

        #[test]
        fn smooth_integrals_converge_faster_than_by_independent_numbers() {
            // Variance over pixels of the mean of a product of all four numbers, at 4 and at 64 frames.
            let variance = |frames: u32| {
                let means = (0..400).map(|pixel| {
                    let points = numbers(3, pixel, 0, frames);
                    points.iter().map(|u| f64::from(u.x * u.y * u.z * u.w)).sum::<f64>() / f64::from(frames)
                });
                means.map(|mean| (mean - 0.0625).powi(2)).sum::<f64>() / 400.0
            };
            let slope = (variance(64) / variance(4)).ln() / 16.0f64.ln();
            assert!(slope < -1.4, "{slope}");
        }

        #[test]
        fn direction_numbers_give_the_published_points() {
            // The first points in Gray-free order, times 8.
            let points: Vec<[u32; 4]> = (0..8)
                .map(|index| [0, 1, 2, 3].map(|dimension| coordinate(index, dimension) >> 29))
                .collect();
            let known: [[u32; 8]; 4] = [
                [0, 4, 2, 6, 1, 5, 3, 7],
                [0, 4, 6, 2, 5, 1, 3, 7],
                [0, 4, 6, 2, 3, 7, 5, 1],
                [0, 4, 6, 2, 1, 5, 7, 3],
            ];
            for (dimension, known) in known.iter().enumerate() {
                let own: Vec<u32> = points.iter().map(|point| point[dimension]).collect();
                assert_eq!(own, known, "{dimension}");
            }
            assert_eq!([1, 2, 3].map(|dimension| coordinate(8, dimension) >> 28), [15, 9, 5]);
        }
    }
}
