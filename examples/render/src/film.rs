//! What the passes add up to, with the same bits in whatever order they come.

mod stored;

pub use stored::FilmLayout;
pub(crate) use stored::Unfit;

use crate::compare::luminance;
use crate::kind::{ByKind, Kind, Split};
use crate::plan::LayerFilters;
use crate::samples::{PassImage, SparseSample, SparseSamples};
use crate::scene::Scene;
use covbeam::{
    FILM_TILE, FILM_TILE_PIXELS, FilmEvidence, FilmFilterNode, FilmFilters, FilmNode, FilmPixel, FilmSample,
    FilmSums, FilmUnit, ImageFilter, Reconstruction, standard_errors, verify_filters,
};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// A finished picture, row by row from the upper left pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Radiance [W/(m² sr)], linear, Rec. 709 primaries.
    pub radiance: Vec<Vec3>,
    /// Standard error of each pixel's luminance, from the two halves of the passes; None for a single pass and for pictures of
    /// other programs.
    pub error: Option<Vec<f32>>,
    /// What the gather did; None for methods that gather nothing and for pictures of other programs.
    pub layers: Option<Layers>,
    /// Where the eye rays were; None if every pixel had one in each pass.
    pub maps: Option<Maps>,
    /// The picture's parts by kind of light, which add up to it; empty unless the film keeps them.
    pub kinds: Vec<(Kind, Vec<Vec3>)>,
}

impl Picture {
    /// Median over the lit pixels of the standard error over the luminance; None where the errors are not known or no pixel is lit.
    pub fn median_relative_error(&self) -> Option<f64> {
        let pixels = self.radiance.iter().zip(self.error.as_ref()?);
        let relative = pixels.filter_map(|(radiance, error)| {
            let luminance = luminance(*radiance);
            (luminance > 0.0).then(|| error / luminance)
        });
        let mut relative: Vec<f32> = relative.collect();
        let middle = relative.len() / 2;
        if relative.is_empty() {
            return None;
        }
        Some(f64::from(*relative.select_nth_unstable_by(middle, f32::total_cmp).1))
    }
}

/// How the beams around each pixel's eye ray were gathered; one value a pixel, 0 where no pair was accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Mean gather radius, weighted by contribution [scene unit].
    pub radius: Vec<f32>,
    /// Mean standard deviation of the fluence spectrum along the kernel axis, weighted by contribution
    /// [cycles / scene unit].
    pub sigma: Vec<f32>,
    /// Accepted pairs of beam and eye ray a pass.
    pub samples: Vec<f32>,
}

/// How the eye rays of a picture were spread and its fog filtered: the thesis' Figure 5.20. One value a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// The fog before the first surface, through the filters [W/(m² sr)].
    pub volume: Vec<Vec3>,
    /// By layer of light.
    pub layers: Vec<LayerMaps>,
}

impl Maps {
    /// Eye rays a pixel in the latest pass, of the layer that has most: what another wants sees the same ray.
    pub fn density(&self) -> Vec<f32> {
        let mut most = Vec::new();
        for layer in &self.layers {
            most.resize(layer.density.len(), 0.0);
            most.iter_mut().zip(layer.density.iter()).for_each(|(most, density)| *most = density.max(*most));
        }
        most
    }
}

/// The same of one layer: of all light, or of straight and of other light, ….
#[derive(Clone, Debug, PartialEq)]
pub struct LayerMaps {
    /// Its light; None: all light.
    pub kind: Option<Kind>,
    /// The filters of the latest pass, as far as the samples agree with them.
    pub filters: Vec<ImageFilter>,
    /// Eye rays a pixel in the latest pass.
    pub density: Arc<Vec<f32>>,
}

/// Why a pass cannot be added; the film is unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilmError {
    /// A value that no estimate of light can have.
    #[error("pixel ({x}, {y}) of a pass has {what} = {value}; expected a finite number that is not negative")]
    BadValue {
        /// Column of the pixel, 0 = left.
        x: u32,
        /// Row of the pixel, 0 = top.
        y: u32,
        /// Name of the value.
        what: &'static str,
        /// What it was.
        value: f32,
    },
    /// The pass is not a picture of this film.
    #[error(
        "a pass of {width} x {height} pixels ({radiance} of radiance, {planned} of planned eye rays, {gather} of gather sums) does not fit a film \
         of {film_width} x {film_height}"
    )]
    Size {
        /// Pixels across, of the pass.
        width: u32,
        /// Pixels down, of the pass.
        height: u32,
        /// Values of radiance it holds.
        radiance: usize,
        /// Pixels that its eye rays were planned for.
        planned: usize,
        /// Gather sums it holds.
        gather: usize,
        /// Pixels across, of the film.
        film_width: u32,
        /// Pixels down, of the film.
        film_height: u32,
    },
}

