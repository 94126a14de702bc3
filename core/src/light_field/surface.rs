//! What smooth and diffuse surfaces do to a light field: reflection and refraction with curvature, Lambert's
//! law.

use super::frame::{self, Frame, sagittal_or};
use super::{LightField, convolved, turn};
use glam::{DVec3, Vec3};

/// Cosines below this are taken for exactly grazing: in `f64` they have fewer than four digits left.
const GRAZING: f64 = 1e-12;

/// Curvature tensor of a surface at a hit, in the tangent frame (`tangent`, `normal x tangent`) \[1/m\];
/// positive = convex towards the side that the normal points to (a sphere of radius R with outward normal:
/// 1/R).
///
/// ```
/// use covbeam::{Curvature, Vec3};
/// // A cylinder of radius 2 along z, seen from outside; a plane is the default.
/// let _cylinder = Curvature { tangent: Vec3::Z, along: 0.0, across: 0.5, ..Curvature::default() };
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curvature {
    /// First axis of the tensor: perpendicular to the normal, any length but 0. Where it has no direction
    /// across the normal, some axis is used: right for a plane and for a sphere, where every axis serves.
    pub tangent: Vec3,
    /// Normal curvature along `tangent` \[1/m\].
    pub along: f32,
    /// Normal curvature along `normal x tangent` \[1/m\].
    pub across: f32,
    /// The off-diagonal entry \[1/m\].
    pub twist: f32,
}

impl LightField {
    /// Reflection by a smooth mirror, plane or curved.
    ///
    /// Spectrum: mirrored in the plane of incidence; curvature adds angular to spatial frequencies (the
    /// transpose of how it bends rays). The determinant is kept.
    ///
    /// - `normal`: at the hit, on either side of the surface. A ray that grazes to below 1e-12 leaves the
    ///   field as it was.
    /// - `curvature`: of the surface as seen from `normal`, finite.
    ///
    /// Exact to first order in the ray's offset and slope. Test: `the_mirror_agrees_with_traced_rays`.
    ///
    /// Source: derived (Coddington's equations with an off-diagonal term). Differs from the thesis' chapter 3
    /// in the sagittal plane, where its published implementation leaves out the cosine.
    ///
    /// ```
    /// use covbeam::{Curvature, LightField, Vec3};
    /// // A concave mirror of radius 2 sends a parallel beam of radius 1 m through its focus at 1.
    /// let dish = Curvature { tangent: Vec3::X, along: -0.5, across: -0.5, twist: 0.0 };
    /// let mut light = LightField::gaussian(-Vec3::Z, Vec3::X, [1.0, 1.0], [1e6, 1e6]);
    /// light.reflect(Vec3::Z, &dish);
    /// assert_eq!(light.direction, Vec3::Z);
    /// light.travel(1.0);
    /// assert!((light.slice()[0] / 1e6 - 1.0).abs() < 1e-6);
    /// ```
    #[doc(alias = "Coddington")]
    #[doc(alias = "mirror")]
    pub fn reflect(&mut self, normal: Vec3, curvature: &Curvature) {
        let frame = self.frame();
        let Some(hit) = Hit::new(&frame, normal, curvature) else { return };
        let c = hit.cosine;
        let mut columns = self.columns();
        turn(&mut columns, &frame, hit.sagittal);
        for [u, v, x, y] in &mut columns {
            *x += -2.0 * c * hit.ss * *u - 2.0 * hit.st * *v;
            *y = -*y + 2.0 * hit.st * *u + 2.0 * hit.tt / c * *v;
            *v = -*v;
        }
        let direction = frame.z + 2.0 * c * hit.normal;
        self.leave(columns, hit.sagittal, direction);
    }

    /// Refraction into another medium through a smooth surface, plane or curved. Returns true if light
    /// passes.
    ///
    /// Spectrum: angular frequencies scaled by n₂/n₁ (in the plane of incidence also by c_t/c_i), in-plane
    /// spatial ones by c_i/c_t; curvature adds angular to spatial frequencies. det Σ' = det Σ (n₂/n₁)⁴.
    ///
    /// - `normal`, `curvature`: as in [`LightField::reflect`].
    /// - `eta` > 0, finite: refractive index on the side of the incoming light over that on the other side.
    ///
    /// Returns false, and leaves the field as it was, on total internal reflection, exactly grazing
    /// incidence, or arguments without meaning.
    ///
    /// Exact to first order. Within 1e-4 rad of total reflection the cosine of the refracted ray itself loses
    /// digits (relative error 1e-16/c_t²). Test: `refraction_agrees_with_traced_rays`.
    ///
    /// Source: derived (Coddington's equations with an off-diagonal term); the thesis' implementation has
    /// none.
    ///
    /// ```
    /// use covbeam::{Curvature, LightField, Vec3};
    /// // Glass to air at 60 degrees: total reflection.
    /// let mut light = LightField::point(Vec3::new(0.866, 0.0, -0.5), 0.0);
    /// assert!(!light.refract(Vec3::Z, &Curvature::default(), 1.5));
    /// // Air to glass bends towards the normal.
    /// assert!(light.refract(Vec3::Z, &Curvature::default(), 1.0 / 1.5));
    /// assert!((light.direction.x - 0.866 / 1.5).abs() < 1e-4);
    /// ```
    #[doc(alias = "Coddington")]
    #[doc(alias = "lens")]
    pub fn refract(&mut self, normal: Vec3, curvature: &Curvature, eta: f32) -> bool {
        let frame = self.frame();
        let Some(hit) = Hit::new(&frame, normal, curvature) else { return false };
        if !(eta > 0.0 && eta.is_finite()) {
            return false;
        }
        let (eta, c_i) = (f64::from(eta), hit.cosine);
        // (1 - η)(1 + η) is exact where 1 - η² sin² would cancel.
        let transmitted = (1.0 - eta) * (1.0 + eta) + (eta * c_i) * (eta * c_i);
        if transmitted <= 0.0 {
            return false;
        }
        let c_t = libm::sqrt(transmitted);
        // P/n₂ = c_t - η c_i, without its cancellation at η near 1.
        let power = (1.0 - eta) * (1.0 + eta) / (c_t + eta * c_i);
        let mut columns = self.columns();
        turn(&mut columns, &frame, hit.sagittal);
        for [u, v, x, y] in &mut columns {
            *x += power / eta * (hit.ss * *u + hit.st / c_i * *v);
            *y = c_i / c_t * (*y + power / (eta * c_i) * (hit.st * *u + hit.tt / c_i * *v));
            *u /= eta;
            *v *= c_t / (eta * c_i);
        }
        let direction = eta * frame.z + (eta * c_i - c_t) * hit.normal;
        self.leave(columns, hit.sagittal, direction);
        true
    }

