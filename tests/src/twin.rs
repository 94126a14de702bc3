//! The naive twin of the light field: the textbook 4x4 covariance, generic over the number it is computed with.
//!
//! With [`Big`] (1600 bits) it is the truth that the square root is measured against; with `f32` it is the form
//! that the square root replaces. Rays are (x, y, u, v), positions first. Nothing here is clever: every linear
//! operator writes down M and computes M⁻ᵀ Σ M⁻¹ with a general inverse; scattering and the slice are written
//! with the subtraction of the textbook.

use covbeam::{Curvature, LightField, Vec3};
use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers that a twin computes with.
pub trait Real:
    Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Exactly this number, as far as the type can hold it.
    fn of(value: f64) -> Self;
    /// Rounded.
    fn to_f64(&self) -> f64;
    /// The square root.
    fn root(self) -> Self;
    /// Variance standing for infinity: an exact point in space, an exact beam in angle.
    fn infinite() -> Self;
    /// Added to the diagonal of a matrix that is about to be inverted, so that the result is the limit
    /// (pseudo-inverse) where the matrix is singular. Only the truth can afford one.
    fn regularisation() -> Self;
    /// Squared sine below which two directions are parallel.
    const PARALLEL: f64;
}

/// A binary floating-point number of so many bits.
#[derive(Clone, Debug)]
pub struct Binary<const BITS: usize>(FBig<HalfEven, 2>);

/// Enough for infinity = 2⁴⁰⁰ and regularisation = 2⁻⁸⁰⁰ in one matrix, with 400 bits left.
pub type Big = Binary<1600>;

/// Enough for a thousand events over six decades of length and four of curvature, where the textbook's
/// subtractions lose two bits an event: after 730 of them 1600 bits have lost all.
pub type Bigger = Binary<3200>;

macro_rules! big_operator {
    ($name:ident, $method:ident) => {
        impl<const BITS: usize> $name for Binary<BITS> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self($name::$method(self.0, other.0))
            }
        }
    };
}
big_operator!(Add, add);
big_operator!(Sub, sub);
big_operator!(Mul, mul);
big_operator!(Div, div);

impl<const BITS: usize> Neg for Binary<BITS> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<const BITS: usize> Real for Binary<BITS> {
    fn of(value: f64) -> Self {
        Self(FBig::try_from(value).expect("finite").with_precision(BITS).value())
    }
    fn to_f64(&self) -> f64 {
        self.0.to_f64().value()
    }
    fn root(self) -> Self {
        Self(self.0.sqrt())
    }
    fn infinite() -> Self {
        Self::of(2f64.powi(400))
    }
    fn regularisation() -> Self {
        Self::of(2f64.powi(-800))
    }
    const PARALLEL: f64 = 1e-200;
}

impl Real for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
    fn to_f64(&self) -> f64 {
        f64::from(*self)
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn infinite() -> Self {
        2f32.powi(100)
    }
    fn regularisation() -> Self {
        0.0
    }
    const PARALLEL: f64 = 1e-13;
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn to_f64(&self) -> f64 {
        *self
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn infinite() -> Self {
        2f64.powi(100)
    }
    fn regularisation() -> Self {
        0.0
    }
    const PARALLEL: f64 = 1e-30;
}

impl Twin<f64> {
    /// Rounds the covariance to single precision: storage in `f32`, operators in `f64`.
    pub fn store_in_single_precision(&mut self) {
        self.covariance = self.covariance.map(|row| row.map(|entry| f64::from(entry as f32)));
    }
}

/// A dense matrix of four rows.
pub type Matrix<R> = [[R; 4]; 4];

/// Where light starts.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// [`LightField::point`]: direction, angular variance.
    Point(Vec3, f32),
    /// [`LightField::disk`]: direction, normal, radius, angular variance.
    Disk(Vec3, Vec3, f32, f32),
    /// [`LightField::collimated`]: direction, radius.
    Collimated(Vec3, f32),
    /// [`LightField::gaussian`]: direction, x axis, spatial variances, angular variances.
    Gaussian(Vec3, Vec3, [f32; 2], [f32; 2]),
}