/// Adds up passes exactly.
///
/// Every value is rounded once to a multiple of the film's unit and summed as a whole number, so the sum does not depend on
/// the order of the passes ([`FilmUnit`]); because no term is negative, that holds for sums that stop at the largest number too.
/// Costs 40 bytes a pixel; where not every pixel has an eye ray in each pass, 48 more for each layer of light; 32 more where passes have
/// gather sums, and 120 where it keeps the kinds of light apart.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    /// What the unit comes from.
    typical: f32,
    unit: FilmUnit,
    passes: u32,
    odd_passes: u32,
    /// What pixels keep to themselves: all of the light, or, with planned eye rays, that from beyond the first surface.
    own: Vec<FilmSums>,
    /// With planned eye rays: the fog before the first surface, by layer.
    fog: Vec<FogLayer>,
    gather: Vec<[i64; 4]>,
    /// Some: the kinds of light are kept apart, of layers as this splits them.
    split: Option<Split>,
    /// `own` by kind.
    kinds: Vec<[FilmSums; 3]>,
}

/// A layer of the fog before the first surface.
#[derive(Clone, Debug)]
struct FogLayer {
    sums: Vec<FilmSums>,
    density: Vec<u64>,
    /// Of the latest pass, in the order of their numbers.
    latest: LayerFilters,
}

/// Units of the sums of densities and of numbers of pairs in 1.
const UNITS: f64 = (1_u64 << 32) as f64;

const FITS: &str = "the film's size is that of the plan";
const RADIANCE_NAMES: [&str; 3] = ["red radiance", "green radiance", "blue radiance"];
const GATHER_NAMES: [&str; 4] =
    ["gathered contribution", "contribution x radius", "contribution x σ", "pairs"];

impl Film {
    /// A film without passes, of `width` x `height` pixels, for radiance around 1, give or take a factor of a thousand.
    pub fn new(width: u32, height: u32) -> Self {
        Self::of_radiance(width, height, 1.0)
    }

    /// A film for the pictures of a scene.
    pub fn of_scene(scene: &Scene) -> Self {
        Self::of_radiance(scene.camera.width, scene.camera.height, scene.typical_radiance())
    }

    /// A film for pictures whose radiance is about `typical` [W/(m² sr)], give or take a factor of a thousand.
    pub fn of_radiance(width: u32, height: u32, typical: f32) -> Self {
        Self {
            width,
            height,
            typical,
            unit: FilmUnit::new(typical),
            passes: 0,
            odd_passes: 0,
            own: Vec::new(),
            fog: Vec::new(),
            gather: Vec::new(),
            split: None,
            kinds: Vec::new(),
        }
    }

    /// Keeps the kinds of light apart from now on, for passes of a renderer that does ([`crate::pass::Renderer::keep_kinds`]). Call it before
    /// the first pass.
    pub fn keep_kinds(&mut self, split: Split) {
        self.split = Some(split);
    }

    fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Passes added so far.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Adds a pass.
    ///
    /// # Errors
    /// A NaN, an infinity or a negative number anywhere in `pass` (the error names the pixel), or a pass of another
    /// size or with gather sums where earlier ones had none; the film is then unchanged.
    pub fn add(&mut self, pass: &PassImage) -> Result<(), FilmError> {
        self.check(pass)?;
        let odd = pass.pass % 2 == 1;
        let pixels = self.pixels();
        self.own.resize(pixels, FilmSums::default());
        let unit = self.unit;
        for (sums, radiance) in self.own.iter_mut().zip(&pass.radiance) {
            sums.add(&unit, *radiance, odd);
        }
        if !pass.gather.is_empty() {
            self.gather.resize(pixels, [0; 4]);
            self.gather
                .iter_mut()
                .zip(&pass.gather)
                .for_each(|(sums, values)| add_gather(sums, values, &unit));
        }
        if self.split.is_some() {
            self.kinds.resize(pixels, [FilmSums::default(); 3]);
            for (sums, light) in self.kinds.iter_mut().zip(&pass.kinds) {
                add_kinds(sums, light, &unit, odd);
            }
        }
        if let Some(sparse) = &pass.sparse {
            self.add_sparse(sparse, odd);
        }
        self.passes += 1;
        self.odd_passes += u32::from(odd);
        Ok(())
    }

