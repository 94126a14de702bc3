//! What is around a scene, infinitely far away.

use super::aim::{Aim, Ball};
use super::cells::Cells;
use super::rays::{CURVATURE, EmittedPhoton};
use crate::medium::SceneMedium;
use crate::object::Object;
use crate::random::PathSampler;
use covbeam::LightField;
use glam::{DMat3, Mat3, Vec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A picture of the sky: light from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    picture: Arc<Picture>,
    aim: Aim,
}

#[derive(PartialEq)]
struct Picture {
    /// Of the directions that light comes from.
    cells: Cells,
    /// Of the spectrum of each cell's light \[cycles²/rad²\].
    variances: Vec<f32>,
    /// Integral of the radiance over all directions \[W/m²\].
    all: Vec3,
    /// The most of each channel [W/(m² sr)].
    brightest: Vec3,
}

impl std::fmt::Debug for Picture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Picture {{ {:?}, {} W/m² }}", self.cells, self.all)
    }
}

impl Sky {
    /// A sky for a scene whose media are all in one ball, and all that its light can meet in another. Three of four photons are sent to the
    /// media. None: no cells, not a whole number of rows, no light in any, or light that is negative or not finite.
    ///
    /// - `radiance`: that arrives from cells of equal angles [W/(m² sr)]. Rows run from +Z down to -Z, columns in azimuth from π, by way of +X
    ///   in the middle, down to -π.
    /// - `columns`: cells of a row.
    /// - `turn`: the direction in the picture is this rotation of that in the scene.
    pub fn around(radiance: Vec<Vec3>, columns: usize, turn: Mat3, media: Ball, scene: Ball) -> Option<Self> {
        Self::aimed(radiance, columns, turn, Aim::around(media, scene))
    }

    /// A sky that shines on a scene's objects, and on its media where they are; `outside`: the one that is outside of objects. None where there
    /// is nothing of either, too.
    pub fn new(
        (radiance, columns, turn): (Vec<Vec3>, usize, Mat3),
        objects: &[Object],
        media: &[SceneMedium],
        outside: Option<u32>,
    ) -> Option<Self> {
        Self::aimed(radiance, columns, turn, Aim::at(objects, None, media, outside)?)
    }

    fn aimed(radiance: Vec<Vec3>, columns: usize, turn: Mat3, aim: Aim) -> Option<Self> {
        let rows = radiance.len().checked_div(columns)?;
        let brightness: Vec<f64> = radiance.iter().map(|value| f64::from(value.max_element())).collect();
        // Azimuth π - 2π turn is a turn the other way around, from -X.
        let [x, y, z] = [turn.row(0), turn.row(1), turn.row(2)].map(|row| row.as_dvec3().normalize());
        let brightest = radiance.iter().copied().fold(Vec3::ZERO, Vec3::max);
        let cells = Cells::new(radiance, columns, DMat3::from_cols(-x, y, z), PI, |_| 1.0)?;
        let variances = variances(&brightness, rows, columns, &cells);
        let all = cells.integral(|_| 1.0);
        Some(Self { picture: Arc::new(Picture { cells, variances, all, brightest }), aim })
    }

    /// Box of all that it shines on.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        self.aim.bounds()
    }

    /// What the photons have that are sent to the media.
    pub(super) fn flux(&self) -> Vec3 {
        self.picture.all * self.aim.area()
    }

    /// Middle of what it shines on, and how far that reaches.
    pub(super) fn middle(&self) -> (Vec3, f32) {
        self.aim.middle()
    }

    /// A point ahead of the scene, on one of its sides.
    pub(super) fn position(&self) -> Vec3 {
        self.aim.ahead(Vec3::NEG_Y)
    }

    /// As [`super::Light::emit_at`].
    pub(super) fn emit_at(&self, place: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        let drawn = self.picture.cells.draw(place);
        let (origin, density) = self.aim.start(-drawn.direction, sampler.uniform_pair());
        let direction = -drawn.direction.as_vec3().normalize();
        EmittedPhoton::new(origin, direction, drawn.weight / density, Vec3::ZERO)
    }

    /// As [`super::Light::light_field`]: uniform in space.
    pub(super) fn light_field(&self, direction: Vec3) -> LightField {
        let variance = self.picture.cells.find(-direction).map_or(0.0, |cell| self.picture.variances[cell]);
        LightField::gaussian(direction, Vec3::ZERO, [0.0; 2], [variance; 2])
    }

    /// As [`super::Light::flux_density`]: one direction stands for the whole sky, drawn by how bright it is.
    pub(super) fn flux_density(&self, place: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        // (0, 0) is the middle of the light.
        let drawn = self.picture.cells.draw(xi.map(|xi| (xi + 0.5).fract()));
        let (is_lit, from) = self.aim.reaches(place, -drawn.direction);
        (if is_lit { drawn.weight } else { Vec3::ZERO }, from)
    }

    /// Its radiance in a direction of view.
    pub(super) fn seen_along(&self, direction: Vec3) -> Vec3 {
        self.picture.cells.value(direction)
    }

    pub(super) fn brightest(&self) -> Vec3 {
        self.picture.brightest
    }

    /// Whether a photon without a history may have started there.
    pub(super) fn may_have_sent(&self, origin: Vec3) -> bool {
        self.aim.is_ahead(origin)
    }
}

/// Of light as bright as a cell's all power of the sky fills a disk, and has that disk's spectrum: a sun's cells are a small bright one.
/// Where the sky changes from cell to cell, its relative gradient speaks.
fn variances(sky: &[f64], rows: usize, columns: usize, cells: &Cells) -> Vec<f32> {
    let at = |row: usize, column: usize| sky[row * columns + column];
    let power: f64 = sky
        .chunks(columns)
        .enumerate()
        .map(|(row, sky)| cells.solid_angle(row) * sky.iter().sum::<f64>())
        .sum();
    // The larger of two differences of neighbours in a row of three, over their mean.
    let steepest = |[before, here, after]: [f64; 3]| {
        let mean = ((before + here + after) / 3.0).max(1e-300);
        (here - before).abs().max((after - here).abs()) / mean
    };
    let variance = |cell: usize| {
        let (row, column) = (cell / columns, cell % columns);
        let here = sky[cell];
        let radius2 = (power / here.max(1e-300) / PI).min(TAU);
        let sine = libm::sin((row as f64 + 0.5) * (PI / rows as f64)).max(0.5 / rows as f64);
        let beside = [at(row, (column + columns - 1) % columns), here, at(row, (column + 1) % columns)];
        let around = steepest(beside) / (sine * (TAU / columns as f64));
        let above = [at(row.saturating_sub(1), column), here, at((row + 1).min(rows - 1), column)];
        let gradient = around.max(steepest(above) / (PI / rows as f64));
        ((1.0 / (PI * PI * radius2)) as f32).max((gradient * gradient) as f32 * CURVATURE)
    };
    (0..sky.len()).map(variance).collect()
}
