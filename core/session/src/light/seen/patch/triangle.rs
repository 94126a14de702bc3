//! A triangle seen from a place: points of it drawn by solid angle.

use glam::{DVec3, Vec3};

/// Beyond so many of its longest sides points drawn by area do as well, to a few per cent of the mean.
const FAR: f64 = 16.0;

/// Places nearer to the triangle's plane are taken to be at this height, in its longest sides.
const LEAST_HEIGHT: f64 = 1e-9;

/// A triangle as a place sees it.
pub(crate) struct SeenTriangle {
    /// \[sr\]; 0 from its plane and from behind.
    pub(crate) solid_angle: f64,
    /// From the place.
    corners: [DVec3; 3],
    normal: DVec3,
    /// The same for all points of it, about.
    is_far: bool,
}

impl SeenTriangle {
    /// Seen from `place`; its front is where the corners run counter-clockwise. One without area is not seen.
    pub(crate) fn new(corners: [Vec3; 3], place: Vec3) -> Self {
        let corners = corners.map(|corner| corner.as_dvec3() - place.as_dvec3());
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        let doubled = cross.length();
        let normal = cross / doubled;
        let side = (b - a).length().max((c - b).length()).max((a - c).length());
        let height = -a.dot(normal);
        if !(doubled > 0.0 && height > 0.0) {
            return Self { solid_angle: 0.0, corners, normal, is_far: false };
        }
        // Next to the plane directions to the corners may lie in it; a height without consequence tells the sides apart.
        let lift = (LEAST_HEIGHT * side - height).max(0.0) * normal;
        let corners = corners.map(|corner| corner - lift);
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let distance2 = middle.length_squared();
        let is_far = distance2 > FAR * FAR * side * side;
        let solid_angle = if is_far {
            0.5 * doubled * -middle.dot(normal) / (distance2 * distance2.sqrt())
        } else {
            let [a, b, c] = corners.map(DVec3::normalize);
            // A. van Oosterom and J. Strackee 1983.
            let solid = 2.0 * libm::atan2(a.dot(b.cross(c)).abs(), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
            if solid < 0.0 { solid + 4.0 * std::f64::consts::PI } else { solid }
        };
        Self { solid_angle, corners, normal, is_far }
    }

    /// Draws a point with uniform numbers: what it stands for, 1 / its probability density \[sr\], and where it is, from the place.
    pub(crate) fn sample(&self, [u, v]: [f64; 2]) -> (f64, DVec3) {
        let [a, b, c] = self.corners;
        if self.is_far {
            let root = u.sqrt();
            let point = (1.0 - root) * a + root * (1.0 - v) * b + root * v * c;
            let doubled = (b - a).cross(c - a).length();
            let distance2 = point.length_squared();
            let cosine = -point.dot(self.normal) / distance2.sqrt();
            return (0.5 * doubled * cosine.max(0.0) / distance2, point);
        }
        let direction = by_solid_angle(self.corners.map(DVec3::normalize), self.solid_angle, [u, v]);
        let distance = a.dot(self.normal) / direction.dot(self.normal);
        let point = if distance.is_finite() { distance * direction } else { (a + b + c) / 3.0 };
        (self.solid_angle, point)
    }
}

/// A direction in the spherical triangle of three unit vectors (J. Arvo 1995): a smaller triangle with the side from `a` to `b` has the share
/// `u` of its area, and the direction lies on that one's far side.
fn by_solid_angle([a, b, c]: [DVec3; 3], area: f64, [u, v]: [f64; 2]) -> DVec3 {
    let aside = |v: DVec3, from: DVec3| (v - v.dot(from) * from).normalize_or_zero();
    let (to_b, to_c) = (aside(b, a), aside(c, a));
    let cos_alpha = to_b.dot(to_c).clamp(-1.0, 1.0);
    let sin_alpha = (1.0 - cos_alpha * cos_alpha).sqrt();
    let alpha = libm::acos(cos_alpha);
    let (s, t) = libm::sincos(u * area - alpha);
    let (p, q) = (t - cos_alpha, s + sin_alpha * a.dot(b));
    let cosine = ((q * t - p * s) * cos_alpha - q) / ((q * s + p * t) * sin_alpha);
    // Of slivers the cosine to `c` may be rounded to more than 1.
    let cosine = if cosine.is_finite() { cosine.max(a.dot(c)).min(1.0) } else { 1.0 };
    let far = cosine * a + (1.0 - cosine * cosine).max(0.0).sqrt() * to_c;
    let z = 1.0 - v * (1.0 - far.dot(b));
    z * b + (1.0 - z * z).max(0.0).sqrt() * aside(far, b)
}