    fn add_sparse(&mut self, pass: &SparseSamples, odd: bool) {
        let (pixels, unit) = (self.pixels(), self.unit);
        self.gather.resize(pixels, [0; 4]);
        for plan in pass.plans.iter().skip(self.fog.len()) {
            let (sums, density) = (vec![FilmSums::default(); pixels], vec![0; pixels]);
            self.fog.push(FogLayer { sums, density, latest: plan.filters().clone() });
        }
        for (layer, plan) in self.fog.iter_mut().zip(&pass.plans) {
            for (sum, density) in layer.density.iter_mut().zip(plan.density()) {
                *sum += (f64::from(*density) * UNITS).round_ties_even() as u64;
            }
            if layer.latest.pass < plan.filters().pass {
                layer.latest = plan.filters().clone();
            }
        }
        for sample in &pass.fog {
            let sums = &mut self.fog[sample.layer as usize].sums;
            sums[sample.pixel as usize].add(&unit, sample.radiance, odd);
        }
        for SparseSample { pixel, has_surfaces, light, gather } in &pass.samples {
            let pixel = *pixel as usize;
            if *has_surfaces {
                self.own[pixel].add(&unit, light.iter().sum(), odd);
                if let Some(sums) = self.kinds.get_mut(pixel) {
                    add_kinds(sums, light, &unit, odd);
                }
            }
            add_gather(&mut self.gather[pixel], gather, &unit);
        }
    }

    /// The mean of the passes; black without any. Where not every pixel had an eye ray, the fog before the first surface is
    /// reconstructed with the filters of the latest pass, as far as the two halves of the passes agree with them.
    pub fn picture(&self) -> Picture {
        let passes = f64::from(self.passes.max(1));
        let radiance =
            |pixels: &[FilmPixel]| -> Vec<Vec3> { pixels.par_iter().map(|pixel| pixel.radiance).collect() };
        let mut pixels = vec![FilmPixel::default(); self.pixels()];
        let mut kinds = self.own_kinds();
        let mut layers = Vec::new();
        let brightness = self.brightness();
        for (number, layer) in self.fog.iter().enumerate() {
            let of_layer = |kind: Kind| self.split.is_some_and(|split| split.of(kind) == number);
            let kind =
                kinds.iter_mut().find(|(kind, _)| of_layer(*kind)).map(|(_, light)| light.as_mut_slice());
            let verified = self.reconstruct(layer, &brightness, &mut pixels, kind);
            layers.push(self.maps(layer, &verified));
        }
        let maps = (!layers.is_empty()).then(|| Maps { volume: radiance(&pixels), layers });
        self.add_own(&mut pixels);
        let halves = self.odd_passes > 0 && self.odd_passes < self.passes;
        let error = halves.then(|| {
            let mut error = vec![0.0; pixels.len()];
            let rows = error.par_chunks_mut(self.width as usize).enumerate();
            rows.for_each(|(row, out)| {
                standard_errors(self.width, self.height, &pixels, row as u32, out).expect(FITS);
            });
            error
        });
        let radiance = radiance(&pixels);
        // Before the layers take their place.
        drop(pixels);
        let share = |sum: i64, whole: i64| if whole == 0 { 0.0 } else { (sum as f64 / whole as f64) as f32 };
        let layers = (!self.gather.is_empty()).then(|| Layers {
            radius: self.gather.par_iter().map(|s| share(s[1], s[0])).collect(),
            sigma: self.gather.par_iter().map(|s| share(s[2], s[0])).collect(),
            samples: self.gather.par_iter().map(|s| (s[3] as f64 / UNITS / passes) as f32).collect(),
        });
        let (width, height) = (self.width, self.height);
        Picture { width, height, radiance, error, layers, maps, kinds }
    }