/// What happens to light on its way.
#[derive(Clone, Copy, Debug)]
pub enum Event {
    /// [`LightField::travel`].
    Travel(f32),
    /// [`LightField::reflect`].
    Reflect(Vec3, Curvature),
    /// [`LightField::refract`].
    Refract(Vec3, Curvature, f32),
    /// [`LightField::occlude`].
    Occlude(Vec3, f32),
    /// [`LightField::narrow`].
    Narrow(Vec3, f32),
    /// [`LightField::scatter`].
    Scatter(Vec3, f32),
    /// [`LightField::diffuse`].
    Diffuse(Vec3, Vec3),
}

impl Event {
    /// The same with other numbers, but for directions.
    pub fn with_numbers(&self, mut other: impl FnMut(f32) -> f32) -> Self {
        let mut bent = |k: Curvature| Curvature {
            tangent: k.tangent,
            along: other(k.along),
            across: other(k.across),
            twist: other(k.twist),
        };
        match *self {
            Self::Travel(distance) => Self::Travel(other(distance)),
            Self::Reflect(normal, k) => Self::Reflect(normal, bent(k)),
            Self::Refract(normal, k, eta) => Self::Refract(normal, bent(k), other(eta)),
            Self::Occlude(towards, distance) => Self::Occlude(towards, other(distance)),
            Self::Narrow(across, variance) => Self::Narrow(across, other(variance)),
            Self::Scatter(direction, variance) => Self::Scatter(direction, other(variance)),
            Self::Diffuse(normal, direction) => Self::Diffuse(normal, direction),
        }
    }
}

/// The library's field after a source and some events. Panics if light meets total reflection.
pub fn light_field(source: Source, events: &[Event]) -> LightField {
    let mut field = start(source);
    for event in events {
        apply(&mut field, event);
    }
    field
}

/// The library's field at its source.
pub fn start(source: Source) -> LightField {
    match source {
        Source::Point(direction, angular) => LightField::point(direction, angular),
        Source::Disk(direction, normal, radius, angular) => {
            LightField::disk(direction, normal, radius, angular)
        }
        Source::Collimated(direction, radius) => LightField::collimated(direction, radius),
        Source::Gaussian(direction, x_axis, spatial, angular) => {
            LightField::gaussian(direction, x_axis, spatial, angular)
        }
    }
}

/// The library's operator of an event. Panics on total reflection.
pub fn apply(field: &mut LightField, event: &Event) {
    match *event {
        Event::Travel(distance) => field.travel(distance),
        Event::Reflect(normal, curvature) => field.reflect(normal, &curvature),
        Event::Refract(normal, curvature, eta) => {
            assert!(field.refract(normal, &curvature, eta), "total reflection");
        }
        Event::Occlude(towards, distance) => field.occlude(towards, distance),
        Event::Narrow(across, variance) => field.narrow(across, variance),
        Event::Scatter(direction, variance) => field.scatter(direction, variance),
        Event::Diffuse(normal, direction) => field.diffuse(normal, direction),
    }
}

/// Covariance of a light field's spectrum, order (x, y, u, v), with its frame.
#[derive(Clone, Debug)]
pub struct Twin<R> {
    /// Σ.
    pub covariance: Matrix<R>,
    /// The frame's x axis.
    pub x: [R; 3],
    /// The direction of propagation.
    pub z: [R; 3],
}

impl<R: Real> Twin<R> {
    /// The twin of [`light_field`].
    pub fn new(source: Source, events: &[Event]) -> Self {
        let mut twin = Self::start(source);
        for event in events {
            twin.apply(event);
        }
        twin
    }

