//! Means with their standard errors, and whether two means agree.

/// A mean and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// Value of the mean.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

impl Mean {
    /// Returns the mean of independent samples, at least two.
    pub fn from_samples(samples: &[f64]) -> Mean {
        let n = samples.len() as f64;
        let value = samples.iter().sum::<f64>() / n;
        let variance = samples.iter().map(|sample| (sample - value).powi(2)).sum::<f64>() / (n - 1.0);
        Mean { value, error: (variance / n).sqrt() }
    }

    /// Signed difference of two independent means, this minus the other, in standard errors of that difference.
    pub fn z_score(&self, other: &Mean) -> f64 {
        let difference = self.value - other.value;
        if difference == 0.0 { 0.0 } else { difference / self.error.hypot(other.error) }
    }

    /// Difference of two independent means, in standard errors of that difference.
    pub fn sigmas(&self, other: &Mean) -> f64 {
        self.z_score(other).abs()
    }

    /// Whether two means agree within this many standard errors; a NaN agrees with nothing.
    pub fn agrees(&self, other: &Mean, sigmas: f64) -> bool {
        self.sigmas(other) <= sigmas
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_within_their_errors_agree() {
        let (a, b) = (Mean::from_samples(&[1.0, 1.2, 0.8, 1.0]), Mean::from_samples(&[1.1, 1.3, 0.9, 1.0]));
        assert!((a.error - (0.08f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
        assert!(a.agrees(&b, 3.0));
    }

    #[test]
    fn detects_a_mean_five_errors_away() {
        let (a, b) = (Mean::from_samples(&[1.0, 1.2, 0.8, 1.0]), Mean::from_samples(&[2.0, 2.2, 1.8, 2.0]));
        assert!(!a.agrees(&b, 3.0) && a.sigmas(&b) > 5.0);
        assert!(!a.agrees(&Mean { value: f64::NAN, error: 1.0 }, 3.0));
    }
}
