//! The local light field's covariance, kept as a square root, and what each event of a light path does to it.
//!
//! Covariance tracing is a Kalman filter: travel and curvature are state transitions, occlusion is process
//! noise, scattering is a measurement update, and the fluence's slice is the limit of a perfect measurement.
//! The square-root form of that filter is used: L lower triangular with Σ = L Lᵀ, angles before positions.
//!
//! | event | on L | on Σ |
//! |---|---|---|
//! | linear map q' = M q of the rays | tri(M⁻ᵀ L) | M⁻ᵀ Σ M⁻¹ |
//! | signal multiplied by g of covariance A Aᵀ | tri(\[L A\]) | Σ + A Aᵀ |
//! | signal convolved in angle with a lobe of covariance C Cᵀ | lower right of tri(\[\[C, L_u\], \[0, L\]\]) | (Σ⁻¹ + (C Cᵀ)⁻¹)⁻¹ |
//! | integral over angle | the lower-right 2x2 block of L | Schur complement |
//!
//! The textbook form subtracts covariances and loses every digit near point sources, collimated beams and
//! foci; here no covariance is subtracted, inverted, regularised or clamped. L is stored in `f32`; an
//! operator works in `f64` and rounds once when it is done.

mod fluence;
mod frame;
pub(crate) mod medium;
mod occlusion;
mod surface;
mod triangular;

pub use fluence::FluenceSpectrum;
pub use surface::Curvature;

use core::f64::consts::PI;
use frame::{Frame, sagittal_or};
use glam::{DVec3, Vec3};
use triangular::triangular;

/// Root of the variance of an exact point (in space), an exact parallel beam (in angle), or an edge on the
/// ray.
///
/// Far beyond any finite source: 1/(π R) reaches it at R = 3e-16. A source of finite size R seen from a
/// distance d is told from a point by R against d times its angular bandwidth, so at any distance above 1e-6
/// the deviation from the exact limit is below 1e-17. Its square still fits in `f32`. A power of two, so that
/// scaling by it is exact.
const SHARP: f64 = (1u64 << 50) as f64;

/// Largest entry of a stored root. Light that is bent again and again has an angular frequency that grows
/// without limit, by 2¹³⁰ in a thousand bounces.
const UNBOUNDED: f64 = (1u128 << 100) as f64;

/// Square root of the covariance of a local light field's spectrum, with the frame it is expressed in.
///
/// Guarantee of every operator: the covariance stays positive semi-definite (it is L Lᵀ), nothing becomes NaN
/// or infinite (a column of the root beyond 2¹⁰⁰ is scaled back to it), and an argument out of its range or
/// without meaning (NaN, an infinite vector, one without a direction or without a part across the ray where
/// that counts) leaves the field as it was. Vectors may have any length. A source takes +z for a direction
/// that is none, 0 for a variance and infinity for a radius that is negative or NaN.
///
/// Error: one rounding of the ten numbers to `f32` per operator. The slice agrees with a 1600-bit evaluation
/// to 1e-6, 1e-5 after 1000 events (test `every_hard_case_is_within_its_tolerance`). Long ways of strongly bent
/// light lose more: a rounding counts as many times as the angles then spread more along one axis than along
/// the other, and where curvature times distance is beyond 1e7, 24 bits hold one of the two. Of 1000 random
/// chains of up to 1000 events, with ways of 1e-3 to 1e3 m and curvatures of 0.01 to 100 per m, half agree to
/// 1e-7, 99 % to 7e-6, all to 2e-4 (command `stability`).
///
/// Size: 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightField {
    /// Lower-triangular L with Σ = L Lᵀ, rows (u, v, x, y), packed row by row:
    /// `[uu, vu, vv, xu, xv, xx, yu, yv, yx, yy]`. Rows u and v in cycles/rad, x and y in cycles/m. A column
    /// whose diagonal entry is 0 is 0.
    pub root: [f32; 10],
    /// The frame's x axis, unit, perpendicular to `direction`; y = direction x x_axis. Every operator except
    /// [`LightField::occlude`] and [`LightField::narrow`] may turn it, travel included: it is kept along the
    /// largest angular variance, where rounding does least harm.
    pub x_axis: Vec3,
    /// The central ray's direction of propagation, unit.
    pub direction: Vec3,
}

