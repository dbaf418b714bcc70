//! The numbers of camera paths: independent, or points of Sobol sequences over a pixel's frames [Sobol' 1967; direction numbers of
//! Joe and Kuo 2008].
//!
//! A path draws four numbers at a time, a group. Each group has a four-dimensional sequence of its own, whose points are in another
//! order (padding [Kollig and Keller 2002, Efficient multidimensional sampling]). What a frame's points are is the same for all
//! pixels and is computed once; each pixel scrambles their digits by itself [Owen 1995; the hash of Laine and Karras 2011 with the
//! constants of Vegdahl 2021, Building a better LK hash], so that pixels are independent and each number is uniform. A number is
//! a function of (seed, pixel, frame, dimension) as before: in any order, on any runner.
//!
//! Points of one sequence are no independent samples and say nothing of their variance. So frames take turns in `batches`
//! sequences, and the variance is that between these.

use crate::interface::sequence::Sequence;
use crate::math::rng::{Rng, units};
use spirv_std::glam::{UVec4, Vec4};

/// The next four numbers of a camera path, uniform in [0, 1), multiples of 2^-24: points of the sequence as far as it has groups.
#[inline(always)]
pub fn next4(rng: &mut Rng, sequence: &Sequence) -> Vec4 {
    let group = rng.dimension();
    let is_in = group < sequence.groups;
    let bits = rng.next_bits(if is_in { sequence.batch } else { rng.frame() });
    if is_in { units(scrambled(sequence.points[group as usize], bits)) } else { units(bits) }
}

/// Scrambles the digits of four numbers, each by those before it, and puts the first digits into the highest bits. The lowest bits
/// of a seed, which touch the first digits, are taken from the middle: those of PCG4D depend on too little.
#[inline(always)]
fn scrambled(point: UVec4, seeds: UVec4) -> UVec4 {
    let scrambled = |digits: u32, seed: u32| laine_karras(digits, seed.rotate_left(16)).reverse_bits();
    UVec4::new(
        scrambled(point.x, seeds.x),
        scrambled(point.y, seeds.y),
        scrambled(point.z, seeds.z),
        scrambled(point.w, seeds.w),
    )
}

/// A hash in which no bit touches a lower one.
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
        /// The points of frame `frame` where frames take turns in `batches` sequences.
        pub fn sobol(seed: u32, batches: u32, frame: u32) -> Sequence {
            let (batch, index) = (frame % batches.max(1), frame / batches.max(1));
            let mut points = [UVec4::ZERO; SEQUENCE_GROUPS];
            for (group, point) in points.iter_mut().enumerate() {
                let order = pcg4d(UVec4::new(group as u32, batch, seed, 0x736f_626f)).x;
                // Another order of the same points: the first 2^k remain a whole block of so many.
                let place = laine_karras(index.reverse_bits(), order).reverse_bits();
                *point = UVec4::from_array([0, 1, 2, 3].map(|lane| coordinate(place, lane).reverse_bits()));
            }
            Sequence { points, groups: SEQUENCE_GROUPS as u32, batch, padding: [0; 2] }
        }
    }

    /// A coordinate of a Sobol point, times 2^32.
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

        /// The numbers of a group in a frame of a pixel.
        fn draw(seed: u32, pixel: u32, group: usize, batches: u32, frame: u32) -> Vec4 {
            let sequence = Sequence::sobol(seed, batches, frame);
            let mut rng = Rng::new(Stream::Camera, seed, pixel, frame);
            (0..=group).map(|_| next4(&mut rng, &sequence)).last().unwrap()
        }

        fn numbers(seed: u32, pixel: u32, group: usize, frames: u32) -> Vec<Vec4> {
            (0..frames).map(|frame| draw(seed, pixel, group, 1, frame)).collect()
        }

        #[test]
        fn a_block_of_frames_fills_every_interval_of_every_dimension() {
            for (pixel, group, log) in [(0, 0, 6), (17, 3, 5), (1 << 20, SEQUENCE_GROUPS - 1, 4)] {
                let count = 1 << log;
                // Any aligned block of a power of two.
                for (block, points) in numbers(5, pixel, group, 4 * count).chunks(count as usize).enumerate()
                {
                    for lane in 0..4 {
                        let mut cells: Vec<u32> =
                            points.iter().map(|u| (u[lane] * count as f32) as u32).collect();
                        cells.sort_unstable();
                        assert_eq!(cells, (0..count).collect::<Vec<_>>(), "block {block} lane {lane}");
                    }
                    // Of the first two dimensions every elementary interval, too.
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

        #[test]
        fn each_number_is_uniform_and_pixels_groups_and_batches_are_independent() {
            let count = 40_000;
            let (mut sums, mut squares, mut products) = (Vec4::ZERO, Vec4::ZERO, [Vec4::ZERO; 4]);
            for pixel in 0..count {
                let u = draw(9, pixel, 1, 2, 2) - 0.5;
                let others = [
                    draw(9, pixel + 1, 1, 2, 2),
                    draw(9, pixel, 2, 2, 2),
                    // The first point of the other batch, and another seed.
                    draw(9, pixel, 1, 2, 1),
                    draw(10, pixel, 1, 2, 2),
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
        fn smooth_integrals_converge_faster_than_by_chance() {
            // Variance of the mean of a product of all four, over pixels, at 4 and at 64 frames.
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
        fn directions_are_those_of_the_tables() {
            // The first points in Gray-free order, times 8.
            let points: Vec<[u32; 4]> =
                (0..8).map(|index| [0, 1, 2, 3].map(|lane| coordinate(index, lane) >> 29)).collect();
            let known: [[u32; 8]; 4] = [
                [0, 4, 2, 6, 1, 5, 3, 7],
                [0, 4, 6, 2, 5, 1, 3, 7],
                [0, 4, 6, 2, 3, 7, 5, 1],
                [0, 4, 6, 2, 1, 5, 7, 3],
            ];
            for (lane, known) in known.iter().enumerate() {
                let own: Vec<u32> = points.iter().map(|point| point[lane]).collect();
                assert_eq!(own, known, "{lane}");
            }
            assert_eq!([1, 2, 3].map(|lane| coordinate(8, lane) >> 28), [15, 9, 5]);
        }
    }
}
