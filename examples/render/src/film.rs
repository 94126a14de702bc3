//! What the passes add up to, with the same bits in whatever order they come.

use crate::plan::{Plan, Wanted};
use covbeam::{FilmNode, FilmSample, ImageFilter, Reconstruction};
use glam::Vec3;
use rayon::prelude::*;

/// One pass' picture, row by row from the upper left pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassImage {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Estimate of radiance [W/(m² sr)]; empty where not every pixel has an eye ray.
    pub radiance: Vec<Vec3>,
    /// The eye rays, where not every pixel has one.
    pub sparse: Option<SparseSamples>,
    /// Per pixel, over accepted pairs with contribution c (luminance): Σ c, Σ c·radius, Σ c·σ, number of pairs.
    /// Empty for methods that gather nothing (light-trace).
    pub gather: Vec<[f32; 4]>,
}

/// What few eye rays saw, one value a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseSamples {
    /// The fog before the first surface, which is filtered as `plan` says: radiance, and 1 if there was an eye ray.
    pub volume: Vec<FilmSample>,
    /// Surfaces, and all that is seen through and in them.
    pub surfaces: Vec<FilmSample>,
    /// The plan that the eye rays were chosen by.
    pub plan: Plan,
}

impl SparseSamples {
    /// Without any eye rays yet.
    pub fn new(plan: Plan) -> Self {
        let none = vec![FilmSample::default(); plan.filters().len()];
        Self { volume: none.clone(), surfaces: none, plan }
    }

    /// Sets what an eye ray through a pixel saw of what was wanted from it.
    pub fn set(&mut self, pixel: usize, wanted: Wanted, volume: Vec3, surfaces: Vec3) {
        let sample =
            |radiance: Vec3, wanted: bool| FilmSample { radiance, weight: f32::from(u8::from(wanted)) };
        self.volume[pixel] = sample(volume, wanted.volume);
        self.surfaces[pixel] = sample(surfaces, wanted.surfaces);
    }
}

/// A finished picture, row by row from the upper left pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Radiance [W/(m² sr)], linear, Rec. 709 primaries.
    pub radiance: Vec<Vec3>,
    /// What the gather did; None for methods that gather nothing and for pictures of other programs.
    pub layers: Option<Layers>,
    /// Where the eye rays were; None if every pixel had one in each pass.
    pub maps: Option<Maps>,
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
    /// The filters of the latest pass.
    pub filters: Vec<ImageFilter>,
    /// Eye rays a pixel in the latest pass.
    pub density: Vec<f32>,
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
        "a pass of {width} x {height} pixels ({radiance} of radiance, {sparse} of eye rays, {gather} of gather sums) does not fit a film of \
         {film_width} x {film_height}"
    )]
    Size {
        /// Pixels across, of the pass.
        width: u32,
        /// Pixels down, of the pass.
        height: u32,
        /// Values of radiance it holds.
        radiance: usize,
        /// Values of few eye rays it holds.
        sparse: usize,
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
/// Every value is rounded once to a multiple of 2⁻⁸⁰ (8e-25) and summed as an integer of 128 bits, so the sum does not
/// depend on the order of the passes. An f32 of 2⁻⁵⁶ (1.4e-17) or more is kept whole. Sums stop at 2⁴⁷ (1.4e14), which
/// a picture in any sane unit does not reach; because no term is negative, that too is independent of the order.
/// Costs 48 bytes a pixel, or 144 where not every pixel has an eye ray in each pass; and 64 more where passes have gather sums.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    passes: u32,
    radiance: Vec<[i128; 3]>,
    gather: Vec<[i128; 4]>,
    volume: Vec<[i128; 4]>,
    surfaces: Vec<[i128; 4]>,
    density: Vec<[i128; 1]>,
    /// Of the latest pass, in the order of their numbers.
    plan: Option<Plan>,
}

/// 2⁸⁰: units of the fixed-point sums in 1.
const UNITS: f64 = (1_u128 << 80) as f64;

