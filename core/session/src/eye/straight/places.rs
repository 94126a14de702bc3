//! Places along a piece of an eye path that look at a lamp: dense where the camera sees much of what the lamp's light does there.

use covbeam::{Column, Medium};
use smallvec::{SmallVec, smallvec};

/// Parts of a piece of which the camera sees as much of the fog.
const PARTS: u32 = 16;

/// A part may begin with a gap in the fog, and is cut where this share of its column is past: behind that.
const BEHIND_GAP: f32 = 0.02;

/// Optical depth from which on even fog is seen unevenly.
const DEEP: f32 = 0.5;

/// Share of the places that goes by the lamp alone: of fog that tables of columns leave out.
const BY_LAMP: f32 = 0.05;

/// What a lamp shines on of a piece, by the angle seen from it.
pub(super) struct Angles {
    /// Distances along the ray.
    pub(super) from: f32,
    pub(super) to: f32,
    /// Of what is nearest to the lamp, and how far from it that is.
    pub(super) foot: f32,
    pub(super) height: f32,
    /// Of both ends, and of those of a gap that is left to beams.
    pub(super) start: f32,
    pub(super) end: f32,
    pub(super) gap: [f32; 2],
}

impl Angles {
    fn skipped(&self) -> f32 {
        self.gap[1] - self.gap[0]
    }

    /// Of all but the gap.
    fn width(&self) -> f32 {
        self.end - self.start - self.skipped()
    }

    /// Distance of an angle that is counted from the start, the gap left out, and the angle's tangent.
    pub(super) fn place(&self, angle: f32) -> (f32, f32) {
        let angle = self.start + angle;
        let tangent = libm::tanf(if angle < self.gap[0] { angle } else { angle + self.skipped() });
        (self.foot + self.height * tangent, tangent)
    }

    /// The angle of a distance, counted like that.
    fn counted(&self, distance: f32) -> f32 {
        let angle = libm::atanf((distance - self.foot) / self.height).clamp(self.start, self.end);
        angle - self.start - (angle.min(self.gap[1]) - self.gap[0]).max(0.0)
    }
}

/// What the camera sees of the fog along a piece.
pub(super) struct Seen<'a> {
    fog: &'a Medium<'a>,
    column: Column<'a>,
    /// Distances between which it is about even, and what is left of it there.
    cuts: SmallVec<[(f32, f32); 2 * PARTS as usize]>,
}

impl<'a> Seen<'a> {
    pub(super) fn new(fog: &'a Medium<'a>, column: Column<'a>, from: f32, to: f32) -> Self {
        let mut seen = Self { fog, column, cuts: SmallVec::new() };
        let extinction = fog.mean_extinction();
        let [start, all] = [column.at(from), column.at(to) - column.at(from)];
        let is_even = matches!(column, Column::Uniform) && !(extinction * all > DEEP);
        if is_even || !(all > 0.0 && extinction > 0.0) {
            return seen;
        }
        let hidden = -libm::expm1f(-extinction * all);
        let part = |number: u32| -libm::log1pf(-hidden * number as f32 / PARTS as f32) / extinction;
        for number in 0..PARTS {
            let (here, next) = (part(number), part(number + 1).min(all));
            for column in [here, here + BEHIND_GAP * (next - here)] {
                let distance = seen.column.distance_at(start + column);
                if distance > seen.cuts.last().map_or(from, |cut| cut.0) && distance < to {
                    seen.cuts.push((distance, seen.left(distance)));
                }
            }
        }
        seen
    }

    /// What the camera sees of all fog behind a distance, but for a factor.
    fn left(&self, distance: f32) -> f32 {
        self.fog.transmittance(self.column.at(distance)).dot(self.fog.scattering)
    }
}

/// Where the places are: stretches, each with its first angle and the share of all places before it, up to the end of the last.
pub(super) struct Places {
    stretches: SmallVec<[(f32, f32); 36]>,
}

impl Places {
    /// As many in each stretch as it is worth: by how much of the fog is seen there, and by the mean of 1/d² over it.
    pub(super) fn new(seen: &Seen, angles: &Angles) -> Self {
        let width = angles.width();
        let mut stretches: SmallVec<_> = smallvec![(0.0, 0.0)];
        let inside = seen.cuts.iter().filter(|cut| cut.0 > angles.from && cut.0 < angles.to);
        let mut sum = 0.0;
        let (mut angle, mut distance, mut left) = (0.0, angles.from, None);
        for &(end, after) in inside {
            let before = left.unwrap_or_else(|| seen.left(angles.from));
            let next = angles.counted(end);
            sum += (before - after) * (next - angle) / (end - distance);
            stretches.push((next, sum));
            (angle, distance, left) = (next, end, Some(after));
        }
        if let Some(before) = left {
            sum += (before - seen.left(angles.to)) * (width - angle) / (angles.to - distance);
        }
        stretches.push((width, sum));
        let is_sound = sum > 0.0 && sum.is_finite();
        for (angle, share) in &mut stretches {
            let by_lamp = *angle / width;
            *share = if is_sound { BY_LAMP * by_lamp + (1.0 - BY_LAMP) * (*share / sum) } else { by_lamp };
        }
        Self { stretches }
    }

