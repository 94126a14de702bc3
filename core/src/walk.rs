//! The walk of a straight segment over the cells of a lattice.

use crate::GridLayout;
use glam::Vec3;

/// Which cells a walk visits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lattice {
    /// The voxels themselves.
    Voxels,
    /// The cells between the voxels' centres: `n + 1` on each axis, the outer ones half outside the box. Cell i lies
    /// between the centres i - 1 and i.
    Centres,
}

/// A walk over the cells that a segment crosses inside the box, in f64: planes are computed afresh at each step, so
/// nothing drifts.
///
/// Source: Amanatides and Woo (1987).
pub(crate) struct Walk {
    /// The segment in units of cells: `start + s slope`.
    start: [f64; 3],
    inverse_slope: [f64; 3],
    /// Distance along the segment of the next plane on each axis.
    next: [f64; 3],
    cell: [u32; 3],
    /// Distance along the segment that the walk has reached, and where it ends.
    position: f64,
    end: f64,
    done: bool,
}

impl Walk {
    /// None where the segment misses the box. `direction` is not zero; an infinite `length` ends at the box.
    pub(crate) fn new(
        layout: &GridLayout,
        lattice: Lattice,
        origin: Vec3,
        direction: Vec3,
        length: f32,
    ) -> Option<Self> {
        let mut walk = Self {
            start: [0.0; 3],
            inverse_slope: [0.0; 3],
            next: [f64::INFINITY; 3],
            cell: [0; 3],
            position: 0.0,
            end: f64::from(length),
            done: false,
        };
        let (shift, more) = if lattice == Lattice::Centres { (0.5, 1) } else { (0.0, 0) };
        let mut slope = [0.0; 3];
        for axis in 0..3 {
            let min = f64::from(layout.min[axis]);
            let count = f64::from(layout.cells[axis]);
            let scale = count / (f64::from(layout.max[axis]) - min);
            let start = (f64::from(origin[axis]) - min) * scale + shift;
            slope[axis] = f64::from(direction[axis]) * scale;
            walk.start[axis] = start;
            if slope[axis] == 0.0 {
                if !(shift..=count + shift).contains(&start) {
                    return None;
                }
                continue;
            }
            let inverse = 1.0 / slope[axis];
            walk.inverse_slope[axis] = inverse;
            let (low, high) = ((shift - start) * inverse, (count + shift - start) * inverse);
            walk.position = walk.position.max(low.min(high));
            walk.end = walk.end.min(low.max(high));
        }
        if walk.position >= walk.end {
            return None;
        }
        for (axis, slope) in slope.iter().enumerate() {
            let entry = walk.start[axis] + walk.position * slope;
            walk.cell[axis] = (entry as u32).min(layout.cells[axis] + more - 1);
            walk.update_next(axis);
        }
        Some(walk)
    }

    /// Distance along the segment that the walk has reached.
    pub(crate) fn position(&self) -> f64 {
        self.position
    }

    /// Distance along the segment at which the walk ends.
    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    fn update_next(&mut self, axis: usize) {
        let inverse = self.inverse_slope[axis];
        if inverse != 0.0 {
            let plane = f64::from(self.cell[axis]) + if inverse > 0.0 { 1.0 } else { 0.0 };
            self.next[axis] = (plane - self.start[axis]) * inverse;
        }
    }

    /// The next piece of positive length: its cell, and where it starts and ends along the segment.
    pub(crate) fn next_piece(&mut self) -> Option<([u32; 3], f64, f64)> {
        while !self.done {
            let [x, y, z] = self.next;
            let axis = if x <= y && x <= z {
                0
            } else if y <= z {
                1
            } else {
                2
            };
            let cell = self.cell;
            let from = self.position;
            let to = self.next[axis].min(self.end);
            // The border's plane is computed as `end` was, so this also stops the walk at the border.
            if to >= self.end {
                self.done = true;
                return (to > from).then_some((cell, from, to));
            }
            let forward = self.inverse_slope[axis] > 0.0;
            self.cell[axis] = if forward { self.cell[axis] + 1 } else { self.cell[axis] - 1 };
            self.update_next(axis);
            if to > from {
                self.position = to;
                return Some((cell, from, to));
            }
        }
        None
    }
}
