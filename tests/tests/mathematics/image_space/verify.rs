//! Sums over passes, what they say of the filters, tiles, and standard errors.

use covbeam::{
    FILM_TILE, FILM_TILE_PIXELS, FilmEvidence, FilmFilterNode, FilmFilters, FilmLattice, FilmNode, FilmPixel,
    FilmSample, FilmSums, FilmUnit, ImageFilter, ImageSpectrum, Reconstruction, Vec3, standard_errors,
    verify_filters,
};
use covbeam_tests::random::Stream;
use std::f64::consts::PI;

const SIDE: u32 = 129;
const PIXELS: usize = (SIDE * SIDE) as usize;

/// Of a normal distribution.
fn normal(stream: &mut Stream) -> f64 {
    (-2.0 * (1.0 - stream.uniform()).ln()).sqrt() * (2.0 * PI * stream.uniform()).cos()
}

/// A picture of passes with an eye ray a pixel each, whose filters are predicted as wide as can be.
struct Film {
    lattice: FilmLattice,
    regions: Vec<u32>,
    samples: Vec<FilmSample>,
    nodes: Vec<FilmFilterNode>,
}

impl Film {
    fn new(passes: u32, mut seen: impl FnMut(u32, u32) -> f64) -> Self {
        let lattice = FilmLattice::new(SIDE, SIDE).unwrap();
        let unit = FilmUnit::new(1.0);
        let mut sums = vec![FilmSums::default(); PIXELS];
        for pass in 1..=passes {
            for (i, sums) in sums.iter_mut().enumerate() {
                let value = seen(i as u32 % SIDE, i as u32 / SIDE);
                sums.add(&unit, Vec3::splat(value as f32), pass % 2 == 1);
            }
        }
        let samples = sums.iter().map(|sums| sums.sample(&unit, passes.into())).collect();
        let regions = vec![1; PIXELS];
        let mut nodes = vec![FilmFilterNode::default(); lattice.node_count()];
        let spectra = vec![ImageSpectrum { weight: 1.0, ..ImageSpectrum::default() }; nodes.len()];
        FilmFilters::new(lattice, &regions, &spectra, 0.01, &mut nodes).unwrap();
        Self { lattice, regions, samples, nodes }
    }

    fn look<R>(&self, nodes: &[FilmFilterNode], look: impl FnOnce(&Reconstruction, &FilmFilters) -> R) -> R {
        let mut blocks = vec![FilmNode::default(); Reconstruction::node_count(SIDE, SIDE)];
        let picture = Reconstruction::new(SIDE, SIDE, &self.samples, &self.regions, &mut blocks).unwrap();
        look(&picture, &FilmFilters::of(self.lattice, &self.regions, nodes).unwrap())
    }

    fn evidence(&self) -> Vec<FilmEvidence> {
        self.look(&self.nodes, |picture, filters| {
            (0..self.nodes.len()).map(|node| filters.evidence(node, picture)).collect()
        })
    }

    fn verified(&self) -> Vec<FilmFilterNode> {
        let mut nodes = self.nodes.clone();
        verify_filters(&self.lattice, &self.evidence(), &mut nodes).unwrap();
        nodes
    }

    fn picture(&self, nodes: &[FilmFilterNode]) -> Vec<FilmPixel> {
        self.look(nodes, |picture, filters| {
            let mut pixels = vec![FilmPixel::default(); PIXELS];
            let mut tile = [FilmPixel::default(); FILM_TILE_PIXELS];
            for (left, top) in (0..SIDE).step_by(8).flat_map(|x| (0..SIDE).step_by(8).map(move |y| (x, y))) {
                picture.tile(left, top, filters, &mut tile);
                for (i, pixel) in tile.iter().enumerate() {
                    let (x, y) = (left + i as u32 % FILM_TILE, top + i as u32 / FILM_TILE);
                    if x < SIDE && y < SIDE {
                        pixels[(y * SIDE + x) as usize] = *pixel;
                    }
                }
            }
            pixels
        })
    }
}

