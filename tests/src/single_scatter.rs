//! Single-scattered light in heterogeneous media by quadrature, without noise and without any of the renderer's code.

use glam::DVec3;
use std::f64::consts::PI;

/// Relative density of the medium.
#[derive(Clone, Debug)]
pub enum Density {
    /// exp(-y / scale height).
    Exponential {
        /// > 0.
        scale_height: f64,
    },
    /// Values at the centres of voxels, trilinear between them, held over the border's half voxel, 0 outside the box.
    Voxels {
        /// Lower corner.
        min: DVec3,
        /// Upper corner.
        max: DVec3,
        /// Voxels along x, y, z.
        cells: [usize; 3],
        /// x fastest, then y, then z.
        values: Vec<f64>,
    },
}

impl Density {
    /// Density at a point.
    pub fn at(&self, p: DVec3) -> f64 {
        match self {
            Density::Exponential { scale_height } => (-p.y / scale_height).exp(),
            Density::Voxels { min, max, cells, values } => {
                if p.cmplt(*min).any() || p.cmpgt(*max).any() {
                    return 0.0;
                }
                let unit = (p - *min) / (*max - *min);
                let mut sum = 0.0;
                // Each of the eight corners with the product of its three hats.
                let low: [i64; 3] = std::array::from_fn(|a| (unit[a] * cells[a] as f64 - 0.5).floor() as i64);
                for corner in 0..8 {
                    let (mut weight, mut index, mut stride) = (1.0, 0, 1);
                    for a in 0..3 {
                        let node = low[a] + (corner >> a & 1);
                        weight *= 1.0 - (unit[a] * cells[a] as f64 - 0.5 - node as f64).abs();
                        index += node.clamp(0, cells[a] as i64 - 1) as usize * stride;
                        stride *= cells[a];
                    }
                    sum += weight * values[index];
                }
                sum
            }
        }
    }

    /// The part of the way along a ray, up to `length`, where the density is not 0.
    fn inside(&self, origin: DVec3, direction: DVec3, length: f64) -> (f64, f64) {
        match self {
            Density::Exponential { .. } => (0.0, length),
            Density::Voxels { min, max, .. } => {
                let (from, to) = slab(*min, *max, origin, direction);
                (from.max(0.0), to.min(length))
            }
        }
    }

    /// ∫ density ds between two points: a closed form of the exponential; of voxels Gauss' rule of two points over steps of a quarter of one
    /// (the kinks between them leave 1e-4 of a voxel's column).
    pub fn column(&self, from: DVec3, to: DVec3) -> f64 {
        let offset = to - from;
        let length = offset.length();
        if length == 0.0 {
            return 0.0;
        }
        let side = match self {
            Density::Exponential { scale_height } => {
                // (1 - e⁻ʳ)/r, by its series where r is small.
                let rise = offset.y / scale_height;
                let mean = if rise.abs() < 1e-6 { 1.0 - 0.5 * rise } else { -(-rise).exp_m1() / rise };
                return length * self.at(from) * mean;
            }
            Density::Voxels { min, max, cells, .. } => {
                let side = |a: usize| (max[a] - min[a]) / cells[a] as f64;
                side(0).min(side(1)).min(side(2))
            }
        };
        let direction = offset / length;
        let (start, end) = self.inside(from, direction, length);
        if start >= end {
            return 0.0;
        }
        let steps = ((end - start) / (0.25 * side)).ceil();
        let step = (end - start) / steps;
        let node = 0.5 / 3f64.sqrt();
        let sum: f64 = (0..steps as u32)
            .map(|i| {
                let middle = start + (f64::from(i) + 0.5) * step;
                self.at(from + (middle - node * step) * direction)
                    + self.at(from + (middle + node * step) * direction)
            })
            .sum();
        0.5 * step * sum
    }
}

/// Where a ray's line is inside a box.
fn slab(min: DVec3, max: DVec3, origin: DVec3, direction: DVec3) -> (f64, f64) {
    let (a, b) = ((min - origin) / direction, (max - origin) / direction);
    (a.min(b).max_element(), a.max(b).min_element())
}

