//! What the passes add up to, with the same bits in whatever order they come.

pub mod passes;
mod picture;
mod planes;
pub mod samples;
mod stored;

pub use picture::{LayerMaps, Layers, Maps, Picture};
pub use stored::FilmLayout;
pub use stored::Unfit;

use crate::film::samples::{PassImage, SparseSample, SparseSamples};
use crate::kind::{ByKind, Split};
use crate::plan::LayerFilters;
use crate::scene::Scene;
use covbeam::{FilmSums, FilmUnit};

/// Why a pass cannot be added; the film is unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilmError {
    /// A value that no estimate of light can have.
    #[error(
        "pixel ({x}, {y}) of a pass has {what} = {value}; expected a finite number that is not negative: are light or albedo of the scene too bright \
         to be told, or is a lamp without size on what it lights?"
    )]
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

    /// Keeps the kinds of light apart from now on, for passes of a renderer that does ([`crate::settings::Layers::EachKind`]). Call it before
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
    use glam::Vec3;

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
