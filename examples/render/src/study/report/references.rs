//! What pictures are compared with, and the errors.

use super::spend::{Budget, Watch, spend};
use crate::files::output::{OutputError, read_picture};
use crate::study::compare::{CompareError, compare};
use crate::study::regions::{Region, of_scene};
use covbeam_session::color::luminance;
use covbeam_session::film::{Film, FilmError, Picture};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A reference is made of plain beams, so that no error that spectra, plans or filters make is in both it and what it judges. Its kernels are this
/// much narrower than the scene asks for: what plain beams themselves blur is wrong by a sixteenth of that.
const RADIUS_SHARE: f32 = 0.25;

/// Of the two runs; no method is measured with these.
const SEEDS: [u32; 2] = [1001, 1002];

/// Why there is no reference.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] OutputError),
    /// Another size than that of the pictures.
    #[error(
        "'{path}': the reference has {width} x {height} pixels, but with --width {asked} the scene's pictures have {asked} x {asked_height}; \
         leave --width out, or give another folder with --references"
    )]
    Width {
        /// The file.
        path: PathBuf,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Pixels across that were asked for.
        asked: u32,
        /// Pixels down that follow from it.
        asked_height: u32,
    },
    /// Another shape than that of the scene's pictures, or of the other half.
    #[error(
        "'{path}': the reference has {width} x {height} pixels; expected {expected} as the scene's camera has them; render it anew"
    )]
    Shape {
        /// The file.
        path: PathBuf,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Width x height.
        expected: String,
    },
    /// NaN, infinity, or all black.
    #[error("'{path}' is no reference: {source}; render it anew, or give another folder with --references")]
    Bad {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: CompareError,
    },
    /// The scene shows nothing.
    #[error("the scene '{scene}' has no light in its picture: {source}; turn the camera or the light")]
    Dark {
        /// Its name.
        scene: String,
        /// What is wrong.
        source: CompareError,
    },
    /// A pass that no picture can be made of.
    #[error("the reference of '{scene}' went wrong: {source}")]
    Pass {
        /// Its name.
        scene: String,
        /// What is wrong.
        source: FilmError,
    },
}

/// Error of a picture in a region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegionError {
    /// Mean of (I - R₁)(I - R₂) / (R² + (0.01 mean R)²) on luminance; may come out below 0 where the error is less than its noise.
    pub rel_mse: f64,
    /// Standard error of `rel_mse` as a mean over the region's pixels, as if these were independent: what the number is worth.
    pub standard_error: f64,
    /// mean(I - R) / mean R.
    pub bias: f64,
}

/// A reference made of two independent runs, R₁ and R₂ with mean R.
pub struct Reference {
    /// R.
    pub picture: Picture,
    /// R₁ and R₂ by luminance; both are R where only one picture is known.
    halves: [Vec<f64>; 2],
    mean: Vec<f64>,
    floor: f64,
    /// Where errors are told: whole, smooth, sharp, and the named regions of the ball scenes; none is empty.
    pub regions: Vec<Region>,
    /// relMSE of R itself, by region; None if only one picture is known: errors then hold it.
    pub noise: Option<Vec<f64>>,
    /// Where it came from, in words.
    pub origin: String,
}

impl Reference {
    fn new(
        scene: &str,
        first: Option<&Picture>,
        picture: Picture,
        origin: String,
    ) -> Result<Self, CompareError> {
        compare(&picture, &picture, |_, _| true)?;
        if let Some(first) = first {
            compare(first, &picture, |_, _| true)?;
        }
        let mean = luminances(&picture);
        let halves = match first.map(luminances) {
            Some(first) => {
                let second = mean.iter().zip(&first).map(|(mean, first)| 2.0 * mean - first).collect();
                [first, second]
            }
            None => [mean.clone(), mean.clone()],
        };
        let floor = (0.01 * mean.iter().sum::<f64>() / mean.len() as f64).powi(2);
        let regions = of_scene(scene, &picture);
        let mut reference = Self { picture, halves, mean, floor, regions, noise: None, origin };
        if first.is_some() {
            // (R₁ - R)² is a quarter of (R₁ - R₂)², and that is the variance of R.
            let noise = |region: &Region| {
                reference.over(region, |i| (reference.halves[0][i] - reference.mean[i]).powi(2)).0
            };
            reference.noise = Some(reference.regions.iter().map(noise).collect());
        }
        Ok(reference)
    }

    /// Mean of `square` over the metric's denominator in a region, and its standard error.
    fn over(&self, region: &Region, square: impl Fn(usize) -> f64) -> (f64, f64) {
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for (i, r) in self.mean.iter().enumerate() {
            if region.contains(i as u32 % self.picture.width, i as u32 / self.picture.width) {
                let term = square(i) / (r * r + self.floor);
                sum += term;
                squares += term * term;
                count += 1.0;
            }
        }
        let mean = sum / count;
        (mean, ((squares / count - mean * mean).max(0.0) / count).sqrt())
    }