/// How many times as wide as predicted a node's filter is.
fn shares(film: &Film, nodes: &[FilmFilterNode]) -> Vec<f32> {
    let found = |nodes: &[FilmFilterNode]| -> Vec<f32> {
        film.look(nodes, |_, filters| {
            let pixels = (0..nodes.len()).map(|node| film.lattice.pixel(node));
            pixels.map(|[x, y]| filters.filter(x, y).xx.sqrt()).collect()
        })
    };
    found(nodes).iter().zip(found(&film.nodes)).map(|(found, predicted)| found / predicted).collect()
}

#[test]
fn even_light_keeps_its_filters_however_noisy() {
    for noise in [0.02, 0.3] {
        let (mut narrowed, mut all, mut ratio) = (0, 0, 0.0);
        for seed in 0..6 {
            let mut stream = Stream::new(100 + seed);
            let film = Film::new(6, |_, _| 1.0 + noise * normal(&mut stream));
            let nodes = film.verified();
            let shares = shares(&film, &nodes);
            narrowed += shares.iter().filter(|share| **share < 0.9).count();
            all += shares.len();
            // The stated variance against how far the picture strays.
            let picture = film.picture(&nodes);
            let stated: f64 = picture.iter().map(|pixel| f64::from(pixel.variance)).sum();
            let truly: f64 = picture.iter().map(|pixel| f64::from(pixel.radiance.x - 1.0).powi(2)).sum();
            ratio += truly / stated / 6.0;
        }
        println!("noise {noise}: {narrowed} of {all} narrowed, true variance over stated {ratio:.2}");
        // A few in a hundred by chance: two and a half variances, over some ten independent nodes, of six widths.
        assert!(narrowed * 25 < all, "{narrowed} of {all}");
        // Twenty filters beside each other fit in a picture, so six of them stray by .13; three of those.
        assert!((0.6..1.4).contains(&ratio), "{ratio}");
    }
}

/// A pixel that is bright in both halves by chance is what beams, whose brightness has no bound, do now and then; were it light, more nodes
/// than one would have seen it.
#[test]
fn what_one_node_alone_says_narrows_no_filter() {
    let mut stream = Stream::new(300);
    let mut rays = 0;
    let lattice = FilmLattice::new(SIDE, SIDE).unwrap();
    let bright = lattice.pixel(lattice.node_count() / 2);
    let film = Film::new(6, |x, y| {
        rays += 1;
        if [x, y] == bright { 6.0 } else { 1.0 + 0.3 * normal(&mut stream) }
    });
    let shares = shares(&film, &film.verified());
    let narrowed = shares.iter().filter(|share| **share < 0.9).count();
    assert!(narrowed * 25 < shares.len(), "{narrowed} of {}", shares.len());
}

/// But at the picture's border a node may be the only one whose filter reaches a light: what it finds in both halves alike is believed.
#[test]
fn what_a_node_at_the_border_finds_alike_in_both_halves_narrows_its_filter() {
    let film = Film::new(1, |_, _| 1.0);
    let across = SIDE.div_ceil(film.lattice.pixel(1)[0]) as usize;
    let is_narrowed_beside = |node: usize, halves: [f32; 2], none: &[usize]| {
        let even = FilmEvidence { first: [1.0; 7], second: [1.0; 7], brightness: 1.0 };
        let mut evidence = vec![even; film.nodes.len()];
        evidence[node].first[0] = halves[0];
        evidence[node].second[0] = halves[1];
        evidence[node].brightness = 0.5 * (halves[0] + halves[1]);
        let mut nodes = film.nodes.clone();
        none.iter().for_each(|node| nodes[*node] = FilmFilterNode::default());
        let before = nodes[node];
        verify_filters(&film.lattice, &evidence, &mut nodes).unwrap();
        nodes[node].to_words()[..3] != before.to_words()[..3]
    };
    let is_narrowed = |node, halves| is_narrowed_beside(node, halves, &[]);
    let (border, inside) = (20, 20 * across + 20);
    assert!(is_narrowed(border, [10.0, 10.5]));
    // By chance, and where other nodes would have seen it too.
    assert!(!is_narrowed(border, [10.0, 3.0]));
    assert!(!is_narrowed(inside, [10.0, 10.5]));
    // The border of a medium is one, too: the nodes beside see none, and none of them could have seen it.
    assert!(is_narrowed_beside(inside, [10.0, 12.0], &[inside - 1]));
    assert!(!is_narrowed_beside(inside, [10.0, 3.0], &[inside - 1]));
}

