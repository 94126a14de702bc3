//! Symmetric 2x2 matrices: covariances in the plane of the picture.

use libm::sqrtf;

/// \[xx xy; xy yy\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Symmetric {
    pub(super) xx: f32,
    pub(super) xy: f32,
    pub(super) yy: f32,
}

impl Symmetric {
    /// The larger and the smaller eigenvalue.
    pub(super) fn eigenvalues(&self) -> [f32; 2] {
        let Self { xx, xy, yy } = *self;
        let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let spread = sqrtf(half * half + xy * xy);
        let (high, low) = (middle + spread, middle - spread);
        // Of a nearly singular matrix the difference has no digits left; determinant over the other eigenvalue has.
        let low = if middle > 0.0 && high > 0.0 { low.max((xx * yy - xy * xy) / high) } else { low };
        [high, low]
    }

    /// The matrix with `change`d eigenvalues; None unless all of it is finite.
    pub(super) fn through_eigenvalues(&self, change: impl Fn(f32) -> f32) -> Option<Self> {
        let Self { xx, xy, yy } = *self;
        let half = 0.5 * (xx - yy);
        let spread = sqrtf(half * half + xy * xy);
        let [high, low] = self.eigenvalues();
        let (a, b) = (change(high), change(low));
        // Cosine and sine of twice the angle of the first axis, and squares of those of the angle: nothing here cancels, so that the
        // smaller of two very unequal values keeps its digits.
        let (c, s) = if spread > 0.0 { (half / spread, xy / spread) } else { (1.0, 0.0) };
        let large = 0.5 * (1.0 + c.abs());
        let small = 0.25 * s * s / large;
        let (cc, ss) = if c > 0.0 { (large, small) } else { (small, large) };
        let changed = Self { xx: a * cc + b * ss, xy: 0.5 * (a - b) * s, yy: a * ss + b * cc };
        (changed.xx + changed.yy + changed.xy).is_finite().then_some(changed)
    }

    /// The largest matrix that is neither above `self` nor above `bound` on the axes on which the two are both diagonal: the ellipse
    /// inside both ellipses. `bound` is positive definite; None unless all of it is finite.
    pub(super) fn within(&self, bound: &Self) -> Option<Self> {
        // With bound = L Lᵀ and K = L⁻¹ self L⁻ᵀ: L min(K, 1) Lᵀ.
        let l_xx = sqrtf(bound.xx);
        let l_yx = bound.xy / l_xx;
        let l_yy = sqrtf((bound.yy - l_yx * l_yx).max(f32::MIN_POSITIVE));
        let (top_x, top_y) = (self.xx / l_xx, self.xy / l_xx);
        let low_x = (self.xy - l_yx * top_x) / l_yy;
        let low_y = (self.yy - l_yx * top_y) / l_yy;
        let k = Self { xx: top_x / l_xx, xy: low_x / l_xx, yy: (low_y - l_yx * (low_x / l_xx)) / l_yy };
        let k = k.through_eigenvalues(|value| value.min(1.0))?;
        let within = Self {
            xx: l_xx * l_xx * k.xx,
            xy: l_xx * (l_yx * k.xx + l_yy * k.xy),
            yy: l_yx * l_yx * k.xx + 2.0 * l_yx * l_yy * k.xy + l_yy * l_yy * k.yy,
        };
        (within.xx + within.yy + within.xy).is_finite().then_some(within)
    }
}
