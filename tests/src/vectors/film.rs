//! Image space: spectra of pixels, their filters, regions, and the picture.

use super::grids::{Grid, segment};
use super::hard::{Fog, Hard, Voxels};
use super::media::medium;
use super::words::{Script, Words};
use covbeam::{
    EyeRay, FILM_TILE, FILM_TILE_PIXELS, FilmEvidence, FilmFilterNode, FilmFilters, FilmLattice, FilmNode,
    FilmPixel, FilmSample, FilmSums, FilmUnit, GridLayout, ImageSpectrum, PixelStep, Reconstruction,
    RegionNode, Vec3, film_regions, part_regions, pixel_threshold, standard_errors, verify_filters,
};

pub(super) fn write(script: &mut Script) {
    let hard = &mut Hard::new(6);
    script.comment("Image space");
    spectra(script, hard);
    for _ in 0..8 {
        filters(script, hard);
    }
    for (width, height) in [(1, 1), (3, 2), (9, 9)] {
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
            let medium = fog.view();
            let mut knots = Vec::new();
            medium.tabulate(origin, direction, length, &mut |knot| knots.push(knot));
            let column = medium.density.column(origin, direction, &knots);
            let found = ImageSpectrum::along(&ray, &steps, &grid.fluence(), &medium, &column);
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
    part_regions(width, height, &depth, &mut regions, &mut vec![RegionNode::default(); count])
        .expect("as many as pixels");
    script.call("film_regions", &[&width, &height, &depth], &[&regions]);
    let typical = hard.decades(-2.0, 2.0);
    script.call("film_new", &[&width, &height, &typical, &regions], &[]);
    let mut film = Film::new(width, height, typical, regions);
    let nodes: Vec<[u32; 2]> = (0..film.lattice.node_count()).map(|node| film.lattice.pixel(node)).collect();
    script.call("film_nodes", &[], &[&nodes]);
    for pass in [2, 1] {
        film.plan(script, hard, pass);
        film.add(script, hard, pass, typical);
        film.picture(script, pass);
    }
}

/// The samples of a picture, as a host keeps them.
struct Film {
    lattice: FilmLattice,
    unit: FilmUnit,
    regions: Vec<u32>,
    volume: Vec<FilmSums>,
    rest: Vec<FilmSums>,
    expected: Vec<f64>,
    density: Vec<f32>,
    planned: Vec<FilmFilterNode>,
    /// Of the pass with the largest number.
    latest: (u32, Vec<FilmFilterNode>),
}

struct Ray {
    pixel: [u32; 2],
    has: [bool; 2],
    light: [Vec3; 2],
}

impl Words for Ray {
    fn append(&self, line: &mut String) {
        self.pixel.append(line);
        self.has.append(line);
        self.light.append(line);
    }
}

impl Film {
    fn new(width: u32, height: u32, typical: f32, regions: Vec<u32>) -> Self {
        let lattice = FilmLattice::new(width, height).expect("small");
        let none = vec![FilmSums::default(); regions.len()];
        Self {
            lattice,
            unit: FilmUnit::new(typical),
            volume: none.clone(),
            rest: none,
            expected: vec![0.0; regions.len()],
            density: Vec::new(),
            planned: Vec::new(),
            latest: (0, Vec::new()),
            regions,
        }
    }

    fn plan(&mut self, script: &mut Script, hard: &mut Hard, pass: u32) {
        let count = self.lattice.node_count();
        let spectra: Vec<ImageSpectrum> = (0..count)
            .map(|_| {
                let (xx, yy) = (hard.decades(-6.0, 0.0), hard.decades(-6.0, 0.0));
                let xy = 0.9 * hard.between(-1.0, 1.0) * (xx * yy).sqrt();
                let weight = if hard.chance(0.1) { 0.0 } else { hard.decades(-3.0, 0.0) };
                ImageSpectrum { xx, xy, yy, weight }
            })
            .collect();
        let (error, paths) = (hard.decades(-3.0, 0.0), hard.below(100));
        let mut nodes = vec![FilmFilterNode::default(); count];
        let filters = FilmFilters::new(self.lattice, &self.regions, &spectra, error, &mut nodes);
        let (filters, least) = (filters.expect("as many as pixels"), self.lattice.least_density(paths));
        let width = self.lattice.width as usize;
        self.density = (0..self.regions.len())
            .map(|i| filters.filter((i % width) as u32, (i / width) as u32).density().max(least))
            .collect();
        script.call("film_plan", &[&pass, &error, &paths, &spectra], &[]);
        script.call("film_density", &[], &[&self.density]);
        self.planned = nodes;
    }

    fn add(&mut self, script: &mut Script, hard: &mut Hard, pass: u32, typical: f32) {
        let mut rays = Vec::new();
        for (i, density) in self.density.iter().enumerate() {
            self.expected[i] += (f64::from(*density) * 4_294_967_296.0).round_ties_even();
            let has = [hard.chance(f64::from(*density)), hard.chance(0.2)];
            let light = [(); 2].map(|()| typical * hard.decades(-3.0, 3.0) * Vec3::new(1.0, 0.5, 0.0));
            let pixel = [i as u32 % self.lattice.width, i as u32 / self.lattice.width];
            for (sums, (has, light)) in
                [&mut self.volume, &mut self.rest].into_iter().zip(has.into_iter().zip(light))
            {
                if has {
                    sums[i].add(&self.unit, light, pass % 2 == 1);
                }
            }
            if has[0] || has[1] {
                rays.push(Ray { pixel, has, light });
            }
        }
        script.call("film_add", &[&rays], &[]);
        if self.latest.0 < pass {
            self.latest = (pass, self.planned.clone());
        }
    }

    fn picture(&self, script: &mut Script, pass: u32) {
        let FilmLattice { width, height, .. } = self.lattice;
        let volume: Vec<FilmSample> = self
            .volume
            .iter()
            .zip(&self.expected)
            .map(|(sums, expected)| sums.sample(&self.unit, expected / 4_294_967_296.0))
            .collect();
        let rest: Vec<FilmSample> =
            self.rest.iter().map(|sums| sums.sample(&self.unit, f64::from(sums.rays()))).collect();
        let blocks = || vec![FilmNode::default(); Reconstruction::node_count(width, height)];
        let (mut of_volume, mut of_rest) = (blocks(), blocks());
        let fits = "as many as pixels";
        let volume = Reconstruction::new(width, height, &volume, &self.regions, &mut of_volume).expect(fits);
        let around = Reconstruction::new(width, height, &rest, &self.regions, &mut of_rest).expect(fits);
        let mut nodes = self.latest.1.clone();
        let filters = FilmFilters::of(self.lattice, &self.regions, &self.latest.1).expect(fits);
        let evidence: Vec<FilmEvidence> =
            (0..nodes.len()).map(|node| filters.evidence(node, &volume)).collect();
        verify_filters(&self.lattice, &evidence, &mut nodes).expect(fits);
        let filters = FilmFilters::of(self.lattice, &self.regions, &nodes).expect(fits);
        let (mut all, mut fog) = (vec![FilmPixel::default(); rest.len()], vec![Vec3::ZERO; rest.len()]);
        let mut tile = [FilmPixel::default(); FILM_TILE_PIXELS];
        for (x, y) in (0..width * height).map(|i| (i % width, i / width)) {
            let step = FILM_TILE;
            if x % step == 0 && y % step == 0 {
                volume.tile(x, y, &filters, &mut tile);
                for (i, pixel) in tile.iter().enumerate() {
                    let (x, y) = (x + i as u32 % step, y + i as u32 / step);
                    if x < width && y < height {
                        all[(y * width + x) as usize] = *pixel;
                    }
                }
            }
        }
        for (i, (pixel, own)) in all.iter_mut().zip(&rest).enumerate() {
            fog[i] = pixel.radiance;
            if own.weight > 0.0 {
                pixel.radiance += own.radiance / own.weight;
                pixel.difference += own.halves().map_or(0.0, |[odd, even]| odd - even);
            } else {
                pixel.radiance += around.nearby(i as u32 % width, i as u32 / width);
            }
        }
        let mut line = String::new();
        for (pixel, fog) in all.iter().zip(&fog) {
            let FilmPixel { radiance, variance, difference } = pixel;
            let parts: [&dyn Words; 4] = [radiance, fog, variance, difference];
            parts.iter().for_each(|part| part.append(&mut line));
        }
        script.call("film_picture", &[], &[&Appended(line)]);
        if pass == 1 {
            let mut errors = vec![0.0; all.len()];
            standard_errors(width, height, &all, 0, &mut errors).expect(fits);
            script.call("film_errors", &[&width, &height, &all], &[&errors]);
        }
    }
}

/// Words as they are.
struct Appended(String);

impl Words for Appended {
    fn append(&self, line: &mut String) {
        line.push_str(&self.0);
    }
}
