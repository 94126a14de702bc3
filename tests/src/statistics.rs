//! Means of independent runs and whether two of them differ.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Mean of some independent values with its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Number of values.
    pub count: f64,
    /// Mean.
    pub mean: f64,
    /// Standard error of the mean.
    pub error: f64,
}

impl Sample {
    /// Needs two values or more.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Self { count, mean, error: (variance / count).sqrt() }
    }
}

/// Two-sided p-value of Welch's t-test that two samples have the same mean.
pub fn welch(a: Sample, b: Sample) -> f64 {
    let (va, vb) = (a.error * a.error, b.error * b.error);
    let t = (a.mean - b.mean) / (va + vb).sqrt();
    let freedom = (va + vb).powi(2) / (va * va / (a.count - 1.0) + vb * vb / (b.count - 1.0));
    let distribution = StudentsT::new(0.0, 1.0, freedom).expect("positive degrees of freedom");
    2.0 * distribution.cdf(-t.abs())
}

/// The level at which each of `tests` tests must reject so that all together reject a true hypothesis with
/// probability `level` (Šidák).
pub fn sidak(level: f64, tests: usize) -> f64 {
    1.0 - (1.0 - level).powf(1.0 / tests as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn welch_matches_a_worked_example() {
        // Samples of 10 with mean 5, error 0.3 and mean 6, error 0.4: t = 2 at 16.69 degrees of freedom;
        // two-sided p = 0.0621 (numerical integral of Student's density).
        let a = Sample { count: 10.0, mean: 5.0, error: 0.3 };
        let b = Sample { count: 10.0, mean: 6.0, error: 0.4 };
        assert!((welch(a, b) - 0.0621).abs() < 3e-4, "{}", welch(a, b));
    }

    #[test]
    fn sidak_of_one_test_is_the_level() {
        assert!((sidak(0.01, 1) - 0.01).abs() < 1e-12);
        assert!((sidak(0.05, 10) - 0.005_116).abs() < 1e-6);
    }
}