const RADIANCE_NAMES: [&str; 3] = ["red radiance", "green radiance", "blue radiance"];
const FITS: &str = "the film's size is that of the plan";
const SAMPLE_NAMES: [&str; 4] = ["red radiance", "green radiance", "blue radiance", "weight of eye rays"];
const GATHER_NAMES: [&str; 4] =
    ["gathered contribution", "contribution x radius", "contribution x σ", "pairs"];

impl Film {
    /// A film without passes, of `width` x `height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            passes: 0,
            radiance: Vec::new(),
            gather: Vec::new(),
            volume: Vec::new(),
            surfaces: Vec::new(),
            density: Vec::new(),
            plan: None,
        }
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
        add_all(&mut self.radiance, pass.radiance.iter().map(Vec3::to_array));
        add_all(&mut self.gather, pass.gather.iter().copied());
        if let Some(SparseSamples { volume, surfaces, plan }) = &pass.sparse {
            add_all(&mut self.volume, volume.iter().map(numbers));
            add_all(&mut self.surfaces, surfaces.iter().map(numbers));
            add_all(&mut self.density, plan.filters().iter().map(|filter| [filter.density()]));
            if self.plan.as_ref().is_none_or(|latest| latest.pass() < plan.pass()) {
                self.plan = Some(plan.clone());
            }
        }
        self.passes += 1;
        Ok(())
    }

    /// The mean of the passes; black without any. Where not every pixel had an eye ray, the fog before the first surface is
    /// reconstructed with the filters of the latest pass.
    pub fn picture(&self) -> Picture {
        let passes = f64::from(self.passes.max(1));
        let mean = |sum: &i128| (*sum as f64 / UNITS / passes) as f32;
        let share =
            |sum: i128, whole: i128| if whole == 0 { 0.0 } else { (sum as f64 / whole as f64) as f32 };
        let (radiance, maps) = match &self.plan {
            Some(plan) => {
                let (radiance, maps) = self.reconstruct(plan);
                (radiance, Some(maps))
            }
            None if self.passes == 0 => (vec![Vec3::ZERO; self.pixels()], None),
            None => (self.radiance.iter().map(|s| Vec3::from(s.each_ref().map(mean))).collect(), None),
        };
        let layers = (!self.gather.is_empty()).then(|| Layers {
            radius: self.gather.iter().map(|s| share(s[1], s[0])).collect(),
            sigma: self.gather.iter().map(|s| share(s[2], s[0])).collect(),
            samples: self.gather.iter().map(|s| mean(&s[3])).collect(),
        });
        Picture { width: self.width, height: self.height, radiance, layers, maps }
    }

    fn reconstruct(&self, plan: &Plan) -> (Vec<Vec3>, Maps) {
        let (width, height) = (self.width, self.height);
        let sums = self.volume.iter().zip(&self.density);
        let samples: Vec<FilmSample> = sums.map(|(sums, [density])| expected(sums, *density)).collect();
        let nodes_len = Reconstruction::node_count(width, height);
        let mut nodes = vec![FilmNode::default(); nodes_len];
        let regions = plan.surfaces().regions();
        let volume = Reconstruction::new(width, height, &samples, regions, &mut nodes).expect(FITS);
        // Without a filter a pixel keeps to its own eye rays, or takes the nearest ones as long as it has none.
        let mut surface_nodes = vec![FilmNode::default(); nodes_len];
        let surfaces: Vec<FilmSample> = self.surfaces.iter().map(|sums| expected(sums, sums[3])).collect();
        let surfaces =
            Reconstruction::new(width, height, &surfaces, regions, &mut surface_nodes).expect(FITS);
        let filters = plan.filters();
        let pixels = filters.par_iter().enumerate().map(|(pixel, filter)| {
            let (x, y) = (pixel as u32 % width, pixel as u32 / width);
            let fog = volume.pixel(x, y, filter);
            (fog + surfaces.pixel(x, y, &ImageFilter::NONE), fog)
        });
        let (radiance, volume): (Vec<_>, Vec<_>) = pixels.unzip();
        let density = filters.iter().map(ImageFilter::density).collect();
        (radiance, Maps { volume, filters: filters.to_vec(), density })
    }

    fn check(&self, pass: &PassImage) -> Result<(), FilmError> {
        let pixels = self.pixels();
        let first = self.passes == 0;
        let is_sparse = if first { pass.sparse.is_some() } else { self.plan.is_some() };
        let gather = if first { pass.gather.len() } else { self.gather.len() };
        let radiance = if is_sparse { 0 } else { pixels };
        let fits = (pass.width, pass.height) == (self.width, self.height)
            && pass.radiance.len() == radiance
            && pass.sparse.is_some() == is_sparse
            && pass.sparse.as_ref().is_none_or(|sparse| {
                [sparse.volume.len(), sparse.surfaces.len(), sparse.plan.filters().len()] == [pixels; 3]
            })
            && pass.gather.len() == gather
            && (gather == 0 || gather == pixels);
        if !fits {
            return Err(FilmError::Size {
                width: pass.width,
                height: pass.height,
                radiance: pass.radiance.len(),
                sparse: pass.sparse.as_ref().map_or(0, |sparse| sparse.volume.len()),
                gather: pass.gather.len(),
                film_width: self.width,
                film_height: self.height,
            });
        }
        let radiance = pass.radiance.iter().map(|v| v.to_array());
        self.check_values(radiance, RADIANCE_NAMES)?;
        if let Some(SparseSamples { volume, surfaces, .. }) = &pass.sparse {
            self.check_values(volume.iter().map(numbers), SAMPLE_NAMES)?;
            self.check_values(surfaces.iter().map(numbers), SAMPLE_NAMES)?;
        }
        self.check_values(pass.gather.iter().copied(), GATHER_NAMES)
    }

    fn check_values<const N: usize>(
        &self,
        values: impl Iterator<Item = [f32; N]>,
        names: [&'static str; N],
    ) -> Result<(), FilmError> {
        for (pixel, values) in (0_u32..).zip(values) {
            for (value, what) in values.into_iter().zip(names) {
                if !value.is_finite() || value < 0.0 {
                    return Err(FilmError::BadValue {
                        x: pixel % self.width,
                        y: pixel / self.width,
                        what,
                        value,
                    });
                }
            }
        }
        Ok(())
    }
}

