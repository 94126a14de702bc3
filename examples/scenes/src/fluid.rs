//! A small smoke simulation after J. Stam, *Stable Fluids* (1999), and R. Fedkiw, J. Stam and H. W. Jensen, *Visual
//! Simulation of Smoke* (2001): advection on a staggered grid, buoyancy, vorticity confinement, pressure projection.
//!
//! The unit of length is a cell and the unit of time is a step. The floor (y = 0) is solid, the other sides are open.
//! Smoke is carried by the limited `MacCormack` scheme of A. Selle et al. (2008), which keeps wisps that the
//! semi-Lagrangian scheme blurs.

/// Over-relaxation of the pressure solver and its sweeps a step; it starts from the last step's pressure.
const RELAXATION: f32 = 1.7;
const SWEEPS: u32 = 30;

/// Values on a regular lattice with unit spacing.
#[derive(Clone, Debug)]
pub struct Field {
    /// Points along x, y and z.
    pub size: [usize; 3],
    /// Position of the first point.
    pub origin: [f32; 3],
    /// One value a point, x first, then y, then z.
    pub values: Vec<f32>,
}

/// The cube of lattice points around a position, and where in it the position is.
struct Cube {
    first: usize,
    fraction: [f32; 3],
}

impl Field {
    fn new(size: [usize; 3], origin: [f32; 3]) -> Self {
        Self { size, origin, values: vec![0.0; size[0] * size[1] * size[2]] }
    }

    /// Index of a point.
    pub fn index(&self, x: usize, y: usize, z: usize) -> usize {
        x + self.size[0] * (y + self.size[1] * z)
    }

    /// Where a point is.
    fn position(&self, x: usize, y: usize, z: usize) -> [f32; 3] {
        [self.origin[0] + x as f32, self.origin[1] + y as f32, self.origin[2] + z as f32]
    }

    fn cube(&self, position: [f32; 3]) -> Cube {
        let mut corner = [0; 3];
        let mut fraction = [0.0; 3];
        for axis in 0..3 {
            let last = (self.size[axis] - 1) as f32;
            let at = (position[axis] - self.origin[axis]).clamp(0.0, last);
            corner[axis] = (at as usize).min(self.size[axis] - 2);
            fraction[axis] = at - corner[axis] as f32;
        }
        Cube { first: self.index(corner[0], corner[1], corner[2]), fraction }
    }

    fn corners(&self, cube: &Cube) -> [f32; 8] {
        let (row, layer) = (self.size[0], self.size[0] * self.size[1]);
        let v = &self.values[cube.first..cube.first + layer + row + 2];
        [v[0], v[1], v[row], v[row + 1], v[layer], v[layer + 1], v[layer + row], v[layer + row + 1]]
    }

    /// Trilinear; outside the lattice the nearest value of its border.
    pub fn sample(&self, position: [f32; 3]) -> f32 {
        let cube = self.cube(position);
        let v = self.corners(&cube);
        let [fx, fy, fz] = cube.fraction;
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        mix(
            mix(mix(v[0], v[1], fx), mix(v[2], v[3], fx), fy),
            mix(mix(v[4], v[5], fx), mix(v[6], v[7], fx), fy),
            fz,
        )
    }
}

/// Air with smoke and heat in it.
#[derive(Clone, Debug)]
pub struct Fluid {
    /// Cells along x, y and z.
    pub cells: [usize; 3],
    /// Velocity along x, y and z, at the faces across the axis.
    pub velocity: [Field; 3],
    /// Amount of smoke at the cells' centres.
    pub density: Field,
    /// Warmth above the surroundings at the cells' centres; 1 lifts with `buoyancy`.
    pub heat: Field,
    /// Upward acceleration per heat \[cells/step²\].
    pub buoyancy: f32,
    /// Strength of the vorticity confinement, >= 0.
    pub confinement: f32,
    pressure: Field,
}

