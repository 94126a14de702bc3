//! The picture from the rays, against sums over all pixels.

use covbeam::{FilmNode, FilmSample, FilmSizeError, ImageFilter, Reconstruction, Vec3};
use covbeam_tests::random::Stream;
use proptest::prelude::*;

/// What a reconstruction is made of.
#[derive(Clone, Debug)]
pub(super) struct Rays {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) samples: Vec<FilmSample>,
    pub(super) regions: Vec<u32>,
}

impl Rays {
    /// One region, with a ray of weight 1 and this radiance through each pixel.
    pub(super) fn full(width: u32, height: u32, radiance: impl Fn(u32, u32) -> f32) -> Self {
        let sample = |i: u32| FilmSample {
            radiance: Vec3::splat(radiance(i % width, i / width)),
            weight: 1.0,
            ..FilmSample::default()
        };
        let samples: Vec<_> = (0..width * height).map(sample).collect();
        Self { width, height, regions: vec![1; samples.len()], samples }
    }

    /// A picture without rays, of one region.
    pub(super) fn none(width: u32, height: u32) -> Self {
        let count = (width * height) as usize;
        Self { width, height, samples: vec![FilmSample::default(); count], regions: vec![1; count] }
    }

    pub(super) fn reconstruct<R>(&self, look: impl FnOnce(&Reconstruction) -> R) -> R {
        let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(self.width, self.height)];
        look(&Reconstruction::new(self.width, self.height, &self.samples, &self.regions, &mut nodes).unwrap())
    }

    /// All pixels through one filter.
    pub(super) fn picture(&self, filter: &ImageFilter) -> Vec<Vec3> {
        let pixels = 0..self.width * self.height;
        self.reconstruct(|from| pixels.map(|i| from.pixel(i % self.width, i / self.width, filter)).collect())
    }
}

const AT_REACH: f64 = 0.011_108_996_538_242_306;

/// A Gaussian that ends at 3 standard deviations, where its value is subtracted.
fn weight(deviations: f64) -> f64 {
    ((-0.5 * deviations * deviations).exp() - AT_REACH).max(0.0)
}

/// Pixels across of the blocks that may stand for their pixels: powers of two up to the filter's smallest standard deviation.
fn blocks(filter: &ImageFilter) -> Vec<u32> {
    let (xx, xy, yy) =
        (f64::from(filter.xx) + 1.0 / 12.0, f64::from(filter.xy), f64::from(filter.yy) + 1.0 / 12.0);
    let smallest = 0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    let largest = smallest.sqrt().log2().floor().max(0.0) as u32;
    (0..=largest).map(|power| 1 << power).collect()
}

