//! What nobody need say of a scene: cells of the covariance grid, radii of kernels, light paths a pass.
//!
//! All of it follows from a survey, a function of the scene alone, never of a clock or of the machine's threads: a scene without numbers
//! gives the same picture everywhere. Scaled with the scene's unit of length (and the media's coefficients with its inverse), all lengths
//! scale alike and the counts stay. The grid's box is the survey's.

use crate::pilot::survey::Survey;
use crate::scene::geometry::divide;
use crate::scene::{Scene, Settings};
use covbeam::{GridLayout, KernelShape, Schedule};
use covbeam_geometry::MAX_COORDINATE;
use glam::Vec3;

/// Voxels of the grid. Few and wide: beside a shadow the dimmest voxel around bounds what a kernel may leak, and it must be seen from afar.
const CELLS: u32 = 24 * 24 * 24;

/// Largest radius of kernels, in shortest sides of a voxel. A kernel as wide as a voxel leaks past what its voxels know; and one twice as
/// wide has half of a beam's noise for twice its pairs, which pays only as long as pairs are a small part of a pass. Of .5, .25, .18, .13 and
/// .06 of a voxel the third or fourth has the least error at equal time in 15 of 17 scenes, at 72 to 144 pixels.
const MOST_IN_VOXEL: f32 = 0.15;

/// Radius of the first kernels, in sides of a cube as large as the space that the scene takes.
const RADIUS_IN_SPACE: f32 = 1.0 / 160.0;

/// Bounds on it, in sides of the picture where the light is.
const RADIUS_IN_PICTURE: [f32; 2] = [1.0 / 80.0, 1.0 / 45.0];

/// Radii of kernels fall as passes^(α - 1) = passes^(-1/5): squared bias and variance fall alike then, in one dimension, as with the bound on
/// the bias of adaptive kernels. With 1/2 it is noise alone that is left: two to eight times the error after some hundred passes.
const ALPHA: f32 = 0.8;

/// Beams that kernels of the first radius meet along the middle one of the eye rays, in a pass.
const MEETINGS: f64 = 64.0;

/// Light paths a pass where the camera sees no light in a medium.
const PATHS_OF_SURFACES: f64 = 5000.0;

/// Bounds on light paths a pass: fewer leave too few light fields in the grid; with more, too few passes fit in a few seconds to
/// smooth silhouettes.
const PATHS_OF_SMALL: [f64; 2] = [1000.0, 10_000.0];

/// Most of those that go where the picture needs them: each has several beams there. With more there are too few passes in a second or two:
/// in 21 scenes of a fleet that have 10,000 otherwise the error after 1.25 s was 1.36 times as large, and 1.2 times with the bound on a pixel's.
const MOST_GUIDED: f64 = 5000.0;

/// Most light paths a pass of a picture of any size: some 100 MB of beams.
const MOST: f64 = 200_000.0;

/// Pixels from which on a pass gets more light paths: below, it is the photons that it spends its time on.
const LARGE: f64 = 256.0 * 256.0;

/// Radius of the first pass' kernels. The larger the space that the light fills, the wider the gaps between its beams; but a kernel is never
/// small or large in the picture.
fn radius(survey: &Survey) -> f32 {
    let [least, most] = RADIUS_IN_PICTURE.map(|share| share * survey.view);
    (RADIUS_IN_SPACE * survey.space).clamp(least, most).clamp(1.0 / MAX_COORDINATE, MAX_COORDINATE)
}

/// Largest radius, which follows from the voxels: [`MOST_IN_VOXEL`] of them.
fn max_radius(grid: &GridLayout) -> f32 {
    let cells = Vec3::from(grid.cells.map(|n| n as f32));
    MOST_IN_VOXEL * ((grid.max - grid.min) / cells).min_element()
}