/// How a lamp's intensity depends on the direction.
#[derive(Clone, Copy, Debug)]
pub enum Emission {
    /// Not at all.
    Even,
    /// Falls by smoothstep in the angle.
    Spot {
        /// Unit.
        axis: DVec3,
        /// \[rad\]
        inner: f64,
        /// \[rad\]
        outer: f64,
    },
    /// As the cosine: a small piece of a diffuse surface that shines on one side.
    Lambert {
        /// Unit.
        normal: DVec3,
    },
}

/// A light without size.
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    /// Where.
    pub position: DVec3,
    /// W/sr per channel, where it is greatest.
    pub intensity: DVec3,
    /// In which directions.
    pub emission: Emission,
}

/// A black room filled with a medium, lit by one lamp, with a black ball in it.
#[derive(Clone, Debug)]
pub struct World {
    /// Relative density.
    pub density: Density,
    /// σ_s per channel at density 1.
    pub scattering: DVec3,
    /// σ_a per channel at density 1.
    pub absorption: DVec3,
    /// Mean cosine g of Henyey-Greenstein's phase function.
    pub asymmetry: f64,
    /// The light.
    pub lamp: Lamp,
    /// Centre and radius of the ball.
    pub ball: (DVec3, f64),
    /// Corners of the room.
    pub room: (DVec3, DVec3),
}

impl World {
    /// Distance at which a ray meets the ball.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let (center, radius) = self.ball;
        let offset = center - origin;
        let along = offset.dot(direction);
        let half = (radius * radius - (offset - along * direction).length_squared()).sqrt();
        // NaN, where the line misses the ball, is no hit.
        (along - half > 0.0).then_some(along - half)
    }

    /// Radiance of light scattered once that arrives at `eye` from unit `direction`.
    ///
    /// The midpoint rule in the angle at which the lamp sees the ray, in `points` steps: 1/d² is integrated exactly,
    /// the border of a shadow is off by half a step.
    pub fn radiance(&self, eye: DVec3, direction: DVec3, points: u32) -> DVec3 {
        let wall = slab(self.room.0, self.room.1, eye, direction).1;
        let length = self.hit(eye, direction).map_or(wall, |hit| hit.min(wall));
        let (start, end) = self.density.inside(eye, direction, length);
        if start >= end {
            return DVec3::ZERO;
        }
        let foot = (self.lamp.position - eye).dot(direction);
        let height = (self.lamp.position - eye - foot * direction).length();
        let (low, high) = (((start - foot) / height).atan(), ((end - foot) / height).atan());
        let step = (high - low) / f64::from(points);
        let extinction = self.scattering + self.absorption;
        let mut seen = (eye, 0.0);
        let mut sum = DVec3::ZERO;
        for k in 0..points {
            let angle = low + (f64::from(k) + 0.5) * step;
            let p = eye + (foot + height * angle.tan()) * direction;
            seen = (p, seen.1 + self.density.column(seen.0, p));
            let from_lamp = p - self.lamp.position;
            let distance = from_lamp.length();
            let incoming = from_lamp / distance;
            let intensity = self.intensity(incoming);
            let dark = self.hit(self.lamp.position, incoming).is_some_and(|hit| hit < distance);
            if dark || intensity == DVec3::ZERO {
                continue;
            }
            let depth = extinction * (seen.1 + self.density.column(self.lamp.position, p));
            let g = self.asymmetry;
            let cosine = -incoming.dot(direction);
            let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
            // ds / d² = dθ / height.
            sum += intensity * (-depth).exp() * (phase * self.density.at(p) * step / height);
        }
        sum * self.scattering
    }

    fn intensity(&self, direction: DVec3) -> DVec3 {
        let share = match self.lamp.emission {
            Emission::Even => 1.0,
            Emission::Spot { axis, inner, outer } => {
                let q = ((outer - direction.angle_between(axis)) / (outer - inner)).clamp(0.0, 1.0);
                q * q * (3.0 - 2.0 * q)
            }
            Emission::Lambert { normal } => direction.dot(normal).max(0.0),
        };
        self.lamp.intensity * share
    }
}

