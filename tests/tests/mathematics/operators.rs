//! Mirror and refraction against finite differences of an independent ray tracer, and against Coddington's focal
//! distances.

use covbeam::{Curvature, LightField, Vec3};
use covbeam_tests::random::Stream;
use covbeam_tests::twin::{Real, Twin};

type V = [f64; 3];

fn v(v: Vec3) -> V {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
/// a + t b.
fn along(a: V, t: f64, b: V) -> V {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}
fn unit(a: V) -> V {
    along([0.0; 3], 1.0 / dot(a, a).sqrt(), a)
}

/// A ray's plane coordinates (x, y, u, v) in a frame at the origin: offsets where it crosses the plane across z,
/// and slopes.
fn coordinates(origin: V, direction: V, x: V, z: V) -> [f64; 4] {
    let y = cross(z, x);
    let slope = dot(direction, z);
    let at = along(origin, -dot(origin, z) / slope, direction);
    [dot(at, x), dot(at, y), dot(direction, x) / slope, dot(direction, y) / slope]
}

/// A quadric through the origin, h = -½ pᵀ K p above the tangent plane, in double precision.
struct Quadric {
    axes: [V; 3],
    k: [f64; 3],
}

impl Quadric {
    fn new(normal: Vec3, curvature: &Curvature) -> Self {
        let n = unit(v(normal));
        let t = v(curvature.tangent);
        let first = unit(along(t, -dot(t, n), n));
        let k = [curvature.along, curvature.across, curvature.twist].map(f64::from);
        Self { axes: [first, cross(n, first), n], k }
    }

    /// Where the ray meets the surface, and the unit normal there on the ray's side.
    fn meet(&self, origin: V, direction: V) -> (V, V) {
        let [e1, e2, n] = self.axes;
        let [along_1, along_2, twist] = self.k;
        let mut t = 0.0;
        for _ in 0..50 {
            let p = along(origin, t, direction);
            let (a, b) = (dot(p, e1), dot(p, e2));
            let gradient = [along_1 * a + twist * b, along_2 * b + twist * a];
            let value = dot(p, n) + 0.5 * (gradient[0] * a + gradient[1] * b);
            let slope =
                dot(direction, n) + gradient[0] * dot(direction, e1) + gradient[1] * dot(direction, e2);
            t -= value / slope;
        }
        let p = along(origin, t, direction);
        let (a, b) = (dot(p, e1), dot(p, e2));
        let tilt = along(along(n, along_1 * a + twist * b, e1), along_2 * b + twist * a, e2);
        let normal = unit(tilt);
        (p, if dot(normal, direction) > 0.0 { along([0.0; 3], -1.0, normal) } else { normal })
    }

    /// The ray after a mirror (`eta` None) or a refraction.
    fn bend(&self, origin: V, direction: V, eta: Option<f64>) -> (V, V) {
        let (p, n) = self.meet(origin, direction);
        let d = unit(direction);
        let cosine = -dot(d, n);
        let out = match eta {
            None => along(d, 2.0 * cosine, n),
            Some(eta) => {
                let c_t = (1.0 - eta * eta * (1.0 - cosine * cosine)).sqrt();
                along(along([0.0; 3], eta, d), eta * cosine - c_t, n)
            }
        };
        (p, unit(out))
    }
}

/// Σ of a field, order (x, y, u, v), from its root in double precision.
fn covariance(field: &LightField) -> [[f64; 4]; 4] {
    let [uu, vu, vv, xu, xv, xx, yu, yv, yx, yy] = field.root.map(f64::from);
    let rows = [[xu, xv, xx, 0.0], [yu, yv, yx, yy], [uu, 0.0, 0.0, 0.0], [vu, vv, 0.0, 0.0]];
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| rows[i][k] * rows[j][k]).sum()))
}

