//! Functions of single precision that compile to vector code inside loops, with the same bits on every
//! processor, and symmetric matrices.

use glam::Mat3;
use libm::sqrtf;

/// √x, correctly rounded.
#[inline(always)]
pub(crate) fn sqrt(x: f32) -> f32 {
    // The standard library's compiles to vector code inside loops, libm's does not.
    #[cfg(feature = "bvh")]
    return x.sqrt();
    #[cfg(not(feature = "bvh"))]
    return libm::sqrtf(x);
}

/// e^x.
///
/// Guarantee: a relative error below 1.2e-7 (2⁻²³) for x in [-87, 87]; below -87, where e^x < 2e-38, 0; above
/// 87, infinity; NaN for NaN. (Tests `the_exponential_…`.)
///
/// Source: range reduction to [-ln 2 / 2, ln 2 / 2] as in Cody and Waite (1980), polynomial of degree 7 by
/// Moshier (Cephes).
// libm's cannot be computed eight at a time. Eight-wide twin: beam_map/simd.rs.
#[inline(always)]
pub(crate) fn exp(x: f32) -> f32 {
    let rounded = x * core::f32::consts::LOG2_E + ROUND;
    let power = rounded - ROUND;
    let r = x - power * LN_2[0] - power * LN_2[1];
    let p = EXP_SERIES.into_iter().reduce(|sum, term| sum * r + term).unwrap_or(0.0);
    let p = p * (r * r) + r + 1.0;
    // The last bits of `rounded` are the power; the exponent's bias is 127.
    let value = p * f32::from_bits(rounded.to_bits().wrapping_add(127) << 23);
    if x < -EXP_LIMIT {
        0.0
    } else if x > EXP_LIMIT {
        f32::INFINITY
    } else {
        value
    }
}

/// (e^x - 1)/x, the mean of e^t for t from 0 to x: 1 at 0.
///
/// Guarantee: a relative error below 4e-7 for x in \[-1e30, 87\], without cancellation at small x; above 87, infinity; NaN for NaN and infinity. (Test
/// `the_mean_of_the_exponential_…`.)
// Eight-wide twin: beam_map/simd.rs.
#[inline(always)]
pub(crate) fn exp_mean(x: f32) -> f32 {
    if x.abs() <= SERIES_LIMIT {
        EXP_SERIES.into_iter().reduce(|sum, term| sum * x + term).unwrap_or(0.0) * x + 1.0
    } else {
        (exp(x) - 1.0) / x
    }
}

/// 1.5 · 2²³: numbers this large have no fraction, so that adding it rounds.
pub(crate) const ROUND: f32 = 12_582_912.0;

/// ln 2 in two parts; the first has so few digits that its multiples are exact.
pub(crate) const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];

/// (e^r - 1 - r)/r² for |r| <= ln 2 / 2, highest power first.
pub(crate) const EXP_SERIES: [f32; 6] =
    [1.987_569_2e-4, 1.398_2e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5e-1];

/// ln 2 / 2.
pub(crate) const SERIES_LIMIT: f32 = 0.346_573_6;

/// Beyond it [`exp`] is 0 or infinite.
pub(crate) const EXP_LIMIT: f32 = 87.0;

/// Where the six numbers of a symmetric 3x3 matrix stand in it: xx, yy, zz, xy, xz, yz.
pub(crate) const SIX: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// The symmetric matrix of \[xx, yy, zz, xy, xz, yz\].
pub(crate) fn symmetric([xx, yy, zz, xy, xz, yz]: [f32; 6]) -> Mat3 {
    Mat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
}

/// A symmetric 2x2 matrix \[xx xy; xy yy\].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sym2 {
    pub(crate) xx: f32,
    pub(crate) xy: f32,
    pub(crate) yy: f32,
}

impl Sym2 {
    /// The larger and the smaller eigenvalue.
    pub(crate) fn eigenvalues(&self) -> [f32; 2] {
        let (middle, (spread, _)) = (0.5 * (self.xx + self.yy), self.turn());
        let (high, low) = (middle + spread, middle - spread);
        // Of a nearly singular matrix the difference has no digits left; determinant over the other
        // eigenvalue has.
        let low = if middle > 0.0 && high > 0.0 { low.max(self.determinant() / high) } else { low };
        [high, low]
    }

    /// Half the difference of the eigenvalues, and cosine and sine of twice the angle of the larger one's
    /// axis.
    fn turn(&self) -> (f32, [f32; 2]) {
        let half = 0.5 * (self.xx - self.yy);
        let spread = sqrtf(half * half + self.xy * self.xy);
        (spread, if spread > 0.0 { [half / spread, self.xy / spread] } else { [1.0, 0.0] })
    }

    pub(crate) fn determinant(&self) -> f32 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// The axis of the larger eigenvalue, unit.
    pub(crate) fn axis(&self) -> [f32; 2] {
        let (_, [c, s]) = self.turn();
        let near = sqrtf(0.5 * (1.0 + c.abs()));
        let far = 0.5 * s / near;
        if c >= 0.0 { [near, far] } else { [far, near] }
    }

    /// The matrix with each entry changed.
    pub(crate) fn map(&self, change: impl Fn(f32) -> f32) -> Self {
        Self { xx: change(self.xx), xy: change(self.xy), yy: change(self.yy) }
    }

    /// Adds `share` times another matrix.
    pub(crate) fn add(&mut self, share: f32, other: &Self) {
        self.xx += share * other.xx;
        self.xy += share * other.xy;
        self.yy += share * other.yy;
    }

    /// The inverse of a positive definite matrix.
    pub(crate) fn inverse(&self) -> Self {
        let Self { xx, xy, yy } = *self;
        // What rounding made singular is thin: it keeps its width and gets the least depth.
        let determinant = self.determinant().max(1e-7 * xx * yy);
        Self { xx: yy / determinant, xy: -xy / determinant, yy: xx / determinant }
    }

    /// The matrix with `change`d eigenvalues; None unless all of it is finite.
    pub(crate) fn through_eigenvalues(&self, change: impl Fn(f32) -> f32) -> Option<Self> {
        let (_, [c, s]) = self.turn();
        let [a, b] = self.eigenvalues().map(change);
        // Squares of the angle's cosine and sine: nothing here cancels, so that the smaller of two very
        // unequal values keeps its digits.
        let large = 0.5 * (1.0 + c.abs());
        let small = 0.25 * s * s / large;
        let (cc, ss) = if c > 0.0 { (large, small) } else { (small, large) };
        let changed = Self { xx: a * cc + b * ss, xy: 0.5 * (a - b) * s, yy: a * ss + b * cc };
        (changed.xx + changed.yy + changed.xy).is_finite().then_some(changed)
    }

    /// The largest matrix that is neither above `self` nor above `bound` on the axes on which the two are
    /// both diagonal: the ellipse inside both ellipses. `bound` is positive definite; None unless all of it
    /// is finite.
    pub(crate) fn within(&self, bound: &Self) -> Option<Self> {
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