    /// At the source.
    pub fn start(source: Source) -> Self {
        let zero = [R::of(0.0), R::of(0.0), R::of(0.0)];
        let (z, x, variances) = match source {
            Source::Point(direction, angular) => {
                (direction, zero, [R::infinite(), R::infinite(), variance(angular), variance(angular)])
            }
            Source::Disk(direction, normal, radius, angular) => {
                let (z, n) = (unit(&vector::<R>(direction)), unit(&vector(normal)));
                let cosine = dot(&z, &n);
                let spatial = reciprocal_square::<R>(radius);
                let foreshortened = spatial.clone() / (cosine.clone() * cosine);
                (direction, cross(&z, &n), [spatial, foreshortened, variance(angular), variance(angular)])
            }
            Source::Collimated(direction, radius) => {
                let spatial = reciprocal_square::<R>(radius);
                (direction, zero, [spatial.clone(), spatial, R::infinite(), R::infinite()])
            }
            Source::Gaussian(direction, x_axis, [x, y], [u, v]) => {
                (direction, vector(x_axis), [variance(x), variance(y), variance(u), variance(v)])
            }
        };
        let z = unit(&vector(z));
        let across = sub(&x, &scale(&dot(&x, &z), &z));
        let x = if parallel(&across) { some_axis_across(&z) } else { unit(&across) };
        let [a, b, c, d] = variances;
        Self { covariance: diagonal([a, b, c, d]), x, z }
    }

    /// One event. Panics on total reflection.
    pub fn apply(&mut self, event: &Event) {
        match *event {
            Event::Travel(distance) => {
                let mut m = identity();
                m[0][2] = R::of(f64::from(distance));
                m[1][3] = R::of(f64::from(distance));
                self.map(&m);
            }
            Event::Reflect(normal, curvature) => self.reflect(normal, &curvature),
            Event::Refract(normal, curvature, eta) => self.refract(normal, &curvature, eta),
            Event::Occlude(towards, distance) => {
                let n = self.across(towards);
                self.add(0, &n, &reciprocal_square(2.0 * distance));
            }
            Event::Narrow(across, angular) => {
                let n = self.across(across);
                self.add(2, &n, &variance(angular));
            }
            Event::Scatter(direction, lobe) => {
                let out = unit(&vector(direction));
                self.turn_to(&self.sagittal(&out));
                let cos_theta = dot(&self.z, &out);
                for i in 0..4 {
                    self.covariance[1][i] = self.covariance[1][i].clone() * cos_theta.clone();
                    self.covariance[i][1] = self.covariance[i][1].clone() * cos_theta.clone();
                }
                if lobe == 0.0 {
                    self.integrate_over_angle();
                } else {
                    self.convolve(&variance(lobe));
                }
                self.z = out;
            }
            Event::Diffuse(normal, direction) => self.diffuse(normal, direction),
        }
    }

    /// Continues in the frame that the library stored: its rounding to `f32` is an input of the next event, like a
    /// renderer's own directions. Returns how far the stored direction is from this twin's.
    pub fn adopt_frame(&mut self, field: &LightField) -> f64 {
        let z = unit(&vector::<R>(field.direction));
        let stored = vector(field.x_axis);
        let x = unit(&sub(&stored, &scale(&dot(&stored, &z), &z)));
        let difference = sub(&z, &self.z);
        let distance = dot(&difference, &difference).root().to_f64();
        // The library turns its frame at every event.
        self.turn_to(&unit(&sub(&x, &scale(&dot(&x, &self.z), &self.z))));
        self.x = x;
        self.z = z;
        distance
    }

    /// Σ_xx - Σ_xu Σ_uu⁻¹ Σ_ux: the 2x2 slice at zero angular frequency.
    pub fn slice(&self) -> [[R; 2]; 2] {
        let mut integrated = self.clone();
        integrated.integrate_over_angle();
        let c = &integrated.covariance;
        [[c[0][0].clone(), c[0][1].clone()], [c[1][0].clone(), c[1][1].clone()]]
    }

    /// The slice's determinant.
    pub fn slice_determinant(&self) -> R {
        let [[a, b], [c, d]] = self.slice();
        a * d - b * c
    }