impl LightField {
    /// Light of an exact point source.
    ///
    /// Spectrum: infinitely wide in space (root 2⁵⁰ cycles/m), `angular_variance` along u and v.
    ///
    /// - `direction`: of propagation.
    /// - `angular_variance` \[cycles²/rad²\] >= 0: of the lamp's emission: [`EVEN_LAMP`](crate::EVEN_LAMP) for
    ///   one that shines evenly; infinity for a single direction.
    ///
    /// Source: thesis 5.3.1.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::point(Vec3::Z, 0.25);
    /// light.travel(2.0);
    /// // Seen from a distance d, an angular variance A is a spatial one of A/d².
    /// assert!((light.slice()[0] - 0.0625).abs() < 1e-7);
    /// ```
    pub fn point(direction: Vec3, angular_variance: f32) -> Self {
        Self::gaussian(direction, Vec3::ZERO, [f32::INFINITY; 2], [angular_variance; 2])
    }

    /// Light of a disk source at its centre.
    ///
    /// Spectrum: a disk of radius R has 1/(π²R²) in space, foreshortened to 1/(π²R²cos²θ) in the plane of
    /// `direction` and `normal`; `angular_variance` along u and v.
    ///
    /// - `direction`: of propagation.
    /// - `normal`: of the disk, either sign; a disk facing `direction` if it has none.
    /// - `radius` \[m\] >= 0: 0 is a point, infinity a uniform field.
    /// - `angular_variance` \[cycles²/rad²\]: as in [`LightField::point`].
    ///
    /// Source: thesis 5.3.1; the constant is derived (1/(4π²w²) of a Gaussian with w = R/2, the disk's own).
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let light = LightField::disk(Vec3::Z, Vec3::Z, 0.5, 0.0);
    /// let variance = 1.0 / (std::f32::consts::PI * 0.5).powi(2);
    /// assert!((light.slice()[0] / variance - 1.0).abs() < 1e-6);
    /// ```
    pub fn disk(direction: Vec3, normal: Vec3, radius: f32, angular_variance: f32) -> Self {
        let z = frame::unit(direction).unwrap_or(DVec3::Z);
        let n = frame::unit(normal).unwrap_or(z);
        let root = sharpness(radius);
        let foreshortened = (root / z.dot(n).abs()).min(SHARP);
        let angular = deviation(angular_variance);
        // 0/0: an infinite disk seen edge on.
        let foreshortened = if foreshortened.is_nan() { 0.0 } else { foreshortened };
        Self::uncorrelated(
            Frame::new(sagittal_or(z, n, DVec3::ZERO), z),
            [angular, angular, root, foreshortened],
        )
    }

    /// An exactly parallel beam.
    ///
    /// Spectrum: infinitely wide in angle (root 2⁵⁰ cycles/rad), 1/(π²R²) in space.
    ///
    /// - `direction`: of propagation.
    /// - `radius` \[m\] >= 0: 0 is a pencil without width, infinity a plane wave's uniform field.
    ///
    /// Source: derived; the mirror image of [`LightField::point`].
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut laser = LightField::collimated(Vec3::X, 0.01);
    /// let before = laser.slice();
    /// laser.travel(1000.0);
    /// assert_eq!(laser.slice(), before);
    /// ```
    pub fn collimated(direction: Vec3, radius: f32) -> Self {
        let z = frame::unit(direction).unwrap_or(DVec3::Z);
        let root = sharpness(radius);
        Self::uncorrelated(Frame::new(DVec3::ZERO, z), [SHARP, SHARP, root, root])
    }

    /// A field without correlations, from its four variances.
    ///
    /// Spectrum: the given variances along x, y, u, v; a Gaussian of standard deviation w has 1/(4π²w²).
    ///
    /// - `direction`: of propagation.
    /// - `x_axis`: the part of it across `direction` is the frame's x axis; some axis is chosen if it has
    ///   none.
    /// - `spatial_variance` along x and y \[cycles²/m²\] >= 0: 0 is uniform, infinity a point or a line.
    /// - `angular_variance` along x and y \[cycles²/rad²\] >= 0: 0 is isotropic, infinity parallel.
    ///
    /// Source: thesis Eq 5.12.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let sheet = LightField::gaussian(Vec3::Z, Vec3::X, [4.0, 0.0], [1.0, 1.0]);
    /// assert_eq!(sheet.slice(), [4.0, 0.0, 0.0]);
    /// ```
    pub fn gaussian(
        direction: Vec3,
        x_axis: Vec3,
        spatial_variance: [f32; 2],
        angular_variance: [f32; 2],
    ) -> Self {
        let z = frame::unit(direction).unwrap_or(DVec3::Z);
        let x = frame::unit(x_axis).unwrap_or(DVec3::ZERO);
        let [x_variance, y_variance] = spatial_variance;
        let [u_variance, v_variance] = angular_variance;
        let roots = [u_variance, v_variance, x_variance, y_variance].map(deviation);
        Self::uncorrelated(Frame::new(x, z), roots)
    }