/// Least and largest value that a pixel may have: Σ w radiance / Σ w weight over the pixels of its region, where blocks of up to
/// the filter's smallest standard deviation may count as standing at their middle, in red.
///
/// A block of s x s pixels has each of them within (s - 1)/√2 pixels of its middle, so a pixel's distance in standard deviations is off by
/// at most that over the smallest one. Which weights within these bounds make the ratio least: the largest for all pixels that are
/// darker than some value, the smallest for the others.
fn bounds(rays: &Rays, x: u32, y: u32, filter: &ImageFilter) -> Option<[f64; 2]> {
    let (xx, xy, yy) =
        (f64::from(filter.xx) + 1.0 / 12.0, f64::from(filter.xy), f64::from(filter.yy) + 1.0 / 12.0);
    let smallest = 0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    let determinant = xx * yy - xy * xy;
    let block = f64::from(*blocks(filter).last().expect("a pixel is a block"));
    let off = (block - 1.0) / 2.0_f64.sqrt() / smallest.sqrt();
    let own = rays.regions[(y * rays.width + x) as usize];
    let mut terms = Vec::new();
    for (i, sample) in rays.samples.iter().enumerate() {
        if rays.regions[i] != own || sample.weight == 0.0 {
            continue;
        }
        let dx = f64::from(i as u32 % rays.width) - f64::from(x);
        let dy = f64::from(i as u32 / rays.width) - f64::from(y);
        let distance = ((yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant).sqrt();
        let (least, most) = (weight(distance + off), weight((distance - off).max(0.0)));
        if most > 0.0 {
            let (radiance, rays) = (f64::from(sample.radiance.x), f64::from(sample.weight));
            terms.push((radiance / rays, rays * least, rays * most));
        }
    }
    terms.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ratio = |cut: usize, low_first: bool| {
        let weigh = |(i, (value, least, most)): (usize, &(f64, f64, f64))| {
            let weight = if (i < cut) == low_first { *most } else { *least };
            (weight * value, weight)
        };
        let sum = terms
            .iter()
            .enumerate()
            .map(weigh)
            .fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1));
        (sum.1 > 0.0).then(|| sum.0 / sum.1)
    };
    let over =
        |low_first: bool| (0..=terms.len()).filter_map(move |cut| ratio(cut, low_first)).collect::<Vec<_>>();
    // With nothing under the filter even where its bounds are least, the reconstruction widens it.
    let certain: f64 = terms.iter().map(|term| term.1).sum();
    (certain > 1e-6).then(|| {
        let least = over(true).into_iter().fold(f64::INFINITY, f64::min);
        [least, over(false).into_iter().fold(f64::NEG_INFINITY, f64::max)]
    })
}

/// What a plane fitted to the region's pixels has at the pixel, in red, with how far off the pixel the filter's centre is, squared, in its
/// variances: weighted least squares over 1, u and v, with 0.03 of the weight added to the squares of both slopes, within the range of the
/// values, by Cramer's rule.
///
/// - `block`: pixels across of squares whose rays all lie in their middle.
fn plane(rays: &Rays, x: u32, y: u32, filter: &ImageFilter, block: u32) -> Option<(f64, f64)> {
    let (xx, xy, yy) =
        (f64::from(filter.xx) + 1.0 / 12.0, f64::from(filter.xy), f64::from(filter.yy) + 1.0 / 12.0);
    // Places in standard deviations, up to a turn, which changes nothing: those of the Cholesky factor.
    let (l_xx, l_yx) = (xx.sqrt(), xy / xx.sqrt());
    let l_yy = (yy - l_yx * l_yx).sqrt();
    let own = rays.regions[(y * rays.width + x) as usize];
    let (mut squares, mut right) = ([[0.0_f64; 3]; 3], [0.0_f64; 3]);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for (i, sample) in rays.samples.iter().enumerate() {
        if rays.regions[i] != own || sample.weight == 0.0 {
            continue;
        }
        let middle = |at: u32| f64::from(at / block * block) + 0.5 * f64::from(block - 1);
        let u = (middle(i as u32 % rays.width) - f64::from(x)) / l_xx;
        let v = (middle(i as u32 / rays.width) - f64::from(y) - l_yx * u) / l_yy;
        let share = weight((u * u + v * v).sqrt()) * f64::from(sample.weight);
        if share == 0.0 {
            continue;
        }
        let value = f64::from(sample.radiance.x) / f64::from(sample.weight);
        (least, most) = (least.min(value), most.max(value));
        let row = [1.0, u, v];
        for i in 0..3 {
            right[i] += share * row[i] * value;
            for j in 0..3 {
                squares[i][j] += share * row[i] * row[j];
            }
        }
    }
    let all = squares[0][0];
    let off = (squares[0][1].powi(2) + squares[0][2].powi(2)) / (all * all);
    squares[1][1] += 0.03 * all;
    squares[2][2] += 0.03 * all;
    let determinant = |m: &[[f64; 3]; 3]| -> f64 {
        (0..3)
            .map(|i| {
                m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3])
            })
            .sum()
    };
    let mut with_right = squares;
    (0..3).for_each(|i| with_right[i][0] = right[i]);
    let fitted = determinant(&with_right) / determinant(&squares);
    // What is left of the weights, at least a tenth, or else the mean counts.
    let minor = squares[1][1] * squares[2][2] - squares[1][2].powi(2);
    let left = determinant(&squares) / minor / all;
    (all > 1e-6 && (left - 0.1).abs() > 1e-3).then(|| {
        let mean = right[0] / all;
        (if left > 0.1 { fitted.clamp(least, most) } else { mean }, off)
    })
}