    /// Eq 5.14 in the order of [`covbeam::FluenceSpectrum::to_array`].
    pub fn fluence(&self) -> [f64; 6] {
        let slice = self.slice();
        let axes = [self.x.clone(), cross(&self.z, &self.x)];
        [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|(i, j)| {
            let mut sum = R::of(0.0);
            for (row, a) in slice.iter().zip(&axes) {
                for (entry, b) in row.iter().zip(&axes) {
                    sum = sum + entry.clone() * a[i].clone() * b[j].clone();
                }
            }
            sum.to_f64()
        })
    }

    /// Σ' = M⁻ᵀ Σ M⁻¹.
    pub fn map(&mut self, m: &Matrix<R>) {
        let inverse = inverse(m);
        self.covariance = product(&transpose(&inverse), &product(&self.covariance, &inverse));
    }

    fn reflect(&mut self, normal: Vec3, curvature: &Curvature) {
        let (n, cosine, [k_ss, k_st, k_tt]) = self.meet(normal, curvature);
        let two = R::of(2.0);
        let mut m = identity();
        m[1][1] = -R::of(1.0);
        m[2][0] = two.clone() * cosine.clone() * k_ss;
        m[2][1] = two.clone() * k_st.clone();
        m[3][0] = -(two.clone() * k_st);
        m[3][1] = -(two.clone() * k_tt / cosine.clone());
        m[3][3] = -R::of(1.0);
        self.map(&m);
        self.z = unit(&add(&self.z, &scale(&(two * cosine), &n)));
    }

    fn refract(&mut self, normal: Vec3, curvature: &Curvature, eta: f32) {
        let (n, c_i, [k_ss, k_st, k_tt]) = self.meet(normal, curvature);
        let (one, eta) = (R::of(1.0), R::of(f64::from(eta)));
        let sine_squared = eta.clone() * eta.clone() * (one.clone() - c_i.clone() * c_i.clone());
        let c_t = (one - sine_squared).root();
        assert!(c_t.to_f64() > 0.0, "total reflection");
        let power = c_t.clone() - eta.clone() * c_i.clone();
        let mut m = identity();
        m[1][1] = c_t.clone() / c_i.clone();
        m[2][2] = eta.clone();
        m[3][3] = eta.clone() * c_i.clone() / c_t.clone();
        m[2][0] = -(power.clone() * k_ss);
        m[2][1] = -(power.clone() * k_st.clone() / c_i.clone());
        m[3][0] = -(power.clone() * k_st / c_t.clone());
        m[3][1] = -(power * k_tt / (c_t.clone() * c_i.clone()));
        self.map(&m);
        self.z = unit(&add(&scale(&eta, &self.z), &scale(&(eta * c_i - c_t), &n)));
    }

    fn diffuse(&mut self, normal: Vec3, direction: Vec3) {
        let (n, out) = (unit(&vector(normal)), unit(&vector(direction)));
        self.turn_to(&self.sagittal(&n));
        let s_in = self.x.clone();
        let y_in = cross(&self.z, &s_in);
        let t_in = unit(&sub(&y_in, &scale(&dot(&y_in, &n), &n)));
        let mut m = identity();
        m[1][1] = R::of(1.0) / dot(&y_in, &t_in);
        self.map(&m);
        self.integrate_over_angle();
        self.z = out;
        let s_out = self.sagittal(&n);
        let y_out = cross(&self.z, &s_out);
        let t_out = unit(&sub(&y_out, &scale(&dot(&y_out, &n), &n)));
        let mut turned = identity();
        turned[0] = [dot(&s_out, &s_in), dot(&s_out, &t_in), R::of(0.0), R::of(0.0)];
        turned[1] = [dot(&t_out, &s_in), dot(&t_out, &t_in), R::of(0.0), R::of(0.0)];
        self.map(&turned);
        let mut seen = identity();
        seen[1][1] = dot(&y_out, &t_out);
        self.map(&seen);
        self.x = s_out;
    }