    /// Where a layer's eye rays were, and the filters that were found.
    fn maps(&self, layer: &FogLayer, verified: &[FilmFilterNode]) -> LayerMaps {
        let (width, height) = (self.width, self.height);
        let LayerFilters { kind, lattice, regions, density, .. } = &layer.latest;
        let filters = FilmFilters::of(*lattice, regions, verified).expect(FITS);
        let all = (0..width * height).into_par_iter();
        let filters = all.map(|pixel| filters.filter(pixel % width, pixel / width)).collect();
        LayerMaps { kind: *kind, filters, density: Arc::clone(density) }
    }

    /// A layer's samples, means over the passes.
    fn samples(&self, layer: &FogLayer) -> Vec<FilmSample> {
        let sums = layer.sums.par_iter().zip(&layer.density);
        sums.map(|(sums, density)| sums.sample(&self.unit, *density as f64 / UNITS)).collect()
    }

    /// The same, to be filtered.
    fn volume<'a>(
        &self,
        layer: &'a FogLayer,
        samples: &'a [FilmSample],
        nodes: &'a mut Vec<FilmNode>,
    ) -> Reconstruction<'a> {
        nodes.resize(Reconstruction::node_count(self.width, self.height), FilmNode::default());
        Reconstruction::new(self.width, self.height, samples, &layer.latest.regions, nodes).expect(FITS)
    }

    /// Of the fog's light of all layers at the nodes of the lattice, where there is more than one.
    fn brightness(&self) -> Vec<f32> {
        let mut brightness = Vec::new();
        for layer in self.fog.iter().filter(|_| self.fog.len() > 1) {
            let (samples, mut nodes) = (self.samples(layer), Vec::new());
            let volume = self.volume(layer, &samples, &mut nodes);
            let predicted = layer.latest.filters();
            brightness.resize(layer.latest.nodes.len(), 0.0);
            let numbered = brightness.par_iter_mut().enumerate();
            numbered.for_each(|(node, sum)| *sum += predicted.evidence(node, &volume).brightness);
        }
        brightness
    }

    /// Adds a layer of the fog before the first surface, also to a picture of its kind; returns its filters at the nodes of the lattice.
    fn reconstruct(
        &self,
        layer: &FogLayer,
        brightness: &[f32],
        pixels: &mut [FilmPixel],
        kind: Option<&mut [Vec3]>,
    ) -> Vec<FilmFilterNode> {
        let width = self.width;
        let (samples, mut nodes) = (self.samples(layer), Vec::new());
        let volume = self.volume(layer, &samples, &mut nodes);

        let LayerFilters { lattice, regions, nodes, .. } = &layer.latest;
        let mut verified = nodes.to_vec();
        let predicted = layer.latest.filters();
        let evidence = (0..verified.len()).into_par_iter().map(|node| {
            let own = predicted.evidence(node, &volume);
            own.beside(brightness.get(node).map_or(0.0, |all| all - own.brightness))
        });
        let evidence: Vec<FilmEvidence> = evidence.collect();
        verify_filters(lattice, &evidence, &mut verified).expect(FITS);
        let filters = FilmFilters::of(*lattice, regions, &verified).expect(FITS);

        let tiles = (width * FILM_TILE) as usize;
        let add = |row: u32, pixels: &mut [FilmPixel], mut kind: Option<&mut [Vec3]>| {
            let mut tile = [FilmPixel::default(); FILM_TILE_PIXELS];
            for x in (0..width).step_by(FILM_TILE as usize) {
                volume.tile(x, row, &filters, &mut tile);
                for (y, tile) in tile.chunks(FILM_TILE as usize).enumerate() {
                    let line = y * width as usize;
                    for (x, found) in (x as usize..width as usize).zip(tile) {
                        let Some(pixel) = pixels.get_mut(line + x) else { continue };
                        pixel.radiance += found.radiance;
                        pixel.variance += found.variance;
                        pixel.difference += found.difference;
                        if let Some(kind) = &mut kind {
                            kind[line + x] += found.radiance;
                        }
                    }
                }
            }
        };
        let rows = pixels.par_chunks_mut(tiles).enumerate();
        let first = |row: usize| row as u32 * FILM_TILE;
        match kind {
            None => rows.for_each(|(row, pixels)| add(first(row), pixels, None)),
            Some(kind) => rows
                .zip(kind.par_chunks_mut(tiles))
                .for_each(|((row, pixels), kind)| add(first(row), pixels, Some(kind))),
        }
        verified
    }

    /// Adds the light that pixels keep to themselves.
    fn add_own(&self, pixels: &mut [FilmPixel]) {
        if self.own.is_empty() {
            return;
        }
        let samples = self.means(&self.own, |sums| sums);
        pixels.par_iter_mut().zip(&samples).zip(self.filled(&samples)).for_each(
            |((pixel, own), radiance)| {
                pixel.radiance += radiance;
                pixel.difference += own.halves().map_or(0.0, |[odd, even]| odd - even);
            },
        );
    }

    /// The same, a picture a kind.
    fn own_kinds(&self) -> Vec<(Kind, Vec<Vec3>)> {
        let of_kind = |kind: Kind| {
            let samples = self.means(&self.kinds, |sums: &[FilmSums; 3]| &sums[kind as usize]);
            (kind, self.filled(&samples))
        };
        self.split.iter().flat_map(|split| split.kinds()).map(of_kind).collect()
    }

    fn means<T: Sync>(&self, all: &[T], sums: impl Fn(&T) -> &FilmSums + Sync) -> Vec<FilmSample> {
        let mean = |sums: &FilmSums| sums.sample(&self.unit, f64::from(sums.rays()));
        all.par_iter().map(|of_pixel| mean(sums(of_pixel))).collect()
    }

    /// Radiance of samples over their numbers of rays. Pixels without an eye ray take that of the nearest ones as long as they have none.
    fn filled(&self, samples: &[FilmSample]) -> Vec<Vec3> {
        let own = |sample: &FilmSample| sample.radiance / sample.weight;
        let is_sparse = samples.par_iter().any(|sample| sample.weight == 0.0);
        let Some(layer) = self.fog.first().filter(|_| is_sparse) else {
            return samples.par_iter().map(own).collect();
        };
        let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(self.width, self.height)];
        let regions = &layer.latest.regions;
        let around = Reconstruction::new(self.width, self.height, samples, regions, &mut nodes).expect(FITS);
        let numbered = samples.par_iter().enumerate();
        let filled = numbered.map(|(index, sample)| {
            let (x, y) = (index as u32 % self.width, index as u32 / self.width);
            if sample.weight > 0.0 { own(sample) } else { around.nearby(x, y) }
        });
        filled.collect()
    }

    fn check(&self, pass: &PassImage) -> Result<(), FilmError> {
        let pixels = self.pixels();
        let first = self.passes == 0;
        let plans = pass.sparse.as_ref().map_or(0, |sparse| sparse.plans.len());
        let is_sparse = if first { plans > 0 } else { !self.fog.is_empty() };
        let has_gather = if first { !pass.gather.is_empty() } else { !is_sparse && !self.gather.is_empty() };
        let expected = |wanted: bool| if wanted { pixels } else { 0 };
        let of_plans = || pass.sparse.iter().flat_map(|sparse| &sparse.plans);
        let planned = of_plans().map(|plan| plan.density().len()).max().unwrap_or(0);
        let fits = (pass.width, pass.height) == (self.width, self.height)
            && pass.radiance.len() == expected(!is_sparse)
            && (self.split.is_none() || pass.kinds.len() == expected(!is_sparse))
            && (first || plans == self.fog.len())
            && of_plans().all(|plan| plan.density().len() == expected(is_sparse))
            && pass.gather.len() == expected(has_gather);
        if !fits {
            return Err(FilmError::Size {
                width: pass.width,
                height: pass.height,
                radiance: pass.radiance.len(),
                planned,
                gather: pass.gather.len(),
                film_width: self.width,
                film_height: self.height,
            });
        }
        let numbered = |index: usize| index as u32;
        for (index, radiance) in pass.radiance.iter().enumerate() {
            self.check_values(numbered(index), radiance.to_array(), RADIANCE_NAMES)?;
        }
        for (index, gather) in pass.gather.iter().enumerate() {
            self.check_values(numbered(index), *gather, GATHER_NAMES)?;
        }
        for sparse in pass.sparse.iter() {
            for sample in &sparse.fog {
                self.check_values(sample.pixel, sample.radiance.to_array(), RADIANCE_NAMES)?;
            }
            for sample in &sparse.samples {
                for light in sample.light {
                    self.check_values(sample.pixel, light.to_array(), RADIANCE_NAMES)?;
                }
                self.check_values(sample.pixel, sample.gather, GATHER_NAMES)?;
            }
        }
        Ok(())
    }

    fn check_values<const N: usize>(
        &self,
        pixel: u32,
        values: [f32; N],
        names: [&'static str; N],
    ) -> Result<(), FilmError> {
        for (value, what) in values.into_iter().zip(names) {
            if !value.is_finite() || value < 0.0 {
                let (x, y) = (pixel % self.width, pixel / self.width);
                return Err(FilmError::BadValue { x, y, what, value });
            }
        }
        Ok(())
    }
}

