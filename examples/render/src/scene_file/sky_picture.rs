//! Pictures of the sky: numbers that are no radiance are named, or replaced where the scene asks for it.

use covbeam_geometry::MAX_COORDINATE;
use glam::Vec3;

/// Names of channels.
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// So many pixels aside a sound number is looked for, at most.
const FARTHEST: usize = 8;

/// The first number of a picture that is no radiance, and how many there are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bad {
    /// Column and row, from the upper left corner.
    pub(crate) at: [usize; 2],
    /// Of the channel.
    pub(crate) channel: &'static str,
    pub(crate) value: f32,
    /// Of all pixels, those with one.
    pub(crate) pixels: usize,
}

/// Whether it is a radiance that a sky may have.
fn is_sound(value: f32) -> bool {
    (0.0..=MAX_COORDINATE).contains(&value)
}

/// What is wrong with a picture; None: nothing.
pub(crate) fn find_bad(cells: &[Vec3], columns: usize) -> Option<Bad> {
    let is_bad = |cell: &Vec3| !cell.to_array().into_iter().all(is_sound);
    let first = cells.iter().position(is_bad)?;
    let values = cells[first].to_array();
    let channel = values.into_iter().position(|value| !is_sound(value))?;
    Some(Bad {
        at: [first % columns, first / columns],
        channel: CHANNELS[channel],
        value: values[channel],
        pixels: cells.iter().filter(|cell| is_bad(cell)).count(),
    })
}

/// The picture with each bad number replaced: one below 0 by 0; NaN by the mean of the sound numbers of its channel in the 3 x 3 pixels around
/// it; infinity, or more than 1e9, by the largest of them. Where there is none, of 5 x 5 pixels, and so on up to 17 x 17; the picture goes on
/// at its left and right ends. None: there is a number without any sound one so near.
pub(crate) fn repaired(cells: &[Vec3], columns: usize) -> Option<Vec<Vec3>> {
    let repair = |(index, cell): (usize, &Vec3)| {
        let mut values = cell.to_array();
        for (channel, value) in values.iter_mut().enumerate().filter(|(_, value)| !is_sound(**value)) {
            *value = if *value < 0.0 {
                0.0
            } else {
                let near = (1..=FARTHEST).find_map(|reach| around(cells, columns, index, channel, reach))?;
                if value.is_nan() { near.mean } else { near.largest }
            };
        }
        Some(Vec3::from(values))
    };
    cells.iter().enumerate().map(repair).collect()
}

/// Sound numbers of a channel around a pixel.
struct Near {
    mean: f32,
    largest: f32,
}

/// None: there is none.
fn around(cells: &[Vec3], columns: usize, index: usize, channel: usize, reach: usize) -> Option<Near> {
    let rows = cells.len() / columns;
    let (row, column) = (index / columns, index % columns);
    let (mut sum, mut count, mut largest) = (0.0, 0u32, 0.0f32);
    for row in row.saturating_sub(reach)..=(row + reach).min(rows - 1) {
        for step in 0..(2 * reach + 1).min(columns) {
            let column = (column + columns * reach + step - reach) % columns;
            let value = cells[row * columns + column][channel];
            if is_sound(value) {
                (sum, count, largest) = (sum + f64::from(value), count + 1, largest.max(value));
            }
        }
    }
    (count > 0).then(|| Near { mean: (sum / f64::from(count)) as f32, largest })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four columns, three rows.
    fn picture(bad: &[(usize, f32)]) -> Vec<Vec3> {
        let mut cells: Vec<Vec3> = (0..12).map(|cell| Vec3::new(cell as f32, 1.0, 2.0)).collect();
        bad.iter().for_each(|&(index, value)| cells[index].x = value);
        cells
    }

    #[test]
    fn the_first_bad_number_is_named_and_all_are_counted() {
        assert_eq!(find_bad(&picture(&[]), 4), None);
        let bad = find_bad(&picture(&[(6, f32::INFINITY), (9, -1.0)]), 4);
        assert_eq!(bad, Some(Bad { at: [2, 1], channel: "R", value: f32::INFINITY, pixels: 2 }));
    }

    #[test]
    fn each_kind_is_replaced_by_its_rule() {
        let of = |index: usize, value: f32| {
            let mended = repaired(&picture(&[(index, value)]), 4).expect("sound neighbours");
            let sound = picture(&[]);
            let others = mended.iter().zip(&sound).enumerate();
            assert!(others.filter(|(place, _)| *place != index).all(|(_, (mended, given))| mended == given));
            assert_eq!([mended[index].y, mended[index].z], [1.0, 2.0]);
            mended[index].x
        };
        assert_eq!(of(5, -3.0), 0.0);
        assert_eq!(of(5, f32::NEG_INFINITY), 0.0);
        // 0, 1, 2, 4, 6, 8, 9, 10.
        assert_eq!(of(5, f32::NAN), 5.0);
        assert_eq!(of(5, f32::INFINITY), 10.0);
        assert_eq!(of(5, 2e9), 10.0);
        // At the left end of the middle row: 0, 1, 5, 8, 9 and, from the right end, 3, 7, 11.
        assert_eq!(of(4, f32::NAN), 5.5);
        assert_eq!(of(4, f32::INFINITY), 11.0);
    }

    #[test]
    fn holes_are_filled_from_what_is_around_them_and_a_picture_of_nothing_else_is_not() {
        let hole: Vec<(usize, f32)> = (0..11).map(|index| (index, f32::NAN)).collect();
        let mended = repaired(&picture(&hole), 4).expect("one sound number");
        assert!(mended.iter().all(|cell| cell.x == 11.0));
        let nothing: Vec<(usize, f32)> = (0..12).map(|index| (index, f32::NAN)).collect();
        assert_eq!(repaired(&picture(&nothing), 4), None);
        assert_eq!(repaired(&[Vec3::splat(f32::NAN)], 1), None);
    }
}
