//! The part of a ray that a light shines on if nothing is in its way.

use covbeam_geometry::shape::intersect_sphere;
use glam::DVec3;

/// The part of `from..to` inside a convex body, which the line enters and leaves at the `cuts`, if at all.
fn convex_part(mut cuts: [f64; 2], from: f32, to: f32, inside: impl Fn(f64) -> bool) -> Option<(f32, f32)> {
    let (from, to) = (f64::from(from), f64::from(to));
    cuts.sort_by(f64::total_cmp);
    let [first, second] = cuts.map(|cut| if cut.is_nan() { from } else { cut.clamp(from, to) });
    let pieces = [(from, first), (first, second), (second, to)].into_iter().filter(|&(start, end)| {
        let middle = if end < f64::INFINITY { 0.5 * (start + end) } else { 2.0 * start.abs() + 1.0 };
        start < end && inside(middle)
    });
    let (from, to) = pieces.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    let (from, to) = (from as f32, to as f32);
    (from < to).then_some((from, to))
}

/// The part inside a cone.
///
/// - `m`: from the tip to the ray's origin; `d`: the ray's direction; `axis`: unit, into the cone.
/// - `cosine`: of the angle between the axis and the border, in (0, 1).
pub(super) fn in_cone(
    m: DVec3,
    d: DVec3,
    axis: DVec3,
    cosine: f64,
    [from, to]: [f32; 2],
) -> Option<(f32, f32)> {
    let c2 = cosine * cosine;
    // (p·axis)² = c² |p|² for p = m + t d.
    let (md, dd) = (m.dot(axis), d.dot(axis));
    let a = dd * dd - c2 * d.length_squared();
    let b = md * dd - c2 * m.dot(d);
    let c = md * md - c2 * m.length_squared();
    let q = -(b + b.signum() * (b * b - a * c).max(0.0).sqrt());
    convex_part([q / a, c / q], from, to, |t| {
        let p = m + t * d;
        p.dot(axis) > cosine * p.length()
    })
}

/// The part inside a cylinder without ends.
///
/// - `m`: from a point of the axis to the ray's origin; `d`: the ray's direction; `axis`: unit.
pub(super) fn in_cylinder(
    m: DVec3,
    d: DVec3,
    axis: DVec3,
    radius: f64,
    [from, to]: [f32; 2],
) -> Option<(f32, f32)> {
    let across = |v: DVec3| v - v.dot(axis) * axis;
    let (m, d) = (across(m), across(d));
    let a = d.length_squared();
    let b = m.dot(d);
    // The distance of the line from the axis: no difference of large squares.
    let nearest = if a > 0.0 { m - b / a * d } else { m };
    let half = ((radius * radius - nearest.length_squared()).max(0.0) / a).sqrt();
    convex_part([-b / a - half, -b / a + half], from, to, |t| (m + t * d).length_squared() < radius * radius)
}

/// The part before a plane.
///
/// - `m`: from a point of the plane to the ray's origin; `d`: the ray's direction; `normal`: to the side in question.
pub(super) fn before(m: DVec3, d: DVec3, normal: DVec3, [from, to]: [f32; 2]) -> Option<(f32, f32)> {
    let crossing = -m.dot(normal) / d.dot(normal);
    convex_part([crossing; 2], from, to, |t| (m + t * d).dot(normal) > 0.0)
}

/// From the first to the last place outside a sphere: between them the ray may cross it.
///
/// - `m`: from the centre to the ray's origin; `d`: the ray's direction.
pub(super) fn outside_sphere(m: DVec3, d: DVec3, radius: f64, [from, to]: [f32; 2]) -> Option<(f32, f32)> {
    let (mut ends, crossed) = ((from, to), intersect_sphere(DVec3::ZERO, radius, m, d));
    if let Some((enter, leave)) = crossed {
        let is_inside = |t: f32| (enter..leave).contains(&f64::from(t));
        ends.0 = if is_inside(from) { leave as f32 } else { from };
        ends.1 = if is_inside(to) { enter as f32 } else { to };
    }
    (ends.0 < ends.1).then_some(ends)
}