    /// Errors of a picture of the same size, by region.
    pub fn errors(&self, picture: &Picture) -> Vec<RegionError> {
        let found = luminances(picture);
        let of = |region: &Region| {
            let [first, second] = &self.halves;
            let (rel_mse, standard_error) =
                self.over(region, |i| (found[i] - first[i]) * (found[i] - second[i]));
            let (mut difference, mut all) = (0.0, 0.0);
            for (i, r) in self.mean.iter().enumerate() {
                if region.contains(i as u32 % picture.width, i as u32 / picture.width) {
                    difference += found[i] - r;
                    all += r;
                }
            }
            RegionError { rel_mse, standard_error, bias: difference / all }
        };
        self.regions.iter().map(of).collect()
    }

    /// (I - R) / √(R² + (0.01 mean R)²) of each pixel, on luminance.
    pub fn relative_errors(&self, picture: &Picture) -> Vec<f32> {
        let found = luminances(picture);
        let pixel = |(i, r): (&f64, &f64)| ((i - r) / (r * r + self.floor).sqrt()) as f32;
        found.iter().zip(&self.mean).map(pixel).collect()
    }

    /// Reads `NAME.exr` and, where it is, the first of its two runs, `NAME-half.exr`. `width`: what the user asked for; None takes
    /// the reference's, to which the scene's camera is then set.
    ///
    /// # Errors
    /// A file that cannot be read, has another shape than the scene's pictures, or is no picture of light.
    pub fn load(
        path: &Path,
        name: &str,
        scene: &mut Scene,
        width: Option<u32>,
    ) -> Result<Self, ReferenceError> {
        let picture = read_picture(path)?;
        let (across, down) = (picture.width, picture.height);
        if let Some(asked) = width.filter(|asked| *asked != across) {
            let asked_height = scene.camera.height_for(asked);
            return Err(ReferenceError::Width {
                path: path.to_owned(),
                width: across,
                height: down,
                asked,
                asked_height,
            });
        }
        if scene.camera.height_for(across) != down {
            let expected = format!("{across} x {}", scene.camera.height_for(across));
            return Err(ReferenceError::Shape {
                path: path.to_owned(),
                width: across,
                height: down,
                expected,
            });
        }
        let half_path = path.with_file_name(format!("{name}-half.exr"));
        let half = if half_path.exists() { Some(read_picture(&half_path)?) } else { None };
        if let Some(half) = half.as_ref().filter(|half| (half.width, half.height) != (across, down)) {
            let (width, height) = (half.width, half.height);
            return Err(ReferenceError::Shape {
                path: half_path,
                width,
                height,
                expected: format!("{across} x {down}"),
            });
        }
        let origin = match half {
            Some(_) => format!("{name}.exr and its first run, {name}-half.exr"),
            None => format!("{name}.exr alone: errors hold its noise"),
        };
        let reference = Self::new(name, half.as_ref(), picture, origin)
            .map_err(|source| ReferenceError::Bad { path: path.to_owned(), source })?;
        scene.camera.set_width(across);
        Ok(reference)
    }

    /// Renders two runs of plain beams with narrow kernels. None: cancelled.
    ///
    /// # Errors
    /// A pass that went wrong, or a black picture.
    pub fn render(
        name: &str,
        scene: &Scene,
        budget: Budget,
        watch: &Watch,
    ) -> Result<Option<Self>, ReferenceError> {
        let mut scene = scene.clone();
        scene.settings.schedule.radius *= RADIUS_SHARE;
        let mut runs = Vec::new();
        for (number, seed) in SEEDS.into_iter().enumerate() {
            watch.begin(format!("{name}: reference, run {} of 2", number + 1), budget);
            let mut renderer = Renderer::new(&scene, Settings::of_scene(Method::Plain, &scene, seed));
            let mut film = Film::of_scene(&scene);
            let spent = spend(&mut renderer, &mut film, budget, 0.0, watch, |_, _, _| {})
                .map_err(|source| ReferenceError::Pass { scene: name.to_owned(), source })?;
            let Some(spent) = spent else { return Ok(None) };
            runs.push((film.picture(), spent));
        }
        let [(first, spent), (second, other)] = &runs[..] else { unreachable!("two seeds") };
        let radiance = first.radiance.iter().zip(&second.radiance).map(|(a, b)| 0.5 * (*a + *b)).collect();
        let mean = Picture { width: first.width, height: first.height, radiance, ..Picture::default() };
        let origin = format!(
            "rendered for this report: two runs of plain beams, {} and {} passes, {:.1} CPU-seconds in all, radius × {RADIUS_SHARE}",
            spent.passes,
            other.passes,
            spent.cpu_seconds + other.cpu_seconds
        );
        let reference = Self::new(name, Some(first), mean, origin);
        reference.map(Some).map_err(|source| ReferenceError::Dark { scene: name.to_owned(), source })
    }
}

fn luminances(picture: &Picture) -> Vec<f64> {
    picture.radiance.iter().map(|v| f64::from(luminance(*v))).collect()
}
