//! Runs of some passes, and the regions that their errors are read in.

use crate::{Outcome, Size};
use covbeam_render::compare::{Comparison, compare};
use covbeam_render::film::{Film, Picture};
use covbeam_render::operators::Operator;
use covbeam_render::output::read_picture;
use covbeam_render::pass::{Method, PassTimes, Renderer};
use covbeam_render::random::Emission;
use covbeam_render::scene::Scene;
use covbeam_tests::regions::{Region, by_sharpness, of_ball, whole};
use std::path::{Path, PathBuf};

/// Names of the regions of [`by_sharpness`], in its order.
pub(crate) const SHARPNESS: [&str; 3] = ["whole", "smooth", "sharp"];

/// Some passes of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) method: Method,
    pub(crate) emission: Emission,
    pub(crate) seed: u32,
    pub(crate) photons: u32,
    pub(crate) passes: u32,
    pub(crate) left_out: Option<Operator>,
}

impl<'a> Run<'a> {
    /// With the scene's photons, low-discrepancy emission and all operators.
    pub(crate) fn new(scene: &'a Scene, method: Method, seed: u32, passes: u32) -> Self {
        let (emission, photons) = (Emission::LowDiscrepancy, scene.settings.photons);
        Self { scene, method, emission, seed, photons, passes, left_out: None }
    }

    /// The picture and its core time.
    pub(crate) fn picture(&self) -> Outcome<(Picture, PassTimes)> {
        self.step_by_step(|_, _, _| Ok(()))
    }

    /// Like [`Run::picture`], and calls `after` with the pass, the picture so far and its core-seconds after each pass
    /// that is a power of two.
    pub(crate) fn step_by_step(
        &self,
        mut after: impl FnMut(u32, &Picture, f64) -> Outcome<()>,
    ) -> Outcome<(Picture, PassTimes)> {
        let Self { scene, method, emission, seed, photons, passes, left_out } = *self;
        let mut renderer = Renderer::with_emission(scene, method, photons, seed, emission);
        if let Some(operator) = left_out {
            renderer.leave_out(operator);
        }
        let mut film = Film::of_scene(scene);
        let mut total = PassTimes::default();
        for index in 1..=passes {
            let (image, times) = renderer.pass(index, &|| false).expect("never cancelled");
            film.add(&image)?;
            total += times;
            if index.is_power_of_two() {
                after(index, &film.picture(), total.total())?;
            }
        }
        Ok((film.picture(), total))
    }
}

/// The scene, with its pictures scaled to the width asked for.
pub(crate) fn load(path: &Path, size: Size) -> Outcome<Scene> {
    let mut scene = Scene::load(path)?;
    if let Some(width) = size.width {
        let camera = &mut scene.camera;
        let height = f64::from(camera.height) * f64::from(width) / f64::from(camera.width);
        (camera.width, camera.height) = (width, (height.round() as u32).max(1));
    }
    Ok(scene)
}

/// The reference, if it is as large as the scene's pictures.
pub(crate) fn load_reference(path: &Path, scene: &Scene) -> Outcome<Picture> {
    let reference = read_picture(path)?;
    let camera = &scene.camera;
    if (reference.width, reference.height) != (camera.width, camera.height) {
        return Err(format!(
            "{}: the reference has {} x {} pixels, the scene's picture {} x {}; choose --width {} or another reference",
            path.display(),
            reference.width,
            reference.height,
            camera.width,
            camera.height,
            reference.width
        )
        .into());
    }
    Ok(reference)
}

/// A file's name without its ending.
pub(crate) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The named regions of the ball scenes; None for any other scene.
pub(crate) fn ball_regions(path: &Path, scene: &Scene) -> Option<[Region; 6]> {
    let is_ball = ["glass-ball", "black-ball"].contains(&name(path).as_str());
    is_ball.then(|| of_ball(scene.camera.width))
}

/// The named regions of the ball scenes that are none of [`SHARPNESS`].
pub(crate) fn other_regions(path: &Path, scene: &Scene) -> Vec<Region> {
    let named = ball_regions(path, scene).into_iter().flatten();
    named.filter(|region| !SHARPNESS.contains(&region.name)).collect()
}

/// The named regions of the ball scenes; in other scenes those read off the reference, or the whole picture.
pub(crate) fn regions(path: &Path, scene: &Scene, reference: Option<&Picture>) -> Vec<Region> {
    match (ball_regions(path, scene), reference) {
        (Some(regions), _) => regions.to_vec(),
        (None, Some(reference)) => by_sharpness(reference).to_vec(),
        (None, None) => vec![whole(scene.camera.width, scene.camera.height)],
    }
}