/// A dense random field: every entry of the root is non-zero and no two are alike.
fn dense_field(random: &mut Stream) -> LightField {
    let mut field = LightField::gaussian(random.direction(), random.direction(), [1.0; 2], [1.0; 2]);
    field.root =
        std::array::from_fn(|_| (random.between(0.3, 2.0) * (random.uniform() - 0.5).signum()) as f32);
    field
}

/// Applies one event to dense fields at random skew hits and compares with M by central differences of traced rays.
/// Returns the worst entry of Σ', relative to the variances of its row and column.
fn worst_against_traced_rays(refract: bool) -> f64 {
    let mut random = Stream::new(5);
    let mut worst: f64 = 0.0;
    let mut hits = 0;
    while hits < 2000 {
        let normal = random.direction();
        let mut field = dense_field(&mut random);
        let cosine = dot(v(field.direction), unit(v(normal)));
        let eta = refract.then(|| random.between(0.5, 2.0) as f32);
        // Total reflection, and angles so grazing that the difference step leaves the quadric's vertex.
        let passes = eta.is_none_or(|e| f64::from(e).powi(2) * (1.0 - cosine * cosine) < 0.95);
        if cosine.abs() < 0.2 || !passes {
            continue;
        }
        hits += 1;
        let curvature = Curvature {
            tangent: random.direction(),
            along: random.between(-1.0, 1.0) as f32,
            across: random.between(-3.0, 3.0) as f32,
            twist: random.between(-2.0, 2.0) as f32,
        };
        let before = field;
        match eta {
            None => field.reflect(normal, &curvature),
            Some(eta) => assert!(field.refract(normal, &curvature, eta)),
        }

        let quadric = Quadric::new(normal, &curvature);
        let (x, z) = (v(before.x_axis), v(before.direction));
        let z = unit(z);
        let x = unit(along(x, -dot(x, z), z));
        let y = cross(z, x);
        let bend = |q: [f64; 4]| {
            let origin = along(along([0.0; 3], q[0], x), q[1], y);
            quadric.bend(origin, along(along(z, q[2], x), q[3], y), eta.map(f64::from))
        };
        let (_, out) = bend([0.0; 4]);
        let stored = v(field.direction);
        assert!((0..3).all(|i| (out[i] - stored[i]).abs() < 2e-7), "{out:?} {stored:?}");
        let x_out = unit(along(v(field.x_axis), -dot(v(field.x_axis), out), out));
        let mut m = [[0.0; 4]; 4];
        // Truncation h² ~ 1e-10, cancellation 1e-16/h = 1e-11.
        let h = 1e-5;
        for j in 0..4 {
            let mut q = [0.0; 4];
            q[j] = h;
            let (p, d) = bend(q);
            let forward = coordinates(p, d, x_out, out);
            q[j] = -h;
            let (p, d) = bend(q);
            let backward = coordinates(p, d, x_out, out);
            for i in 0..4 {
                m[i][j] = (forward[i] - backward[i]) / (2.0 * h);
            }
        }
        let expected = transformed(covariance(&before), m);
        let got = covariance(&field);
        for i in 0..4 {
            for j in 0..4 {
                let scale = (expected[i][i] * expected[j][j]).sqrt();
                worst = worst.max((got[i][j] - expected[i][j]).abs() / scale);
            }
        }
    }
    worst
}

/// M⁻ᵀ Σ M⁻¹, with the inverse and the products of the 1600-bit twin: conditioning plays no part.
fn transformed(covariance: [[f64; 4]; 4], m: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    use covbeam_tests::twin::Big;
    let big = |m: [[f64; 4]; 4]| m.map(|row| row.map(Big::of));
    let axis = [1.0, 0.0, 0.0].map(Big::of);
    let mut twin = Twin { covariance: big(covariance), x: axis.clone(), z: axis };
    twin.map(&big(m));
    twin.covariance.map(|row| row.map(|entry| entry.to_f64()))
}

#[test]
fn the_mirror_agrees_with_traced_rays() {
    let worst = worst_against_traced_rays(false);
    println!("mirror: worst of 2000 skew hits {worst:.1e}");
    // Truncation of the differences, h² times third derivatives: curvature 3 at cosine 0.2 gives 1e-5.
    assert!(worst < 2e-5, "{worst}");
}

