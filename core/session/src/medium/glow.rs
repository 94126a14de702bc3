//! Light that a medium sends out of itself, as fire and glowing gas do: the same in all directions, whatever the medium scatters or absorbs.

use crate::medium::density::MediumDensity;
use covbeam::{Column, EyeRay, GridLayout, Medium};
use covbeam_geometry::shape::intersect_box;
use glam::{Vec3, Vec3Swizzles};
use std::f32::consts::PI;
use std::fmt;

/// Steps that are taken across a voxel, at least.
const STEPS: f32 = 4.0;

/// Optical depth of a step below which the first three terms of a series are good to 5e-6.
const THIN: f32 = 0.05;

/// Emission coefficient in voxels: trilinear between their middles, held over the half voxel at the border of the box, 0 outside of it.
#[derive(Clone, PartialEq)]
pub struct Glow {
    layout: GridLayout,
    /// [W/(m³ sr)], x first, then y, then z.
    values: Vec<Vec3>,
    /// Sums of them up to the end of each row of voxels along x, mean of the channels.
    rows: Vec<f64>,
    radius: f32,
}

impl fmt::Debug for Glow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let GridLayout { min, max, cells: [x, y, z] } = self.layout;
        write!(f, "Glow {{ {x} x {y} x {z} voxels, {min}..{max} }}")
    }
}

impl Glow {
    /// None: it is dark.
    ///
    /// - `layout`: sound as that of a [`crate::medium::volume::Volume`]; `values`: as many, finite and >= 0, whose [`Glow::flux`] must be finite, too.
    pub fn new(layout: GridLayout, values: Vec<Vec3>) -> Option<Self> {
        let mut sum = 0.0;
        let rows = values.chunks(layout.cells[0] as usize).map(|row| {
            sum += row.iter().copied().map(mean).sum::<f64>();
            sum
        });
        let rows = rows.collect();
        let radius = equal_radius(&layout, &values);
        let shines = values.iter().any(|value| *value != Vec3::ZERO);
        shines.then_some(Self { layout, values, rows, radius })
    }

    /// The same everywhere in a box.
    pub fn even(min: Vec3, max: Vec3, emission: Vec3) -> Option<Self> {
        Self::new(GridLayout { min, max, cells: [1; 3] }, vec![emission])
    }

