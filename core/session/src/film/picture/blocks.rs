//! Means over blocks of pixels, where a pixel alone has seldom an eye ray.

use rayon::prelude::*;

/// Pixels along the side of a block.
const SIDE: usize = 8;

/// Mean radius and σ of each pixel, weighted by light: from sums over blocks, bilinear between their middles; 0 where there is no light around.
/// None: cancelled.
///
/// - `gather`: sums of the pixels, of light, light x radius and light x σ; `width`: pixels a row.
pub(super) fn means(
    gather: &[[i64; 4]],
    width: u32,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<[Vec<f32>; 2]> {
    let width = width as usize;
    let (across, down) = (width.div_ceil(SIDE), (gather.len() / width).div_ceil(SIDE));
    let block = |number: usize| {
        let (x0, y0) = (number % across * SIDE, number / across * SIDE);
        let rows = gather.chunks(width).skip(y0).take(SIDE);
        let pixels = rows.flat_map(|row| &row[x0..(x0 + SIDE).min(width)]);
        pixels.fold([0.0; 3], |sums, pixel| [0, 1, 2].map(|which| sums[which] + pixel[which] as f64))
    };
    let blocks: Vec<[f64; 3]> = (0..across * down).into_par_iter().map(block).collect();
    // Between which two blocks, and how far towards the second.
    let between = |place: usize, count: usize| {
        let position = ((place as f64 + 0.5) / SIDE as f64 - 0.5).clamp(0.0, (count - 1) as f64);
        let low = position as usize;
        (low, (low + 1).min(count - 1), position - low as f64)
    };
    let pixel = |index: usize| {
        let (left, right, x) = between(index % width, across);
        let (upper, lower, y) = between(index / width, down);
        let at = |row: usize, column: usize, which: usize| blocks[row * across + column][which];
        let [light, radius, sigma] = [0, 1, 2].map(|which| {
            let row = |row| at(row, left, which) * (1.0 - x) + at(row, right, which) * x;
            row(upper) * (1.0 - y) + row(lower) * y
        });
        if light > 0.0 { [radius, sigma].map(|sum| (sum / light) as f32) } else { [0.0; 2] }
    };
    let mut found = [vec![0.0; gather.len()], vec![0.0; gather.len()]];
    let [radius, sigma] = &mut found;
    let rows = radius.par_chunks_mut(width).zip(sigma.par_chunks_mut(width)).enumerate();
    let done = rows.map(|(y, (radius, sigma))| {
        for (x, (radius, sigma)) in radius.iter_mut().zip(sigma).enumerate() {
            [*radius, *sigma] = pixel(y * width + x);
        }
        (!cancelled()).then_some(())
    });
    done.collect::<Option<()>>()?;
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radius 2 and σ 5 on the left, 6 and 9 on the right, which has thrice the light, in one pixel a block.
    #[test]
    fn one_pixel_of_a_block_speaks_for_all_of_it_and_blocks_go_over_into_each_other() {
        let (width, height) = (16, 11);
        let mut gather = vec![[0; 4]; width * height];
        (gather[5], gather[8 * width + 1]) = ([10, 20, 50, 1], [10, 20, 50, 1]);
        (gather[2 * width + 9], gather[10 * width + 15]) = ([30, 180, 270, 1], [30, 180, 270, 1]);
        let [radius, sigma] = means(&gather, width as u32, &|| false).expect("not cancelled");
        for y in 0..height {
            for x in 0..width {
                let share = ((x as f64 + 0.5) / 8.0 - 0.5).clamp(0.0, 1.0);
                let light = 10.0 * (1.0 - share) + 30.0 * share;
                let mean =
                    |left: f64, right: f64| (10.0 * left * (1.0 - share) + 30.0 * right * share) / light;
                let found = [radius[y * width + x], sigma[y * width + x]].map(f64::from);
                for (found, expected) in found.into_iter().zip([mean(2.0, 6.0), mean(5.0, 9.0)]) {
                    assert!((found - expected).abs() < 1e-6, "({x}, {y}): {found} for {expected}");
                }
            }
        }
        assert_eq!(means(&[[0; 4]; 6], 3, &|| false).expect("not cancelled"), [vec![0.0; 6], vec![0.0; 6]]);
        assert!(means(&gather, width as u32, &|| true).is_none());
    }
}