    /// Turns the frame into the plane of incidence. Returns the normal on the incoming side, the cosine, and the
    /// curvature tensor's ss, st, tt.
    fn meet(&mut self, normal: Vec3, curvature: &Curvature) -> ([R; 3], R, [R; 3]) {
        let mut n = unit(&vector(normal));
        let given = n.clone();
        let mut sign = R::of(1.0);
        if dot(&n, &self.z).to_f64() > 0.0 {
            n = scale(&R::of(-1.0), &n);
            sign = -sign;
        }
        let cosine = -dot(&n, &self.z);
        self.turn_to(&self.sagittal(&given));
        let s = self.x.clone();
        let t = cross(&s, &n);
        if curvature.along == 0.0 && curvature.across == 0.0 && curvature.twist == 0.0 {
            return (n, cosine, [R::of(0.0), R::of(0.0), R::of(0.0)]);
        }
        let tangent = vector(curvature.tangent);
        let first = unit(&sub(&tangent, &scale(&dot(&tangent, &given), &given)));
        let second = cross(&given, &first);
        let k = |a: &[R; 3], b: &[R; 3]| {
            let (a1, a2, b1, b2) = (dot(a, &first), dot(a, &second), dot(b, &first), dot(b, &second));
            sign.clone()
                * (R::of(f64::from(curvature.along)) * a1.clone() * b1.clone()
                    + R::of(f64::from(curvature.across)) * a2.clone() * b2.clone()
                    + R::of(f64::from(curvature.twist)) * (a1 * b2 + a2 * b1))
        };
        (n, cosine, [k(&s, &s), k(&s, &t), k(&t, &t)])
    }

    /// Unit vector across the ray and `other`; the x axis if these are parallel.
    fn sagittal(&self, other: &[R; 3]) -> [R; 3] {
        let s = cross(&self.z, other);
        if parallel(&s) { self.x.clone() } else { unit(&s) }
    }

    /// Turns the frame about z so that its x axis is `s`.
    fn turn_to(&mut self, s: &[R; 3]) {
        let y = cross(&self.z, &self.x);
        let (c, d) = (dot(&self.x, s), dot(&y, s));
        let mut m = identity();
        for at in [0, 2] {
            m[at][at] = c.clone();
            m[at][at + 1] = d.clone();
            m[at + 1][at] = -d.clone();
            m[at + 1][at + 1] = c.clone();
        }
        self.map(&m);
        self.x = s.clone();
    }

    /// The unit vector along the part of `direction` across the ray, in (x, y).
    fn across(&self, direction: Vec3) -> [R; 2] {
        let v = vector(direction);
        let (x, y) = (dot(&self.x, &v), dot(&cross(&self.z, &self.x), &v));
        let length = (x.clone() * x.clone() + y.clone() * y.clone()).root();
        [x / length.clone(), y / length]
    }

    /// Σ + variance n nᵀ on the two rows from `at` on.
    fn add(&mut self, at: usize, n: &[R; 2], variance: &R) {
        for i in 0..2 {
            for j in 0..2 {
                let term = variance.clone() * n[i].clone() * n[j].clone();
                self.covariance[at + i][at + j] = self.covariance[at + i][at + j].clone() + term;
            }
        }
    }

    fn integrate_over_angle(&mut self) {
        self.convolve(&R::of(0.0));
        for i in 0..4 {
            for j in 2..4 {
                self.covariance[i][j] = R::of(0.0);
                self.covariance[j][i] = R::of(0.0);
            }
        }
    }

    /// Σ - Σ E (Eᵀ Σ E + lobe)⁻¹ Eᵀ Σ, E selecting the angles: (Σ⁻¹ + B⁻¹)⁻¹ without inverting Σ.
    fn convolve(&mut self, lobe: &R) {
        let c = self.covariance.clone();
        let diagonal = lobe.clone() + R::regularisation();
        let (a, b) = (c[2][2].clone() + diagonal.clone(), c[2][3].clone());
        let d = c[3][3].clone() + diagonal;
        let determinant = a.clone() * d.clone() - b.clone() * b.clone();
        let inverse = [[d, -b.clone()], [-b, a]];
        for i in 0..4 {
            for j in 0..4 {
                let mut sum = R::of(0.0);
                for k in 0..2 {
                    for l in 0..2 {
                        sum = sum + c[i][2 + k].clone() * inverse[k][l].clone() * c[2 + l][j].clone();
                    }
                }
                self.covariance[i][j] = c[i][j].clone() - sum / determinant.clone();
            }
        }
    }
}