/// Beams' noise lies across many nodes: where both halves have the same by chance, all of a window says that the light is uneven.
#[test]
fn noise_across_many_nodes_leaves_no_patch_unfiltered() {
    let (mut bare, mut all) = (0, 0);
    for seed in 0..6 {
        let mut stream = Stream::new(200 + seed);
        // Streaks like a beam's of each pass: eight of 3 by 24 pixels on an even background, each as bright as it.
        let passes = 6;
        let streaks: Vec<Vec<_>> = (0..passes)
            .map(|_| (0..8).map(|_| std::array::from_fn(|_| stream.between(0.0, SIDE.into()))).collect())
            .collect();
        let mut rays = 0;
        let film = Film::new(passes, |x, y| {
            let pass: &Vec<[f64; 3]> = &streaks[rays / PIXELS];
            rays += 1;
            let streak = |at: &[f64; 3]| {
                let (sin, cos) = (at[2] * PI / f64::from(SIDE)).sin_cos();
                let (x, y) = (f64::from(x) - at[0], f64::from(y) - at[1]);
                let (along, across) = ((cos * x + sin * y) / 24.0, (cos * y - sin * x) / 3.0);
                (-0.5 * (along * along + across * across)).exp()
            };
            1.0 + pass.iter().map(streak).sum::<f64>()
        });
        let shares = shares(&film, &film.verified());
        bare += shares.iter().filter(|share| **share < 0.3).count();
        all += shares.len();
    }
    println!("streaks: {bare} of {all} bare");
    // A quarter as wide or less, where nothing is to be seen but noise: one in a thousand.
    assert!(bare * 1000 < all, "{bare} of {all}");
}

#[test]
fn beside_a_step_filters_narrow_until_they_see_no_more_than_noise() {
    let mut stream = Stream::new(7);
    let truth = |x: u32| if x < SIDE / 2 { 1.0 } else { 4.0 };
    let film = Film::new(8, |x, _| truth(x) * (1.0 + 0.2 * normal(&mut stream)));
    let nodes = film.verified();
    let shares = shares(&film, &nodes);
    let edge = f64::from(SIDE / 2);
    for (node, share) in shares.iter().enumerate() {
        let distance = (f64::from(film.lattice.pixel(node)[0]) - edge).abs();
        // What is nearer than a standard deviation, 8 pixels, is wrong by a third of the step.
        assert!(distance > 6.0 || *share < 0.6, "{share} at {distance}");
    }
    // Means over columns, in which chance is small: 129 rows.
    let (before, after) = (film.picture(&film.nodes), film.picture(&nodes));
    let column = |picture: &[FilmPixel], x: u32| {
        let values = (0..SIDE).map(|y| f64::from(picture[(y * SIDE + x) as usize].radiance.x));
        (values.sum::<f64>() / f64::from(SIDE) / truth(x) - 1.0).abs()
    };
    let (mut worst_before, mut worst_after) = (0.0_f64, 0.0_f64);
    for x in (0..SIDE).filter(|x| (f64::from(*x) + 0.5 - edge).abs() > 4.0) {
        worst_before = worst_before.max(column(&before, x));
        worst_after = worst_after.max(column(&after, x));
    }
    println!("beyond 4 pixels: off by {worst_before:.3} as predicted, {worst_after:.3} verified");
    // Half of the step reaches the darker side at the edge itself; four pixels away, .31 of it, which is .9 of what is there.
    assert!(worst_before > 0.5 && worst_after < 0.05, "{worst_before}, {worst_after}");
}