    /// Travel in free space.
    ///
    /// Spectrum: sheared, ω_u' = ω_u - d ω_x, ω_v' = ω_v - d ω_y; the determinant is kept.
    ///
    /// - `distance` \[m\]: finite; 0 changes nothing, a negative one goes back.
    ///
    /// Guarantee: travelling a and then b is travelling a + b.
    ///
    /// Source: thesis 5.3.1 (the textbook transport shear).
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::point(Vec3::Z, 1.0);
    /// light.travel(10.0);
    /// assert!((light.slice()[2] - 0.01).abs() < 1e-8);
    /// ```
    pub fn travel(&mut self, distance: f32) {
        if !distance.is_finite() || distance == 0.0 {
            return;
        }
        let d = f64::from(distance);
        // Positions first: what the angles have of their own is then in columns where the positions have
        // nothing, and a long way, d ω_x beyond 1e16 ω_u, cannot swallow it.
        let mut columns = triangular(self.columns().map(|[u, v, x, y]| [x, y, u, v]));
        for [x, y, u, v] in &mut columns {
            *u -= d * *x;
            *v -= d * *y;
        }
        let frame = self.frame();
        self.store(columns.map(|[x, y, u, v]| [u, v, x, y]), &frame);
    }

    /// The same light in a frame turned about the ray, e.g. to read [`LightField::slice`] along given axes.
    ///
    /// Spectrum: unchanged; its covariance's rows are mixed, (u, v) and (x, y) alike.
    ///
    /// - `x_axis`: its part across the ray becomes the x axis.
    ///
    /// Guarantee: `fluence()` stays what it was, up to rounding. Test:
    /// `turning_the_frame_changes_no_fluence`.
    ///
    /// Source: thesis 5.3.1.2 (the local frame is free about the ray).
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::gaussian(Vec3::Z, Vec3::X, [4.0, 9.0], [1.0, 1.0]);
    /// light.rotate(Vec3::new(1.0, 1.0, 0.0));
    /// // Half-way between the axes: both variances are the mean, the covariance half the difference.
    /// assert!((light.slice()[0] - 6.5).abs() < 1e-5 && (light.slice()[1] - 2.5).abs() < 1e-5);
    /// ```
    pub fn rotate(&mut self, x_axis: Vec3) {
        let Some([x, y]) = self.across(x_axis) else { return };
        let frame = self.frame();
        let s = x * frame.x + y * frame.y;
        let mut columns = self.columns();
        turn(&mut columns, &frame, s);
        self.x_axis = s.as_vec3();
        self.pack(&triangular(columns));
    }

    /// Narrowing of the emitted or transmitted directions, such as by the soft rim of a spot light.
    ///
    /// Spectrum: `angular_variance` is added along one axis; the signal is multiplied by a function of angle.
    ///
    /// - `across`: world direction in which the signal falls off; the part of it across the ray counts.
    /// - `angular_variance` \[cycles²/rad²\] >= 0: 0 changes nothing, infinity leaves one direction (root
    ///   2⁵⁰). A Gaussian rim of standard deviation s has 1/(4π²s²).
    ///
    /// Source: thesis 5.3.1 (products in the primal domain).
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::point(Vec3::Z, 0.0);
    /// light.narrow(Vec3::X, 4.0);
    /// light.travel(2.0);
    /// assert_eq!(light.slice(), [1.0, 0.0, 0.0]);
    /// ```
    pub fn narrow(&mut self, across: Vec3, angular_variance: f32) {
        if angular_variance.is_nan() || angular_variance < 0.0 {
            return;
        }
        let Some([n_u, n_v]) = self.across(across) else { return };
        let root = deviation(angular_variance);
        self.multiply([n_u * root, n_v * root, 0.0, 0.0]);
    }

