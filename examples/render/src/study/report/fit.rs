//! What curves of error say: slopes, and values between measured points.

/// Passes from which on points count for a slope: before, the schedules have hardly begun.
pub(super) const FIRST_FITTED: f64 = 4.0;

/// Fewest points of a slope.
const FEWEST: usize = 3;

/// Exponent p of the power law y ~ xᵖ with the least squared distance to the points in the logarithms of both; None for fewer than
/// three points with x, y > 0, or if all lie at one x.
pub fn slope(points: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let positive = points.into_iter().filter(|(x, y)| *x > 0.0 && *y > 0.0);
    let logs: Vec<(f64, f64)> = positive.map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let (mean_x, mean_y) = (
        logs.iter().map(|point| point.0).sum::<f64>() / count,
        logs.iter().map(|point| point.1).sum::<f64>() / count,
    );
    let spread: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let shared: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    (logs.len() >= FEWEST && spread > 0.0).then(|| shared / spread)
}

/// y at `x`, on the power laws between neighbouring points, which have rising x > 0 and y > 0; None outside them.
pub fn at(points: &[(f64, f64)], x: f64) -> Option<f64> {
    if let [(only, y)] = points {
        return (*only == x).then_some(*y);
    }
    let pair = points.windows(2).find(|pair| (pair[0].0..=pair[1].0).contains(&x))?;
    Some(between(pair[0], pair[1], x))
}

/// The first x at which the curve through the points falls to `y`; None if it never does, and if it starts below, since nobody measured
/// when it got there.
pub fn reached(points: &[(f64, f64)], y: f64) -> Option<f64> {
    let pair = points.windows(2).find(|pair| pair[0].1 >= y && pair[1].1 <= y)?;
    let swapped = |(x, y): (f64, f64)| (y, x);
    Some(between(swapped(pair[0]), swapped(pair[1]), y))
}

fn between((x0, y0): (f64, f64), (x1, y1): (f64, f64), x: f64) -> f64 {
    if x0 == x1 {
        return y1;
    }
    let share = (x / x0).ln() / (x1 / x0).ln();
    y0 * (y1 / y0).powf(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(exponent: f64) -> Vec<(f64, f64)> {
        (0..8).map(|i| f64::from(1 << i)).map(|x| (x, 3.0 * x.powf(exponent))).collect()
    }

    #[test]
    fn the_slope_of_a_power_law_is_its_exponent() {
        for exponent in [-2.0 / 3.0, -0.8, -1.0, 0.5] {
            assert!((slope(law(exponent)).unwrap() - exponent).abs() < 1e-12);
        }
        // Factors whose logarithms are orthogonal to 1 and to the place leave the slope as it is: +1, -1, -1, +1 at even steps.
        let bent =
            law(-0.8).into_iter().take(4).zip([1.3, 1.0 / 1.3, 1.0 / 1.3, 1.3]).map(|((x, y), f)| (x, y * f));
        assert!((slope(bent).unwrap() + 0.8).abs() < 1e-12);
    }

    #[test]
    fn too_few_points_have_no_slope() {
        assert_eq!(slope([(1.0, 1.0), (2.0, 0.5)]), None);
        assert_eq!(slope([(1.0, 1.0), (2.0, 0.5), (4.0, -0.1)]), None, "an error below nothing is no point");
        assert_eq!(slope([(2.0, 1.0), (2.0, 0.5), (2.0, 0.2)]), None);
    }

    #[test]
    fn between_points_a_curve_is_a_power_law() {
        let points = [(1.0, 3.0), (4.0, 0.75), (64.0, 3.0 / 64.0)];
        for x in [1.0, 1.7, 4.0, 20.0, 64.0] {
            assert!((at(&points, x).unwrap() * x / 3.0 - 1.0).abs() < 1e-12);
            assert!((reached(&points, 3.0 / x).unwrap() / x - 1.0).abs() < 1e-12);
        }
        assert_eq!((at(&points, 0.9), at(&points, 65.0)), (None, None));
        assert_eq!((reached(&points, 3.1), reached(&points, 0.04)), (None, None));
        assert_eq!((at(&[], 1.0), reached(&[], 1.0), at(&[(2.0, 5.0)], 2.0)), (None, None, Some(5.0)));
    }
}
