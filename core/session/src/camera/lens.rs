//! The opening of a thin lens.

use std::f32::consts::{PI, TAU};

/// A thin lens around the camera's position: a disk, or a regular polygon. What lies at its focus distance is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the opening, up to its corners and before `ratio` [scene unit], > 0.
    pub radius: f32,
    /// Where things are sharp: distance along the viewing axis, of panoramas from the camera [scene unit], > 0.
    pub focus_distance: f32,
    /// Corners of the opening: 3 and more; fewer make a disk.
    pub blades: u32,
    /// Angle from `right` towards `up` of the middle of one of the polygon's edges \[rad\].
    pub rotation: f32,
    /// Height of the opening over its width, > 0.
    pub ratio: f32,
}

impl Lens {
    /// A place in the opening: to the right and up from its middle [scene unit]. Even numbers in [0, 1) give even places; (0, 0) is the middle.
    pub fn place(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [across, up] = if self.blades < 3 {
            let (sine, cosine) = libm::sincosf(TAU * v);
            [u.sqrt() * cosine, u.sqrt() * sine]
        } else {
            // A triangle of the middle and an edge, and a place in it: far from the middle, and aside along the edge.
            let edges = u * self.blades as f32;
            let far = edges.fract().sqrt();
            let half = PI / self.blades as f32;
            let [middle, aside] = [far * libm::cosf(half), far * (2.0 * v - 1.0) * libm::sinf(half)];
            let (sine, cosine) = libm::sincosf(self.rotation + 2.0 * half * edges.floor());
            [middle * cosine - aside * sine, middle * sine + aside * cosine]
        };
        [self.radius * across / self.ratio, self.radius * up]
    }

    /// Farthest that a place is from the middle, at most [scene unit].
    pub(crate) fn reach(&self) -> f32 {
        self.radius * self.ratio.recip().max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_fill_the_opening_evenly() {
        // As many as all numbers of blades divide.
        const SIDE: u32 = 480;
        for blades in [0, 3, 5, 8] {
            let lens = Lens { radius: 0.5, focus_distance: 1.0, blades, rotation: 0.7, ratio: 2.0 };
            let middle = |index: u32| (index as f32 + 0.5) / SIDE as f32;
            let places = (0..SIDE * SIDE).map(|i| lens.place([middle(i % SIDE), middle(i / SIDE)]));
            let places: Vec<[f64; 2]> = places.map(|[x, y]| [2.0 * f64::from(x), f64::from(y)]).collect();
            let mean = |of: fn([f64; 2]) -> f64| {
                places.iter().map(|place| of(*place)).sum::<f64>() / places.len() as f64
            };
            assert!(mean(|[x, _]| x).abs() < 1e-3 && mean(|[_, y]| y).abs() < 1e-3, "{blades} blades");
            // Mean of r²: R²/2 of a disk, R² (2 + cos(2 π/n))/6 of a polygon with corners at R; half of it either way.
            let corners = f64::from(blades);
            let square = if blades == 0 {
                0.125
            } else {
                0.25 * (2.0 + (2.0 * std::f64::consts::PI / corners).cos()) / 6.0
            };
            for found in [mean(|[x, _]| x * x), mean(|[_, y]| y * y)] {
                assert!(
                    (2.0 * found / square - 1.0).abs() < 2e-3,
                    "{blades} blades: {found} for {square} / 2"
                );
            }
            assert!(mean(|[x, y]| x * y).abs() < 1e-3, "{blades} blades");
            assert!(places.iter().all(|[x, y]| x.hypot(*y) <= 0.5 + 1e-6), "{blades} blades");
        }
    }

    #[test]
    fn an_edge_lies_where_the_rotation_says() {
        let lens = Lens { radius: 1.0, focus_distance: 1.0, blades: 4, rotation: 0.3, ratio: 1.0 };
        // The middle of the first edge of a square: cos 45° from the middle.
        let [x, y] = lens.place([0.25 - 1e-7, 0.5]);
        let expected = std::f32::consts::FRAC_1_SQRT_2;
        assert!((x - expected * 0.3_f32.cos()).abs() < 1e-5 && (y - expected * 0.3_f32.sin()).abs() < 1e-5);
    }
}