    /// Scattering in a medium, or by a rough surface's lobe, into `direction`.
    ///
    /// Spectrum: in-plane spatial frequencies scaled by cos θ, then the angular part is multiplied with the
    /// spectrum of the phase function: (Σ⁻¹ + B⁻¹)⁻¹ with B = `angular_variance` along u and v.
    ///
    /// - `direction`: of propagation after the event.
    /// - `angular_variance` \[cycles²/rad²\] >= 0 of the lobe, [`crate::PhaseFunction::angular_variance`]: 0
    ///   is isotropic and leaves exactly the slice, infinity a lobe that does not blur.
    ///
    /// Source: thesis 5.3.1 (scattering operator); projection derived.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::gaussian(Vec3::Z, Vec3::X, [4.0, 9.0], [1.0, 1.0]);
    /// let before = light.slice();
    /// light.scatter(Vec3::Z, 0.0);
    /// assert_eq!(light.slice(), before);
    /// // Isotropic scattering keeps no angular frequency: travel no longer changes the slice.
    /// light.travel(5.0);
    /// assert_eq!(light.slice(), [0.0; 3]);
    /// ```
    pub fn scatter(&mut self, direction: Vec3, angular_variance: f32) {
        let Some(out) = frame::unit(direction) else { return };
        if angular_variance.is_nan() || angular_variance < 0.0 {
            return;
        }
        let frame = self.frame();
        let s = sagittal_or(frame.z, out, frame.x);
        let cos_theta = frame.z.dot(out);
        let mut columns = self.columns();
        turn(&mut columns, &frame, s);
        for column in &mut columns {
            column[3] *= cos_theta;
        }
        if angular_variance < f32::INFINITY {
            columns = convolved(&columns, deviation(angular_variance));
        }
        self.leave(columns, s, out);
    }

    /// Diagonal root, rows (u, v, x, y).
    fn uncorrelated(frame: Frame, [u, v, x, y]: [f64; 4]) -> Self {
        let (x_axis, direction) = (frame.x.as_vec3(), frame.z.as_vec3());
        let mut field = Self { root: [0.0; 10], x_axis, direction };
        let columns = [[u, 0.0, 0.0, 0.0], [0.0, v, 0.0, 0.0], [0.0, 0.0, x, 0.0], [0.0, 0.0, 0.0, y]];
        field.pack(&columns);
        field
    }

    /// The signal is multiplied by a function whose spectrum's covariance is a aᵀ: Σ + a aᵀ.
    fn multiply(&mut self, a: [f64; 4]) {
        let [c0, c1, c2, c3] = self.columns();
        self.pack(&triangular([c0, c1, c2, c3, a]));
    }

    /// The unit vector along the part of `direction` across the ray, in the local (x, y).
    fn across(&self, direction: Vec3) -> Option<[f64; 2]> {
        let (frame, v) = (self.frame(), frame::unit(direction)?);
        let (x, y) = (frame.x.dot(v), frame.y.dot(v));
        let length = libm::sqrt(x * x + y * y);
        // Below this, what is left across the ray is the rounding of the stored axes.
        (length > 1e-7).then(|| [x / length, y / length])
    }

    fn frame(&self) -> Frame {
        let z = frame::unit(self.direction).unwrap_or(DVec3::Z);
        Frame::new(frame::unit(self.x_axis).unwrap_or(DVec3::ZERO), z)
    }

    /// L by columns.
    fn columns(&self) -> [[f64; 4]; 4] {
        let [uu, vu, vv, xu, xv, xx, yu, yv, yx, yy] = self.root.map(f64::from);
        [[uu, vu, xu, yu], [0.0, vv, xv, yv], [0.0, 0.0, xx, yx], [0.0, 0.0, 0.0, yy]]
    }

    /// Stores any root, after an event that leaves the ray with direction `z` and, before it is turned to the
    /// principal axes, the axis `x`.
    fn leave(&mut self, columns: [[f64; 4]; 4], x: DVec3, z: DVec3) {
        let frame = Frame::new(x, z.normalize_or(z));
        self.direction = frame.z.as_vec3();
        self.store(columns, &frame);
    }

