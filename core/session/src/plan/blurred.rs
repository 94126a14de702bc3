//! Which pixels a lens blurs: what they see may lie beside what the middle of the lens sees through them.

/// Whether each pixel is no farther from a border than the lens blurs what is beside that.
///
/// - `size`: of the picture; `regions`: of its pixels, 0 at a border.
/// - `blur`: radius that the nearest thing in a pixel is blurred to [pixels], >= 0 and finite.
pub(super) fn blurred(size: [u32; 2], regions: &[u32], blur: &[f32]) -> Vec<bool> {
    let [width, height] = size.map(|side| side as usize);
    let is_border = |index: usize| regions[index] == 0;
    // How far a border reaches: that of the nearer thing beside it, which makes it, up to two pixels away.
    let mut reach: Vec<f32> =
        (0..blur.len()).map(|i| if is_border(i) { blur[i] + 1.0 } else { 0.0 }).collect();
    for _ in 0..2 {
        let from =
            |index: usize| if reach[index] > 0.0 { reach[index].max(blur[index] + 1.0) } else { blur[index] };
        let largest = |index: usize| {
            let beside = beside(index, width, height).into_iter().flatten().map(from);
            if is_border(index) { beside.fold(from(index), f32::max) } else { 0.0 }
        };
        reach = (0..blur.len()).map(largest).collect();
    }
    // A pixel further away from it a pixel less is left: there and back.
    let falls = |reach: &mut [f32], index: usize, neighbours: [Option<usize>; 2]| {
        for beside in neighbours.into_iter().flatten() {
            reach[index] = reach[index].max(reach[beside] - 1.0);
        }
    };
    for index in 0..reach.len() {
        let [left, above, ..] = beside(index, width, height);
        falls(&mut reach, index, [left, above]);
    }
    for index in (0..reach.len()).rev() {
        let [.., right, below] = beside(index, width, height);
        falls(&mut reach, index, [right, below]);
    }
    reach.into_iter().map(|reach| reach > 0.0).collect()
}

/// The pixels to the left of one, above, to the right and below.
fn beside(index: usize, width: usize, height: usize) -> [Option<usize>; 4] {
    let (x, y) = (index % width, index / width);
    [
        (x > 0).then(|| index - 1),
        (y > 0).then(|| index - width),
        (x + 1 < width).then_some(index + 1),
        (y + 1 < height).then_some(index + width),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A border of two columns, the nearer thing to its left.
    #[test]
    fn pixels_as_far_from_a_border_as_the_nearer_thing_is_blurred_are_found() {
        let (width, height) = (40, 5);
        let regions: Vec<u32> = (0..width * height)
            .map(|i| match i % width {
                ..19 => 1,
                19..21 => 0,
                _ => 2,
            })
            .collect();
        for [near, far] in [[6.5, 0.0], [0.0, 0.0], [3.0, 9.0]] {
            let blur: Vec<f32> =
                (0..width * height).map(|i| if i % width < 20 { near } else { far }).collect();
            let found = blurred([width, height], &regions, &blur);
            for y in 0..height {
                let row = &found[(y * width) as usize..((y + 1) * width) as usize];
                let count = row.iter().filter(|blurred| **blurred).count();
                // The two of the border, and as many as it reaches on either side: the larger blur, and the pixel of the border itself.
                let widest = f32::max(near, far);
                let expected = 2 + 2 * widest.ceil() as usize;
                assert_eq!(count, expected, "blurred by {near} and {far}: {row:?}");
                assert!(row[19] && row[20] && !row[0] && !row[39]);
            }
        }
    }
}