/// Light paths a pass: as many as let a pixel meet [`MEETINGS`] beams, so that the eye rays of a pass cost as much in any scene; more in
/// large pictures, whose passes have much to do that no photon costs: in proportion to the root of their pixels, which shares the growth
/// between photons and pixels.
fn photons(scene: &Scene, survey: &Survey, radius: f32) -> u32 {
    let for_meetings = |meetings| MEETINGS / (2.0 * f64::from(radius) * meetings);
    let [fewest, most] = PATHS_OF_SMALL;
    let paths = survey.meetings.map_or(PATHS_OF_SURFACES, for_meetings).clamp(fewest, most);
    two_digits((paths * for_size(scene)).min(MOST))
}

/// Guided light paths a pass, of a scene that has `photons` others.
fn guided_photons(scene: &Scene, photons: u32) -> u32 {
    photons.min(two_digits(MOST_GUIDED * for_size(scene)))
}

/// As many times the light paths of a small picture.
fn for_size(scene: &Scene) -> f64 {
    let pixels = f64::from(scene.camera.width) * f64::from(scene.camera.height);
    (pixels / LARGE).sqrt().max(1.0)
}

/// Rounded to two digits: the last ones of the survey are not the same on every processor.
fn two_digits(number: f64) -> u32 {
    let step = libm::pow(10f64, (libm::log10(number) - 1.0).floor());
    ((number / step).round() * step).round() as u32
}

/// What is said of a scene's grid and render. All else follows from the scene.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    /// Corners of the grid's box.
    pub corners: Option<(Vec3, Vec3)>,
    /// How it is divided.
    pub cells: Option<Cells>,
    /// Settings; the four below replace theirs.
    pub settings: Settings,
    /// Light paths a pass, of all kinds of paths alike.
    pub photons: Option<u32>,
    /// Radius of the first pass' kernels \[scene unit\], > 0.
    pub radius: Option<f32>,
    /// Their largest radius \[scene unit\], > 0.
    pub max_radius: Option<f32>,
}

/// How the grid's box is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// Along x, y and z.
    Counts([u32; 3]),
    /// Into cubes, so many along the longest side.
    Longest(u32),
}

impl Default for Given {
    /// Nothing is said.
    fn default() -> Self {
        let settings = settings();
        Self { corners: None, cells: None, settings, photons: None, radius: None, max_radius: None }
    }
}

impl Scene {
    /// Gives the scene its grid and settings: what is given, and for the rest what the scene asks for. Looks at neither before.
    pub fn complete(&mut self, given: &Given) {
        let is_complete = given.corners.is_some() && given.radius.is_some() && given.photons.is_some();
        let survey = (!is_complete).then(|| Survey::new(self));
        let survey = || survey.expect("made where a number is missing");
        let (min, max) = given.corners.unwrap_or_else(|| (survey().min, survey().max));
        let cells = match given.cells {
            Some(Cells::Counts(counts)) => counts,
            Some(Cells::Longest(count)) => cubes(max - min, count),
            None => divide(max - min, CELLS),
        };
        self.grid = GridLayout { min, max, cells };
        let radius = given.radius.unwrap_or_else(|| radius(&survey()));
        let max_radius = given.max_radius.unwrap_or_else(|| max_radius(&self.grid));
        let photons = given.photons.unwrap_or_else(|| photons(self, &survey(), radius));
        let guided_photons = given.photons.unwrap_or_else(|| guided_photons(self, photons));
        let schedule = Schedule { radius, max_radius, ..given.settings.schedule };
        self.settings = Settings { photons, guided_photons, schedule, ..given.settings };
    }
}

/// Gives all instants the grid and the settings of one of them, the grid around what all light.
pub fn complete_all(instants: &mut [Scene], given: &Given) {
    instants.iter_mut().for_each(|scene| {
        scene.settings = given.settings;
        scene.complete(given);
    });
    let Some((first, others)) = instants.split_first_mut().filter(|(_, others)| !others.is_empty()) else {
        return;
    };
    let corners = others.iter().fold((first.grid.min, first.grid.max), |(min, max), scene| {
        (min.min(scene.grid.min), max.max(scene.grid.max))
    });
    first.complete(&Given { corners: Some(corners), ..*given });
    others.iter_mut().for_each(|scene| (scene.grid, scene.settings) = (first.grid, first.settings));
}

