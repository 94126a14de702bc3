//! Image space: spectra of pixels, their filters, regions, and the picture.

use super::grids::{Grid, segment};
use super::hard::{Fog, Hard, Voxels};
use super::media::medium;
use super::words::Script;
use covbeam::{
    EyeRay, FilmNode, FilmSample, GridLayout, ImageFilter, ImageSpectrum, PixelStep, Reconstruction, Vec3,
    film_regions, pixel_threshold,
};

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(6);
    script.comment("Image space");
    spectra(script, hard);
    for _ in 0..16 {
        filters(script, hard);
    }
    for (width, height) in [(1, 1), (7, 5), (11, 6)] {
        picture(script, hard, width, height);
    }
}

fn spectra(script: &mut Script, hard: &mut Hard) {
    let (min, max) = (Vec3::splat(-1.0), Vec3::new(1.0, 2.0, 1.5));
    let voxels = Voxels::new(hard, min, max, [4, 3, 2], 2.0);
    script.call("density_new", &[&voxels.layout, &voxels.values], &[]);
    let mut grid = Grid::new(script, GridLayout { min, max, cells: [6, 5, 4] });
    let fogs = [
        Fog::homogeneous(medium(hard)),
        Fog::exponential(medium(hard), hard.point(1.0), hard.direction(), hard.decades(-0.5, 1.0)),
        Fog::voxels(medium(hard), &voxels),
    ];
    let segments: Vec<_> = (0..12).map(|_| segment(hard, 1.0)).collect();
    grid.deposit(script, &fogs[0], &segments);
    grid.resolve(script);
    for fog in &fogs {
        for _ in 0..5 {
            let origin = 3.0 * hard.unit();
            let direction = (hard.point(0.8) - origin).normalize();
            let length = if hard.chance(0.3) { f32::INFINITY } else { hard.decades(-0.5, 1.0) };
            let ray = EyeRay { origin, direction, length };
            let steps = [(); 2].map(|()| PixelStep {
                origin: if hard.chance(0.7) { Vec3::ZERO } else { hard.decades(-4.0, -1.0) * hard.unit() },
                direction: hard.decades(-4.0, -1.0) * hard.unit(),
            });
            let density = fog.density();
            let mut knots = Vec::new();
            density.tabulate(&fog.medium, origin, direction, length, &mut |knot| knots.push(knot));
            let column = density.column(origin, direction, &knots);
            let found = ImageSpectrum::along(&ray, &steps, &grid.fluence(), &fog.medium, &density, &column);
            script.call("image_spectrum_along", &[fog, &ray, &steps], &[&found]);
            filter(script, hard, &found);
        }
    }
}

fn filters(script: &mut Script, hard: &mut Hard) {
    // A covariance, now and then a singular one, or none.
    let (xx, yy) = (hard.decades(-8.0, 2.0), hard.decades(-8.0, 2.0));
    let share = if hard.chance(0.2) { 1.0 } else { hard.between(-1.0, 1.0) };
    let weight = if hard.chance(0.2) { 0.0 } else { hard.decades(-6.0, 2.0) };
    filter(script, hard, &ImageSpectrum { xx, xy: share * (xx * yy).sqrt(), yy, weight });
    let (x, y) = (hard.below(4000), hard.below(4000));
    let (pass, seed) = (hard.below(1 << 20), hard.below(u32::MAX));
    script.call("pixel_threshold", &[&pass, &seed, &x, &y], &[&pixel_threshold(x, y, pass, seed)]);
}

fn filter(script: &mut Script, hard: &mut Hard, spectrum: &ImageSpectrum) {
    let (error, widest) = (hard.decades(-4.0, 0.0), hard.decades(-1.0, 3.0));
    let filter = spectrum.filter(error, widest);
    script.call("image_spectrum_filter", &[spectrum, &error, &widest], &[&filter]);
    script.call("image_filter_density", &[&filter], &[&filter.density()]);
}

fn picture(script: &mut Script, hard: &mut Hard, width: u32, height: u32) {
    let count = (width * height) as usize;
    // Two surfaces with an edge down the middle, the sky above, and a hole.
    let depth: Vec<f32> = (0..width * height)
        .map(|i| match (i % width, i / width) {
            (_, 0) => f32::INFINITY,
            (3, 3) => 0.0,
            (x, y) if x < width / 2 => 2.0 + 0.01 * y as f32,
            _ => 5.0,
        })
        .collect();
    let mut regions = vec![0; count];
    film_regions(width, height, &depth, &mut regions).expect("as many as pixels");
    script.call("film_regions", &[&width, &height, &depth], &[&regions]);
    script.call("reconstruction_new", &[&width, &height], &[]);
    for empty in [0.7, 0.1] {
        let samples: Vec<FilmSample> = (0..count)
            .map(|_| {
                if hard.chance(empty) {
                    return FilmSample::default();
                }
                let weight = hard.decades(0.0, 2.0);
                let radiance = Vec3::from_array([(); 3].map(|()| weight * hard.decades(-3.0, 2.0)));
                FilmSample { radiance, weight, ..FilmSample::default() }
            })
            .collect();
        script.call("reconstruction_update", &[&samples, &regions], &[]);
        let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(width, height)];
        let picture = Reconstruction::new(width, height, &samples, &regions, &mut nodes);
        let picture = picture.expect("as many as pixels");
        for _ in 0..10 {
            let (x, y) = (hard.below(width), hard.below(height));
            let filter = if hard.chance(0.2) {
                ImageFilter::NONE
            } else {
                let (xx, yy) = (hard.decades(-2.0, 2.0), hard.decades(-2.0, 2.0));
                ImageFilter { xx, xy: 0.9 * hard.between(-1.0, 1.0) * (xx * yy).sqrt(), yy }
            };
            script.call("reconstruction_pixel", &[&x, &y, &filter], &[&picture.pixel(x, y, &filter)]);
        }
    }
}
