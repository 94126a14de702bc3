//! How much fog a pixel sees, and how that varies from pixel to pixel: even light in fog is as bright as there is fog on the way through it.

use std::f32::consts::PI;

/// A symmetric matrix over the picture's plane: x to the right, y down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bend {
    pub(super) xx: f32,
    pub(super) xy: f32,
    pub(super) yy: f32,
}

/// Covariance of the spectrum of what is as bright as `seen` around a pixel [cycles²/pixel²].
///
/// That of f is -f''/f/(4π²) if it is positive; where f bends the other way filters err as much, so that the Hessian's eigenvalues count by
/// their size.
///
/// - `seen`: rows of a pixel and of the eight around it; that in the middle > 0.
pub(super) fn bend([above, row, below]: [[f32; 3]; 3]) -> Bend {
    let here = row[1];
    let xx = row[0] - 2.0 * here + row[2];
    let yy = above[1] - 2.0 * here + below[1];
    let xy = 0.25 * (below[2] - below[0] - above[2] + above[0]);
    // Eigenvalues mean ± size: the matrix or its opposite where they have the same sign, else what turns one of them round.
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let size = libm::hypotf(half, xy);
    let (even, along) =
        if mean.abs() >= size { (mean.abs(), 1.0_f32.copysign(mean)) } else { (size, mean / size) };
    let scale = 1.0 / (4.0 * PI * PI * here);
    Bend { xx: scale * (even + along * half), xy: scale * along * xy, yy: scale * (even - along * half) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = 1 + ½ xᵀ H x with H = R diag(a, b) Rᵀ: the result is R diag(|a|, |b|) Rᵀ/(4π²).
    #[test]
    fn eigenvalues_count_by_their_size() {
        for [a, b] in
            [[0.02, 0.005], [-0.02, -0.005], [0.02, -0.005], [-0.005, 0.02], [0.0, 0.0], [0.01, 0.01]]
        {
            for angle in [0.0_f32, 0.3, 1.2, 2.5] {
                let (sine, cosine) = angle.sin_cos();
                let around = |a: f32, b: f32| {
                    [
                        a * cosine * cosine + b * sine * sine,
                        (a - b) * sine * cosine,
                        a * sine * sine + b * cosine * cosine,
                    ]
                };
                let [xx, xy, yy] = around(a, b);
                let at = |x: f32, y: f32| 1.0 + 0.5 * (xx * x * x + 2.0 * xy * x * y + yy * y * y);
                let found = bend([-1.0, 0.0, 1.0].map(|y| [-1.0, 0.0, 1.0].map(|x| at(x, y))));
                let expected = around(a.abs(), b.abs()).map(|value| value / (4.0 * PI * PI));
                for (found, expected) in [found.xx, found.xy, found.yy].into_iter().zip(expected) {
                    // Roundings of 1, four of them, over 4π².
                    assert!((found - expected).abs() < 1e-8, "{a}, {b} at {angle}: {found} for {expected}");
                }
            }
        }
    }
}