    /// Corners of the box.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.layout.min, self.layout.max)
    }

    /// Of a ball that has as much surface for its volume, about \[m\]: how large the things are that glow.
    pub(crate) fn radius(&self) -> f32 {
        self.radius
    }

    /// The largest emission coefficient of any channel [W/(m³ sr)].
    pub(crate) fn largest(&self) -> f32 {
        self.values.iter().map(|value| value.max_element()).fold(0.0, f32::max)
    }

    /// Power of the whole box, all around \[W\].
    pub fn flux(&self) -> Vec3 {
        let sum = self.values.iter().map(|value| value.as_dvec3()).sum::<glam::DVec3>();
        (4.0 * f64::from(PI) * self.voxel().as_dvec3().element_product() * sum).as_vec3()
    }

    /// Size of a voxel.
    fn voxel(&self) -> Vec3 {
        (self.layout.max - self.layout.min) / cells(&self.layout)
    }

    /// A place drawn by how much light it sends out, mean of the channels, and the power \[W\] if all light started there; numbers: uniform
    /// in [0, 1).
    pub(crate) fn draw(&self, [row, along]: [f32; 2], offset: [f32; 3]) -> (Vec3, Vec3) {
        let [nx, ny, _] = self.layout.cells.map(|count| count as usize);
        let total = self.rows[self.rows.len() - 1];
        let row = self.rows.partition_point(|&end| end <= f64::from(row) * total).min(self.rows.len() - 1);
        let voxels = &self.values[row * nx..(row + 1) * nx];
        let mut left = f64::from(along) * voxels.iter().copied().map(mean).sum::<f64>();
        let found = voxels.iter().position(|&value| {
            left -= mean(value);
            left < 0.0
        });
        // Rounding may leave the end of a row.
        let last = || voxels.iter().rposition(|value| *value != Vec3::ZERO).unwrap_or(0);
        let x = found.unwrap_or_else(last);
        let emission = voxels[x];
        let voxel = [x, row % ny, row / ny];
        let place = [0, 1, 2].map(|axis| {
            let count = self.layout.cells[axis] as usize;
            voxel[axis] as f32 + 0.5 + tent(offset[axis], voxel[axis] == 0, voxel[axis] + 1 == count)
        });
        let place = self.layout.min + Vec3::from(place) * self.voxel();
        let all = 4.0 * f64::from(PI) * self.voxel().as_dvec3().element_product() * total;
        let power = emission.as_dvec3() * (all / mean(emission).max(f64::MIN_POSITIVE));
        (place.clamp(self.layout.min, self.layout.max), power.as_vec3())
    }

    /// Emission coefficient at a place in the box.
    fn at(&self, place: Vec3) -> Vec3 {
        let at = (place - self.layout.min) / self.voxel() - 0.5;
        let last = cells(&self.layout) - 1.0;
        let at = at.clamp(Vec3::ZERO, last);
        let low = at.floor().min((last - 1.0).max(Vec3::ZERO));
        let high = at - low;
        let [nx, ny, _] = self.layout.cells.map(|count| count as usize);
        let [x, y, z] = low.to_array().map(|low| low as usize);
        let steps = [(0, 1), (1, nx), (2, nx * ny)];
        let [dx, dy, dz] = steps.map(|(axis, step)| if self.layout.cells[axis] > 1 { step } else { 0 });
        let row = |from: usize| self.values[from].lerp(self.values[from + dx], high.x);
        let plane = |from: usize| row(from).lerp(row(from + dy), high.y);
        let base = (z * ny + y) * nx + x;
        plane(base).lerp(plane(base + dz), high.z)
    }

    /// The part of a ray in the box.
    fn stretch(&self, ray: &EyeRay) -> Option<(f32, f32)> {
        let (min, max) = self.bounds();
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (near, far) = intersect_box(min.as_dvec3(), max.as_dvec3(), origin, direction)?;
        let (from, to) = ((near as f32).max(0.0), (far as f32).min(ray.length));
        (from < to).then_some((from, to))
    }

    /// Whether any of a ray is in the box.
    pub(crate) fn is_met(&self, ray: &EyeRay) -> bool {
        self.stretch(ray).is_some()
    }

    /// Radiance that arrives at a ray's start from all along it.
    ///
    /// Exact where emission and density are the same all along the ray; else emission is linear, and density the same, over a quarter of a voxel.
    ///
    /// - `fog`: the medium, of this density; `column`: along the ray.
    pub(crate) fn seen(&self, fog: &Medium, density: &MediumDensity, ray: &EyeRay, column: &Column) -> Vec3 {
        let Some((from, to)) = self.stretch(ray) else { return Vec3::ZERO };
        let rate = voxels_a_metre(&self.layout, ray.direction).max(match density {
            MediumDensity::Uniform => 0.0,
            MediumDensity::Exponential(exponential) => 1.0 / exponential.scale_height,
            MediumDensity::Grid(volume) => voxels_a_metre(&volume.layout, ray.direction),
        });
        let count = (STEPS * rate * (to - from)).ceil().max(1.0);
        let step = (to - from) / count;
        let place = |distance: f32| self.at(ray.origin + distance * ray.direction);
        let mut sum = Vec3::ZERO;
        let mut start = from;
        let mut here = place(from);
        for index in 1..=count as u32 {
            let end = from + index as f32 * step;
            let next = place(end);
            if here != Vec3::ZERO || next != Vec3::ZERO {
                let (before, after) = (column.at(start), column.at(end));
                let left = fog.transmittance(before);
                if left == Vec3::ZERO {
                    break;
                }
                let [all, of_end] = shares(fog.extinction() * (after - before));
                sum += step * left * (all * here + of_end * (next - here));
            }
            (start, here) = (end, next);
        }
        sum
    }
}

/// Of the channels.
fn mean(color: Vec3) -> f64 {
    color.as_dvec3().element_sum() / 3.0
}

