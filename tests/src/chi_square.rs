//! Pearson's chi-square test of counts in cells against their expectations, and cells of the sphere to count in.

use std::f64::consts::{PI, TAU};

use glam::Vec3;

/// Smallest expected count of a cell; smaller ones are pooled. Below about 20 the statistic of a cell is not normal.
const FEWEST: f64 = 20.0;
/// Standard normal quantile of the level 1e-5: one false alarm in a thousand runs of a hundred fits.
const QUANTILE: f64 = 4.26;

/// Goodness of fit of counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Sum of (seen - expected)^2 / expected.
    pub chi_square: f64,
    /// Number of cells; pooled cells count as one.
    pub cells: f64,
    /// Largest chi-square at a level of 1e-5 [Wilson and Hilferty 1931].
    pub bound: f64,
    /// Whether counts where (almost) none are expected exceed a Poisson law of that mean at a level of 1e-7.
    pub misplaced: bool,
}

impl Fit {
    /// Compares counts with expectations, cell by cell.
    pub fn new(seen: &[u32], expected: &[f64]) -> Fit {
        assert_eq!(seen.len(), expected.len());
        let (mut chi_square, mut cells, mut few, mut few_expected) = (0.0, 0.0, 0.0, 0.0);
        for (&n, &e) in seen.iter().zip(expected) {
            if e < FEWEST {
                few += f64::from(n);
                few_expected += e;
            } else {
                chi_square += (f64::from(n) - e).powi(2) / e;
                cells += 1.0;
            }
        }
        let mut misplaced = false;
        if few_expected >= FEWEST {
            chi_square += (few - few_expected).powi(2) / few_expected;
            cells += 1.0;
        } else {
            misplaced = few > few_expected + 6.0 * few_expected.sqrt() + 10.0;
        }
        let a = 2.0 / (9.0 * f64::max(cells, 1.0));
        let bound = f64::max(cells, 1.0) * (1.0 - a + QUANTILE * a.sqrt()).powi(3);
        Fit { chi_square, cells, bound, misplaced }
    }

    /// Whether the counts fit.
    pub fn passes(&self) -> bool {
        self.chi_square < self.bound && !self.misplaced
    }
}

/// Cells of the sphere of equal solid angles: even in cosine and azimuth.
#[derive(Clone, Copy, Debug)]
pub struct SphereCells {
    /// Rows from z = 1 to z = -1.
    pub rows: usize,
    /// Columns around z.
    pub columns: usize,
}

impl SphereCells {
    /// Number of cells.
    pub fn count(&self) -> usize {
        self.rows * self.columns
    }

    /// The cell of a unit direction.
    pub fn cell_index(&self, direction: Vec3) -> usize {
        let d = direction.as_dvec3();
        let row = (0.5 * (1.0 - d.z) * self.rows as f64) as usize;
        let column = ((d.y.atan2(d.x) / TAU + 0.5) * self.columns as f64) as usize;
        row.min(self.rows - 1) * self.columns + column.min(self.columns - 1)
    }

    /// Integrates a density (1/sr) over every cell, by `sub` (rows, columns) midpoints each.
    pub fn integrate(&self, sub: [usize; 2], density: impl Fn(Vec3) -> f64) -> Vec<f64> {
        let (rows, columns) = (self.rows * sub[0], self.columns * sub[1]);
        let solid_angle = 4.0 * PI / (rows * columns) as f64;
        let around: Vec<(f64, f64)> =
            (0..columns).map(|j| (((j as f64 + 0.5) / columns as f64 - 0.5) * TAU).sin_cos()).collect();
        let mut sums = vec![0.0; self.count()];
        for i in 0..rows {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / rows as f64;
            let r = (1.0 - z * z).sqrt();
            for (j, (sin, cos)) in around.iter().enumerate() {
                let direction = Vec3::new((r * cos) as f32, (r * sin) as f32, z as f32);
                sums[i / sub[0] * self.columns + j / sub[1]] += density(direction) * solid_angle;
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_kernels::math::rng::{Rng, Stream};
    use caustics_kernels::math::warp::uniform_sphere;

    const CELLS: SphereCells = SphereCells { rows: 20, columns: 20 };

    fn seen() -> Vec<u32> {
        let mut seen = vec![0; CELLS.count()];
        for path in 0..200_000 {
            let u = Rng::new(Stream::Light, 77, path, 0).next4();
            seen[CELLS.cell_index(uniform_sphere(u.x, u.y))] += 1;
        }
        seen
    }

    #[test]
    fn uniform_directions_fit_equal_cells() {
        let fit = Fit::new(&seen(), &CELLS.integrate([1, 1], |_| 200_000.0 / (4.0 * PI)));
        assert!(fit.passes(), "{fit:?}");
    }

    #[test]
    fn detects_a_density_off_by_three_percent_on_one_side() {
        let lopsided = |d: Vec3| (1.0 + 0.03 * f64::from(d.z.signum())) * 200_000.0 / (4.0 * PI);
        assert!(!Fit::new(&seen(), &CELLS.integrate([1, 1], lopsided)).passes());
    }

    #[test]
    fn detects_counts_where_the_density_is_zero() {
        let upper = |d: Vec3| if d.z > 0.0 { 100_000.0 / (2.0 * PI) } else { 0.0 };
        let mut seen = seen();
        seen[CELLS.count() / 2..].fill(0);
        assert!(Fit::new(&seen, &CELLS.integrate([1, 1], upper)).passes());
        seen[CELLS.count() - 1] = 25;
        assert!(!Fit::new(&seen, &CELLS.integrate([1, 1], upper)).passes());
    }
}