fn numbers(sample: &FilmSample) -> [f32; 4] {
    let [red, green, blue] = sample.radiance.to_array();
    [red, green, blue, sample.weight]
}

/// A pixel's sums over their expected number of eye rays. A mean over the passes' densities, not each ray over its own: a ray from an
/// early pass, when the grid knew little and wanted few, must not outweigh all later ones (the balance heuristic).
fn expected([red, green, blue, rays]: &[i128; 4], density: i128) -> FilmSample {
    if density == 0 {
        return FilmSample::default();
    }
    let share = |sum: &i128| (*sum as f64 / density as f64) as f32;
    FilmSample { radiance: Vec3::new(share(red), share(green), share(blue)), weight: share(rays) }
}

fn add_all<const N: usize>(sums: &mut Vec<[i128; N]>, values: impl ExactSizeIterator<Item = [f32; N]>) {
    sums.resize(values.len(), [0; N]);
    for (sums, values) in sums.iter_mut().zip(values) {
        add_exactly(sums, values);
    }
}

fn add_exactly<const N: usize>(sums: &mut [i128; N], values: [f32; N]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        // The product is exact (a power of two, far from f64's limits); `as` stops at i128's limits.
        let units = (f64::from(value) * UNITS).round_ties_even() as i128;
        *sum = sum.saturating_add(units);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_pixel(value: f32, gather: [f32; 4]) -> PassImage {
        PassImage {
            width: 1,
            height: 1,
            radiance: vec![Vec3::splat(value)],
            gather: vec![gather],
            sparse: None,
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
            width: 2,
            height: 1,
            radiance: vec![Vec3::ONE; 2],
            gather: vec![[1.0; 4]; 2],
            sparse: None,
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
