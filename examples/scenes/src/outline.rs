//! Closed outlines in the plane, made of straight lines and circular arcs as in Gothic tracery.

use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Corners of a simple polygon, counter-clockwise; the last is joined with the first.
pub type Outline = Vec<DVec2>;

/// Largest angle between two points of an arc \[rad\]: on a radius of 0.2 m the chord stays within 1.1 mm of the arc.
const ARC_STEP: f64 = PI / 15.0;

/// Unit vector at `angle` \[rad\] from +x towards +y.
pub fn unit(angle: f64) -> DVec2 {
    DVec2::new(libm::cos(angle), libm::sin(angle))
}

/// Points of an arc from the angle `from` to the angle `to` \[rad\], both ends included.
pub fn arc(center: DVec2, radius: f64, from: f64, to: f64) -> Outline {
    // A full number of steps up to rounding must not become one more.
    let steps = libm::ceil(((to - from) / ARC_STEP).abs() - 1e-9).max(1.0) as u32;
    (0..=steps)
        .map(|i| center + radius * unit(from + (to - from) * f64::from(i) / f64::from(steps)))
        .collect()
}

/// A regular polygon of `sides` corners around `center`, the first towards +x.
pub fn circle(center: DVec2, radius: f64, sides: u32) -> Outline {
    (0..sides).map(|i| center + radius * unit(TAU * f64::from(i) / f64::from(sides))).collect()
}

/// A foil: `lobes` circles of radius `lobe` whose centres lie `distance` from `center`, the first towards `angle`
/// \[rad\]; the cusps are where neighbours cross. Three lobes make a trefoil, four a quatrefoil.
///
/// # Panics
/// If neighbours do not cross: `lobe <= distance sin(π / lobes)`.
pub fn foil(center: DVec2, lobes: u32, distance: f64, lobe: f64, angle: f64) -> Outline {
    let half = PI / f64::from(lobes);
    assert!(lobe > distance * libm::sin(half), "the lobes of a foil do not cross");
    let across = distance * libm::sin(half);
    let cusp = (distance * libm::cos(half) + libm::sqrt(lobe * lobe - across * across)) * unit(half);
    let reach = libm::atan2(cusp.y, cusp.x - distance);
    let mut outline = Outline::new();
    for i in 0..lobes {
        let axis = angle + 2.0 * half * f64::from(i);
        outline.extend(arc(center + distance * unit(axis), lobe, axis - reach, axis + reach));
        // The cusp is the next lobe's first point.
        outline.pop();
    }
    outline
}

/// Where two circles cross, on the left of the way from `a` to `b`.
///
/// # Panics
/// If they do not cross.
pub fn crossing(a: DVec2, radius_a: f64, b: DVec2, radius_b: f64) -> DVec2 {
    let distance = a.distance(b);
    let along = (distance * distance + radius_a * radius_a - radius_b * radius_b) / (2.0 * distance);
    let across_squared = radius_a * radius_a - along * along;
    assert!(across_squared > 0.0, "the circles do not cross");
    let axis = (b - a) / distance;
    a + along * axis + libm::sqrt(across_squared) * axis.perp()
}

/// The outline turned by `angle` \[rad\] about the origin.
pub fn turned(outline: &[DVec2], angle: f64) -> Outline {
    let turn = unit(angle);
    outline.iter().map(|point| turn.rotate(*point)).collect()
}

/// Area, positive for a counter-clockwise outline.
pub fn area(outline: &[DVec2]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trefoil_is_inside_its_lobes_and_holds_their_area_in_the_limit() {
        // Lobes at distance 0 are one circle: area π r², less what chords of at most 12 degrees cut off
        // (1 - sin δ / δ = 0.7 % at δ = 12 degrees).
        let round = foil(DVec2::ZERO, 3, 0.0, 1.0, 0.3);
        assert!((area(&round) / PI - 1.0).abs() < 0.008, "{}", area(&round));
        let trefoil = foil(DVec2::new(2.0, 1.0), 3, 0.5, 0.6, 0.3);
        for point in &trefoil {
            let nearest = (0..3)
                .map(|i| point.distance(DVec2::new(2.0, 1.0) + 0.5 * unit(0.3 + TAU / 3.0 * f64::from(i))))
                .fold(f64::INFINITY, f64::min);
            // On the nearest lobe's circle: the outline is the border of the union.
            assert!((nearest - 0.6).abs() < 1e-12, "{nearest}");
        }
    }

    #[test]
    fn a_crossing_is_on_both_circles_and_on_the_left() {
        let (a, b) = (DVec2::new(0.3, -0.2), DVec2::new(1.1, 0.4));
        let point = crossing(a, 0.8, b, 0.5);
        assert!((point.distance(a) - 0.8).abs() < 1e-12 && (point.distance(b) - 0.5).abs() < 1e-12);
        assert!((b - a).perp_dot(point - a) > 0.0);
    }
}