/// Compares a region with the same region of the reference.
pub(crate) fn in_region(picture: &Picture, reference: &Picture, region: &Region) -> Outcome<Comparison> {
    Ok(compare(picture, reference, |x, y| region.contains(x, y))?)
}

/// A reference with its regions: those of [`by_sharpness`], then others.
pub(crate) struct Reference {
    picture: Picture,
    pub(crate) regions: Vec<Region>,
    /// Expected relMSE that the noise of the reference adds to that of a picture, by region; None = not known.
    noise: Option<Vec<f64>>,
}

impl Reference {
    /// Reads a reference, and the first of its two runs if that is kept beside it. `others`: regions besides those by sharpness.
    pub(crate) fn load(path: &Path, scene: &Scene, others: Vec<Region>) -> Outcome<Self> {
        let picture = load_reference(path, scene)?;
        let mut regions = by_sharpness(&picture).to_vec();
        regions.extend(others);
        let half = first_run(path);
        let mut noise = None;
        if half.exists() {
            // With R the mean of two runs, (I - R1)(I - R2) = (I - R)² - (R1 - R)² is free of their noise.
            let half = load_reference(&half, scene)?;
            let of = |region: &Region| Ok(in_region(&half, &picture, region)?.rel_mse);
            noise = Some(regions.iter().map(of).collect::<Outcome<Vec<f64>>>()?);
        }
        Ok(Self { picture, regions, noise })
    }

    /// Of a picture, by region, without the reference's noise where that is known.
    pub(crate) fn rel_mse(&self, picture: &Picture) -> Outcome<Vec<f64>> {
        let of = |(index, region): (usize, &Region)| {
            let noise = self.noise.as_ref().map_or(0.0, |noise| noise[index]);
            Ok(in_region(picture, &self.picture, region)?.rel_mse - noise)
        };
        self.regions.iter().enumerate().map(of).collect()
    }

    pub(crate) fn errors(&self, picture: &Picture) -> Outcome<Errors> {
        let mut errors = Errors::default();
        let rel_mse = self.rel_mse(picture)?;
        for (index, region) in self.regions.iter().enumerate().take(SHARPNESS.len()) {
            errors.rel_mse[index] = rel_mse[index];
            errors.bias[index] = in_region(picture, &self.picture, region)?.bias;
        }
        Ok(errors)
    }

    /// For the line above a table.
    pub(crate) fn about_noise(&self) -> String {
        match &self.noise {
            Some(noise) => format!(
                "relMSE is without that of the reference's noise (whole {:.1e}, smooth {:.1e}, sharp {:.1e})",
                noise[0], noise[1], noise[2]
            ),
            None => "relMSE holds the reference's noise".to_owned(),
        }
    }
}

/// Where the first of the two runs of a reference is kept: NAME-half.exr beside NAME.exr.
pub(crate) fn first_run(reference: &Path) -> PathBuf {
    reference.with_file_name(name(reference) + "-half.exr")
}

/// Of a picture, in the regions of [`by_sharpness`].
#[derive(Clone, Copy, Default)]
pub(crate) struct Errors {
    rel_mse: [f64; 3],
    bias: [f64; 3],
}

impl Errors {
    /// Adds one of `count` runs to a mean.
    pub(crate) fn add_share(&mut self, run: &Self, count: f64) {
        for index in 0..3 {
            self.rel_mse[index] += run.rel_mse[index] / count;
            self.bias[index] += run.bias[index] / count;
        }
    }

    /// Ratio of relMSE.
    pub(crate) fn ratio(&self, plain: &Self) -> [f64; 3] {
        std::array::from_fn(|index| self.rel_mse[index] / plain.rel_mse[index])
    }

    /// Cells of a table: relMSE, and bias in percent.
    pub(crate) fn cells(&self) -> [String; 2] {
        let [rel_mse, bias] = [self.rel_mse.map(|e| format!("{e:.2e}")), self.bias.map(percent)];
        [rel_mse.join(" | "), bias.join(" | ")]
    }
}

fn percent(bias: f64) -> String {
    format!("{:+.2}", 100.0 * bias)
}

/// CPU time of this process so far, all threads \[s\]: unlike a clock's it does not grow when others share the cores.
pub(crate) fn cpu_seconds() -> Outcome<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let after_name = stat.rsplit_once(')').ok_or("/proc/self/stat is not as expected")?.1;
    let ticks = |field: usize| -> Outcome<f64> {
        Ok(after_name.split_whitespace().nth(field).ok_or("/proc/self/stat is too short")?.parse::<f64>()?)
    };
    Ok((ticks(11)? + ticks(12)?) / 100.0)
}