    /// The angle of a number in [0, 1), and the angle that a single such place stands for.
    pub(super) fn at(&self, number: f32) -> (f32, f32) {
        let after = self.stretches.partition_point(|stretch| stretch.1 <= number);
        let after = after.clamp(1, self.stretches.len() - 1);
        let ((from, before), (to, until)) = (self.stretches[after - 1], self.stretches[after]);
        let (step, share) = (to - from, until - before);
        if !(share > 0.0) {
            return (from, 0.0);
        }
        (from + step * ((number - before) / share).clamp(0.0, 1.0), step / share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use covbeam::{Density, DensityGrid, GridLayout, Knot};
    use glam::Vec3;

    /// What a lamp beside the ray shines on of 10 m.
    fn angles(height: f32, gap: [f32; 2]) -> Angles {
        let [start, end, near, far] =
            [0.0, 10.0, gap[0], gap[1]].map(|distance: f32| ((distance - 4.0) / height).atan());
        Angles { from: 0.0, to: 10.0, foot: 4.0, height, start, end, gap: [near, far] }
    }

    /// Mean and standard deviation of what places, each alone, say of the light of a lamp along a ray, over its value.
    fn relative(seen: &Seen, angles: &Angles, light: impl Fn(f32) -> f64) -> [f64; 2] {
        let inside = |at: f32| {
            at < angles.foot + angles.height * angles.gap[0].tan()
                || at > angles.foot + angles.height * angles.gap[1].tan()
        };
        let steps = 200_000;
        let expected: f64 = (0..steps)
            .map(|i| (i as f32 + 0.5) * 10.0 / steps as f32)
            .filter(|at| inside(*at))
            .map(|at| light(at) * 10.0 / f64::from(steps))
            .sum();
        let places = Places::new(seen, angles);
        let count = 50_000;
        let values: Vec<f64> = (0..count)
            .map(|i| {
                let (angle, stands_for) = places.at((i as f32 + 0.5) / count as f32);
                let (distance, tangent) = angles.place(angle);
                f64::from(stands_for * angles.height * (1.0 + tangent * tangent)) * light(distance) / expected
            })
            .collect();
        let mean = values.iter().sum::<f64>() / f64::from(count);
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::from(count);
        [mean, variance.sqrt()]
    }

    /// A plume of 1 m in 10 m of nothing, thick even fog, and thin one; near a lamp and far from it, with a stretch left to beams: the mean is
    /// right, and single places are more alike than by the lamp alone.
    #[test]
    fn places_are_dense_where_light_is_seen() {
        let layout = GridLayout { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 10.0), cells: [1, 1, 40] };
        let values: Vec<f32> = (0..40).map(|i| if (24..28).contains(&i) { 1.0 } else { 0.0 }).collect();
        let plume = Density::Grid(DensityGrid::new(layout, &values).unwrap());
        let of = |density, extinction: f32| Medium {
            density,
            ..Medium::homogeneous(0.7 * extinction, 0.3 * extinction)
        };
        let origin = Vec3::new(0.5, 0.5, 0.0);
        for (name, fog) in [
            ("plume", of(plume, 3.0)),
            ("thick", of(Density::Uniform, 1.5)),
            ("thin", of(Density::Uniform, 0.01)),
        ] {
            let mut knots: Vec<Knot> = Vec::new();
            fog.tabulate(origin, Vec3::Z, 10.0, &mut |knot| knots.push(knot));
            let column = fog.density.column(origin, Vec3::Z, &knots);
            let seen = Seen::new(&fog, column, 0.0, 10.0);
            for (height, gap) in [(0.5, [4.0; 2]), (100.0, [4.0; 2]), (0.5, [3.0, 5.0])] {
                let angles = angles(height, gap);
                let light = |at: f32| {
                    let square = f64::from(height).powi(2) + f64::from(at - 4.0).powi(2);
                    let left = f64::from(fog.transmittance(column.at(at)).x);
                    left * f64::from(fog.density.at(origin + at * Vec3::Z)) / square
                };
                let [mean, deviation] = relative(&seen, &angles, light);
                let even = Seen { cuts: SmallVec::new(), ..Seen::new(&fog, column, 0.0, 10.0) };
                let [_, of_even] = relative(&even, &angles, light);
                println!(
                    "{name}, lamp {height} m away, left out {gap:?}: {mean:.5} ± {deviation:.3}, by the lamp alone ± {of_even:.3}"
                );
                // The midpoint rule over a density with kinks errs by less than 1e-3 of a stretch.
                assert!((mean - 1.0).abs() < 2e-3, "{name}, {height}, {gap:?}: {mean}");
                assert!(
                    deviation < if name == "thin" { 1.01 } else { 0.5 } * of_even,
                    "{name}, {height}, {gap:?}: {deviation}, {of_even}"
                );
            }
        }
    }
}
