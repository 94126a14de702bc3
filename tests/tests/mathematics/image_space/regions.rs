//! Regions between silhouettes.

use std::collections::VecDeque;

use covbeam::{FilmSizeError, film_regions};
use proptest::prelude::*;

pub(super) fn regions(width: u32, depth: &[f32]) -> Vec<u32> {
    let mut labels = vec![77; depth.len()];
    film_regions(width, depth.len() as u32 / width, depth, &mut labels).unwrap();
    labels
}

/// Depth along the viewing axis of a plane through `point` with this normal, through a camera with a slope of 1 over `size` pixels.
pub(super) fn plane(size: u32, point: [f64; 3], normal: [f64; 3]) -> impl Fn(u32, u32) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let at = move |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(size) - 0.5;
    move |x, y| dot(point, normal) / dot([at(x), at(y), 1.0], normal)
}

pub(super) fn picture(size: u32, depth: impl Fn(u32, u32) -> f64) -> Vec<f32> {
    (0..size * size).map(|i| depth(i % size, i / size) as f32).collect()
}

#[test]
fn a_floor_seen_at_a_grazing_angle_is_no_edge() {
    // From 1 mm above: neighbouring pixels' depths differ by up to a factor of 50, and 1/depth by 2 % to 100 % a pixel.
    let floor = plane(64, [0.0, 0.001, 0.0], [0.0, 1.0, 0.0]);
    let depth = picture(64, |x, y| if y < 32 { f64::INFINITY } else { floor(x, y) });
    let jump = depth[64 * 40] / depth[64 * 39];
    assert!(jump < 0.9, "each row is nearer by more than 1 %: {jump}");
    let labels = regions(64, &depth);
    // The horizon is no edge either: there 1/depth falls to 0 as a plane does.
    assert!(
        labels[64 * 33..].iter().all(|label| *label == labels[64 * 63]),
        "{:?}",
        &labels[64 * 30..64 * 36]
    );
    assert_ne!(labels[64 * 63], 0);
}

#[test]
fn a_crease_is_no_edge() {
    // Two walls that meet at nearly a right angle, seen from inside the corner and from outside. Their 1/depth changes by 0.8/160
    // and -1.33/160 of itself a pixel: a step too much or too little by half of the two together, 0.7 %.
    let left = plane(160, [0.0, 0.0, 4.0], [0.6, 0.1, 0.8]);
    let right = plane(160, [0.0, 0.0, 4.0], [-0.8, 0.0, 0.6]);
    for depth in
        [picture(160, |x, y| left(x, y).min(right(x, y))), picture(160, |x, y| left(x, y).max(right(x, y)))]
    {
        assert!(regions(160, &depth).iter().all(|label| *label == 1));
    }
    // The wall alone, cut off at the corner, is one.
    let cut = picture(160, |x, y| if x < 80 { left(x, y) } else { 9.0 });
    assert_eq!(regions(160, &cut)[79..81], [0, 0]);
}

#[test]
fn a_step_of_more_than_a_hundredth_is_an_edge() {
    for (far, labels) in [(1.008, [1; 6]), (1.013, [1, 1, 0, 0, 5, 5])] {
        assert_eq!(regions(6, &[1.0, 1.0, 1.0, far, far, far]), labels, "{far}");
        assert_eq!(regions(1, &[far, far, far, 1.0, 1.0, 1.0]), labels, "{far}, down");
        let metres = [100.0, 100.0, 100.0, 100.0 * far, 100.0 * far, 100.0 * far];
        assert_eq!(regions(6, &metres), labels, "the unit of length does not matter");
    }
}

#[test]
fn a_ball_before_a_wall_is_a_region_of_its_own() {
    let radius = |x: u32, y: u32| (f64::from(x) - 31.5).hypot(f64::from(y) - 31.5) / 16.0;
    let ball = |x, y| 4.0 - (1.0 - radius(x, y).powi(2)).max(0.0).sqrt();
    let depth = picture(64, |x, y| if radius(x, y) < 1.0 { ball(x, y) } else { 6.0 });
    let labels = regions(64, &depth);
    let (wall, middle) = (labels[0], labels[64 * 32 + 32]);
    assert!(wall == 1 && middle > 0 && middle != wall);
    for (i, label) in labels.iter().enumerate() {
        let (x, y) = (i as u32 % 64, i as u32 / 64);
        let expected: &[u32] = match radius(x, y) {
            // The limb is steeper than any plane through two pixels, for two pixels; a border is a pixel on each side.
            inside if inside < 0.8 => &[middle],
            inside if inside < 1.0 => &[middle, 0],
            outside if outside < 1.13 => &[wall, 0],
            _ => &[wall],
        };
        assert!(expected.contains(label), "{label} at {x}, {y}");
    }
    let border = labels.iter().filter(|label| **label == 0).count();
    // A circle of 100 pixels' circumference has two pixels of border along it, and no more than three.
    assert!((150..350).contains(&border), "{border}");
}