/// A filter by its standard deviations along its axes and their angle.
pub(super) fn turned(a: f64, b: f64, angle: f64) -> ImageFilter {
    let ((sin, cos), (a, b)) = (angle.sin_cos(), (a * a, b * b));
    ImageFilter {
        xx: (a * cos * cos + b * sin * sin) as f32,
        xy: ((a - b) * sin * cos) as f32,
        yy: (a * sin * sin + b * cos * cos) as f32,
    }
}

/// Pictures of up to 33 x 33 pixels with holes, and regions as stripes, as noise, or one.
pub(super) fn rays() -> impl Strategy<Value = Rays> {
    let shape = (1..34_u32, 1..34_u32, 0..4_u32);
    (shape, any::<u64>(), 0.05..1.0_f64).prop_map(|((width, height, layout), seed, filled)| {
        let mut stream = Stream::new(seed);
        let mut rays = Rays::none(width, height);
        for i in 0..width * height {
            let (x, y) = (i % width, i / width);
            let i = i as usize;
            if stream.uniform() < filled {
                let weight = stream.between(1.0, 20.0) as f32;
                let mut channel = || stream.uniform() as f32 * weight;
                rays.samples[i] = FilmSample {
                    radiance: Vec3::new(channel(), channel(), channel()),
                    weight,
                    ..FilmSample::default()
                };
            }
            rays.regions[i] = match layout {
                0 => 1,
                1 => 1 + (x + 2 * y) / 9,
                2 => 1 + u32::from(x > width / 3) + 2 * u32::from(y > height / 2),
                _ => (stream.uniform() * 3.0) as u32 + 1,
            };
        }
        rays
    })
}

fn filter() -> impl Strategy<Value = ImageFilter> {
    (-1.0..1.2_f64, -1.0..1.2_f64, 0.0..3.15_f64)
        .prop_map(|(a, b, angle)| turned(10f64.powf(a), 10f64.powf(b), angle))
}

proptest! {
    /// Where the filter's centre is the pixel, give or take a tenth of its deviation, also where blocks stand for their pixels. Where it is thinner than 4 pixels, no blocks are taken:
    /// the bounds are one number, reached to rounding: a few thousand terms of f32.
    #[test]
    fn a_pixel_is_the_sum_over_its_region(rays in rays(), filter in filter(), at in (0..33_u32, 0..33_u32)) {
        let (x, y) = (at.0 % rays.width, at.1 % rays.height);
        let is_centred = |block| plane(&rays, x, y, &filter, block).is_some_and(|(_, off)| off < 0.005);
        let is_centred = blocks(&filter).into_iter().all(is_centred);
        if let Some([least, most]) = bounds(&rays, x, y, &filter).filter(|_| is_centred) {
            let found = f64::from(rays.reconstruct(|from| from.pixel(x, y, &filter)).x);
            prop_assert!(least - 2e-5 <= found && found <= most + 2e-5, "{found} outside {least}, {most}");
        }
    }

    /// Where it is not: of filters that take no blocks. Rounding is that of slopes of up to 1/0.03 over a tenth of the weight.
    #[test]
    fn beside_a_border_a_pixel_is_on_the_plane_through_its_region(
        rays in rays(), a in -1.0..0.25_f64, b in -1.0..1.2_f64, angle in 0.0..3.15_f64, at in (0..33_u32, 0..33_u32)
    ) {
        let filter = turned(10f64.powf(a), 10f64.powf(b), angle);
        let (x, y) = (at.0 % rays.width, at.1 % rays.height);
        if let Some((exact, off)) = plane(&rays, x, y, &filter, 1).filter(|(_, off)| (off - 0.01).abs() > 1e-4) {
            let found = f64::from(rays.reconstruct(|from| from.pixel(x, y, &filter)).x);
            if off > 0.01 {
                prop_assert!((found - exact).abs() < 2e-4, "{found}, not {exact}; {off} off");
            }
        }
    }

    #[test]
    fn a_pixel_is_within_the_range_of_what_was_seen(rays in rays(), filter in filter()) {
        let seen = |rays: &Rays| -> Vec<Vec3> {
            let seen = rays.samples.iter().filter(|sample| sample.weight > 0.0);
            seen.map(|sample| sample.radiance / sample.weight).collect()
        };
        let means = seen(&rays);
        let least = means.iter().copied().reduce(Vec3::min).unwrap_or(Vec3::ZERO);
        let most = means.iter().copied().reduce(Vec3::max).unwrap_or(Vec3::ZERO);
        for pixel in rays.picture(&filter) {
            let inside = pixel.cmpge(least - 1e-5).all() && pixel.cmple(most + 1e-5).all();
            prop_assert!(inside, "{pixel} outside {least}, {most}");
        }
    }
}

