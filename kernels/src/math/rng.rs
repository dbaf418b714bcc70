//! Counter-based random numbers: a hash of (stream and seed, path, frame, dimension), so that any number can be
//! sampled in any order on any runner. Hash: PCG4D [Jarzynski and Olano 2020, Hash functions for GPU rendering].

use caustics_kernel_macros::shared;
use spirv_std::glam::{UVec4, Vec4};

/// Stream of random numbers: separates paths whose numbers must be independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Stream {
    /// Paths from the eye.
    Camera = 0x3c6e_f372,
    /// Paths from the lights.
    Light = 0xa54f_f53a,
    /// Paths of the reference, independent of those of the methods that are compared with it.
    Reference = 0x9b05_688c,
    /// Estimates of the energy ledger, which must not change the other numbers.
    Ledger = 0x510e_527f,
    /// Light paths that keep their numbers for some frames, to detect changes of the light.
    Validation = 0x1f83_d9ab,
}

/// Separates keys of rays from numbers.
const RAY_KEYS: u32 = 0xcbbb_9d5d;

/// Random numbers of one path.
#[derive(Clone, Copy, Debug)]
pub struct Rng {
    key: u32,
    path: u32,
    frame: u32,
    dimension: u32,
}

impl Rng {
    /// Random numbers of path `path` in frame `frame`.
    #[inline]
    pub fn new(stream: Stream, seed: u32, path: u32, frame: u32) -> Self {
        Rng { key: seed.wrapping_mul(0x9e37_79b9) ^ stream as u32, path, frame, dimension: 0 }
    }

    /// Four independent numbers, uniform in [0, 1), multiples of 2^-24.
    #[inline]
    pub fn next4(&mut self) -> Vec4 {
        units(self.next_bits(self.frame))
    }

    /// Bits of the next four numbers, for another frame.
    #[inline]
    pub fn next_bits(&mut self, frame: u32) -> UVec4 {
        let bits = pcg4d(UVec4::new(self.path, frame, self.dimension, self.key));
        self.dimension += 1;
        bits
    }

    /// Key for the `number`-th ray that starts here; independent of all sampled numbers, and none of them.
    #[inline]
    pub fn ray_key(&self, number: u32) -> u32 {
        // Paths sample far fewer than 2^16 times.
        pcg4d(UVec4::new(self.path, self.frame, self.dimension | number << 16, self.key ^ RAY_KEYS)).x
    }

    /// Number of times that four numbers were sampled.
    #[inline]
    pub fn dimension(&self) -> u32 {
        self.dimension
    }

    /// Leaves out this many times four numbers.
    #[inline]
    pub fn skip(&mut self, count: u32) {
        self.dimension += count;
    }

    /// Path that the numbers belong to.
    #[inline]
    pub fn path(&self) -> u32 {
        self.path
    }

    /// Frame that the numbers belong to.
    #[inline]
    pub fn frame(&self) -> u32 {
        self.frame
    }
}

/// Numbers uniform in [0, 1), from 32 random bits each.
#[shared]
pub fn units(bits: UVec4) -> Vec4 {
    let unit = |bits: u32| (bits >> 8) as f32 * (1.0 / 16_777_216.0);
    Vec4::new(unit(bits.x), unit(bits.y), unit(bits.z), unit(bits.w))
}

/// PCG4D: four words in, four well-mixed words out.
#[shared]
pub fn pcg4d(input: UVec4) -> UVec4 {
    let step = |w: u32| w.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let (mut x, mut y, mut z, mut w) = (step(input.x), step(input.y), step(input.z), step(input.w));
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    w ^= w >> 16;
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    UVec4::new(x, y, z, w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_and_streams_differ() {
        let (mut sum, mut squares, mut same) = (0.0f64, 0.0f64, 0);
        let count = 100_000;
        for path in 0..count {
            let a = Rng::new(Stream::Camera, 7, path, 3).next4();
            let b = Rng::new(Stream::Light, 7, path, 3).next4();
            for component in 0..4 {
                assert!((0.0..1.0).contains(&a[component]));
                sum += f64::from(a[component]);
                squares += f64::from(a[component]).powi(2);
                same += u32::from(a[component] == b[component]);
            }
        }
        let n = 4.0 * f64::from(count);
        // Standard errors: sqrt(1/12n) and sqrt(4/45n); four of them.
        assert!((sum / n - 0.5).abs() < 4.0 * (1.0 / (12.0 * n)).sqrt());
        assert!((squares / n - 1.0 / 3.0).abs() < 4.0 * (4.0 / (45.0 * n)).sqrt());
        assert!(same <= 2, "streams repeat each other: {same}");
    }

    #[test]
    fn neighbouring_paths_and_dimensions_are_uncorrelated() {
        let count = 100_000;
        let (mut paths, mut dimensions) = (0.0f64, 0.0f64);
        for path in 0..count {
            let mut rng = Rng::new(Stream::Light, 1, path, 0);
            let (a, b) = (rng.next4().x, rng.next4().x);
            let c = Rng::new(Stream::Light, 1, path + 1, 0).next4().x;
            dimensions += f64::from(a - 0.5) * f64::from(b - 0.5);
            paths += f64::from(a - 0.5) * f64::from(c - 0.5);
        }
        // The product of two independent centred uniforms has variance 1/144.
        let bound = 4.0 * (f64::from(count) / 144.0).sqrt();
        assert!(paths.abs() < bound && dimensions.abs() < bound, "{paths} {dimensions} > {bound}");
    }
}