#[test]
fn sheets_of_one_depth_with_something_before_them_in_between_are_two() {
    let depth = picture(16, |x, _| if (6..10).contains(&x) { 2.0 } else { 5.0 });
    let labels = regions(16, &depth);
    for row in labels.chunks(16) {
        assert_eq!(row, [1, 1, 1, 1, 1, 0, 0, 8, 8, 0, 0, 12, 12, 12, 12, 12]);
    }
}

#[test]
fn a_region_that_is_connected_around_a_corner_is_one() {
    // A U: its arms are apart where a scan from above first meets them.
    let depth = picture(12, |x, y| if (4..8).contains(&x) && y < 7 { 2.0 } else { 5.0 });
    let labels = regions(12, &depth);
    assert_eq!((labels[0], labels[11], labels[12 * 11 + 6]), (1, 1, 1));
    // Its mirror image by a W of more arms, of which the right ones reach further up.
    let comb = picture(24, |x, y| if x % 8 >= 4 && y < 20 - x / 2 { 2.0 } else { 5.0 });
    let labels = regions(24, &comb);
    assert!([0, 9, 17].iter().all(|x| labels[24 * 2 + *x as usize] == 1), "{:?}", &labels[48..72]);
}

#[test]
fn depths_that_are_none_are_borders_and_a_missing_surface_is_a_region() {
    for bad in [f32::NAN, 0.0, -0.0, -3.0, f32::NEG_INFINITY] {
        let labels = regions(5, &[4.0, 4.0, bad, 4.0, 4.0]);
        assert_eq!(labels, [1, 0, 0, 0, 5], "{bad}");
    }
    assert_eq!(regions(4, &[f32::INFINITY; 8]), [1; 8]);
    assert_eq!(regions(4, &[f32::NAN; 8]), [0; 8]);
    // The largest depth is as good as none: its inverse is 0 within 1 % of nothing else.
    let labels = regions(6, &[2.0, 2.0, 2.0, f32::INFINITY, f32::INFINITY, f32::INFINITY]);
    assert_eq!(labels, [1, 1, 0, 0, 5, 5]);
    assert_eq!(regions(1, &[2.0]), [1]);
    assert_eq!(regions(1, &[f32::NAN]), [0]);
    assert_eq!(regions(1, &[2.0, 2.0, 9.0, 9.0]), [1, 0, 0, 4]);
    assert_eq!(regions(4, &[2.0, 2.0, 9.0, 9.0]), [1, 0, 0, 4]);
}

#[test]
fn slices_of_another_length_and_pictures_too_large_are_refused_and_nothing_changes() {
    let refused = |width: u32, height: u32, depths: usize, count: usize| {
        let mut labels = vec![77; count];
        let found = film_regions(width, height, &vec![1.0; depths], &mut labels);
        assert!(labels.iter().all(|label| *label == 77));
        found == Err(FilmSizeError)
    };
    assert!(refused(4, 3, 11, 12) && refused(4, 3, 13, 12) && refused(4, 3, 12, 11) && refused(4, 3, 12, 13));
    // Products that wrap to 0 or to the slices' length; one column too many; 2³² pixels.
    for (width, height) in [(1 << 16, 1 << 16), (u32::MAX, u32::MAX), (65_537, 0), (0, 65_537), (1 << 31, 2)]
    {
        assert!(refused(width, height, 0, 0), "{width} x {height}");
    }
    assert!(refused(65_537, 1, 65_537, 65_537));
    for (width, height) in [(0, 0), (65_536, 0), (0, 3)] {
        assert_eq!(film_regions(width, height, &[], &mut []), Ok(()));
    }
    assert!(FilmSizeError.to_string().contains("65536"));
}

/// What the documentation says, in f64: by how much inverse depth misses 1 % where a surface goes on from a pixel to the next one on a side,
/// and as a plane through each of the two. Nothing outside of the picture; NaN where a pixel is none.
pub(super) fn misses(width: usize, depth: &[f32], (x, y): (i64, i64), (dx, dy): (i64, i64)) -> Vec<f64> {
    let height = depth.len() / width;
    let at = |steps: i64| {
        let (x, y) = (x + steps * dx, y + steps * dy);
        let inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
        inside
            .then(|| f64::from(depth[y as usize * width + x as usize]))
            .map(|depth| if depth > 0.0 { 1.0 / depth } else { f64::NAN })
    };
    let (Some(a), Some(b)) = (at(0), at(1)) else { return Vec::new() };
    let limit = 0.01 * a.max(b);
    let guesses =
        [Some((a, b)), at(-1).map(|behind| (2.0 * a - behind, b)), at(2).map(|beyond| (2.0 * b - beyond, a))];
    guesses.into_iter().flatten().map(|(guess, truth)| (guess - truth).abs() - limit).collect()
}