fn add_kinds(sums: &mut [FilmSums; 3], light: &ByKind, unit: &FilmUnit, odd: bool) {
    for (sums, light) in sums.iter_mut().zip(light) {
        sums.add(unit, *light, odd);
    }
}

/// Contributions are in the film's unit, numbers of pairs are not.
fn add_gather(sums: &mut [i64; 4], [light, radius, sigma, pairs]: &[f32; 4], unit: &FilmUnit) {
    let pairs = (f64::from(*pairs) * UNITS) as i64;
    let values = [unit.whole(*light), unit.whole(*radius), unit.whole(*sigma), pairs];
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum = sum.saturating_add(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_pixel(value: f32, gather: [f32; 4]) -> PassImage {
        PassImage {
            pass: 1,
            width: 1,
            height: 1,
            radiance: vec![Vec3::splat(value)],
            gather: vec![gather],
            ..PassImage::default()
        }
    }

    #[test]
    fn a_picture_is_the_mean_radiance_and_the_contribution_weighted_means() {
        let mut film = Film::new(1, 1);
        // Contribution 1 at radius 2 and σ 8, then contribution 3 at radius 4 and σ 16; 10 and 20 pairs.
        film.add(&one_pixel(1.0, [1.0, 2.0, 8.0, 10.0])).unwrap();
        film.add(&one_pixel(2.0, [3.0, 12.0, 48.0, 20.0])).unwrap();
        let picture = film.picture();
        assert_eq!(picture.radiance, [Vec3::splat(1.5)]);
        let layers = picture.layers.unwrap();
        assert_eq!((layers.radius[0], layers.sigma[0], layers.samples[0]), (3.5, 14.0, 15.0));
    }

    #[test]
    fn a_bad_value_names_its_pixel_and_leaves_the_film_unchanged() {
        let mut film = Film::new(3, 2);
        let good = PassImage { width: 3, height: 2, radiance: vec![Vec3::ONE; 6], ..PassImage::default() };
        film.add(&good).unwrap();
        let before = film.picture();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
            let mut pass = good.clone();
            pass.radiance[5].y = bad;
            let message = film.add(&pass).unwrap_err().to_string();
            assert!(message.contains("pixel (2, 1)") && message.contains("green"), "{message}");
        }
        assert_eq!(film.picture(), before);
        assert_eq!(film.passes(), 1);
    }

    #[test]
    fn a_bad_gather_sum_is_refused_too() {
        let error = Film::new(1, 1).add(&one_pixel(1.0, [1.0, 1.0, f32::NAN, 1.0])).unwrap_err();
        assert!(error.to_string().contains("contribution x σ"), "{error}");
    }

    #[test]
    fn passes_of_another_size_are_refused() {
        let mut film = Film::new(2, 1);
        let wide = PassImage {
            pass: 1,
            width: 2,
            height: 1,
            radiance: vec![Vec3::ONE; 2],
            gather: vec![[1.0; 4]; 2],
            ..PassImage::default()
        };
        film.add(&wide).unwrap();
        assert!(matches!(film.add(&one_pixel(1.0, [1.0; 4])), Err(FilmError::Size { .. })));
        assert!(matches!(film.add(&PassImage { gather: vec![], ..wide }), Err(FilmError::Size { .. })));
        assert_eq!(film.passes(), 1);
    }

    #[test]
    fn a_film_without_passes_is_black_and_a_pixel_without_pairs_has_zero_layers() {
        assert_eq!(Film::new(1, 1).picture().radiance, [Vec3::ZERO]);
        let mut film = Film::new(1, 1);
        film.add(&one_pixel(0.0, [0.0; 4])).unwrap();
        assert_eq!(film.picture().layers.unwrap().radius, [0.0]);
    }
}