/// Straight light of a picture in two layers that ends at a border, beyond which one ray in 300 meets some; other light is everywhere.
#[test]
fn a_layer_of_next_to_no_light_does_not_leak_into_that_of_others() {
    const OTHERS: f64 = 0.05;
    let edge = SIDE / 2;
    let (mut alone, mut beside) = (0.0, 0.0);
    let seeds = 8;
    for seed in 0..seeds {
        let mut stream = Stream::new(400 + seed);
        let film = Film::new(6, |x, _| match x >= edge {
            true => 0.2 * (1.0 + 0.1 * normal(&mut stream)).max(0.0),
            false => 0.5 * f64::from(u8::from(stream.uniform() < 1.0 / 300.0)),
        });
        // Of the light seen from 4 to 12 pixels beyond the border, that which filters bring there.
        let leak = |evidence: &[FilmEvidence]| {
            let mut nodes = film.nodes.clone();
            verify_filters(&film.lattice, evidence, &mut nodes).unwrap();
            let picture = film.picture(&nodes);
            let columns = (edge - 12..edge - 4).flat_map(|x| (0..SIDE).map(move |y| (y * SIDE + x) as usize));
            let excess =
                columns.map(|pixel| f64::from(picture[pixel].radiance.x - film.samples[pixel].radiance.x));
            excess.sum::<f64>() / f64::from(8 * SIDE) / OTHERS / seeds as f64
        };
        let evidence = film.evidence();
        alone += leak(&evidence);
        beside += leak(&evidence.iter().map(|found| found.beside(OTHERS as f32)).collect::<Vec<_>>());
    }
    println!(
        "leaked, over the light there: {alone:.3} by evidence of its own, {beside:.3} beside the others"
    );
    assert!(alone > 0.02 && beside < 0.002, "{alone}, {beside}");
}

#[test]
fn a_layer_beside_others_states_the_same_variance() {
    let mut stream = Stream::new(11);
    let film = Film::new(6, |_, _| 1.0 + 0.3 * normal(&mut stream));
    let variance = |others: f32| {
        let evidence: Vec<_> = film.evidence().iter().map(|found| found.beside(others)).collect();
        let mut nodes = film.nodes.clone();
        verify_filters(&film.lattice, &evidence, &mut nodes).unwrap();
        film.picture(&nodes).iter().map(|pixel| f64::from(pixel.variance)).sum::<f64>()
    };
    // A variance is of a layer's light, whatever else is seen there; a negative light is none.
    let [alone, dim, bright, negative] = [0.0, 0.3, 30.0, -30.0].map(variance);
    println!("variance {alone:.4} alone, {dim:.4}, {bright:.4} beside others");
    assert!((dim / alone - 1.0).abs() < 0.05 && (bright / alone - 1.0).abs() < 0.05);
    assert_eq!(alone, negative);
    assert_eq!(FilmEvidence::default().beside(1.0), FilmEvidence::default());
}

#[test]
fn the_halves_may_be_exchanged() {
    let mut stream = Stream::new(8);
    let film = Film::new(4, |x, y| (1.0 + f64::from(x * y) / 4e3) * (1.0 + 0.5 * normal(&mut stream)));
    let evidence = film.evidence();
    let turned: Vec<_> = evidence
        .iter()
        .map(|found| FilmEvidence { first: found.second, second: found.first, ..*found })
        .collect();
    let (mut a, mut b) = (film.nodes.clone(), film.nodes.clone());
    verify_filters(&film.lattice, &evidence, &mut a).unwrap();
    verify_filters(&film.lattice, &turned, &mut b).unwrap();
    assert_eq!(a, b);
    assert_ne!(a, film.nodes);
    assert!(verify_filters(&film.lattice, &evidence[1..], &mut a).is_err());
    assert!(verify_filters(&film.lattice, &evidence, &mut a[1..]).is_err());
}

/// One pass alone, black pictures, a lit pixel, radiance at the limits of floats, NaN in a half.
#[test]
fn no_picture_makes_a_nan() {
    let scales = [1e-30, 1e-20, 1e-10, 1.0, 1e10, 1e20, 1e25];
    for scale in scales {
        let mut stream = Stream::new(9);
        let mut film = Film::new(2, |_, _| 1.0 + 0.2 * normal(&mut stream));
        for sample in &mut film.samples {
            sample.radiance *= scale;
            sample.first *= scale;
        }
        film.samples[700].first = f32::NAN;
        film.samples[900].first_weight = f32::INFINITY;
        for pixel in film.picture(&film.verified()) {
            assert!(
                pixel.radiance.is_finite() && pixel.variance >= 0.0 && pixel.difference.is_finite(),
                "{pixel:?} at {scale}"
            );
        }
    }
    let lit = |at: u32| move |x: u32, y: u32| f64::from(u8::from((x, y) == (at, at)));
    for film in
        [Film::new(1, |_, _| 1.0), Film::new(4, |_, _| 0.0), Film::new(4, lit(64)), Film::new(2, lit(0))]
    {
        for pixel in film.picture(&film.verified()) {
            assert!(
                pixel.radiance.is_finite() && pixel.variance >= 0.0 && pixel.difference.is_finite(),
                "{pixel:?}"
            );
        }
    }
}