impl Fluid {
    /// Air at rest; at least 4 cells along each axis.
    pub fn new(cells: [usize; 3], buoyancy: f32, confinement: f32) -> Self {
        let faces = |axis: usize| {
            let (mut size, mut origin) = (cells, [0.5; 3]);
            size[axis] += 1;
            origin[axis] = 0.0;
            Field::new(size, origin)
        };
        let centers = Field::new(cells, [0.5; 3]);
        Self {
            cells,
            velocity: [faces(0), faces(1), faces(2)],
            density: centers.clone(),
            heat: centers,
            buoyancy,
            confinement,
            // A border of zeros: the pressure outside the open sides.
            pressure: Field::new(cells.map(|n| n + 2), [-0.5; 3]),
        }
    }

    /// One step of time.
    pub fn step(&mut self) {
        self.add_buoyancy();
        self.add_confinement();
        self.project();
        let velocity = self.velocity.clone();
        [self.density, self.heat] = advect_sharply([&self.density, &self.heat], &velocity);
        self.velocity = [0, 1, 2].map(|axis| advect_smoothly(&velocity[axis], &velocity));
    }

    fn add_buoyancy(&mut self) {
        let [nx, ny, nz] = self.cells;
        let up = &mut self.velocity[1];
        for z in 0..nz {
            for y in 1..ny {
                for x in 0..nx {
                    let below = self.heat.index(x, y - 1, z);
                    let heat = (self.heat.values[below] + self.heat.values[below + nx]) / 2.0;
                    let face = up.index(x, y, z);
                    up.values[face] += self.buoyancy * heat;
                }
            }
        }
    }

    /// Pushes the air around the axes of its curls, which the coarse grid damps.
    fn add_confinement(&mut self) {
        let [nx, ny, nz] = self.cells;
        let (row, layer) = (nx, nx * ny);
        let count = layer * nz;
        let [u, v, w] = &self.velocity;
        let mut center = vec![[0.0_f32; 3]; count];
        for (x, y, z) in inner(self.cells, 0) {
            let along = |field: &Field, step: usize| {
                let face = field.index(x, y, z);
                (field.values[face] + field.values[face + step]) / 2.0
            };
            center[x + row * y + layer * z] = [along(u, 1), along(v, nx), along(w, layer)];
        }
        let mut curl = vec![[0.0_f32; 3]; count];
        let mut strength = vec![0.0_f32; count];
        for (x, y, z) in inner(self.cells, 1) {
            let i = x + row * y + layer * z;
            let slope = |of: usize, step: usize| (center[i + step][of] - center[i - step][of]) / 2.0;
            let [cx, cy, cz] =
                [slope(2, row) - slope(1, layer), slope(0, layer) - slope(2, 1), slope(1, 1) - slope(0, row)];
            curl[i] = [cx, cy, cz];
            strength[i] = (cx * cx + cy * cy + cz * cz).sqrt();
        }
        for (x, y, z) in inner(self.cells, 2) {
            let i = x + row * y + layer * z;
            let slope = |step: usize| (strength[i + step] - strength[i - step]) / 2.0;
            let n = [slope(1), slope(row), slope(layer)];
            let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            // Where the curl is even there is no axis to push around.
            if length < 1e-9 {
                continue;
            }
            let [nx, ny, nz] = n.map(|slope| slope / length);
            let [cx, cy, cz] = curl[i];
            let push = [ny * cz - nz * cy, nz * cx - nx * cz, nx * cy - ny * cx];
            for ((field, push), face_step) in self.velocity.iter_mut().zip(push).zip([1, row, layer]) {
                let face = field.index(x, y, z);
                let half = self.confinement * push / 2.0;
                field.values[face] += half;
                field.values[face + face_step] += half;
            }
        }
    }

