//! Making a square root lower triangular by rotations.
//!
//! Method: row by row, Givens rotations of the columns gather the row's mass in one column, its pivot.
//! Rotations do not change L Lᵀ, so nothing is subtracted and no covariance can leave the positive
//! semi-definite cone.
//!
//! Rank: a row without mass takes no column; all columns stay available to the rows below. Only so is the
//! lower-right block the slice of the rows above when these are linearly dependent (the pseudo-inverse of the
//! Schur complement): [[0, 0], [1, 1]] becomes [[0, 0], [0, √2]], not [[0, 0], [√2, 0]].
//!
//! Accuracy: arithmetic in `f64` on roots stored in `f32`. Squares neither overflow nor vanish, so the
//! hypotenuse needs no scaling, and a b - b a cancels to an exact zero for entries that come straight from
//! storage (24 + 24 bits fit in 53), which is what makes the rank decision safe.

/// The lower-triangular root, by columns, of `columns * columnsᵀ`. Column i is zero if row i has no pivot.
pub(super) fn triangular<const ROWS: usize, const COLUMNS: usize>(
    mut columns: [[f64; ROWS]; COLUMNS],
) -> [[f64; ROWS]; ROWS] {
    let mut root = [[0.0; ROWS]; ROWS];
    // Columns before `next` are pivots of the rows above.
    let mut next = 0;
    for row in 0..ROWS {
        for other in next + 1..COLUMNS {
            gather(&mut columns, next, other, row);
        }
        if next < COLUMNS && columns[next][row] != 0.0 {
            root[row] = columns[next];
            next += 1;
        }
    }
    root
}

/// Rotates columns `pivot` and `other` so that all of `row` is in `pivot`.
fn gather<const ROWS: usize, const COLUMNS: usize>(
    columns: &mut [[f64; ROWS]; COLUMNS],
    pivot: usize,
    other: usize,
    row: usize,
) {
    let (a, b) = (columns[pivot][row], columns[other][row]);
    if b == 0.0 {
        return;
    }
    if a == 0.0 {
        columns.swap(pivot, other);
        return;
    }
    let length = libm::sqrt(a * a + b * b);
    let inverse = 1.0 / length;
    let (head, tail) = columns.split_at_mut(other);
    let (p, q) = (&mut head[pivot], &mut tail[0]);
    p[row] = length;
    q[row] = 0.0;
    for (p, q) in p[row + 1..].iter_mut().zip(&mut q[row + 1..]) {
        (*p, *q) = ((a * *p + b * *q) * inverse, (a * *q - b * *p) * inverse);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_without_a_pivot_leaves_its_column_to_the_rows_below() {
        let root = triangular([[0.0, 1.0], [0.0, 1.0]]);
        assert_eq!(root, [[0.0, 0.0], [0.0, core::f64::consts::SQRT_2]]);
    }

    #[test]
    fn dependent_rows_of_stored_numbers_leave_an_exact_zero() {
        // Rows (1/3, 1/7) and 5 (1/3, 1/7) rounded alike: rank one, whatever the rounding of the entries.
        let (a, b) = (f64::from(1.0f32 / 3.0), f64::from(1.0f32 / 7.0));
        let root = triangular([[a, 5.0 * a, 0.0], [b, 5.0 * b, 0.0], [0.0, 0.0, 2.0]]);
        assert_eq!(root[1], [0.0; 3]);
        assert_eq!(root[2], [0.0, 0.0, 2.0]);
    }

    #[test]
    fn rotations_keep_the_product_with_the_transpose_and_clear_the_upper_triangle() {
        let columns = [
            [1.0, -2.0, 3.0, 0.5],
            [0.25, 4.0, -1.0, 2.0],
            [3.0, 1.0, 1.0, 1.0],
            [-1.0, 0.5, 2.0, 7.0],
            [2.0; 4],
        ];
        let root = triangular(columns);
        for i in 0..4 {
            for j in 0..4 {
                let before: f64 = columns.iter().map(|c| c[i] * c[j]).sum();
                let after: f64 = root.iter().map(|c| c[i] * c[j]).sum();
                // A dozen roundings of f64 on entries below 60.
                assert!((before - after).abs() < 1e-13, "{i} {j}: {before} {after}");
                if i < j {
                    assert_eq!(root[j][i], 0.0);
                }
            }
        }
    }

    #[test]
    fn entries_at_both_ends_of_single_precision_neither_overflow_nor_vanish() {
        let (big, small) = (f64::from(f32::MAX), f64::from(f32::from_bits(1)));
        let root = triangular([[big, big], [big, -big]]);
        assert!(root.iter().flatten().all(|e| e.is_finite()));
        let root = triangular([[small, small], [small, -small]]);
        assert!((root[0][0] / small - core::f64::consts::SQRT_2).abs() < 1e-15);
        assert!((root[1][1].abs() / small - core::f64::consts::SQRT_2).abs() < 1e-15);
    }
}