#[test]
fn groups_of_sums_in_any_order_through_words_are_the_sums_of_all() {
    let mut stream = Stream::new(11);
    let unit = FilmUnit::new(0.3);
    // Up to where sums stop at the largest number.
    let rays: Vec<Vec3> =
        (0..60).map(|_| Vec3::splat(10f32.powf(stream.between(-6.0, 9.5) as f32))).collect();
    let sum = |rays: &[Vec3]| {
        let mut sums = FilmSums::default();
        rays.iter().enumerate().for_each(|(i, ray)| sums.add(&unit, *ray, i % 2 == 0));
        sums
    };
    let all = sum(&rays);
    for cut in [2, 20, 58] {
        let (first, second) = rays.split_at(cut);
        let [a, b] = [sum(first), sum(second)].map(|sums| FilmSums::from_words(sums.to_words()).unwrap());
        let (mut ab, mut ba) = (a, b);
        ab.merge(&b);
        ba.merge(&a);
        assert_eq!((ab, ba), (all, all), "{cut}");
    }
    let [red, _, _, first, rays, first_rays] = all.to_words();
    assert_eq!((red, rays, first_rays), (i64::MAX as u64, 60, 30));
    assert!(first > 0);
    let one = [1, 2, 3, 4, 6, 5];
    assert_eq!(FilmSums::from_words(one).unwrap().to_words(), one);
    for (place, word) in [(0, 1 << 63), (3, u64::MAX), (4, 1 << 32), (4, 4), (5, 7)] {
        let mut words = one;
        words[place] = word;
        assert_eq!(FilmSums::from_words(words), None, "{words:?}");
    }
}

#[test]
fn sums_do_not_depend_on_the_order_and_know_their_halves() {
    let mut stream = Stream::new(10);
    let unit = FilmUnit::new(3.0);
    let rays: Vec<(Vec3, bool)> = (0..500)
        .map(|i| (10f32.powf(stream.between(-4.0, 4.0) as f32) * Vec3::new(1.0, 0.5, 0.25), i % 3 == 0))
        .collect();
    let sum = |rays: &mut dyn Iterator<Item = &(Vec3, bool)>| {
        let mut sums = FilmSums::default();
        rays.for_each(|(radiance, odd)| sums.add(&unit, *radiance, *odd));
        sums
    };
    let sums = sum(&mut rays.iter());
    assert_eq!(sums, sum(&mut rays.iter().rev()));
    assert_eq!(sums, sum(&mut rays.iter().skip(123).chain(&rays[..123])));
    assert_eq!(sums.rays(), 500);
    let total = |odd: Option<bool>| -> f64 {
        let of = rays.iter().filter(|ray| odd.is_none_or(|odd| ray.1 == odd));
        of.map(|ray| f64::from(ray.0.x)).sum()
    };
    let sample = sums.sample(&unit, 250.0);
    // Of each ray half a unit of 2⁻³¹, and a rounding of the result.
    assert!((f64::from(sample.radiance.x) / (total(None) / 250.0) - 1.0).abs() < 2e-7);
    assert_eq!((sample.weight, sample.first_weight), (2.0, 167.0 / 250.0));
    // Rec. 709; what is left of the difference of two sums in f32, of which the even half is a good part.
    let luminance = 0.2126 + 0.5 * 0.7152 + 0.25 * 0.0722;
    let [odd, even] = sample.halves().unwrap();
    assert!((f64::from(odd) / (luminance * total(Some(true)) / 167.0) - 1.0).abs() < 1e-5);
    assert!((f64::from(even) / (luminance * total(Some(false)) / 333.0) - 1.0).abs() < 1e-5);
    assert_eq!(sum(&mut rays.iter().filter(|ray| ray.1)).sample(&unit, 1.0).halves(), None);
    assert_eq!(FilmSample::default().halves(), None);

    let mut bad = sums;
    for value in [f32::NAN, -1.0, f32::NEG_INFINITY] {
        bad.add(&unit, Vec3::splat(value), true);
    }
    assert_eq!(bad.sample(&unit, 250.0).radiance, sample.radiance);
    bad.add(&unit, Vec3::splat(f32::INFINITY), true);
    assert!(bad.sample(&unit, 250.0).radiance.is_finite());
    for expected in [0.0, -1.0, f64::NAN] {
        assert_eq!(sums.sample(&unit, expected), FilmSample::default());
    }
    for typical in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(FilmUnit::new(typical), FilmUnit::new(1.0));
    }
}