/// So many points of a disk in the middle of equal areas, in a sunflower's order; `normal` is a unit vector.
pub fn sunflower(center: DVec3, radius: f64, normal: DVec3, count: u32) -> Vec<DVec3> {
    let (e, f) = normal.any_orthonormal_pair();
    let place = |k: u32| {
        let rho = radius * ((f64::from(k) + 0.5) / f64::from(count)).sqrt();
        let (s, c) = (f64::from(k) * PI * (3.0 - 5f64.sqrt())).sin_cos();
        center + rho * (c * e + s * f)
    };
    (0..count).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world(density: Density) -> World {
        World {
            density,
            scattering: DVec3::splat(1e-4),
            absorption: DVec3::new(0.0, 0.3, 1.0),
            asymmetry: 0.0,
            lamp: Lamp {
                position: DVec3::new(0.5, 2.0, 0.0),
                intensity: DVec3::ONE,
                emission: Emission::Even,
            },
            ball: (DVec3::new(0.0, -50.0, 0.0), 1.0),
            room: (DVec3::splat(-4.0), DVec3::splat(4.0)),
        }
    }

    #[test]
    fn airlight_without_extinction_is_the_angle_over_the_distance() {
        let world = world(Density::Exponential { scale_height: 1e12 });
        let (eye, direction) = (DVec3::new(0.5, 0.0, -3.0), DVec3::Z);
        // ∫ dz/(2² + z²) from -3 to 4 = (atan(4/2) + atan(3/2))/2.
        let exact = 1e-4 / (4.0 * PI) * (2f64.atan() + 1.5f64.atan()) / 2.0;
        let radiance = world.radiance(eye, direction, 50).x;
        // Of order 1e-4 x the way is absorbed.
        assert!((radiance / exact - 1.0).abs() < 1.5e-3, "{radiance} {exact}");
    }

    #[test]
    fn columns_are_the_sums_of_densities() {
        let steps = 20_000;
        for (scale_height, to) in
            [(1.5, DVec3::new(1.0, 2.0, -1.0)), (1.5, DVec3::new(1.0, -1.0, -1.0)), (1e12, DVec3::ONE)]
        {
            let (air, from) = (Density::Exponential { scale_height }, DVec3::new(0.0, -1.0, 0.0));
            let at = |k: i32| air.at(from.lerp(to, (f64::from(k) + 0.5) / f64::from(steps)));
            let sum = (0..steps).map(at).sum::<f64>() * (to - from).length() / f64::from(steps);
            assert!((air.column(from, to) / sum - 1.0).abs() < 1e-8, "{to}");
        }
        // A ramp of two voxels, 1 and 3, held over their outer halves: trapezoid 0.5 x 1 + 2 + 0.5 x 3.
        let ramp = Density::Voxels {
            min: DVec3::ZERO,
            max: DVec3::new(2.0, 1.0, 1.0),
            cells: [2, 1, 1],
            values: vec![1.0, 3.0],
        };
        let column = ramp.column(DVec3::new(-7.0, 0.2, 0.9), DVec3::new(9.0, 0.2, 0.9));
        assert!((column - 4.0).abs() < 1e-12, "{column}");
        assert_eq!(ramp.column(DVec3::new(-7.0, 1.2, 0.9), DVec3::new(9.0, 1.2, 0.9)), 0.0);
    }

    #[test]
    fn the_quadrature_has_converged() {
        let values = (0..4 * 5 * 6).map(|i| f64::from(i * 7919 % 31) / 31.0).collect();
        let voxels =
            Density::Voxels { min: DVec3::splat(-2.0), max: DVec3::splat(2.5), cells: [4, 5, 6], values };
        for density in [Density::Exponential { scale_height: 1.5 }, voxels] {
            let world = world(density);
            let direction = DVec3::new(0.1, 0.15, 1.0).normalize();
            let [coarse, fine] =
                [120, 2000].map(|points| world.radiance(DVec3::new(0.0, -0.5, -3.9), direction, points));
            assert!((coarse / fine - 1.0).abs().max_element() < 1e-3, "{coarse} {fine}");
        }
    }
}