#[test]
fn refraction_agrees_with_traced_rays() {
    let worst = worst_against_traced_rays(true);
    println!("refraction: worst of 2000 skew hits {worst:.1e}");
    // As for the mirror, with gentler bending; and the root's rounding to f32.
    assert!(worst < 2e-6, "{worst}");
}

/// A hit at cosine `c` on a surface with principal curvatures in and across the plane of incidence. Returns the light
/// of a source with spatial root `source` at `distance`, before the event, with its s axis.
fn at_the_surface(c: f64, distance: f32) -> (LightField, Vec3) {
    let sine = (1.0 - c * c).sqrt();
    // Plane of incidence: x-z, normal +z, sagittal axis y.
    let direction = Vec3::new(sine as f32, 0.0, -c as f32);
    let mut field = LightField::gaussian(direction, Vec3::Y, [1e4; 2], [0.5; 2]);
    field.travel(distance);
    (field, Vec3::Y)
}

/// At a focal line the fluence is as fine as the image of the source, X/m² for magnification m, and coarse 1 % away.
fn assert_focus(field: &LightField, distance: f64, axis: Vec3, magnification: f64) {
    let variance = |d: f64| {
        let mut there = *field;
        there.travel(d as f32);
        f64::from(there.fluence().variance_along(axis - axis.dot(there.direction) * there.direction))
    };
    let expected = 1e4 / (magnification * magnification);
    let at_focus = variance(distance);
    // Distance and curvature are rounded to f32: out of focus by 1e-7, against a depth of focus of 1e-4.
    assert!((at_focus / expected - 1.0).abs() < 1e-5, "{at_focus} {expected}");
    assert!(variance(distance * 1.01) < 0.05 * expected);
    assert!(variance(distance * 0.99) < 0.05 * expected);
}

#[test]
fn a_curved_mirror_focuses_at_coddingtons_distances() {
    let (c, object) = (0.6, 3.0f32);
    let (k_s, k_t) = (-1.0f32, -0.7f32);
    let (mut field, s) = at_the_surface(c, object);
    field.reflect(Vec3::Z, &Curvature { tangent: Vec3::Y, along: k_s, across: k_t, twist: 0.0 });
    let sagittal = 1.0 / (-2.0 * c * f64::from(k_s) - 1.0 / f64::from(object));
    let tangential = 1.0 / (-2.0 * f64::from(k_t) / c - 1.0 / f64::from(object));
    let in_plane = s.cross(field.direction);
    assert_focus(&field, sagittal, s, sagittal / f64::from(object));
    assert_focus(&field, tangential, in_plane, tangential / f64::from(object));
}

#[test]
fn a_curved_lens_surface_focuses_at_coddingtons_distances() {
    let (n1, n2, c, object) = (1.0f64, 1.5f64, 0.8f64, 8.0f32);
    let (k_s, k_t) = (2.0f32, 1.3f32);
    let (mut field, s) = at_the_surface(c, object);
    let eta = (n1 / n2) as f32;
    assert!(field.refract(
        Vec3::Z,
        &Curvature { tangent: Vec3::Y, along: k_s, across: k_t, twist: 0.0 },
        eta
    ));
    let n2 = n1 / f64::from(eta);
    let c_t = (1.0 - (n1 / n2).powi(2) * (1.0 - c * c)).sqrt();
    let power = n2 * c_t - n1 * c;
    let object = f64::from(object);
    let sagittal = n2 / (power * f64::from(k_s) - n1 / object);
    let tangential = n2 * c_t * c_t / (power * f64::from(k_t) - n1 * c * c / object);
    let in_plane = s.cross(field.direction);
    assert_focus(&field, sagittal, s, n1 * sagittal / (n2 * object));
    assert_focus(&field, tangential, in_plane, n1 * tangential * c / (n2 * object * c_t));
}