/// How far blocks are from the truth: bounds above allow for the worst of pictures.
#[test]
fn blocks_are_close_to_the_sum_over_pixels() {
    let mut stream = Stream::new(5);
    let mut rays = Rays::full(129, 129, |_, _| 0.0);
    for sample in &mut rays.samples {
        sample.radiance = Vec3::splat(stream.uniform() as f32);
    }
    for (a, b, angle) in [(4.0, 4.0, 0.0), (8.0, 12.0, 0.7), (16.0, 16.0, 0.0)] {
        let filter = turned(a, b, angle);
        let exact = |x: u32, y: u32| {
            let (mut sum, mut all) = (0.0, 0.0);
            let (a, b, c) =
                (f64::from(filter.xx) + 1.0 / 12.0, f64::from(filter.xy), f64::from(filter.yy) + 1.0 / 12.0);
            for (i, sample) in rays.samples.iter().enumerate() {
                let (dx, dy) =
                    (f64::from(i as u32 % 129) - f64::from(x), f64::from(i as u32 / 129) - f64::from(y));
                let square = (c * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / (a * c - b * b);
                (sum, all) =
                    (sum + weight(square.sqrt()) * f64::from(sample.radiance.x), all + weight(square.sqrt()));
            }
            sum / all
        };
        let places: Vec<[u32; 2]> =
            (0..40).map(|_| [0.0; 2].map(|_: f64| stream.between(48.0, 81.0) as u32)).collect();
        let mut error = 0.0;
        rays.reconstruct(|from| {
            for [x, y] in &places {
                error += (f64::from(from.pixel(*x, *y, &filter).x) - exact(*x, *y)).powi(2) / 40.0;
            }
        });
        let (error, noise) = (error.sqrt(), (12.0 * 4.0 * std::f64::consts::PI * a * b).sqrt().recip());
        println!("{a} x {b}: {error:.5}, noise {noise:.5}");
        // White noise of variance 1/12 is the worst that blocks can be given. A pixel of it strays from 1/2 by that over the filter's
        // 4π sqrt(det H) pixels, in squares; blocks of up to its smallest deviation measured at 0.2 to 0.3 of it.
        assert!(error < 0.4 * noise, "{error} against {noise}");
    }
}

#[test]
fn a_constant_picture_stays_as_it_is() {
    // Sums and products with a power of two do not round otherwise than those of the weights.
    let mut rays = Rays::full(65, 47, |_, _| 0.25);
    let mut stream = Stream::new(6);
    for sample in &mut rays.samples {
        let weight = if stream.uniform() < 0.3 { stream.between(1.0, 9.0) as f32 } else { 0.0 };
        *sample = FilmSample { radiance: Vec3::splat(0.25 * weight), weight, ..FilmSample::default() };
    }
    for filter in
        [turned(0.0, 0.0, 0.0), turned(0.5, 0.5, 0.0), turned(3.0, 11.0, 0.4), turned(30.0, 30.0, 0.0)]
    {
        assert!(rays.picture(&filter).iter().all(|pixel| *pixel == Vec3::splat(0.25)), "{filter:?}");
    }
}

#[test]
fn a_linear_picture_stays_as_it_is_away_from_its_border() {
    let value = |x: u32, y: u32| 3.0 * x as f32 - 2.0 * y as f32 + 700.0;
    let rays = Rays::full(200, 160, value);
    for (filter, reach) in [
        (turned(0.5, 0.5, 0.0), 2),
        (turned(2.0, 7.0, 0.5), 22),
        (turned(5.0, 5.0, 0.0), 16),
        (turned(12.0, 16.0, 1.0), 50),
    ] {
        rays.reconstruct(|from| {
            for (x, y) in
                (reach..200 - reach).step_by(7).flat_map(|x| (reach..160 - reach).map(move |y| (x, y)))
            {
                let found = from.pixel(x, y, &filter).x;
                // Fifty times less than a pixel's worth of the slope: sums over a lattice of a third of the standard deviation, of a Gaussian whose slope
                // jumps at its end.
                let slope = 13.0_f32.sqrt();
                assert!((found - value(x, y)).abs() < 0.02 * slope, "{found} at {x}, {y}, {filter:?}");
            }
        });
    }
}

/// At a border a filter lacks a side: its mean would be that of the light 0.8 standard deviations inside.
#[test]
fn a_slope_goes_on_up_to_the_border_of_a_picture_and_of_a_region() {
    let value = |x: u32, y: u32| 3.0 * x as f32 - 2.0 * y as f32 + 700.0;
    let mut rays = Rays::full(200, 160, value);
    for (i, region) in rays.regions.iter_mut().enumerate() {
        *region = 1 + u32::from(i % 200 >= 90);
    }
    for deviation in [2.0, 5.0, 12.0] {
        let filter = turned(deviation, deviation, 0.0);
        rays.reconstruct(|from| {
            for (x, y) in
                [(0, 80), (89, 80), (90, 80), (199, 80), (40, 0), (150, 159), (0, 0), (199, 159), (1, 2)]
            {
                let found = from.pixel(x, y, &filter).x;
                // A tenth of how far the mean is off.
                let mean_is_off = 0.8 * deviation as f32 * 13.0_f32.sqrt();
                let error = found - value(x, y);
                assert!(error.abs() < 0.1 * mean_is_off, "{error} at {x}, {y}, of {deviation} pixels");
            }
        });
    }
}

#[test]
fn no_light_crosses_a_border_of_regions() {
    let side = |x: u32, y: u32| x + y / 3 >= 20;
    let mut rays = Rays::full(45, 37, |x, y| if side(x, y) { 1048576.0 } else { 1.0 });
    for (i, region) in rays.regions.iter_mut().enumerate() {
        *region = if side(i as u32 % 45, i as u32 / 45) { 1665 } else { 1 };
    }
    // Also from rays far apart: the filter finds the nearest of its own side.
    let mut sparse = rays.clone();
    for (i, sample) in sparse.samples.iter_mut().enumerate() {
        if i % 91 != 0 {
            *sample = FilmSample::default();
        }
    }
    for rays in [rays, sparse] {
        for filter in
            [turned(0.3, 0.3, 0.0), turned(2.0, 2.0, 0.0), turned(6.0, 1.0, 0.3), turned(40.0, 40.0, 0.0)]
        {
            for (i, pixel) in rays.picture(&filter).iter().enumerate() {
                let expected = if side(i as u32 % 45, i as u32 / 45) { 1048576.0 } else { 1.0 };
                assert_eq!(*pixel, Vec3::splat(expected), "pixel {i}, {filter:?}");
            }
        }
    }
}

#[test]
fn a_pixel_at_a_border_keeps_to_its_own_ray_and_gives_it_to_no_other() {
    let mut rays = Rays::full(9, 9, |x, _| if x == 4 { 1024.0 } else { 2.0 });
    for i in 0..81 {
        rays.regions[i] = if i % 9 == 4 { 0 } else { 1 };
    }
    for (i, pixel) in rays.picture(&turned(3.0, 3.0, 0.0)).iter().enumerate() {
        assert_eq!(pixel.x, if i % 9 == 4 { 1024.0 } else { 2.0 });
    }
    // Without one, it takes the nearest there are, of whichever region.
    for i in 0..81 {
        if i % 9 == 4 || i % 9 == 5 {
            rays.samples[i] = FilmSample::default();
        }
    }
    assert_eq!(rays.picture(&turned(3.0, 3.0, 0.0))[4], Vec3::splat(2.0));
}

#[test]
fn a_region_without_rays_takes_the_nearest_of_others() {
    let mut rays = Rays::none(17, 33);
    rays.regions[..17 * 16].fill(18);
    rays.samples[17 * 32] =
        FilmSample { radiance: Vec3::new(2.0, 4.0, 8.0), weight: 2.0, ..FilmSample::default() };
    for filter in [ImageFilter::NONE, turned(2.0, 2.0, 0.0), turned(100.0, 0.0, 0.0)] {
        assert!(rays.picture(&filter).iter().all(|pixel| *pixel == Vec3::new(1.0, 2.0, 4.0)), "{filter:?}");
    }
}

#[test]
fn what_the_nodes_held_does_not_matter_and_their_number_is_that_of_all_blocks() {
    assert_eq!(Reconstruction::node_count(5, 3), 3 * 2 + 2 + 1);
    assert_eq!(Reconstruction::node_count(17, 33), 9 * 17 + 5 * 9 + 3 * 5 + 2 * 3 + 2 + 1);
    assert_eq!(Reconstruction::node_count(1, 1), 0);
    assert_eq!(Reconstruction::node_count(1, 9), 5 + 3 + 2 + 1);
    assert_eq!(Reconstruction::node_count(0, 7), 0);
    let rays = Rays::full(17, 33, |x, y| (x * y) as f32);
    let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(17, 33)];
    let filter = turned(6.0, 6.0, 0.0);
    let mut pixel = || {
        let from = Reconstruction::new(17, 33, &rays.samples, &rays.regions, &mut nodes).unwrap();
        from.pixel(3, 30, &filter)
    };
    let first = pixel();
    assert_eq!(pixel(), first);
}

#[test]
fn slices_of_another_length_and_pictures_too_large_are_refused() {
    let refused = |width, height, samples: usize, regions: usize, nodes: usize| {
        let (samples, regions) = (vec![FilmSample::default(); samples], vec![1; regions]);
        let mut nodes = vec![FilmNode::default(); nodes];
        Reconstruction::new(width, height, &samples, &regions, &mut nodes).err() == Some(FilmSizeError)
    };
    assert!(!refused(5, 3, 15, 15, 9));
    assert!(refused(5, 3, 14, 15, 9) && refused(5, 3, 16, 15, 9));
    assert!(refused(5, 3, 15, 14, 9) && refused(5, 3, 15, 16, 9));
    assert!(refused(5, 3, 15, 15, 8) && refused(5, 3, 15, 15, 10));
    assert!(
        refused(1 << 16, 1 << 16, 0, 0, 0)
            && refused(u32::MAX, u32::MAX, 0, 0, 0)
            && refused(65_537, 0, 0, 0, 0)
    );
}