#[test]
fn the_unit_is_a_power_of_two_below_what_is_typical() {
    // 2 is the power of two below 3.
    let unit = FilmUnit::new(3.0);
    assert_eq!([0.0, 1.0, 2.0, 1e-30].map(|radiance| unit.whole(radiance)), [0, 1 << 31, 1 << 32, 0]);
    assert_eq!(unit.whole(f32::INFINITY), i64::MAX);
    assert_eq!(unit.whole(f32::NAN), 0);
}

#[test]
fn a_tile_is_its_pixels() {
    let mut stream = Stream::new(11);
    let film = Film::new(1, |_, _| stream.uniform());
    film.look(&film.nodes, |picture, filters| {
        let (mut worst, mut squares) = (0.0_f32, 0.0_f32);
        let pixels = film.picture(&film.nodes);
        for (x, y) in (0..SIDE).flat_map(|x| (0..SIDE).map(move |y| (x, y))) {
            let exact = picture.pixel(x, y, &filters.filter(x, y)).x;
            let off = pixels[(y * SIDE + x) as usize].radiance.x - exact;
            (worst, squares) = (worst.max(off.abs()), squares + off * off);
        }
        let rms = (squares / PIXELS as f32).sqrt();
        println!("interpolated: rms {rms:.5}, worst {worst:.5}");
        // Bilinear over a step h: h²/8 x the second derivatives along both axes, each at most 2 φ(1)/σ² x the range of a picture through a
        // Gaussian; h is at most σ. White noise of variance 1/12 through it strays by 1/(σ sqrt(48 π)) = .010 for σ = 8: a fifth of it.
        assert!(worst < 0.122 && rms < 0.002, "{worst}, {rms}");
    });
    // Where a filter is none, or the picture ends, nothing is interpolated; outside, nothing is written.
    let none = vec![FilmFilterNode::default(); film.nodes.len()];
    film.look(&none, |picture, filters| {
        let mut tile = [FilmPixel { variance: -1.0, ..FilmPixel::default() }; FILM_TILE_PIXELS];
        picture.tile(128, 0, filters, &mut tile);
        for (i, pixel) in tile.iter().enumerate() {
            let expected = picture.pixel(128, i as u32 / 8, &ImageFilter::NONE).x;
            let written = if i % 8 == 0 { (expected, 0.0) } else { (0.0, -1.0) };
            assert_eq!((pixel.radiance.x, pixel.variance), written);
        }
    });
}

#[test]
fn light_of_one_region_does_not_reach_the_tiles_of_another() {
    let mut film = Film::new(2, |x, _| if x < 60 { 1.0 } else { 8.0 });
    for (i, region) in film.regions.iter_mut().enumerate() {
        *region = if i as u32 % SIDE < 60 { 1 } else { 61 };
    }
    let spectra = vec![ImageSpectrum { weight: 1.0, ..ImageSpectrum::default() }; film.nodes.len()];
    let mut nodes = film.nodes.clone();
    FilmFilters::new(film.lattice, &film.regions, &spectra, 0.01, &mut nodes).unwrap();
    film.nodes = nodes;
    for (i, pixel) in film.picture(&film.verified()).iter().enumerate() {
        let expected = if i as u32 % SIDE < 60 { 1.0 } else { 8.0 };
        // Sums of equal numbers, and shares that add up to 1, to rounding.
        assert!((pixel.radiance.x / expected - 1.0).abs() < 1e-5, "{i}: {}", pixel.radiance.x);
    }
}