fn cells(layout: &GridLayout) -> Vec3 {
    Vec3::from(layout.cells.map(|count| count as f32))
}

/// Of a step through an optical depth τ: the mean of exp(-τs) over s from 0 to 1, and that of s exp(-τs).
fn shares(depth: Vec3) -> [Vec3; 2] {
    let is_thin = depth.cmplt(Vec3::splat(THIN));
    let (left, safe) = ((-depth).exp(), depth.max(Vec3::splat(THIN)));
    let all = (1.0 - left) / safe;
    let of_end = (1.0 - left * (1.0 + depth)) / (safe * safe);
    let thin = [1.0 - depth * (0.5 - depth / 6.0), 0.5 - depth * (1.0 / 3.0 - depth / 8.0)];
    [Vec3::select(is_thin, thin[0], all), Vec3::select(is_thin, thin[1], of_end)]
}

/// How many voxels a ray crosses on the axis on which these are most; 0 where there is but one voxel.
fn voxels_a_metre(layout: &GridLayout, direction: Vec3) -> f32 {
    let cells = cells(layout);
    let rate = direction.abs() * cells / (layout.max - layout.min);
    Vec3::select(cells.cmpgt(Vec3::ONE), rate, Vec3::ZERO).max_element()
}

/// Where around the middle of a voxel its share of the light starts, in voxels: it falls to nothing at the next middle, and is held up to
/// the border of the box.
fn tent(u: f32, is_first: bool, is_last: bool) -> f32 {
    let (side, is_border, u) =
        if u < 0.5 { (-1.0, is_first, 2.0 * u) } else { (1.0, is_last, 2.0 * u - 1.0) };
    side * if is_border { 0.5 * u } else { 1.0 - (1.0 - u).max(0.0).sqrt() }
}