/// The grid of a scene before it has one.
pub const NO_GRID: GridLayout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1; 3] };

/// Numbers of cubes in a box of this size, `count` along its longest side.
fn cubes(size: Vec3, count: u32) -> [u32; 3] {
    let side = size.as_dvec3().max_element() / f64::from(count);
    size.to_array().map(|length| ((f64::from(length) / side - 1e-6).ceil() as u32).max(1))
}

/// Settings that depend on nothing.
fn settings() -> Settings {
    Settings {
        passes: 64,
        photons: 5000,
        guided_photons: 5000,
        seed: 1,
        schedule: Schedule {
            shape: KernelShape::Epanechnikov,
            radius: 1.0,
            alpha: ALPHA,
            max_radius: 1.0,
            error: 0.01,
        },
        light_field_share: 0.1,
        bounces: None,
        limits: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;
    use crate::scene::made::{Made, camera, cuboid, lambert, point, sphere, spot};

    /// Medium with a spot, and with a ball before a wall; lengths in `scale`, all of it moved by `shift`.
    fn fog(scale: f32, shift: Vec3, objects: bool) -> Scene {
        let place = |x: f32, y: f32, z: f32| (scale * Vec3::new(x, y, z) + shift).to_array();
        let camera = camera(place(0.0, 0.0, -5.0), place(0.0, 0.0, 0.0), 40.0, [64, 48]);
        let mut made = Made::new(camera).fog(0.25 / scale, 0.0625 / scale).in_fog();
        if objects {
            made = made
                .object(sphere(place(0.0, 0.0, 0.5), 0.5 * scale), Material::Black)
                .object(cuboid(place(-8.0, -8.0, 4.0), place(8.0, 8.0, 5.0)), lambert(0.5));
        }
        made.light(spot(place(1.0, 2.0, 0.0), place(0.0, 0.0, 0.5), 10.0, [15.0, 20.0])).scene()
    }

    #[test]
    fn lengths_scale_with_the_scene_and_counts_stay() {
        let unit = fog(1.0, Vec3::ZERO, true);
        // Powers of two scale every number without rounding.
        for scale in [1.0 / 128.0, 512.0] {
            let scaled = fog(scale, Vec3::ZERO, true);
            assert_eq!((scaled.grid.min, scaled.grid.max), (scale * unit.grid.min, scale * unit.grid.max));
            assert_eq!(scaled.grid.cells, unit.grid.cells);
            let mut expected = unit.settings;
            expected.schedule.radius *= scale;
            expected.schedule.max_radius *= scale;
            assert_eq!(scaled.settings, expected);
        }
    }

    #[test]
    fn the_box_moves_with_the_scene() {
        let still = fog(1.0, Vec3::ZERO, true);
        let shift = Vec3::new(30.0, -20.0, 10.0);
        let moved = fog(1.0, shift, true);
        // A path whose roundings differ may leave its beam in the next voxel of the survey: a 16th of the box' mean side.
        let side = (still.grid.max - still.grid.min).element_product().cbrt();
        let ends = [(moved.grid.min, still.grid.min + shift), (moved.grid.max, still.grid.max + shift)];
        for (end, expected) in ends {
            assert!((end - expected).abs().max_element() < side / 15.0, "{end} for {expected}");
        }
        // Of 2048 paths and 576 eye rays few differ; photons are given to two digits.
        let ratio = |of: fn(&Settings) -> f64| of(&moved.settings) / of(&still.settings);
        assert!((ratio(|settings| settings.schedule.radius.into()) - 1.0).abs() < 0.01);
        assert!((ratio(|settings| settings.photons.into()) - 1.0).abs() < 0.05);
    }

    #[test]
    fn the_box_ends_at_the_wall_and_holds_the_lit_fog_before_it() {
        let GridLayout { min, max, .. } = fog(1.0, Vec3::ZERO, true).grid;
        // The wall is at z = 4, and the picture there 2 · 9 tan 20° = 6.55 high and 8.74 wide.
        assert!(max.z <= 4.001 && max.x - min.x <= 8.74 && max.y - min.y <= 6.56, "{min} {max}");
        // The cone runs from (1, 2, 0) to the ball.
        assert!(min.cmple(Vec3::new(-0.5, -0.5, -1.0)).all(), "{min}");
        assert!(max.cmpge(Vec3::new(0.5, 0.5, 0.5)).all(), "{max}");
    }

    #[test]
    fn fog_without_end_and_without_objects_has_a_box_around_the_light_in_it() {
        let GridLayout { min, max, .. } = fog(1.0, Vec3::ZERO, false).grid;
        assert!(
            min.cmple(Vec3::new(-0.4, -0.8, -0.3)).all() && max.cmpge(Vec3::splat(0.4)).all(),
            "{min} {max}"
        );
        // An optical depth of 4 is 12.8 away from the camera at z = -5.
        assert!(min.z >= -5.0 && max.z <= 7.81, "{min} {max}");
    }

    #[test]
    fn a_large_picture_gets_as_many_more_paths_as_the_root_of_its_pixels() {
        let mut scene = fog(1.0, Vec3::ZERO, true);
        let survey = Survey { meetings: Some(0.1), ..Survey::new(&scene) };
        let mut paths = |side| {
            (scene.camera.width, scene.camera.height) = (side, side);
            photons(&scene, &survey, 0.1)
        };
        // 64 beams of 0.1/m in strips 0.2 m wide: 3200 paths.
        assert_eq!([64, 256, 1024].map(&mut paths), [3200, 3200, 13_000]);
        assert_eq!(paths(16384), MOST as u32);
        let mut guided = |side, photons| {
            (scene.camera.width, scene.camera.height) = (side, side);
            guided_photons(&scene, photons)
        };
        assert_eq!([guided(64, 3200), guided(256, 10_000), guided(1024, 40_000)], [3200, 5000, 20_000]);
    }

    #[test]
    fn cells_are_about_cubic_and_never_too_many() {
        assert_eq!(divide(Vec3::ONE, CELLS), [24; 3]);
        assert_eq!(divide(Vec3::new(4.0, 1.0, 2.0), CELLS), [48, 12, 24]);
        for size in [
            Vec3::new(1.0, 1e-3, 1.0),
            Vec3::new(1e-3, 1.0, 1e-3),
            Vec3::new(2e9, 2e9, 1e-9),
            Vec3::new(1e-9, 2e9, 1e-9),
        ] {
            let cells = divide(size, CELLS);
            let count: f64 = cells.iter().map(|n| f64::from(*n)).product();
            // The last count makes up for what rounding the others took, but for its own half.
            assert!((count / f64::from(CELLS) - 1.0).abs() < 0.02, "{size}: {cells:?}");
        }
    }

    #[test]
    fn scenes_with_next_to_nothing_in_them_have_sound_defaults() {
        for coefficient in [0.1, 1e9, 1e-9, 0.0] {
            for (place, is_shut) in
                [([0.0; 3], false), ([5.0; 3], true), ([1e9, 1e9, -1e9], false), ([0.0, 0.0, 1e-9], false)]
            {
                let camera = camera([0.0; 3], [0.0, 0.0, 1.0], 0.001, [1, 1]);
                let mut made = Made::new(camera).fog(coefficient, coefficient).in_fog();
                if is_shut {
                    made = made.object(cuboid([4.0; 3], [6.0; 3]), Material::Black);
                }
                let Scene { grid, settings, .. } = made.light(point(place, 1e9)).scene();
                let what = format!("{coefficient}, {place:?}");
                let voxel = (grid.max - grid.min) / Vec3::from(grid.cells.map(|n| n as f32));
                assert!(grid.min.is_finite() && voxel.min_element() > 0.0, "{what}: {grid:?}");
                assert!(
                    settings.schedule.radius > 0.0 && settings.schedule.radius.is_finite(),
                    "{what}: {settings:?}"
                );
                assert!(settings.schedule.max_radius > 0.0, "{what}: {settings:?}");
                assert!((1000..=10_000).contains(&settings.photons), "{what}: {settings:?}");
            }
        }
    }
}