#[test]
fn a_pixel_without_rays_takes_the_mean_of_the_smallest_block_that_has_some() {
    let (mut samples, mut regions) = ([FilmSample::default(); 64], [1; 64]);
    let lit = |value: f32| FilmSample { radiance: Vec3::splat(value), weight: 1.0, ..FilmSample::default() };
    (samples[9], samples[26]) = (lit(4.0), lit(2.0));
    regions[63] = 5;
    let mut blocks = vec![FilmNode::default(); Reconstruction::node_count(8, 8)];
    let picture = Reconstruction::new(8, 8, &samples, &regions, &mut blocks).unwrap();
    // (1, 1) lies in the block of (0, 0), (2, 3) in that of 4 x 4; the whole picture has two regions.
    assert_eq!(picture.nearby(0, 0), Vec3::splat(4.0));
    assert_eq!(picture.nearby(3, 2), Vec3::splat(2.0));
    assert_eq!(picture.nearby(3, 0), Vec3::splat(3.0));
    for (x, y) in [(7, 7), (7, 0)] {
        assert_eq!(picture.nearby(x, y), picture.pixel(x, y, &ImageFilter::NONE));
    }
    assert_eq!(picture.nearby(8, 0), Vec3::ZERO);
}

#[test]
fn the_standard_error_is_that_of_the_mean_of_the_halves() {
    let mut stream = Stream::new(12);
    // Halves that are apart by 2 in the mean of squares are each off by sqrt 2, and their mean by 1; and 3 from the filtered light.
    let pixels: Vec<FilmPixel> = (0..96 * 64)
        .map(|_| FilmPixel {
            difference: (2.0 * normal(&mut stream)) as f32,
            variance: 3.0,
            ..FilmPixel::default()
        })
        .collect();
    let mut errors = vec![0.0; pixels.len()];
    standard_errors(96, 64, &pixels, 0, &mut errors).unwrap();
    let mean = errors.iter().map(|error| f64::from(error * error)).sum::<f64>() / 6144.0;
    // sqrt(2/6144) = .018; five of them.
    assert!((mean - 4.0).abs() < 0.09, "{mean}");
    // 25 squared normal numbers: .28 of the 1.
    let spread = errors.iter().map(|error| (f64::from(error * error) - mean).powi(2)).sum::<f64>() / 6144.0;
    assert!((0.2..0.4).contains(&spread.sqrt()), "{spread}");
    let mut rows = vec![0.0; 96 * 7];
    standard_errors(96, 64, &pixels, 30, &mut rows).unwrap();
    assert_eq!(rows, errors[96 * 30..96 * 37]);
    for (width, height, first, count) in [(96, 63, 0, 96), (96, 64, 64, 96), (96, 64, 0, 95), (0, 0, 0, 0)] {
        assert!(standard_errors(width, height, &pixels, first, &mut vec![0.0; count]).is_err());
    }
}

/// Stripes with silhouettes between them, each with light of its own: blocks hold many regions, and some share a bit.
#[test]
fn stripes_keep_to_their_own_light_and_silhouettes_to_theirs() {
    let region = |x: u32, y: u32| if x % 12 == 11 { 0 } else { 1 + x / 12 + 11 * (y / 20) };
    let light = |x: u32, y: u32| match region(x, y) {
        0 => 1000.0 + f64::from(x + 7 * y),
        region => f64::from(region),
    };
    let mut film = Film::new(2, light);
    film.regions = (0..PIXELS as u32).map(|i| region(i % SIDE, i / SIDE)).collect();
    let spectra = vec![ImageSpectrum { weight: 1.0, ..ImageSpectrum::default() }; film.nodes.len()];
    let mut nodes = film.nodes.clone();
    FilmFilters::new(film.lattice, &film.regions, &spectra, 0.01, &mut nodes).unwrap();
    film.nodes = nodes;
    let mut filtered = 0;
    film.look(&film.nodes, |_, filters| {
        for (i, pixel) in film.picture(&film.nodes).iter().enumerate() {
            let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
            filtered += u32::from(filters.filter(x, y).xx > 4.0);
            let expected = light(x, y) as f32;
            // Sums of equal numbers, and shares that add up to 1, to rounding.
            assert!((pixel.radiance.x / expected - 1.0).abs() < 1e-5, "{x}, {y}: {}", pixel.radiance.x);
        }
    });
    assert!(filtered > PIXELS as u32 / 2, "{filtered} pixels have a filter");
}