    /// Diffuse (Lambert) reflection or transmission at a surface into `direction`.
    ///
    /// Spectrum: projected on the surface (in-plane spatial frequencies times c_i), integrated over angle,
    /// and seen from `direction` (in-plane ones divided by c_o).
    ///
    /// - `normal`: of the surface, either sign.
    /// - `direction`: of propagation after the event. The division by c_o is not bounded: a pattern seen at a
    ///   grazing angle is that dense.
    ///
    /// A cosine below 1e-12 on either side leaves the field as it was. The variation of the two cosines over
    /// the footprint is not accounted for.
    ///
    /// Source: derived (thesis 5.3.1 for the convolution).
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::gaussian(-Vec3::Z, Vec3::X, [4.0, 9.0], [1.0, 1.0]);
    /// light.diffuse(Vec3::Z, Vec3::new(0.0, 3f32.sqrt(), 1.0)); // leaves at 60 degrees, foreshortened along y
    /// let spectrum = light.fluence();
    /// assert!((spectrum.xx - 4.0).abs() < 1e-5);
    /// assert!((spectrum.xx + spectrum.yy + spectrum.zz - (4.0 + 9.0 * 4.0)).abs() < 1e-4);
    /// ```
    #[doc(alias = "Lambert")]
    pub fn diffuse(&mut self, normal: Vec3, direction: Vec3) {
        let frame = self.frame();
        let (Some(n), Some(out)) = (frame::unit(normal), frame::unit(direction)) else { return };
        let (c_i, c_o) = (frame.z.dot(n).abs(), out.dot(n).abs());
        if c_i < GRAZING || c_o < GRAZING {
            return;
        }
        let mut columns = self.columns();
        let s_in = sagittal_or(frame.z, n, frame.x);
        turn(&mut columns, &frame, s_in);
        let y_in = frame.z.cross(s_in);
        let t_in = in_surface(y_in, n).unwrap_or(y_in);
        let s_out = sagittal_or(out, n, s_in);
        let y_out = out.cross(s_out);
        let t_out = in_surface(y_out, n).unwrap_or(y_out);
        for column in &mut columns {
            column[3] *= c_i;
        }
        let mut columns = convolved(&columns, 0.0);
        for [_, _, x, y] in &mut columns {
            let on_surface = *x * s_in + *y * t_in;
            *x = s_out.dot(on_surface);
            *y = t_out.dot(on_surface) / c_o;
        }
        self.leave(columns, s_out, out);
    }
}

/// A surface as the incoming ray meets it.
struct Hit {
    /// Unit, on the incoming side.
    normal: DVec3,
    /// Unit, across the plane of incidence.
    sagittal: DVec3,
    /// Of the angle of incidence, > 0.
    cosine: f64,
    /// Curvature tensor in (sagittal, in-plane tangent), positive = convex towards the incoming side.
    ss: f64,
    st: f64,
    tt: f64,
}

impl Hit {
    fn new(frame: &Frame, normal: Vec3, curvature: &Curvature) -> Option<Self> {
        let given = frame::unit(normal)?;
        let cosine = -given.dot(frame.z);
        let finite =
            curvature.along.is_finite() && curvature.across.is_finite() && curvature.twist.is_finite();
        if cosine.abs() < GRAZING || !finite {
            return None;
        }
        let side = cosine.signum();
        let normal = side * given;
        let s = sagittal_or(frame.z, given, frame.x);
        // In the surface, and towards y: y = z x s, and -z is on the normal's side.
        let t = s.cross(normal);
        let first = Frame::new(frame::unit(curvature.tangent).unwrap_or(DVec3::ZERO), given);
        let [along, across, twist] = [curvature.along, curvature.across, curvature.twist].map(f64::from);
        let bend = |a: DVec3, b: DVec3| {
            let (a1, a2, b1, b2) = (a.dot(first.x), a.dot(first.y), b.dot(first.x), b.dot(first.y));
            side * (along * a1 * b1 + across * a2 * b2 + twist * (a1 * b2 + a2 * b1))
        };
        Some(Self {
            normal,
            sagittal: s,
            cosine: cosine.abs(),
            ss: bend(s, s),
            st: bend(s, t),
            tt: bend(t, t),
        })
    }
}

/// The unit vector along the part of `v` in the surface with unit normal `n`.
fn in_surface(v: DVec3, n: DVec3) -> Option<DVec3> {
    (v - v.dot(n) * n).try_normalize()
}