/// Three times the volume over the surface, across which emission falls: seen along the axes, as of boxes.
fn equal_radius(layout: &GridLayout, values: &[Vec3]) -> f32 {
    let voxel = ((layout.max - layout.min) / cells(layout)).as_dvec3();
    let [nx, ny, nz] = layout.cells.map(|count| count as usize);
    let faces = [voxel.yz(), voxel.xz(), voxel.xy()].map(|sides| sides.x * sides.y);
    let at = |x: usize, y: usize, z: usize| mean(values[(z * ny + y) * nx + x]);
    let (mut sum, mut surface) = (0.0, 0.0);
    for (x, y, z) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (x, y, z)))) {
        let here = at(x, y, z);
        sum += here;
        // Outside there is nothing.
        let before = [
            if x > 0 { at(x - 1, y, z) } else { 0.0 },
            if y > 0 { at(x, y - 1, z) } else { 0.0 },
            if z > 0 { at(x, y, z - 1) } else { 0.0 },
        ];
        let is_last = [x + 1 == nx, y + 1 == ny, z + 1 == nz];
        for axis in 0..3 {
            let ends = if is_last[axis] { here } else { 0.0 };
            surface += faces[axis] * ((here - before[axis]).abs() + ends);
        }
    }
    (3.0 * sum * voxel.element_product() / f64::max(surface, f64::MIN_POSITIVE)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const LAYOUT: GridLayout =
        GridLayout { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(0.5, 2.0, 3.0), cells: [3, 2, 1] };

    fn glow() -> Glow {
        let value = |i: usize| Vec3::new(i as f32, (i * i) as f32, 0.0);
        Glow::new(LAYOUT, [0, 3, 1, 0, 5, 2].map(value).to_vec()).expect("bright")
    }

    /// Sums over the box by the definition of what is between voxels, and by what is drawn: how much light, and where.
    #[test]
    fn places_are_drawn_by_how_much_they_glow() {
        let glow = glow();
        let mut random = Random::new([1, 2, 3, 4]);
        let count = 400_000;
        let volume = (LAYOUT.max - LAYOUT.min).element_product();
        let (mut expected, mut found) = ([0.0_f64; 8], [0.0_f64; 8]);
        let add = |sums: &mut [f64; 8], place: Vec3, light: Vec3| {
            let light = light.as_dvec3();
            let cell = usize::from(place.x > -0.1) + 2 * usize::from(place.y > 0.7);
            sums[2 * cell] += light.x / f64::from(count);
            sums[2 * cell + 1] += light.y / f64::from(count);
        };
        for _ in 0..count {
            let mut number = || random.uniform();
            let [x, y, z, row, along] = [number(), number(), number(), number(), number()];
            let place = LAYOUT.min + Vec3::new(x, y, z) * (LAYOUT.max - LAYOUT.min);
            add(&mut expected, place, 4.0 * PI * volume * glow.at(place));
            let (place, power) = glow.draw([row, along], [number(), number(), number()]);
            add(&mut found, place, power);
        }
        println!("{found:?} for {expected:?}");
        // 400,000 places: a standard error of some 2e-3 of each sum.
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 0.01 * expected, "{found} for {expected}");
        }
        let total: f64 = expected.iter().step_by(2).sum();
        assert!((f64::from(glow.flux().x) / total - 1.0).abs() < 5e-3, "{} for {total}", glow.flux());
    }

    /// Against 200,000 steps along a slanted ray through a medium whose density varies too.
    #[test]
    fn what_is_seen_is_the_integral_of_emission_times_transmittance() {
        let glow = glow();
        let density = crate::medium::volume::Volume {
            layout: GridLayout { cells: [1, 4, 5], ..LAYOUT },
            values: (0..20).map(|i| (i * 7 % 5) as f32 * 0.4).collect(),
        };
        let grid = covbeam::DensityGrid::new(density.layout, &density.values).expect("sound");
        let fog = Medium {
            scattering: Vec3::new(0.5, 0.0, 2.0),
            absorption: Vec3::new(1.0, 0.3, 0.0),
            density: covbeam::Density::Grid(grid),
            ..Medium::default()
        };
        let ray = EyeRay {
            origin: Vec3::new(-1.5, -0.2, 1.7),
            direction: Vec3::new(1.0, 1.2, 0.7).normalize(),
            length: 2.2,
        };
        let mut knots = Vec::new();
        let column = crate::scene::media::column(&fog, ray.origin, ray.direction, ray.length, &mut knots);
        let steps = 200_000;
        let step = ray.length / steps as f32;
        let expected: glam::DVec3 = (0..steps)
            .map(|index| (index as f32 + 0.5) * step)
            .filter(|at| {
                glow.is_met(&EyeRay { origin: ray.origin + *at * ray.direction, length: 1e-6, ..ray })
            })
            .map(|at| {
                let emission = glow.at(ray.origin + at * ray.direction) * step;
                (emission * fog.transmittance(column.at(at))).as_dvec3()
            })
            .sum();
        let seen = glow.seen(&fog, &MediumDensity::Grid(density.clone()), &ray, &column);
        println!("{seen} for {expected}");
        // Few voxels, whose values have nothing in common: in smoother ones it is less.
        assert!(
            ((seen / expected.as_vec3()) - 1.0).abs().truncate().max_element() < 0.006,
            "{seen} for {expected}"
        );
    }

    #[test]
    fn the_radius_is_that_of_a_cube_or_about_that_of_a_ball() {
        let even = Glow::even(Vec3::ZERO, Vec3::splat(4.0), Vec3::ONE).expect("bright");
        assert_eq!(even.radius(), 2.0);
        let side = 40;
        let inside = |i: usize| {
            let at = Vec3::new((i % side) as f32, (i / side % side) as f32, (i / side / side) as f32);
            let middle = at + 0.5 - 0.5 * side as f32;
            if middle.length() < 15.0 { Vec3::ONE } else { Vec3::ZERO }
        };
        let layout = GridLayout { min: Vec3::ZERO, max: Vec3::splat(4.0), cells: [side as u32; 3] };
        let ball = Glow::new(layout, (0..side * side * side).map(inside).collect()).expect("bright");
        // Seen along the axes a ball's surface is 1.5 times as large.
        assert!((ball.radius() - 1.5 / 1.5).abs() < 0.03, "{}", ball.radius());
    }
}