/// 1/(π² r²), infinite at 0.
fn reciprocal_square<R: Real>(radius: f32) -> R {
    if radius == 0.0 {
        return R::infinite();
    }
    // The rounding of π to f64, 4e-17, is below every tolerance that this twin serves.
    let root = R::of(std::f64::consts::PI) * R::of(f64::from(radius));
    R::of(1.0) / (root.clone() * root)
}

fn variance<R: Real>(value: f32) -> R {
    if value == f32::INFINITY { R::infinite() } else { R::of(f64::from(value)) }
}

fn vector<R: Real>(v: Vec3) -> [R; 3] {
    [v.x, v.y, v.z].map(|c| R::of(f64::from(c)))
}

fn dot<R: Real>(a: &[R; 3], b: &[R; 3]) -> R {
    a[0].clone() * b[0].clone() + a[1].clone() * b[1].clone() + a[2].clone() * b[2].clone()
}

fn cross<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    let minor = |i: usize, j: usize| a[i].clone() * b[j].clone() - a[j].clone() * b[i].clone();
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn add<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    std::array::from_fn(|i| a[i].clone() + b[i].clone())
}

fn sub<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    std::array::from_fn(|i| a[i].clone() - b[i].clone())
}

fn scale<R: Real>(a: &R, v: &[R; 3]) -> [R; 3] {
    std::array::from_fn(|i| a.clone() * v[i].clone())
}

fn unit<R: Real>(v: &[R; 3]) -> [R; 3] {
    let length = dot(v, v).root();
    std::array::from_fn(|i| v[i].clone() / length.clone())
}

fn parallel<R: Real>(across: &[R; 3]) -> bool {
    dot(across, across).to_f64() < R::PARALLEL
}

fn some_axis_across<R: Real>(z: &[R; 3]) -> [R; 3] {
    let along_x = z[0].to_f64().abs() < 0.6;
    let axis = [R::of(f64::from(u8::from(along_x))), R::of(f64::from(u8::from(!along_x))), R::of(0.0)];
    unit(&sub(&axis, &scale(&dot(&axis, z), z)))
}

fn diagonal<R: Real>(entries: [R; 4]) -> Matrix<R> {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entries[i].clone() } else { R::of(0.0) }))
}

/// The unit matrix.
pub fn identity<R: Real>() -> Matrix<R> {
    diagonal([R::of(1.0), R::of(1.0), R::of(1.0), R::of(1.0)])
}

fn transpose<R: Real>(m: &Matrix<R>) -> Matrix<R> {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i].clone()))
}

fn product<R: Real>(a: &Matrix<R>, b: &Matrix<R>) -> Matrix<R> {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..4).fold(R::of(0.0), |sum, k| sum + a[i][k].clone() * b[k][j].clone()))
    })
}

/// Gauss-Jordan with pivoting.
fn inverse<R: Real>(m: &Matrix<R>) -> Matrix<R> {
    let (mut a, mut b) = (m.clone(), identity::<R>());
    for column in 0..4 {
        let size = |row: &usize| a[*row][column].to_f64().abs();
        let pivot = (column..4).max_by(|i, j| size(i).total_cmp(&size(j))).expect("four rows");
        a.swap(column, pivot);
        b.swap(column, pivot);
        let divisor = a[column][column].clone();
        for j in 0..4 {
            a[column][j] = a[column][j].clone() / divisor.clone();
            b[column][j] = b[column][j].clone() / divisor.clone();
        }
        for row in (0..4).filter(|&row| row != column) {
            let factor = a[row][column].clone();
            for j in 0..4 {
                a[row][j] = a[row][j].clone() - factor.clone() * a[column][j].clone();
                b[row][j] = b[row][j].clone() - factor.clone() * b[column][j].clone();
            }
        }
    }
    b
}