    /// Makes the velocity free of divergence: Poisson equation by successive over-relaxation.
    fn project(&mut self) {
        let [nx, ny, nz] = self.cells;
        let floor = &mut self.velocity[1];
        for (x, z) in (0..nz).flat_map(|z| (0..nx).map(move |x| (x, z))) {
            let face = floor.index(x, 0, z);
            floor.values[face] = 0.0;
        }
        let divergence: Vec<f32> = inner(self.cells, 0)
            .map(|(x, y, z)| {
                let [u, v, w] = &self.velocity;
                let across = |field: &Field, step: usize| {
                    let face = field.index(x, y, z);
                    field.values[face + step] - field.values[face]
                };
                across(u, 1) + across(v, nx) + across(w, nx * ny)
            })
            .collect();
        let (row, layer) = (nx + 2, (nx + 2) * (ny + 2));
        let p = &mut self.pressure.values;
        for _ in 0..SWEEPS {
            let mut cell = 0;
            for z in 1..=nz {
                for y in 1..=ny {
                    // The floor lets nothing through, so no pressure acts across it; its neighbours stay 0.
                    let neighbours = if y == 1 { 5.0 } else { 6.0 };
                    for i in (1..=nx).map(|x| x + row * y + layer * z) {
                        let sum = p[i - 1] + p[i + 1] + p[i - row] + p[i + row] + p[i - layer] + p[i + layer];
                        p[i] += RELAXATION * ((sum - divergence[cell]) / neighbours - p[i]);
                        cell += 1;
                    }
                }
            }
        }
        for (axis, (field, step)) in self.velocity.iter_mut().zip([1, row, layer]).enumerate() {
            let size = field.size;
            for (face, (x, y, z)) in inner(size, 0).enumerate() {
                if axis == 1 && y == 0 {
                    continue;
                }
                let i = x + 1 + row * (y + 1) + layer * (z + 1);
                field.values[face] -= p[i] - p[i - step];
            }
        }
    }
}

/// All (x, y, z) at least `margin` from the border, x first.
fn inner(size: [usize; 3], margin: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    let range = move |axis: usize| margin..size[axis] - margin;
    range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| (x, y, z))))
}

fn velocity_at(velocity: &[Field; 3], position: [f32; 3]) -> [f32; 3] {
    [velocity[0].sample(position), velocity[1].sample(position), velocity[2].sample(position)]
}

/// Where the air at `position` is after `time` steps: midpoint rule.
fn trace(velocity: &[Field; 3], position: [f32; 3], time: f32) -> [f32; 3] {
    let add = |v: [f32; 3], time: f32| [0, 1, 2].map(|i| position[i] + time * v[i]);
    let middle = add(velocity_at(velocity, position), time / 2.0);
    add(velocity_at(velocity, middle), time)
}

/// A component of the velocity carried along by the velocity for one step: semi-Lagrangian, which damps what the grid
/// cannot hold.
fn advect_smoothly(field: &Field, velocity: &[Field; 3]) -> Field {
    let mut result = field.clone();
    for (i, (x, y, z)) in inner(field.size, 0).enumerate() {
        result.values[i] = field.sample(trace(velocity, field.position(x, y, z), -1.0));
    }
    result
}

