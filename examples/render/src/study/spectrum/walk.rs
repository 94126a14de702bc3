//! The voxels along a straight segment.

use covbeam::GridLayout;
use glam::{DVec3, Vec3};

/// Edges of a voxel \[scene unit\].
pub(super) fn voxel_size(layout: &GridLayout) -> DVec3 {
    (layout.max.as_dvec3() - layout.min.as_dvec3()) / DVec3::from(layout.cells.map(f64::from))
}

/// Row-major index of a voxel, x fastest.
pub(super) fn index_of(layout: &GridLayout, [x, y, z]: [u32; 3]) -> usize {
    (z as usize * layout.cells[1] as usize + y as usize) * layout.cells[0] as usize + x as usize
}

/// The voxel of an index.
pub(super) fn voxel_of(layout: &GridLayout, index: usize) -> [u32; 3] {
    let [nx, ny, _] = layout.cells.map(|n| n as usize);
    [(index % nx) as u32, (index / nx % ny) as u32, (index / nx / ny) as u32]
}

/// Centre of a voxel.
pub(super) fn center_of(layout: &GridLayout, voxel: [u32; 3]) -> DVec3 {
    layout.min.as_dvec3() + (DVec3::from(voxel.map(f64::from)) + 0.5) * voxel_size(layout)
}

/// The voxel that holds `point`, which may lie on the box's faces; None outside.
pub(super) fn voxel_at(layout: &GridLayout, point: Vec3) -> Option<[u32; 3]> {
    let inside = point.cmpge(layout.min).all() && point.cmple(layout.max).all();
    let cell = (point.as_dvec3() - layout.min.as_dvec3()) / voxel_size(layout);
    inside.then(|| std::array::from_fn(|axis| (cell[axis] as u32).min(layout.cells[axis] - 1)))
}

/// Calls `visit` with the index of every voxel that the segment crosses, in order, and the distances along the
/// segment at which it enters and leaves it. The pieces partition the part of the segment inside the box.
///
/// `direction` is unit; `length` may be infinite.
pub(super) fn walk(
    layout: &GridLayout,
    origin: Vec3,
    direction: Vec3,
    length: f32,
    mut visit: impl FnMut(usize, f64, f64),
) {
    let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
    let min = layout.min.as_dvec3();
    let size = voxel_size(layout);
    let Some([mut at, end]) = inside(layout, origin, direction, length) else { return };
    let entry = (origin + at * direction - min) / size;
    let mut voxel: [i64; 3] =
        std::array::from_fn(|axis| (entry[axis] as i64).clamp(0, i64::from(layout.cells[axis]) - 1));
    let step: [i64; 3] = std::array::from_fn(|axis| if direction[axis] < 0.0 { -1 } else { 1 });
    // Distance along the segment of the next plane on each axis, computed afresh at each step: nothing drifts.
    let plane = |axis: usize, voxel: i64| {
        if direction[axis] == 0.0 {
            return f64::INFINITY;
        }
        let number = voxel + i64::from(direction[axis] > 0.0);
        (min[axis] + number as f64 * size[axis] - origin[axis]) / direction[axis]
    };
    let mut next: [f64; 3] = std::array::from_fn(|axis| plane(axis, voxel[axis]));
    let strides = [1, i64::from(layout.cells[0]), i64::from(layout.cells[0]) * i64::from(layout.cells[1])];
    let mut index: i64 = voxel.iter().zip(strides).map(|(i, stride)| i * stride).sum();
    loop {
        let axis = if next[0] <= next[1] && next[0] <= next[2] {
            0
        } else if next[1] <= next[2] {
            1
        } else {
            2
        };
        let to = next[axis].min(end);
        if to > at {
            visit(index as usize, at, to);
            at = to;
        }
        voxel[axis] += step[axis];
        if to >= end || !(0..i64::from(layout.cells[axis])).contains(&voxel[axis]) {
            return;
        }
        index += step[axis] * strides[axis];
        next[axis] = plane(axis, voxel[axis]);
    }
}

/// Distances at which a segment enters and leaves the box; None: it is beside it.
fn inside(layout: &GridLayout, origin: DVec3, direction: DVec3, length: f32) -> Option<[f64; 2]> {
    let (mut at, mut end) = (0.0_f64, f64::from(length));
    for axis in 0..3 {
        let low = f64::from(layout.min[axis]) - origin[axis];
        let high = f64::from(layout.max[axis]) - origin[axis];
        if direction[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (low, high) = (low / direction[axis], high / direction[axis]);
        at = at.max(low.min(high));
        end = end.min(low.max(high));
    }
    (at < end).then_some([at, end])
}

#[cfg(test)]
mod tests {
    use super::*;
    use covbeam_session::random::Random;

    const LAYOUT: GridLayout =
        GridLayout { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(3.0, 1.0, 5.0), cells: [7, 3, 5] };

    #[test]
    fn the_pieces_of_a_segment_are_in_their_voxels_and_partition_it() {
        let mut random = Random::new([1, 2, 3, 4]);
        let mut point = || {
            let mut coordinate = |low: f32, high: f32| low + (high - low) * random.uniform();
            Vec3::new(coordinate(-2.0, 4.0), coordinate(-0.5, 1.5), coordinate(1.0, 6.0))
        };
        let mut crossed = 0;
        for _ in 0..2000 {
            let (a, b) = (point(), point());
            let direction = (b - a).normalize();
            let length = a.distance(b);
            let mut last: Option<f64> = None;
            walk(&LAYOUT, a, direction, length, |index, from, to| {
                assert!(to > from && last.is_none_or(|last| last == from));
                last = Some(to);
                let middle = a + (0.5 * (from + to)) as f32 * direction;
                let cell = center_of(&LAYOUT, voxel_of(&LAYOUT, index));
                // Half a voxel, and the f32 rounding of `middle`.
                let apart = (middle.as_dvec3() - cell).abs();
                assert!(apart.cmple(0.5 * voxel_size(&LAYOUT) + 1e-6).all(), "{middle} is not in {cell}");
                crossed += 1;
            });
            // Both ends inside: the whole segment.
            if voxel_at(&LAYOUT, a).is_some() && voxel_at(&LAYOUT, b).is_some() {
                assert_eq!(last, Some(f64::from(length)));
            }
        }
        assert!(crossed > 5000, "{crossed} pieces are too few to tell");
    }

    #[test]
    fn a_segment_along_an_axis_crosses_one_row() {
        let mut row = Vec::new();
        let start = Vec3::new(-5.0, 0.5, 3.5);
        walk(&LAYOUT, start, Vec3::X, f32::INFINITY, |index, _, _| row.push(voxel_of(&LAYOUT, index)));
        assert_eq!(row, (0..7).map(|x| [x, 1, 2]).collect::<Vec<_>>());
        row.clear();
        walk(&LAYOUT, start, Vec3::Y, f32::INFINITY, |index, _, _| row.push(voxel_of(&LAYOUT, index)));
        assert_eq!(row, [[0; 3]; 0], "beside the box");
    }

    #[test]
    fn an_index_and_its_voxel_belong_together() {
        for index in 0..LAYOUT.cell_count() {
            assert_eq!(index_of(&LAYOUT, voxel_of(&LAYOUT, index)), index);
            let center = center_of(&LAYOUT, voxel_of(&LAYOUT, index));
            assert_eq!(voxel_at(&LAYOUT, center.as_vec3()), Some(voxel_of(&LAYOUT, index)));
        }
    }
}
