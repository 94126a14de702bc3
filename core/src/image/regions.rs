//! The parts of a picture between silhouettes.

use super::{FilmSizeError, pixel_count};

/// Jumps of inverse depth above this share of the nearer one are edges.
const JUMP: f32 = 0.01;

/// Splits a picture into regions in which the depth of the first surface is continuous.
///
/// - `width`, `height`: of the picture, row by row from the upper left pixel.
/// - `depth` \[m\]: of the first surface seen through the middle of each pixel, along the viewing axis (not
///   along the ray: the inverse of such a depth is linear on a plane, however it is seen). Infinity where
///   there is none; NaN or <= 0 makes the pixel a border.
/// - `labels`: receives the pixel's region, from 1 on, or 0 for a pixel at a border, which filters leave
///   alone: its own light may come from both sides.
///
/// Two neighbours are apart where neither surface, continued as a plane, comes within 1 % of the other in
/// inverse depth. Floors seen at a grazing angle are no edges, nor are creases: one of a right angle from 100
/// pixels a unit of slope on. A region is connected by pixels side by side; its label is the number of its
/// first pixel, counted from 1.
///
/// Errors: a slice of another length than the picture has pixels, or a picture that is too large; nothing
/// changes.
///
/// Source: thesis 5.3.2 names occlusion of the eye path; here it does not enter the spectrum but bounds the
/// filters.
///
/// ```
/// let mut labels = [0; 6];
/// covbeam::film_regions(6, 1, &[5.0, 5.0, 5.0, 2.0, 2.0, 2.0], &mut labels)?;
/// assert_eq!(labels, [1, 1, 0, 0, 5, 5]);
/// # Ok::<(), covbeam::FilmSizeError>(())
/// ```
pub fn film_regions(width: u32, height: u32, depth: &[f32], labels: &mut [u32]) -> Result<(), FilmSizeError> {
    let count = pixel_count(width, height)?;
    if depth.len() != count || labels.len() != count {
        return Err(FilmSizeError);
    }
    let (columns, rows) = (width as usize, height as usize);
    let inverse = inverse_depth(depth);
    for y in 0..rows {
        for x in 0..columns {
            let index = y * columns + x;
            let whole =
                continuous(&inverse, index, x, columns, 1) && continuous(&inverse, index, y, rows, columns);
            labels[index] = if whole && !inverse(index).is_nan() { index as u32 + 1 } else { 0 };
        }
    }
    // Connected components: a label points at an earlier pixel of its region (counted from 1) or at itself.
    for index in 0..count {
        if labels[index] == 0 {
            continue;
        }
        let left = if index % columns > 0 { labels[index - 1] } else { 0 };
        let above = if index >= columns { labels[index - columns] } else { 0 };
        for neighbour in [left, above] {
            if neighbour > 0 {
                join(labels, index as u32 + 1, neighbour);
            }
        }
    }
    for index in 0..count {
        if labels[index] > 0 {
            labels[index] = root(labels, index as u32 + 1);
        }
    }
    Ok(())
}

/// Of each pixel; NaN where it is none.
pub(super) fn inverse_depth(depth: &[f32]) -> impl Fn(usize) -> f32 {
    |index| if depth[index] > 0.0 { 1.0 / depth[index] } else { f32::NAN }
}

/// Whether the surface goes on to both neighbours of a pixel along one axis.
fn continuous(inverse: &impl Fn(usize) -> f32, index: usize, at: usize, count: usize, stride: usize) -> bool {
    (at == 0 || !is_apart(inverse, index - stride, at - 1, count, stride))
        && !is_apart(inverse, index, at, count, stride)
}

/// Whether the surface ends between a pixel and the next one along one axis.
///
/// - `at`: the pixel's place among `count` along it; `stride`: from one to the next.
pub(super) fn is_apart(
    inverse: &impl Fn(usize) -> f32,
    index: usize,
    at: usize,
    count: usize,
    stride: usize,
) -> bool {
    if at + 1 >= count {
        return false;
    }
    let (here, there) = (inverse(index), inverse(index + stride));
    let close = |guess: f32, truth: f32| (guess - truth).abs() <= JUMP * here.max(there);
    let is_continued = close(here, there)
        || at > 0 && close(2.0 * here - inverse(index - stride), there)
        || at + 2 < count && close(2.0 * there - inverse(index + 2 * stride), here);
    !is_continued
}

/// The first pixel of a region, counted from 1; shortens the way there.
pub(super) fn root(labels: &mut [u32], mut label: u32) -> u32 {
    loop {
        let above = labels[label as usize - 1];
        if above == label {
            return label;
        }
        let next = labels[above as usize - 1];
        labels[label as usize - 1] = next;
        label = next;
    }
}

fn join(labels: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(labels, a), root(labels, b));
    labels[a.max(b) as usize - 1] = a.min(b);
}