    /// Stores any root, turned to the principal axes of its angular part.
    ///
    /// Why turn: rounding a stored column tilts it by 6e-8 of its length. If the first column, the largest
    /// after many bends, lay along v rather than u, the other could not absorb that, and the curvature of the
    /// wavefront would be off by v/u times as much (146 times the effect of rounding the inputs, measured on
    /// paths of 1000 bounces; 1.4 times in principal axes).
    fn store(&mut self, mut columns: [[f64; 4]; 4], frame: &Frame) {
        // Of the angular part's covariance, summed so that nothing cancels.
        let a = columns.iter().map(|[u, v, ..]| (u - v) * (u + v)).sum();
        let b = columns.iter().map(|[u, v, ..]| 2.0 * u * v).sum();
        let (c, d) = principal_axis(a, b);
        let x = c * frame.x + d * frame.y;
        turn(&mut columns, frame, x);
        self.x_axis = x.as_vec3();
        self.pack(&triangular(columns));
    }

    /// Rounds the columns of a lower-triangular root to storage.
    fn pack(&mut self, columns: &[[f64; 4]; 4]) {
        let [[uu, vu, xu, yu], [_, vv, xv, yv], [_, _, xx, yx], [.., yy]] = columns.map(bounded);
        self.root = [uu, vu, vv, xu, xv, xx, yu, yv, yx, yy].map(|entry| entry as f32);
    }
}

/// Cosine and sine of the turn to the axis of a symmetric matrix's largest eigenvalue; none if all axes are
/// alike.
///
/// - `a`, `b`: the difference of its diagonal entries, and twice the other one; or half of both.
fn principal_axis(a: f64, b: f64) -> (f64, f64) {
    // Twice the angle has the cosine a/r and the sine b/r.
    let r = libm::sqrt(a * a + b * b);
    // Where squares of squares leave the range of normal numbers, r is no longer the length of (a, b): any
    // axis will do.
    if !(r > 1e-150 && r < f64::INFINITY) {
        return (1.0, 0.0);
    }
    // The larger of the two from a square root, the other by division: neither cancels.
    let larger = libm::sqrt(0.5 * (1.0 + a.abs() / r));
    let smaller = 0.5 * b.abs() / (r * larger);
    let (c, d) = if a >= 0.0 { (larger, smaller) } else { (smaller, larger) };
    (c, if b < 0.0 { -d } else { d })
}

/// Turns the frame about z so that x becomes `s`, a unit vector across z.
fn turn(columns: &mut [[f64; 4]; 4], frame: &Frame, s: DVec3) {
    let (c, d) = (frame.x.dot(s), frame.y.dot(s));
    for [u, v, x, y] in columns {
        (*u, *v) = (c * *u + d * *v, c * *v - d * *u);
        (*x, *y) = (c * *x + d * *y, c * *y - d * *x);
    }
}

/// The signal convolved in angle with an isotropic lobe of variance `lobe`²: the lower right of tri([[C,
/// L_u], [0, L]]).
fn convolved(columns: &[[f64; 4]; 4], lobe: f64) -> [[f64; 4]; 4] {
    let below = columns.map(|[u, v, x, y]| [u, v, u, v, x, y]);
    let [c2, c3, c4, c5] = below;
    let all = triangular([[lobe, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, lobe, 0.0, 0.0, 0.0, 0.0], c2, c3, c4, c5]);
    let [_, _, u, v, x, y] = all;
    [u, v, x, y].map(|[_, _, u, v, x, y]| [u, v, x, y])
}

/// Root 1/(πR) of the variance of a disk or gap of radius R, at most [`SHARP`].
fn sharpness(radius: f32) -> f64 {
    // The sign of -0 would make it negative.
    if radius >= 0.0 { (1.0 / (PI * f64::from(radius.abs()))).min(SHARP) } else { 0.0 }
}

/// Root of a variance, at most [`SHARP`].
fn deviation(variance: f32) -> f64 {
    if variance > 0.0 { libm::sqrt(f64::from(variance)).min(SHARP) } else { 0.0 }
}

/// A column of the root, scaled by a power of two to at most [`UNBOUNDED`]. The direction of an unlimited
/// variance matters, its amount does not: scaled as a whole, a column leaves the slice as it is. Clamping its
/// entries would turn it.
fn bounded(column: [f64; 4]) -> [f64; 4] {
    let largest = column.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    if largest <= UNBOUNDED {
        return column;
    }
    let factor = libm::ldexp(1.0, -libm::ilogb(largest / UNBOUNDED) - 1);
    column.map(|entry| entry * factor)
}