/// Fields on the same lattice carried along by the velocity for one step: limited `MacCormack`, which adds half of what
/// a way forth and back would lose.
fn advect_sharply(fields: [&Field; 2], velocity: &[Field; 3]) -> [Field; 2] {
    let mut carried = fields.map(Field::clone);
    let mut limits = [0, 1].map(|i| vec![(0.0_f32, 0.0_f32); fields[i].values.len()]);
    let lattice = fields[0];
    for (i, (x, y, z)) in inner(lattice.size, 0).enumerate() {
        let from = trace(velocity, lattice.position(x, y, z), -1.0);
        for ((field, carried), limits) in fields.iter().zip(&mut carried).zip(&mut limits) {
            carried.values[i] = field.sample(from);
            let around = field.corners(&field.cube(from));
            limits[i] = around
                .iter()
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        }
    }
    let mut result = carried.clone();
    for (i, (x, y, z)) in inner(lattice.size, 0).enumerate() {
        let to = trace(velocity, lattice.position(x, y, z), 1.0);
        for (k, result) in result.iter_mut().enumerate() {
            let lost = (fields[k].values[i] - carried[k].sample(to)) / 2.0;
            let (low, high) = limits[k][i];
            result.values[i] = (carried[k].values[i] + lost).clamp(low, high);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A warm ball in the middle of still air, after some steps.
    fn risen(steps: u32) -> Fluid {
        let mut fluid = Fluid::new([16, 24, 16], 0.05, 0.1);
        for (x, y, z) in inner(fluid.cells, 6) {
            let i = fluid.heat.index(x, y, z);
            (fluid.heat.values[i], fluid.density.values[i]) = (1.0, 1.0);
        }
        for _ in 0..steps {
            fluid.step();
        }
        fluid
    }

    #[test]
    fn the_projection_leaves_a_hundredth_of_the_divergence() {
        let divergence = |fluid: &Fluid| {
            let [u, v, w] = &fluid.velocity;
            let across =
                |field: &Field, next: usize, face: usize| field.values[face + next] - field.values[face];
            let square = inner(fluid.cells, 0).map(|(x, y, z)| {
                let sum = across(u, 1, u.index(x, y, z))
                    + across(v, 16, v.index(x, y, z))
                    + across(w, 16 * 24, w.index(x, y, z));
                sum * sum
            });
            square.sum::<f32>().sqrt()
        };
        let mut fluid = risen(0);
        fluid.add_buoyancy();
        let before = divergence(&fluid);
        fluid.project();
        // Over-relaxed sweeps on 16 to 24 cells gain about a digit in 15 sweeps; there are 30.
        assert!(divergence(&fluid) < 0.01 * before, "{} {before}", divergence(&fluid));
    }

    #[test]
    fn warm_smoke_rises_and_no_smoke_appears_from_nothing() {
        let fluid = risen(12);
        let weight = |y: usize| (y as f32 + 0.5) - 12.0;
        let moment: f32 = inner(fluid.cells, 0)
            .map(|(x, y, z)| weight(y) * fluid.density.values[fluid.density.index(x, y, z)])
            .sum();
        // It started symmetric about y = 12.
        assert!(moment > 100.0, "{moment}");
        assert!(fluid.density.values.iter().all(|v| (0.0..=1.0).contains(v)));
    }

    #[test]
    fn a_field_linear_in_space_is_sampled_exactly_and_carried_exactly_by_an_even_wind() {
        let mut fluid = Fluid::new([8, 8, 8], 0.0, 0.0);
        for (axis, speed) in [0.5, -0.25, 0.75].into_iter().enumerate() {
            fluid.velocity[axis].values.fill(speed);
        }
        let linear = |p: [f32; 3]| 1.0 + 2.0 * p[0] - 3.0 * p[1] + 0.5 * p[2];
        let mut field = fluid.density.clone();
        for (i, (x, y, z)) in inner(field.size, 0).enumerate() {
            field.values[i] = linear(field.position(x, y, z));
        }
        // Sums of numbers below 32 in f32: 1e-5.
        assert!((field.sample([3.2, 4.9, 2.6]) - linear([3.2, 4.9, 2.6])).abs() < 1e-5);
        let [carried, _] = advect_sharply([&field, &field], &fluid.velocity);
        let smooth = advect_smoothly(&field, &fluid.velocity);
        for (x, y, z) in inner(field.size, 2) {
            let [px, py, pz] = field.position(x, y, z);
            let expected = linear([px - 0.5, py + 0.25, pz - 0.75]);
            let i = field.index(x, y, z);
            assert!(
                (carried.values[i] - expected).abs() < 1e-4 && (smooth.values[i] - expected).abs() < 1e-4
            );
        }
    }
}