/// A flood fill from each first pixel, over neighbours between which the surface goes on.
fn flood(width: usize, depth: &[f32]) -> Vec<u32> {
    let height = depth.len() / width;
    let is_inside = |x: i64, y: i64| (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
    let continuous = |place: (i64, i64), side: (i64, i64)| {
        let misses = misses(width, depth, place, side);
        // No palette of depths below comes near the limit; between two that are infinite it is 0.
        assert!(misses.iter().all(|miss| miss.is_nan() || miss.abs() > 1e-5 || *miss == 0.0));
        misses.is_empty() || misses.iter().any(|miss| *miss <= 1e-7)
    };
    let sides = [(1, 0), (-1, 0), (0, 1), (0, -1)];
    let place = |i: usize| ((i % width) as i64, (i / width) as i64);
    let whole = |i: usize| {
        let (x, y) = place(i);
        depth[i] > 0.0 && sides.iter().all(|side| continuous((x, y), *side))
    };
    let mut labels = vec![0; depth.len()];
    for first in 0..depth.len() {
        if labels[first] > 0 || !whole(first) {
            continue;
        }
        labels[first] = first as u32 + 1;
        let mut open = VecDeque::from([first]);
        while let Some(i) = open.pop_front() {
            let (x, y) = place(i);
            for (dx, dy) in sides {
                let (x, y) = (x + dx, y + dy);
                let next = (y * width as i64 + x) as usize;
                if is_inside(x, y) && labels[next] == 0 && whole(next) {
                    labels[next] = first as u32 + 1;
                    open.push_back(next);
                }
            }
        }
    }
    labels
}

/// Rectangles of a few depths over one another, of which the first two are one surface, and some pixels that are none.
pub(super) fn scene() -> impl Strategy<Value = (usize, Vec<f32>)> {
    let depth = prop::sample::select(vec![1.0, 1.003, 1.5, 3.0, f32::INFINITY]);
    let rectangle = (0..40_usize, 0..40_usize, 1..30_usize, 1..30_usize, depth);
    let broken = (0..1600_usize, prop::sample::select(vec![f32::NAN, 0.0, -1.0]));
    let parts = (prop::collection::vec(rectangle, 0..30), prop::collection::vec(broken, 0..4));
    ((1..40_usize, 1..40_usize), parts).prop_map(|((width, height), (rectangles, broken))| {
        let mut picture = vec![3.0; width * height];
        for (x, y, across, down, depth) in rectangles {
            for (i, pixel) in picture.iter_mut().enumerate() {
                if (x..x + across).contains(&(i % width)) && (y..y + down).contains(&(i / width)) {
                    *pixel = depth;
                }
            }
        }
        for (i, depth) in broken {
            let last = picture.len();
            picture[i % last] = depth;
        }
        (width, picture)
    })
}

proptest! {
    #[test]
    fn regions_are_those_of_a_flood_fill((width, depth) in scene()) {
        prop_assert_eq!(regions(width as u32, &depth), flood(width, &depth));
    }

    /// Pixels as noise: of all sizes, regions of one pixel beside some that wind through the picture.
    #[test]
    fn regions_of_noise_are_those_of_a_flood_fill(width in 1..12_usize, near in prop::collection::vec(0..10_u8, 1..200)) {
        let depth: Vec<f32> = near[..near.len() / width * width].iter().map(|n| if *n < 1 { 1.0 } else { 3.0 }).collect();
        prop_assert_eq!(regions(width as u32, &depth), flood(width, &depth));
    }
}

/// Arms of a comb that join from the right, so that each join hangs a region's first pixel below another's.
#[test]
fn a_comb_of_a_thousand_arms_takes_no_longer_than_a_flat_picture() {
    let size = 4096_u32;
    let comb = |x: u32, y: u32| if x % 8 < 4 || y > 600 { 3.0 } else { 1.0 };
    let slanted = |x: u32, y: u32| if y + x / 8 < 540 { 1.0 } else { comb(x, y) };
    let depth: Vec<f32> = (0..size * 620).map(|i| slanted(i % size, i / size) as f32).collect();
    let start = std::time::Instant::now();
    let labels = regions(size, &depth);
    println!("{:?}", start.elapsed());
    let last = *labels.last().unwrap();
    assert!(last > 0 && labels[labels.len() - size as usize..].iter().all(|label| *label == last));
    // 0.1 s; a walk along a chain of arms from each pixel would take minutes.
    assert!(start.elapsed().as_secs() < 10);
}
